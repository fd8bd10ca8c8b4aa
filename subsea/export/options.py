"""Options of formats: those that both export commands have, and which format each belongs to."""

from dataclasses import dataclass
from typing import Any

from subsea.base.command_line import number_reader
from subsea.base.errors import UserError
from subsea.export import COMPRESSIONS, PLAIN

FORMAT_OF = dict.fromkeys(("morph", "vat", "compress", "instances"), "gltf") | {"poses": "usd"}


@dataclass(frozen=True)
class SceneOptions:
    """Options of the format of a scene."""

    force: bool = False  # replace files of other kinds
    morph: bool = False  # gltf: morph targets instead of skeletons
    vat: bool = False  # gltf: a vertex animation texture for each species
    compress: str = PLAIN  # gltf: one of COMPRESSIONS
    instances: bool = False  # gltf: copies of corals and seaweed by EXT_mesh_gpu_instancing
    poses: int | None = None  # usd: bake this many poses of each species, and place instances


def check_options(options: Any, target: str) -> None:
    """Refuse options of other formats than `target`."""
    for name, owner in FORMAT_OF.items():
        idle = getattr(SceneOptions, name)
        if owner != target and getattr(options, name, idle) != idle:
            raise UserError(f"--{name} is for --to {owner}, not {target}")


def add_detail(parser: Any, level: int) -> None:
    """Add --detail with a default level."""
    parser.add_argument(
        "--detail",
        type=number_reader(int, 0, 3),
        default=level,
        metavar="N",
        help=f"level of detail, 0 is the finest (default {level})",
    )


def add_gltf(parser: Any) -> None:
    """Add the options of glTF files of a species and of a scene."""
    parser.add_argument(
        "--morph", action="store_true", help="gltf: morph targets instead of skeletons"
    )
    parser.add_argument(
        "--compress",
        choices=COMPRESSIONS,
        default=PLAIN,
        help="gltf: round numbers, or compress them and colours; needs the extra `meshopt` "
        "(default none)",
    )
