"""`subsea-capture export`: write a species for other programs."""

import argparse
from functools import partial
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command, add_force, number_reader
from subsea.base.errors import UserError
from subsea.base.file_kinds import GLTF, PICTURE, USD, check_result, json_file
from subsea.base.files import check_folder
from subsea.base.progress import print_line
from subsea.base.system import require
from subsea.export.options import add_detail, add_gltf, check_options

KINDS = {
    ".glb": GLTF,
    ".png": PICTURE,
    ".usdc": USD,
    ".json": json_file("a description of an OpenVAT texture", "os-remap"),
}


COARSEST = 3  # level of detail
GROUP = "use elsewhere"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "export",
        "export a species and its motion to other programs",
        "Writes mesh, texture and a clip for each segment: docs/how-to/export.md. Needs OpenGL\n"
        "but no display. Formats:\n"
        "  gltf  glTF 2.0 with a fitted skeleton, or exact with --morph: OUT/SPECIES.glb\n"
        "  vat   vertex animation texture (OpenVAT) for game engines: OUT/SPECIES_vat/\n"
        "  usd   USD stage with points in each frame, or --skeleton: OUT/SPECIES.usdc; needs the\n"
        "        extra `usd`",
        [
            "subsea-capture export fusilier --to gltf",
            "subsea-capture export fusilier --to vat --out game/Assets",
            "subsea-capture export spotted_eagle_ray --to usd --root baked",
        ],
    )
    parser.add_argument("species", metavar="SPECIES", help="species to export")
    parser.add_argument("--to", choices=["gltf", "vat", "usd"], required=True, help="format")
    parser.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        default=Path(),
        help="folder to write to (default: current folder)",
    )
    parser.add_argument(
        "--root",
        choices=["apart", "baked"],
        default="apart",
        help="store the path as motion of the root (default) or in the points",
    )
    parser.add_argument(
        "--fps",
        type=number_reader(float, 1.0, 240.0),
        metavar="F",
        help="frames per second of all clips (default: those of the species, such as 82.5)",
    )
    add_detail(parser, 0)
    add_gltf(parser)
    parser.add_argument(
        "--levels",
        action="store_true",
        help="gltf: also the coarser levels of detail, as SPECIES_LOD1 and so on (MSFT_lod)",
    )
    parser.add_argument(
        "--skeleton",
        action="store_true",
        help="usd: a skeleton (UsdSkel) instead of points in each frame",
    )
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code."""
    if options.skeleton and options.to != "usd":
        raise UserError(f"--skeleton is for --to usd, not {options.to}")
    if options.levels and (options.to != "gltf" or options.morph):
        raise UserError("--levels is for --to gltf, without --morph")
    if options.levels and options.detail == COARSEST:
        raise UserError(f"--detail {COARSEST} is the coarsest level: --levels needs a finer one")
    if options.to == "usd":
        require("usd", "USD")
        from subsea.export.usd import usd_files as files_of
    elif options.to == "vat":
        from subsea.export.vat import vat_files as files_of
    else:
        from subsea.export.gltf import gltf_files as files_of

    check_options(options, options.to)
    check_folder(options.out)
    model, clips = _clips(options, options.detail)
    for path in files_of(options.out, options.species):
        check_result(path, KINDS[path.suffix], options.force)
    if options.to == "gltf":
        return _export_gltf(options, model, clips)
    baked, notes = options.root == "baked", {}
    if options.to == "vat":
        from subsea.export.vat import write_vat

        files = write_vat(options.out, model, clips, baked)
    else:
        from subsea.export.usd import add_points, write_usd
        from subsea.export.usd_skeleton import add_skinned

        add_meshes, told = add_points, "exact"
        if options.skeleton:
            rig, told = _fitted(model, clips)
            add_meshes = partial(add_skinned, rig=rig)
        files = write_usd(options.out, model, clips, baked, add_meshes)
        notes[files[0]] = f", {told}"
    for path in files:
        print_line(f"{path}: {path.stat().st_size / 1e6:.1f} MB{notes.get(path, '')}")
    return 0


def _clips(options: argparse.Namespace, detail: int) -> tuple[Any, Any]:
    """Make the mesh of the species at a level of detail, and its clips at the chosen rate."""
    from subsea.export.clips import at_rate, make_clips

    model, clips = make_clips(options.species, detail)
    return model, clips if options.fps is None else [at_rate(clip, options.fps) for clip in clips]


def _fitted(model: Any, clips: Any) -> tuple[Any, str]:
    """Fit a skeleton to all clips; return it, and what is to be said of its error."""
    from tqdm import tqdm

    from subsea.export.clips import all_points
    from subsea.export.skinning import fit_skeleton

    bar = partial(tqdm, desc="fitting joints", unit="round", leave=False, disable=None)
    rig = fit_skeleton(model, all_points(clips), bar)
    return rig, (
        f"{len(rig.joints)} joints; vertices are off by {rig.rms_percent:.2f}% of the body "
        f"length (rms), {rig.most_percent:.2f}% at most"
    )


def _export_gltf(options: argparse.Namespace, model: Any, clips: Any) -> int:
    from subsea.export.clips import all_points
    from subsea.export.glb import packing_of
    from subsea.export.gltf import write_gltf
    from subsea.export.skinning import refit
    from subsea.fish.mesh import DETAILS

    packing = packing_of(options.compress)
    rig: Any = None  # with --morph
    told = "exact"
    if not options.morph:
        rig, told = _fitted(model, clips)
    levels = []
    for detail in range(options.detail + 1, len(DETAILS)) if options.levels else ():
        coarse, moved = _clips(options, detail)
        bound = refit(coarse, rig, all_points(moved))
        levels.append((coarse, bound))
        told += f"; level {len(levels)}: {bound.rms_percent:.2f}%, {bound.most_percent:.2f}%"
    path = write_gltf(options.out, model, clips, options.root == "baked", rig, packing, levels)
    print_line(f"{path}: {path.stat().st_size / 1e6:.1f} MB, {told}")
    return 0
