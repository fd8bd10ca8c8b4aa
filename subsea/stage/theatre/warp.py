"""Warps: triangle meshes that map points of a projector to points of the picture it shows.

A place is a point (x, y) of the projector, a source a point (u, v) of the picture. Both are shares
of width and height from the lower left corner.
"""

from itertools import product

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.base.errors import UserError
from subsea.kernels import kernel
from subsea.view.meshes import areas, cut
from subsea.view.rig import LEAST_AREA, Warp

TOLERANCE_PX = 0.2  # largest error of a mesh at the points of its grid
SLACK = 1e-3  # by which other programs' rounding may exceed 0 and 1
FOLDED = 1e-3  # share of a mesh that may be folded over: a wrinkle at the rim of a measurement
FARTHEST = 1e6  # of any coordinate
NEIGHBOURS = [step for step in product((-1, 0, 1), repeat=2) if step != (0, 0)]
_ONE_COLOUR = 1e-6  # share of a picture: a thousandth of its sides


def mesh(places: Array, sources: Array, triangles: Ints) -> Warp:
    """A warp of places (n, 2) and sources (n, 2), the same for both eyes; not yet checked."""
    with np.errstate(over="ignore"):
        vertices = np.column_stack([places, sources, sources]).astype(np.float32)
    return Warp(vertices, np.asarray(triangles, np.int32).reshape(-1, 3))


