"""The command line of the capture tool."""

import argparse
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from subsea.core.atomic_io import check_folder
from subsea.core.command_line import answer, command, number, parse, program
from subsea.core.errors import UserError, unknown
from subsea.core.interrupts import deferred
from subsea.core.resources import resource_path

MAX_JOBS = 64


def main(arguments: Sequence[str] | None = None) -> int:
    """Run ``subsea-capture`` with these arguments (default: the process's); return its exit code.

    0 done, 1 a fish misses what `inspect` asks of it or `learn` found nothing better, 2 something
    the user can mend (one line on standard error), 130 interrupted.
    """
    return answer("subsea-capture", lambda: _run(sys.argv[1:] if arguments is None else arguments))


def _run(arguments: Sequence[str]) -> int:
    parser, commands = parsers()
    if not arguments:
        parser.print_help()
        return 0
    options = parse(parser, commands, arguments)
    code: int = options.run(options)
    return code


def parsers() -> tuple[argparse.ArgumentParser, Any]:
    """The parser of ``subsea-capture`` and its commands."""
    description = "Record the motion of simulated fishes, and judge what was recorded."
    parser = program("subsea-capture", description)
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")

    record = command(
        commands,
        "record",
        "swim fishes and write their repertoires",
        "Three swims and four turns of each species go to OUT/SPECIES.h5. The same species\n"
        "files give the same repertoires, however many jobs record them. A repertoire that is\n"
        "up to date is left alone; a run that was interrupted goes on where it stopped. Those of\n"
        "species of your own lie in your folder of repertoires.",
        [
            "subsea-capture record fusilier",
            "subsea-capture record --all --jobs 2",
            "subsea-capture record --all --cluster tcp://192.168.1.5:8786",
            "subsea-capture record emperor_angelfish --out /tmp/repertoires",
        ],
    )
    record.add_argument("species", metavar="SPECIES", nargs="*", help="species to record")
    record.add_argument("--all", action="store_true", help="record every species that is shipped")
    record.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        help="folder to write to (a checkout's repertoires/, for species of your own your folder)",
    )
    record.add_argument(
        "--jobs",
        metavar="N",
        type=number(int, 1, MAX_JOBS),
        default=1,
        help="processes to record in (1)",
    )
    record.add_argument(
        "--cluster",
        metavar="ADDRESS",
        help="record on the Dask cluster of this scheduler instead, such as tcp://host:8786",
    )
    record.add_argument(
        "--force", action="store_true", help="record what is up to date already, too"
    )
    record.add_argument(
        "--progress", action="store_true", help="show progress also where no terminal is"
    )
    record.set_defaults(run=_record)

    learn = command(
        commands,
        "learn",
        "find the motor controllers of a species' body",
        "Searches the tables [swim] and [turn] of a species file for speed, economy, straightness\n"
        "and exact turns, verifies the winner for longer and under disturbances, and writes it\n"
        "into the file; all else in it stays. Exit code 0 if it found better controllers, 1 if\n"
        "not: then the file stays as it is. Needs cma and scipy (subsea[learn]).",
        [
            "subsea-capture learn fusilier",
            "subsea-capture learn fusilier --only turn --dry-run",
            "subsea-capture learn my_fish.toml --method annealing --out /tmp/my_fish.toml",
        ],
    )
    learn.add_argument("species", metavar="SPECIES", help="species, or the path of its .toml file")
    learn.add_argument("--only", choices=["swim", "turn"], default="", help="learn only this table")
    learn.add_argument(
        "--method",
        choices=["cma", "annealing"],
        default="cma",
        help="CMA-ES (default) or simulated annealing",
    )
    learn.add_argument(
        "--budget",
        metavar="N",
        type=number(int, 1, 1_000_000),
        default=300,
        help="evaluations of each search (300)",
    )
    learn.add_argument(
        "--seed",
        metavar="N",
        type=number(int, 0, 2**31),
        default=1,
        help="the same seed gives the same result (1)",
    )
    learn.add_argument(
        "--ticks", metavar="N", type=number(int, 4, 60), help="fix the ticks of a beat"
    )
    learn.add_argument(
        "--economy",
        metavar="W",
        type=number(float, 0, 10),
        default=0.1,
        help="weight of economy beside speed (0.1)",
    )
    learn.add_argument(
        "--out", metavar="FILE", type=Path, help="species file to write (default: the one read)"
    )
    learn.add_argument("--dry-run", action="store_true", help="write nothing")
    learn.set_defaults(run=_learn)

    inspect = command(
        commands,
        "inspect",
        "show what a repertoire holds and how good it is",
        "Lists the segments, then swims the fish again from the file's provenance and puts its\n"
        "measures beside what is asked of every fish (at least) and where the best should get\n"
        "(aim). Exit code 0 if every measure is at least what is asked, 1 if not; a missed aim\n"
        "is no failure.",
        ["subsea-capture inspect fusilier", "subsea-capture inspect repertoires/fusilier.h5"],
    )
    inspect.add_argument(
        "file", metavar="SPECIES", help="species, or the path of a repertoire (.h5)"
    )
    inspect.set_defaults(run=_inspect)

    plot = command(
        commands,
        "plot",
        "draw the motion of a repertoire",
        "Writes a page for each segment (film strip, trajectories, speed, tail, spectrum, loop\n"
        "closure) and one for the repertoire (paths, speeds, steering map) as PNG files. Needs\n"
        "matplotlib (subsea[plot]).",
        ["subsea-capture plot fusilier --out plots"],
    )
    plot.add_argument("file", metavar="SPECIES", help="species, or the path of a repertoire (.h5)")
    plot.add_argument("--out", metavar="DIR", type=Path, required=True, help="folder for the PNGs")
    plot.set_defaults(run=_plot)

    mesh = command(
        commands,
        "mesh",
        "move a mesh of your own with a recorded segment",
        "Binds a Wavefront OBJ mesh to the fish's scaffold and writes one OBJ for each recorded\n"
        "frame (0.033 s), faces, materials and texture coordinates as they were. The mesh is in\n"
        "body axes and centimetres: x anterior, y dorsal, z right, the origin in the middle of\n"
        "the second ring of nodes. With --fit it only has to head along x.",
        ["subsea-capture mesh fusilier sardine.obj --fit --out frames"],
    )
    mesh.add_argument("file", metavar="SPECIES", help="species, or the path of a repertoire (.h5)")
    mesh.add_argument("mesh", metavar="MESH", type=Path, help="a mesh (.obj)")
    mesh.add_argument("--segment", metavar="NAME", default="swim_fast", help="(swim_fast)")
    mesh.add_argument("--out", metavar="DIR", type=Path, required=True, help="folder for the OBJs")
    mesh.add_argument(
        "--fit", action="store_true", help="scale the mesh to the fish and put its snout in place"
    )
    mesh.set_defaults(run=_mesh)

    export = command(
        commands,
        "export",
        "write a species and its motion for other programs",
        "The mesh that a dive draws, its sheet of colours, and every recorded segment as a clip:\n"
        "  gltf  glTF 2.0 with a skeleton fitted to the motion, or exact with --morph, and an\n"
        "        animation a segment: OUT/SPECIES.glb\n"
        "  vat   a vertex animation texture by the conventions of OpenVAT, for game engines:\n"
        "        OUT/SPECIES_vat/ with texture, mesh, sheet and ranges\n"
        "  usd   a USD stage with points in every frame: OUT/SPECIES.usdc and its sheet. Needs\n"
        "        usd-core (subsea[usd])\n"
        "docs/export.md tells what is in the files and how other programs take them.",
        [
            "subsea-capture export fusilier --to gltf",
            "subsea-capture export fusilier --to vat --out game/Assets",
            "subsea-capture export spotted_eagle_ray --to usd --root baked",
        ],
    )
    export.add_argument("species", metavar="SPECIES", help="name of the species to export")
    export.add_argument("--to", choices=["gltf", "vat", "usd"], required=True, help="the format")
    export.add_argument(
        "--out", metavar="DIR", type=Path, default=Path(), help="folder to write to (this one)"
    )
    export.add_argument(
        "--root",
        choices=["apart", "baked"],
        default="apart",
        help="the way of the fish: a motion of the root (default), or in the points",
    )
    export.add_argument(
        "--detail",
        metavar="N",
        type=number(int, 0, 3),
        default=0,
        help="level of detail, 0 the finest to 3 (0)",
    )
    export.add_argument(
        "--morph", action="store_true", help="gltf: a morph target a frame instead of a skeleton"
    )
    export.set_defaults(run=_export)
    return parser, commands


