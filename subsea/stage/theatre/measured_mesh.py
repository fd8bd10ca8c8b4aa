"""The content of a warp file of any format."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Ints
from subsea.base.errors import UserError
from subsea.stage.theatre.view_angles import ViewAngles
from subsea.stage.theatre.warp import mesh, validated, without_invalid
from subsea.view.rig import Warp

MAX_NODES = 2**20  # of a mesh that lists its nodes
MAX_TRIANGLES = 2**22


class MeasuredMesh(NamedTuple):
    """A warp, and what else its file says of the projector."""

    warp: Warp
    mask: NDArray[np.float32] | None = None  # (h, w, 4) as `rig.DisplayPatch` has it
    view: ViewAngles | None = None  # the view that the mesh bends
    notes: tuple[str, ...] = ()  # a line for each thing that is left out


def grid_triangles(columns: int, rows: int) -> Ints:
    """Triangles (n, 3) of a grid of nodes, row after row."""
    a = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    low = np.stack([a, a + 1, a + columns + 1], axis=1)
    return np.concatenate([low, np.stack([a, a + columns + 1, a + columns], axis=1)])


def strip_triangles(strip: Ints) -> Ints:
    """Triangles (n, 3) of a strip of indices, without those that turn a corner."""
    three = np.stack([strip[:-2], strip[1:-1], strip[2:]], axis=1)
    a, b, c = three.T
    return three[(a != b) & (b != c) & (a != c)]


def node_mesh(places: Array, sources: Array, triangles: Ints, where: str) -> Warp:
    """The warp of nodes (n, 2); those that show no part of the picture are left out."""
    shown = without_invalid(np.asarray(sources, np.float64)[None])[0]
    with np.errstate(invalid="ignore"):
        used = ~np.isnan(shown[:, 0]) & np.isfinite(places).all(axis=1)
    triangles = np.asarray(triangles, np.int64).reshape(-1, 3)
    if triangles.size and not (triangles.min() >= 0 and triangles.max() < len(places)):
        raise UserError(f"a triangle of nodes beyond the {len(places)} of its mesh", file=where)
    kept = triangles[used[triangles].all(axis=1)]
    return validated(mesh(places, np.nan_to_num(shown), kept), where)


def bounded_grid(columns: int, rows: int, where: str) -> None:
    """Refuse a grid of fewer than 2×2 nodes or of more than MAX_NODES."""
    if min(columns, rows) < 2 or columns * rows > MAX_NODES:
        raise UserError(f"{columns}×{rows} nodes, expected 2×2 to {MAX_NODES} in all", file=where)


def numbers_of(words: Sequence[str], count: int, at: str, names: str) -> list[float]:
    """The first `count` words as numbers; else a UserError at `at` that lists `names`."""
    try:
        return [float(words[k]) for k in range(count)]
    except (ValueError, IndexError) as fault:
        raise UserError(f"{at}: expected the numbers {names}") from fault
