"""The interface of a format of scenes: checks, an estimate of its bytes, and writing."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from subsea.base.errors import UserError
from subsea.export.scene import Scene


@dataclass(frozen=True)
class SceneOptions:
    """Options of a format; `SceneWriter.check` refuses those that it does not have."""

    force: bool = False  # replace files of other kinds
    morph: bool = False  # gltf: morph targets instead of skeletons
    vat: bool = False  # gltf: a vertex animation texture for each species
    compress: str = "none"  # gltf: a name of `packing.COMPRESSIONS`
    instances: bool = False  # gltf: copies of corals and seaweed by EXT_mesh_gpu_instancing
    poses: int | None = None  # usd: bake this many poses of each species, and place instances


OF_GLTF = "morph", "vat", "compress", "instances"
OF_USD = ("poses",)


def check_options(options: SceneOptions, target: str, own: Sequence[str]) -> None:
    """Refuse options of other formats than `target`; `own` are the names of those that it has."""
    for name in (*OF_GLTF, *OF_USD):
        if name not in own and getattr(options, name) != getattr(SceneOptions(), name):
            other = "gltf" if name in OF_GLTF else "usd"
            raise UserError(f"--{name} is for --to {other}, not {target}")


class SceneExtent(NamedTuple):
    """The size of a scene before it is recorded."""

    frames: int
    vertices: tuple[int, ...]  # of the mesh of each fish
    triangles: tuple[int, ...]  # likewise
    species: tuple[int, ...]  # a number for the species of each fish


class SceneWriter(NamedTuple):
    """A format of scenes. `out` is the path of `--out`: a file or a folder, as the format wants."""

    # (out, options) before any work: UserError for a wrong suffix, a missing extra, options of
    # other formats, and files that may not be replaced.
    check: Callable[[Path, SceneOptions], None]
    # (extent, options) -> bytes of all fishes and their textures, within a factor of 1.5.
    estimate: Callable[[SceneExtent, SceneOptions], int]
    # (scene, out, options) -> the written files. Nothing is left half-written.
    write: Callable[[Scene, Path, SceneOptions], list[Path]]