def _record(options: argparse.Namespace) -> int:
    from tqdm import tqdm

    from capture.batch import record_all
    from capture.jobs import here, processes
    from capture.kept import repertoire_path
    from subsea.fish.species import shipped_species, species_names
    from subsea.repertoire import SEGMENTS

    known = species_names()
    for name in options.species:
        if name not in known:
            raise unknown("species", name, known)
    if options.all and options.species:
        raise UserError(f"--all and {options.species[0]!r}: give one of the two")
    if options.cluster is not None and options.jobs != 1:
        raise UserError("--jobs and --cluster: give one of the two")
    if not options.all and not options.species:
        raise UserError(f"name a species ({', '.join(known)}) or give --all")
    names = shipped_species() if options.all else list(dict.fromkeys(options.species))
    folders = {name: options.out or _repertoires_of(name) for name in names}
    for folder in dict.fromkeys(folders.values()):
        check_folder(folder)
    bars: dict[str, Any] = {}

    def tell(name: str, segments: int) -> None:
        if name not in bars:
            bars[name] = tqdm(
                total=len(SEGMENTS),
                desc=name,
                position=len(bars),
                unit="segment",
                initial=segments,
                disable=False if options.progress else None,
            )
        bars[name].update(segments - bars[name].n)

    if options.cluster is not None:
        from capture.cluster import cluster

        workers = cluster(options.cluster)
    else:
        workers = here if options.jobs == 1 else processes(options.jobs)
    try:
        with deferred() as check:
            recorded = record_all(folders, workers, check, tell, options.force)
    except KeyboardInterrupt:
        raise KeyboardInterrupt("the same command goes on from here") from None
    finally:
        for bar in bars.values():
            bar.close()
    for name in names:
        path = repertoire_path(folders[name], name)
        print(f"{path}{'' if name in recorded else ': up to date'}")
    return 0


