"""`subsea-capture mesh`: move a user's mesh with a recorded segment."""

import argparse
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command, add_force
from subsea.base.errors import unknown
from subsea.base.file_kinds import MESH, check_results
from subsea.base.files import check_folder
from subsea.base.progress import print_line

GROUP = "use elsewhere"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "mesh",
        "animate your own mesh with a recorded segment",
        "Binds a Wavefront OBJ mesh to the nodes of the fish and writes an OBJ file for each\n"
        "frame (0.033 s). The mesh must be in cm and body axes: x anterior, y dorsal, z right,\n"
        "the origin in the middle of the second ring of nodes. With --fit it only has to head\n"
        "along x.",
        ["subsea-capture mesh fusilier sardine.obj --fit --out frames"],
    )
    parser.add_argument("file", metavar="SPECIES", help="species, or path of a repertoire (.h5)")
    parser.add_argument("mesh", metavar="MESH", type=Path, help="mesh file (.obj)")
    parser.add_argument(
        "--segment", metavar="NAME", default="swim_fast", help="segment (default swim_fast)"
    )
    parser.add_argument("--out", metavar="DIR", type=Path, required=True, help="folder to write to")
    parser.add_argument(
        "--fit", action="store_true", help="scale the mesh to the fish and align its snout"
    )
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code."""
    from tqdm import trange

    from subsea.export.obj import bind_mesh, write_mesh
    from subsea.fish.species import repertoire_file
    from subsea.repertoire import read_repertoire

    repertoire = read_repertoire(repertoire_file(options.file))
    if options.segment not in repertoire.segments:
        raise unknown("segment", options.segment, list(repertoire.segments))
    mesh = bind_mesh(repertoire, options.mesh, options.fit)
    name = f"{options.mesh.stem}_{options.segment}"
    nodes = repertoire.segments[options.segment].nodes
    files = [options.out / f"{name}_{frame:04d}.obj" for frame in range(len(nodes))]
    check_folder(options.out)
    check_results(files, MESH, options.force)
    for frame in trange(len(nodes), unit="frame"):
        write_mesh(files[frame], mesh, nodes[frame])
    print_line(f"{files[0]} and {len(nodes) - 1} more")
    return 0
