"""Motion in a picture: where the place that a pixel shows is in an earlier or later picture.

The surface that a pixel shows is found by the depth that was drawn. A fish bends, so its triangles
are drawn once more here, with their corners before and after; what stands still moves with the
camera alone.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.dive.ride import VALUES
from subsea.frame.packet import ROW_A, ROW_B, instances_of
from subsea.geometry.rotation import matrix as turn_matrix
from subsea.kernels import kernel
from subsea.rendering.fish.bodies import Shapes, Vertices
from subsea.view.optics import Optics, pixel_grid
from subsea.world.world import World

SEEN = 0.5  # opacity from which a pixel shows a body and not what is behind it
NEAR_CM = 1.0  # nearer things are not drawn


class FlowMoment(NamedTuple):
    """The camera and the bodies at a time."""

    matrix: Array  # (4, 4) from the world to the axes of the camera, x right, y down, z ahead
    instances: Array  # (n, 30) of bodies
    points: Array  # (rows, 426, 3) control points, to whose rows the instances refer


def moment_of(world: World, matrix: Array, alpha: float) -> FlowMoment:
    """Keep the bodies of all fishes, `alpha` of the way from the last tick to the current one."""
    instances = instances_of(world, np.arange(len(world.state.fishes.species)), alpha)
    # Rows of simulated fishes change with each tick, and the whole table is large.
    rows, index = np.unique(instances[:, [ROW_A, ROW_B]].astype(np.int64), return_inverse=True)
    instances[:, [ROW_A, ROW_B]] = index.reshape(-1, 2)
    return FlowMoment(matrix, instances, world.library.control_points[rows])


class SeenMaps(NamedTuple):
    """The identities and depths that a camera sees."""

    optics: Optics
    matrix: Array  # (4, 4) from the world to the axes of the camera
    identity: Ints  # (h, w)
    depth: Array  # (h, w) cm along the axis, infinite in open water


class Bodies(NamedTuple):
    """Bodies of one level of detail."""

    vertices: Vertices
    others: tuple[Array, Array]  # (n, m, 3) places of the vertices at two other times
    triangles: Ints  # (k, 3)
    values: Ints  # (n,) identities


class Coverage(NamedTuple):
    """The pixels of a picture (h, w) that bodies cover."""

    gap_cm: Array  # (h, w) between the depth that is drawn and that of the nearest triangle
    moved: Array  # (h, w, 6) cm, world: the same place of the skin a tick before and after
    stamp: Ints  # (h, w) for `cover`


def empty_coverage(size: tuple[int, int]) -> Coverage:
    """Make the coverage of a picture before any body."""
    shape = size[::-1]
    return Coverage(
        np.full(shape, np.inf, np.float32), np.full((*shape, 6), np.nan), np.zeros(shape, np.int64)
    )


@kernel
def cover(
    pixels: Array, corners: Array, triangles: Ints, others: Array, values: Ints,
    seen: tuple[Ints, Array], coverage: tuple[Array, Array, Ints], mark: int,
) -> Ints:  # fmt: skip
    """Enter bodies into a coverage; returns how many pixels of each are hidden (n,).

    `pixels` (n, m, 2) are the vertices in the picture, `corners` (n, m, 2) their depths, cm or NaN,
    and opacities, `others` (n, m, 6) the vertices a tick before and after, `values` (n,) the
    identities, `seen` the maps of identity and depth (h, w). `mark` is a number that no call before
    had, and the next n.
    """
    identity, depth = seen
    gap, moved, stamp = coverage
    high, wide = identity.shape
    hidden = np.zeros(len(values), np.int64)
    for i in range(len(values)):
        for k in range(len(triangles)):
            a, b, c = triangles[k]
            za, zb, zc = corners[i, a, 0], corners[i, b, 0], corners[i, c, 0]
            if not (za > 0.0 and zb > 0.0 and zc > 0.0):
                continue
            ax, ay = pixels[i, a, 0], pixels[i, a, 1]
            bx, by = pixels[i, b, 0] - ax, pixels[i, b, 1] - ay
            cx, cy = pixels[i, c, 0] - ax, pixels[i, c, 1] - ay
            area = bx * cy - cx * by
            if abs(area) < 1e-12:
                continue
            left = max(int(np.ceil(ax + min(0.0, bx, cx))), 0)
            right = min(int(np.floor(ax + max(0.0, bx, cx))), wide - 1)
            top = max(int(np.ceil(ay + min(0.0, by, cy))), 0)
            bottom = min(int(np.floor(ay + max(0.0, by, cy))), high - 1)
            for y in range(top, bottom + 1):
                for x in range(left, right + 1):
                    own = identity[y, x] == values[i]
                    if not own and stamp[y, x] == mark + i:
                        continue
                    px, py = x - ax, y - ay
                    s = (px * cy - cx * py) / area
                    t = (bx * py - px * by) / area
                    if s < 0.0 or t < 0.0 or s + t > 1.0:
                        continue
                    wa, wb, wc = (1.0 - s - t) / za, s / zb, t / zc
                    z = 1.0 / (wa + wb + wc)
                    if own:
                        off = abs(z - depth[y, x])
                        if off < gap[y, x]:
                            gap[y, x] = off
                            for q in range(6):
                                moved[y, x, q] = z * (
                                    wa * others[i, a, q] + wb * others[i, b, q]
                                    + wc * others[i, c, q]
                                )  # fmt: skip
                    elif depth[y, x] < z:
                        opacity = wa * corners[i, a, 1] + wb * corners[i, b, 1]
                        if z * (opacity + wc * corners[i, c, 1]) < SEEN:
                            continue
                        stamp[y, x] = mark + i
                        hidden[i] += 1
    return hidden


def enter_bodies(seen: SeenMaps, bodies: Bodies, coverage: Coverage, mark: int) -> Ints:
    """Enter bodies into a coverage; returns how many pixels of each (n,) are hidden.

    `mark` is a number that no call before had, and the next n.
    """
    points, opacity = carried(seen.matrix, bodies.vertices.places), bodies.vertices.opacity
    drawn = ~np.isnan(opacity) & (points[..., 2] > NEAR_CM)
    depths = np.where(drawn, points[..., 2], np.nan)
    return np.asarray(
        cover(
            seen.optics.project(points),
            np.stack([depths, opacity], axis=-1), bodies.triangles,
            np.concatenate(bodies.others, axis=-1), bodies.values,
            (seen.identity, seen.depth), tuple(coverage), mark,
        )
    )  # fmt: skip


def skin_moved(
    seen: SeenMaps,
    shapes: Shapes,
    now: FlowMoment,
    others: tuple[FlowMoment, FlowMoment],
    who: Ints,
    levels: Ints,
) -> Array:
    """Find the place of the skin (h, w, 6) of each pixel at two other times, NaN where unknown.

    `who` (n,) are the numbers of the fishes in the picture, once each, `levels` (n,) their levels
    of detail. The moments hold all fishes.
    """
    coverage, mark = empty_coverage(seen.optics.size), 1
    for level in np.unique(levels):
        shown = who[levels == level]
        vertices, *moved = (
            shapes.at(int(level), one.instances[shown], one.points) for one in (now, *others)
        )
        places = moved[0].places, moved[1].places
        bodies = Bodies(vertices, places, shapes.triangles[level], VALUES["fish"] + shown)
        enter_bodies(seen, bodies, coverage, mark)
        mark += len(shown)
    return coverage.moved


def body_flow(
    seen: SeenMaps, moved: Array, now: FlowMoment, who: Ints, others: Sequence[FlowMoment]
) -> list[Array]:
    """Compute the motion (h, w, 2), pixels to the right and down, to each of two other moments.

    `moved` is that of a `Coverage`, `who` (n,) are the numbers of the bodies of the moments. All
    but fishes are taken to stand still. NaN behind the camera.
    """
    optics, identity, depth = seen.optics, seen.identity, seen.depth
    row, column = np.nonzero(identity >= VALUES["fish"])
    pixels = np.stack([column, row], axis=-1).astype(np.float64)
    begin, way = optics.rays(pixels)
    skin = begin + (depth[row, column].astype(np.float64) - begin[:, 2])[:, None] * way
    back = np.linalg.inv(now.matrix)
    world = skin @ back[:3, :3].T + back[:3, 3]
    flows = []
    for which, other in enumerate(others):
        flow = still_flow(optics, depth, now.matrix, other.matrix)
        ends = moved[row, column, 3 * which : 3 * which + 3]
        missing = np.isnan(ends[:, 0])
        numbers = identity[row, column][missing] - VALUES["fish"]
        ends[missing] = _as_rigid(world[missing], numbers, who, now.instances, other.instances)
        flow[row, column] = optics.project(carried(other.matrix, ends)) - pixels
        flows.append(flow)
    return flows


def still_flow(optics: Optics, depth: Array, now: Array, other: Array) -> Array:
    """Motion (h, w, 2) of what stands still, between two matrices (4, 4) of the camera."""
    if np.array_equal(other, now):
        return np.zeros((*depth.shape, 2), np.float32)
    change = other @ np.linalg.inv(now)
    far = ~np.isfinite(depth)[..., None]
    points = optics.points(depth)
    seen = points @ change[:3, :3].T + np.where(far, 0.0, change[:3, 3])
    return np.asarray(optics.project(seen) - pixel_grid(optics.size), np.float32)


def _as_rigid(points: Array, numbers: Ints, who: Ints, now: Array, other: Array) -> Array:
    """Carry points (m, 3) of bodies as if these were rigid; for bodies of a few pixels."""
    if not len(points):
        return points
    order = np.argsort(who)
    row = order[np.searchsorted(who[order], numbers)]
    ends = np.empty_like(points)
    for i in np.unique(row):
        mine = row == i
        before, after = (turn_matrix(one[i, 4:8].astype(np.float64)) for one in (now, other))
        body = (points[mine] - now[i, :3]) @ before
        ends[mine] = other[i, :3] + body @ after.T
    return ends


def carried(matrix: Array, points: Array) -> Array:
    """Carry points (…, 3) by a matrix (4, 4)."""
    return np.asarray(points @ matrix[:3, :3].T + matrix[:3, 3])