def _repertoires_of(name: str) -> Path:
    """Where a species is recorded to; what came with an installed package stays as it is."""
    from subsea.fish.species import is_shipped, repertoire_folder

    if is_shipped(name) and not resource_path("pyproject.toml").is_file():
        raise UserError("name the folder to write to: --out DIR")
    return repertoire_folder(name)


def _learn(options: argparse.Namespace) -> int:
    from capture.teach import teach

    return teach(
        options.species,
        options.out,
        options.dry_run,
        options.budget,
        only=options.only,
        method=options.method,
        seed=options.seed,
        ticks=options.ticks,
        thrift=options.economy,
    )


def _inspect(options: argparse.Namespace) -> int:
    from capture.inspect import report
    from subsea.fish.species import repertoire_file

    return 0 if report(repertoire_file(options.file), lambda line: print(line, flush=True)) else 1


def _plot(options: argparse.Namespace) -> int:
    from capture.plot import plot_repertoire
    from subsea.fish.species import repertoire_file
    from subsea.repertoire import read_repertoire

    repertoire = read_repertoire(repertoire_file(options.file))
    check_folder(options.out)
    for path in plot_repertoire(repertoire, options.out):
        print(path)
    return 0


def _mesh(options: argparse.Namespace) -> int:
    from tqdm import trange

    from capture.mesh import bind_mesh, write_mesh
    from subsea.fish.species import repertoire_file
    from subsea.repertoire import read_repertoire

    repertoire = read_repertoire(repertoire_file(options.file))
    if options.segment not in repertoire.segments:
        raise unknown("segment", options.segment, list(repertoire.segments))
    mesh = bind_mesh(repertoire, options.mesh, options.fit)
    check_folder(options.out)
    name = f"{options.mesh.stem}_{options.segment}"
    nodes = repertoire.segments[options.segment].nodes
    for frame in trange(len(nodes), unit="frame"):
        write_mesh(options.out / f"{name}_{frame:04d}.obj", mesh, nodes[frame])
    print(f"{options.out / name}_0000.obj and {len(nodes) - 1} more")
    return 0


def _export(options: argparse.Namespace) -> int:
    from capture.export.clips import make_clips
    from capture.export.usd import write_usd
    from capture.export.vat import write_vat

    if options.morph and options.to != "gltf":
        raise UserError(f"--morph is for --to gltf, not {options.to}")
    check_folder(options.out)
    model, clips = make_clips(options.species, options.detail)
    if options.to == "gltf":
        return _export_gltf(options, model, clips)
    write = {"vat": write_vat, "usd": write_usd}[options.to]
    for path in write(options.out, model, clips, options.root == "baked"):
        print(f"{path}: {path.stat().st_size / 1e6:.1f} MB")
    return 0


def _export_gltf(options: argparse.Namespace, model: Any, clips: Any) -> int:
    from tqdm import tqdm

    from capture.export.gltf import write_gltf
    from capture.export.rig import fit_rig

    rig, told = None, "exact"
    if not options.morph:
        bar = partial(tqdm, desc="fitting joints", unit="round", leave=False, disable=None)
        rig = fit_rig(model, clips, bar)
        told = (
            f"{len(rig.joints)} joints; vertices are off by {rig.rms_percent:.2f}% of the body "
            f"length (rms), {rig.most_percent:.2f}% at most"
        )
    path = write_gltf(options.out, model, clips, options.root == "baked", rig)
    print(f"{path}: {path.stat().st_size / 1e6:.1f} MB, {told}")
    return 0
