"""Triangle meshes of patches: cut them at lines, and lay them where a patch is adjusted."""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.view.adjustment import PatchAdjustment, moved
from subsea.view.rig import LEAST_AREA, DisplayPatch, Projection, Warp, carried

PIECES = 10  # of a cell of a grid of points: shifts of 20 pixels are followed within a fifth of one


def areas(points: Array, triangles: Ints) -> Array:
    """Compute signed areas (m,) of triangles of points (n, 2)."""
    a, b, c = np.moveaxis(points[triangles].astype(np.float64), 1, 0)
    across, up = b - a, c - a
    return np.asarray((across[:, 0] * up[:, 1] - across[:, 1] * up[:, 0]) / 2)


def subdivided(warp: Warp, across: int, up: int, columns: tuple[int, int] = (2, 3)) -> Warp:
    """Cut the triangles of a warp at the columns and rows of a regular grid over the unit square.

    `columns` are those of the vertices whose values are cut: (2, 3) the left source, (0, 1) the
    place.
    """
    vertices, triangles = warp
    for column, pieces in zip(columns, (across, up), strict=True):
        for k in range(1, pieces):
            depth = vertices[:, column] - k / pieces
            sides = depth[triangles]
            crossed = (sides.min(axis=1) < 0) & (sides.max(axis=1) > 0)
            parts = [triangles[~crossed]]
            for side in (1.0, -1.0):
                vertices, half = cut(vertices, triangles[crossed], side * depth)
                parts.append(half[np.abs(areas(vertices[:, :2], half)) > LEAST_AREA])
                depth = vertices[:, column] - k / pieces
            triangles = np.concatenate(parts)
    used, numbers = np.unique(triangles, return_inverse=True)
    return Warp(vertices[used], numbers.reshape(-1, 3).astype(np.int32))


def cut(vertices: Array, triangles: Ints, depth: Array) -> tuple[Array, Ints]:
    """Keep the parts of triangles where `depth` (n,) is not negative; a cut edge gets a vertex."""
    inside = depth[triangles] >= 0
    count = inside.sum(axis=1)
    kept = [triangles[count == 3]]
    for inner in (1, 2):
        some, within = triangles[count == inner], inside[count == inner]
        alone = np.argmax(within if inner == 1 else ~within, axis=1)
        order = (alone[:, None] + np.arange(3)) % 3
        a, b, c = np.take_along_axis(some, order, axis=1).T
        new = []
        for other in (b, c):
            low, high = np.minimum(a, other), np.maximum(a, other)  # alike for both neighbours
            share = (depth[low] / (depth[low] - depth[high]))[:, None]
            new.append(len(vertices) + np.arange(len(a), dtype=np.int32))
            cut_at = vertices[low] + share * (vertices[high] - vertices[low])
            vertices = np.concatenate([vertices, cut_at.astype(np.float32)])
        if inner == 1:
            kept.append(np.stack([a, new[0], new[1]], axis=1))
        else:
            kept.append(np.stack([new[0], b, c], axis=1))
            kept.append(np.stack([new[0], c, new[1]], axis=1))
    return vertices, np.concatenate(kept).astype(np.int32)


def grid_triangles(columns: int, rows: int) -> Ints:
    """List the triangles (n, 3) of a grid of nodes, row after row."""
    a = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    low = np.stack([a, a + 1, a + columns + 1], axis=1)
    return np.concatenate([low, np.stack([a, a + columns + 1, a + columns], axis=1)])


def fine_mesh(patch: DisplayPatch) -> Warp | None:
    """Return the mesh of a patch, cut so that it can follow its adjustment; None: it needs none."""
    adjustment = patch.adjustment
    if adjustment is None or not adjustment.moves:
        return patch.warp
    across = up = 1
    if adjustment.points is not None:
        up, across = (PIECES * (count - 1) for count in adjustment.points.shape[:2])
    if patch.warp is None:
        return _straight(patch, across, up)
    return subdivided(patch.warp, across, up, columns=(0, 1))


def lit_places(patch: DisplayPatch, mesh: Warp) -> Array:
    """Find where the vertices of a patch's `fine_mesh` are lit: (n, 3) as of `moved`."""
    return moved(patch.adjustment or PatchAdjustment(), mesh.vertices[:, :2])


def unmoved(patch: DisplayPatch, place: tuple[float, float]) -> Array:
    """Find the place (2,) of a patch's picture that is lit at a share of its rectangle, or NaN."""
    found = np.asarray(place, np.float64)
    if patch.adjustment is None or not patch.adjustment.moves:
        return found
    mesh = fine_mesh(patch)
    assert mesh is not None  # as it moves
    lit = lit_places(patch, mesh)
    return carried(lit[:, :2] / lit[:, 2:], mesh.vertices[:, :2], mesh.triangles, found[None])[0]


def shown_size(patch: DisplayPatch) -> tuple[float, float]:
    """Width and height of a patch's picture, were it not squeezed, in pixels."""
    width, height = patch.place[2] * patch.squeezed[0], patch.place[3] * patch.squeezed[1]
    turned = patch.adjustment is not None and patch.adjustment.on_its_side
    return (height, width) if turned else (width, height)


def _straight(patch: DisplayPatch, across: int, up: int) -> Warp:
    """Make the mesh that shows the picture of a patch without a warp as it is."""
    x, y = np.meshgrid(np.linspace(0, 1, across + 1), np.linspace(0, 1, up + 1))
    places = np.stack([x, y], axis=-1).reshape(-1, 2)
    sources = places
    if patch.shape == Projection.DOME:  # a mesh shows the whole square of a dome
        size = np.array(shown_size(patch))
        sources = 0.5 + (places - 0.5) * size / size.min()
    vertices = np.column_stack([places, sources, sources]).astype(np.float32)
    return Warp(vertices, grid_triangles(across + 1, up + 1))
