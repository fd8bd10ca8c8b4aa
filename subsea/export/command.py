"""`subsea export`: write a scene of the dive for other programs."""

from argparse import ArgumentTypeError, BooleanOptionalAction, Namespace
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command, add_force, number_reader
from subsea.base.errors import UserError
from subsea.dive import arguments as shared
from subsea.export.options import add_detail, add_gltf

GROUP = "dive and film"  # in the help


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser = add_command(
        commands,
        "export",
        "export a scene to other programs",
        "Writes the fishes with their motion, the camera, sand, stone, corals and seaweed of any\n"
        "seconds of a dive: docs/how-to/export-scene.md. Frames are those of `subsea film`. Needs\n"
        "OpenGL but no display.\n"
        "Targets:\n"
        "  usd   USD stage with points in each frame: OUT.usdc or OUT.usdz; needs the extra `usd`\n"
        "  gltf  glTF 2.0 with a skeleton for each fish: OUT.glb\n"
        "  web   a folder with a page that shows the scene",
        [
            "subsea export peaceful --to usd --out reef.usdc --seconds 4",
            "subsea export preying --to gltf --out hunt.glb --start 20 --seconds 5 --fps 24",
            "subsea export schooling --to web --out school --tour school --with sand,stone",
        ],
    )
    parser.add_argument("scenario", metavar="SCENE", help="scenario: name or .toml file")
    parser.add_argument("--to", required=True, metavar="TARGET", help="usd, gltf or web")
    parser.add_argument("--out", type=Path, required=True, metavar="PATH", help="what to write")
    shared.add(parser, "set")
    source = parser.add_mutually_exclusive_group()
    shared.add(source, "tour")
    source.add_argument(
        "--record",
        type=Path,
        metavar="FILE.h5",
        help="replay a record of SCENE by `subsea simulate`; the submarine stands still",
    )
    shared.add(parser, "follow", "start")
    parser.add_argument(
        "--seconds",
        type=number_reader(float, 0.03, 3600),
        metavar="S",
        help="length of the scene (default 10, or to the end of a tour or record)",
    )
    shared.add(parser, "fps", "size", "fish", "seed")
    parser.add_argument(
        "--with",
        dest="groups",
        type=_groups,
        metavar="LIST",
        help="of sand, stone, corals (and sponges), seaweed; or none (default: all)",
    )
    add_detail(parser, 1)
    parser.add_argument(
        "--loop",
        action=BooleanOptionalAction,
        help="let all fishes swim back to the start, so that the scene repeats (default: for web)",
    )
    parser.add_argument(
        "--poses",
        type=number_reader(int, 1, 1000),
        metavar="N",
        help="usd: bake N poses of each species, and place instances of them",
    )
    add_gltf(parser)
    parser.add_argument(
        "--vat", action="store_true", help="gltf: a vertex animation texture of each species"
    )
    parser.add_argument(
        "--instances",
        action="store_true",
        help="gltf: copies of corals and seaweed as EXT_mesh_gpu_instancing",
    )
    add_force(parser)
    parser.set_defaults(run=run)


def _groups(text: str) -> tuple[str, ...]:
    if text == "none":
        return ()
    names = tuple(name.strip() for name in text.split(","))
    if not all(names):
        raise ArgumentTypeError(f"{text!r} is not a list such as sand,stone, or none")
    return names


def run(options: Namespace) -> int:
    """Export the scene."""
    from subsea.export.options import SceneOptions
    from subsea.export.recording import SceneFilmOptions, export_scene
    from subsea.export.scene import GROUPS
    from subsea.scenario.load import load_scenario

    if options.record is not None:
        given = [name for name in ("changes", "seed", "fish") if getattr(options, name)]
        if given:
            name = "set" if given[0] == "changes" else given[0]
            raise UserError(f"--{name} cannot be combined with --record, which holds its own")
    options.size = options.size or shared.SIZE
    options.groups = GROUPS if options.groups is None else options.groups
    options.loop = options.to == "web" if options.loop is None else options.loop
    options.loaded = load_scenario(options.scenario, options.changes)
    film = SceneFilmOptions(**shared.fields_of(SceneFilmOptions, options))
    return export_scene(options.to, film, SceneOptions(**shared.fields_of(SceneOptions, options)))