def from_grid(sources: Array, size: tuple[int, int]) -> Warp:
    """The warp of sources (h, w, 2) at the middles of a projector's cells, upper row first.

    Where the grid is smooth the mesh is coarse: its error is at most TOLERANCE_PX in a picture of
    `size`. Cells with an invalid corner (`without_invalid`) stay dark. The outermost points are
    extrapolated by half a cell to the border.
    """
    grid, x = _extrapolated(without_invalid(sources), axis=1)
    grid, y = _extrapolated(grid, axis=0)
    y = 1.0 - y
    blocks = _blocks(grid * np.array(size, np.float64), x, y, TOLERANCE_PX)
    left, top, right, bottom = blocks.T
    width = grid.shape[1]
    corners = np.stack([top * width + left, bottom * width + left])
    corners = np.concatenate([corners, [bottom * width + right, top * width + right]])
    used, numbers = np.unique(corners, return_inverse=True)
    a, b, c, d = numbers.reshape(4, -1)
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    places = np.stack([x[used % width], y[used // width]], axis=1)
    return mesh(places, grid.reshape(-1, 2)[used], triangles)


def identity() -> Warp:
    """The warp that changes nothing."""
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    return mesh(corners, corners, np.array([[0, 1, 2], [0, 2, 3]]))


def cropped(warp: Warp, part: tuple[float, float, float, float]) -> Warp:
    """The warp from the whole picture, if `warp` shows its part x, y, width, height."""
    x, y, width, height = part
    vertices = warp.vertices.copy()
    vertices[:, 2:] = vertices[:, 2:] * ([width, height] * 2) + ([x, y] * 2)
    return warp._replace(vertices=vertices)


def without_invalid(sources: Array) -> Array:
    """Sources (h, w, 2), NaN for infinite or far values and repeated (0, 0)."""
    with np.errstate(invalid="ignore"):  # signalling NaN warn when converted
        grid = np.array(sources, np.float64)
    u, v = grid[..., 0], grid[..., 1]
    zero = (u == 0) & (v == 0)
    none = ~((u > -1) & (u < 2) & (v > -1) & (v < 2)) | (zero & (zero.sum() > 1))
    grid[none] = np.nan
    return grid


def validated(warp: Warp, where: str) -> Warp:
    """The triangles that light something, clipped to the picture; else a UserError at `where`.

    Errors are a mesh with three quarters outside of the picture, one that is mostly without area
    or folded over, and one that shows next to nothing of the picture.
    """
    vertices, triangles = warp
    used = np.unique(triangles)
    points, count = vertices[used], len(used)
    if not count:
        raise UserError("an empty mesh, expected triangles that show something", file=where)
    if bad := int((~(np.abs(points) < FARTHEST)).any(axis=1).sum()):
        raise UserError(
            f"{bad} of {count} points of its mesh are nowhere near a picture", file=where
        )
    sizes = np.abs(areas(vertices[:, :2], triangles))
    lit = sizes > LEAST_AREA
    if 2 * lit.sum() < len(lit):
        raise UserError(f"{(~lit).sum()} of {len(lit)} triangles have no area", file=where)
    vertices, triangles = _clipped(vertices, triangles[lit])
    if np.abs(areas(vertices[:, :2], triangles)).sum() < sizes.sum() / 4:
        out = ((points[:, 2:] < -SLACK) | (points[:, 2:] > 1 + SLACK)).any(axis=1)
        raise UserError(f"{out.sum()} of {count} points have u or v outside 0 to 1", file=where)
    on = vertices[triangles][..., :2]
    seen = ((on.max(axis=1) > 0) & (on.min(axis=1) < 1)).all(axis=1)
    if not seen.any():
        raise UserError(f"none of its {len(lit)} triangles lies on the projector", file=where)
    places, sources = areas(vertices[:, :2], triangles), areas(vertices[:, 2:4], triangles)
    if np.abs(sources).sum() < _ONE_COLOUR:
        raise UserError("its u and v have no area, expected some of the picture", file=where)
    turn = np.sign(places) * np.sign(sources)
    folded = turn * np.sign(np.sum(turn * np.abs(places))) < 0
    if np.abs(places[folded]).sum() > FOLDED * np.abs(places).sum():
        raise UserError(f"{folded.sum()} of {len(folded)} triangles are folded over", file=where)
    return Warp(vertices, triangles)


def is_mirrored(warp: Warp) -> bool:
    """True if the picture is mirrored, as no projector on a stand or ceiling does."""
    places = areas(warp.vertices[:, :2], warp.triangles)
    shown = areas(warp.vertices[:, 2:4], warp.triangles)
    return bool(np.sum(np.sign(places) * shown) < 0)


def describe_warp(warp: Warp) -> str:
    """Its size, the lit share of the projector, and whether it mirrors, for a message."""
    lit = min(np.abs(areas(warp.vertices[:, :2], warp.triangles)).sum(), 1.0)
    mirrored = ", mirrored" if is_mirrored(warp) else ""
    count = len(warp.triangles)
    return f"a mesh of {count} triangle{'s' * (count != 1)}, {100 * lit:.0f}% lit{mirrored}"


def rasterized(warp: Warp, values: Array, size: tuple[int, int]) -> Array:
    """Values (n,) of the vertices over all pixels (h, w), upper row first; 0 where dark."""
    picture = np.zeros((size[1], size[0]))
    places, values = warp.vertices[:, :2].astype(np.float64), np.ascontiguousarray(values)
    _rasterize(places, warp.triangles, values, picture)
    return picture[::-1]


def continued(picture: Array, lit: Bools) -> Array:
    """A picture (h, w, c) that goes on steadily for a pixel beyond its `lit` (h, w) part.

    Where a mask is coarser than its projector, pixels at the edge of a mesh mix in what lies beyond
    it.
    """
    rows, columns = lit.shape
    wide, known = np.pad(picture, ((2, 2), (2, 2), (0, 0))), np.pad(lit, 2)
    total, count = np.zeros(picture.shape), np.zeros((rows, columns, 1))
    for down, across in NEIGHBOURS:
        near = np.s_[2 + down : 2 + down + rows, 2 + across : 2 + across + columns]
        far = np.s_[2 + 2 * down : 2 + 2 * down + rows, 2 + 2 * across : 2 + 2 * across + columns]
        steps = (known[near] & known[far])[..., None]
        total += known[near][..., None] * (wide[near] + steps * (wide[near] - wide[far]))
        count += known[near][..., None]
    return np.where(lit[..., None] | (count == 0), picture, total / np.maximum(count, 1))


def _extrapolated(grid: Array, axis: int) -> tuple[Array, Array]:
    """The grid with another first and last row, on the borders, and the positions of the rows."""
    rows = np.moveaxis(grid, axis, 0)
    count = len(rows)
    edges = []
    for outer, inner in ((0, 1), (-1, -2)):
        edge = rows[outer] + (rows[outer] - rows[inner]) / 2 if count > 1 else rows[outer]
        edge = np.where(np.isnan(edge), rows[outer], edge)
        lowest, highest = np.minimum(rows[outer], 0.0), np.maximum(rows[outer], 1.0)
        edges.append(np.clip(edge, lowest, highest)[None])
    rows = np.concatenate([edges[0], rows, edges[1]])
    at = np.concatenate([[0.0], (np.arange(count) + 0.5) / count, [1.0]])
    return np.ascontiguousarray(np.moveaxis(rows, 0, axis)), at


@kernel
def _blocks(grid: Array, x: Array, y: Array, tolerance: float) -> Ints:
    """Blocks (k, 4) of cells, left, top, right, bottom, that two triangles show well enough.

    Blocks are halved until they do. They lie side by side, with corners on each other's straight
    edges: no gap opens there.
    """
    found = [(0, 0, 0, 0)]
    found.pop()
    waiting = [(0, 0, grid.shape[1] - 1, grid.shape[0] - 1)]
    while len(waiting) > 0:
        left, top, right, bottom = waiting.pop()
        if _is_flat(grid, x, y, left, top, right, bottom, tolerance):
            found.append((left, top, right, bottom))
        elif right - left > 1 and right - left >= bottom - top:
            middle = (left + right) // 2
            waiting.append((left, top, middle, bottom))
            waiting.append((middle, top, right, bottom))
        elif bottom - top > 1:
            middle = (top + bottom) // 2
            waiting.append((left, top, right, middle))
            waiting.append((left, middle, right, bottom))
    blocks = np.empty((len(found), 4), np.int64)
    for k in range(len(found)):
        blocks[k, 0], blocks[k, 1], blocks[k, 2], blocks[k, 3] = found[k]
    return blocks


@kernel
def _is_flat(
    grid: Array, x: Array, y: Array, left: int, top: int, right: int, bottom: int, tolerance: float
) -> bool:
    """True if all points of a block exist and lie on its two triangles, up to a tolerance."""
    a, b = grid[top, left], grid[bottom, left]
    c, d = grid[bottom, right], grid[top, right]
    for row in range(top, bottom + 1):
        down = (y[row] - y[top]) / (y[bottom] - y[top])
        for column in range(left, right + 1):
            across = (x[column] - x[left]) / (x[right] - x[left])
            away = 0.0
            for k in range(2):
                if down >= across:
                    on = a[k] + down * (b[k] - a[k]) + across * (c[k] - b[k])
                else:
                    on = a[k] + across * (d[k] - a[k]) + down * (c[k] - d[k])
                away += (grid[row, column, k] - on) ** 2
            if not away <= tolerance * tolerance:  # nor where it is NaN
                return False
    return True


@kernel
def _rasterize(places: Array, triangles: Ints, values: Array, picture: Array) -> None:
    """Interpolate values over the pixels (height, width), lower row first, by their middles."""
    height, width = picture.shape
    for k in range(len(triangles)):
        i, j, m = triangles[k]
        ax, ay = places[i, 0] * width - 0.5, places[i, 1] * height - 0.5
        bx, by = places[j, 0] * width - 0.5 - ax, places[j, 1] * height - 0.5 - ay
        cx, cy = places[m, 0] * width - 0.5 - ax, places[m, 1] * height - 0.5 - ay
        area = bx * cy - by * cx
        if area == 0.0:
            continue
        first = max(int(np.ceil(ay + min(0.0, by, cy) - 1e-6)), 0)
        last = min(int(np.floor(ay + max(0.0, by, cy) + 1e-6)), height - 1)
        begin = max(int(np.ceil(ax + min(0.0, bx, cx) - 1e-6)), 0)
        end = min(int(np.floor(ax + max(0.0, bx, cx) + 1e-6)), width - 1)
        for row in range(first, last + 1):
            for column in range(begin, end + 1):
                px, py = column - ax, row - ay
                s = (px * cy - py * cx) / area
                t = (bx * py - by * px) / area
                if s >= -1e-6 and t >= -1e-6 and s + t <= 1 + 1e-6:
                    picture[row, column] = (
                        values[i] + s * (values[j] - values[i]) + t * (values[m] - values[i])
                    )


def _clipped(vertices: Array, triangles: Ints) -> tuple[Array, Ints]:
    """The parts of triangles whose sources lie in 0 to 1, up to SLACK."""
    shown = vertices[:, 2:]
    near = (shown > -SLACK) & (shown < 1 + SLACK)
    vertices = vertices.copy()
    vertices[:, 2:] = np.where(near, np.clip(shown, 0.0, 1.0), shown)
    for column in range(2, 6):
        vertices, triangles = cut(vertices, triangles, vertices[:, column])
        vertices, triangles = cut(vertices, triangles, 1 - vertices[:, column])
    vertices[:, 2:] = np.clip(vertices[:, 2:], 0.0, 1.0)
    return vertices, triangles
