"""The two coarsest levels of a fish: a speck of 28 control points, and a dot of 9.

Both have control points as vertices, without spline weights, slopes or paired fins, and are lit per
vertex. Their colours come from the coarsest mipmap of the skin, so that they do not flicker.
"""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.fish import sheet_layout
from subsea.fish.mesh import ABSENT
from subsea.fish.surface import (
    DORSAL,
    FIN_V,
    RIGHT,
    TAIL_COLUMNS,
    VENTRAL,
    SurfacePlan,
    U,
    V,
    rest_control_points,
)
from subsea.geometry.curves import greville
from subsea.rendering.fish.atlas import inside

LAYOUT = "3f4 3f4", "a_normal", "a_part"

RINGS = 3, 6, 9  # columns of a speck with four vertices each ...
GIRTH = 6  # ... and that of a dot
ROOT, EDGE = V - TAIL_COLUMNS - 1, V - 1  # first and last column of the tail fin
BACK, FLANK, BELLY = 0, V * (U // 2), V * (U - 1)  # the first points of these rows
# Length of the normals on back and belly: shorter, because flanks bend only near them.
RIDGE = 0.6
FIN_COLUMNS = 3, 8  # of the free edge of a dorsal or ventral fin
AHEAD, UP, ASIDE = np.eye(3)
NORMALS = RIDGE * UP, ASIDE, -RIDGE * UP, -ASIDE  # of a ring
SIDES = [(k, (k + 1) % 4) for k in range(4)]  # of a ring, all counter-clockwise from outside
COLUMNS = 200  # of a body whose area is measured


class Speck(NamedTuple):
    """Vertices and triangles of a coarse fish, common to all species."""

    points: Ints  # (n,) the control point of each vertex
    # (n,) the point from which a vertex is moved: of the edge of a fin at its root, of a dot's ring
    # opposite, else its own
    roots: Ints
    normals: Array  # (n, 3) in body axes; on fins of either side
    thin: Bools  # (n,) True for vertices of fins
    fin: Ints  # (n,) 1 on the dorsal and 2 on the ventral fin, which a species may lack; else 0
    triangles: Ints  # (m, 3) int32, both sides of fins

    @property
    def vertices(self) -> Array:
        """(n, 6) float32, columns as LAYOUT."""
        return np.column_stack([self.normals, self.points, self.roots, self.thin]).astype("f4")


def speck() -> Speck:
    """Build a snout, three rings of back, flanks and belly, the root of the tail, and flat fins."""
    points, normals = [FLANK], [AHEAD]
    for column in RINGS:
        points += _ring(column)
        normals += NORMALS
    points += [BACK + ROOT, BELLY + ROOT]
    normals += [RIDGE * UP, -RIDGE * UP]
    body = len(points)
    points += [row + ROOT for row in (BACK, BELLY)] + [row + EDGE for row in (BACK, FLANK, BELLY)]
    for fin in (DORSAL, VENTRAL):
        root, edge = fin.start, fin.start + FIN_V
        points += [root, *(edge + column for column in FIN_COLUMNS), root + FIN_V - 1]
    risen = np.isin(
        points, np.add.outer([DORSAL.start, VENTRAL.start], FIN_V + np.array(FIN_COLUMNS))
    )
    normals += [ASIDE] * (len(points) - body)
    count = np.arange(len(points))
    first = 1 + 4 * np.arange(len(RINGS))
    closed = [(0, first[0] + a, first[0] + b) for a, b in SIDES]
    for ring in first[:-1]:
        for a, b in SIDES:
            closed += [(ring + a, ring + 4 + a, ring + b), (ring + b, ring + 4 + a, ring + 4 + b)]
    top, right_side, bottom, left_side = first[-1] + np.arange(4)
    over, under = body - 2, body - 1
    closed += [
        (top, over, right_side), (right_side, over, under), (right_side, under, bottom),
        (bottom, under, left_side), (left_side, under, over), (left_side, over, top),
    ]  # fmt: skip
    flat = [(0, 2, 3), (0, 3, 1), (1, 3, 4)] + [
        (begin + a, begin + b, begin + c) for begin in (5, 9) for a, b, c in ((0, 1, 2), (0, 2, 3))
    ]
    thin = body + np.array(flat)
    return Speck(
        points=np.array(points),
        roots=np.array(points) - FIN_V * risen,
        normals=np.array(normals),
        thin=count >= body,
        fin=np.where(count < body + 5, 0, np.where(count < body + 9, 1, 2)),
        triangles=np.concatenate([np.array(closed), thin, thin[:, ::-1]]).astype("i4"),
    )


def dot() -> Speck:
    """Build a snout, one ring, the root of the tail, and a tail of one triangle."""
    ring, tail = _ring(GIRTH), [FLANK + ROOT, BACK + EDGE, BELLY + EDGE]
    points = np.array([FLANK, *ring, FLANK + ROOT, *tail])
    count = np.arange(len(points))
    closed = [(0, 1 + a, 1 + b) for a, b in SIDES] + [(5, 1 + b, 1 + a) for a, b in SIDES]
    return Speck(
        points=points,
        roots=np.array([FLANK, *ring[2:], *ring[:2], FLANK + ROOT, *tail]),
        normals=np.array([AHEAD, *NORMALS, -AHEAD, *[ASIDE] * len(tail)]),
        thin=count > 5,
        fin=np.zeros(len(points), int),
        triangles=np.array([*closed, (6, 7, 8), (6, 8, 7)], "i4"),
    )


def _ring(column: int) -> list[int]:
    """The points of back, right flank, belly and left flank in a column."""
    return [BACK + column, RIGHT.start + FLANK + column, BELLY + column, FLANK + column]


def places(plan: SurfacePlan, shape: Speck) -> Array:
    """Compute the data (n, 4) of a species at the vertices of a speck or a dot.

    Texture coordinates as shares of its cell, ABSENT or 0, and how far the ring of a dot is moved
    out, as a multiple of the way from the opposite point; 0 elsewhere.
    """
    points = rest_control_points(plan, 1.0, 0.0)[shape.points]
    height = points[:, 1]
    if plan.wing:
        height = sheet_layout.unfold(
            plan, points[:, 2], np.where(shape.normals[:, 1] < 0.0, 0.0, 1.0)
        )
    front, rear = sheet_layout.borders(plan)
    top = sheet_layout.half_height(plan)
    out = np.zeros((len(points), 4))
    within = np.stack([(-points[:, 0] - front) / (rear - front), (height + top) / (2.0 * top)], 1)
    out[:, :2] = inside(sheet_layout.BODY, within)
    for number, start, fin, frame in (
        (1, DORSAL.start, plan.dorsal, sheet_layout.DORSAL),
        (2, VENTRAL.start, plan.ventral, sheet_layout.VENTRAL),
    ):
        mine = shape.fin == number
        row, column = np.divmod(shape.points[mine] - start, FIN_V)
        out[mine, :2] = inside(frame, np.stack([greville(FIN_V)[column], row], 1))
        out[mine, 2] = 0.0 if fin else ABSENT
    moved = ~shape.thin & (shape.roots != shape.points)
    if moved.any():
        out[moved, 3] = np.tile(_swelling(plan), 2)
    return out


def _swelling(plan: SurfacePlan) -> tuple[float, float]:
    """Find how far the ring of a dot is moved out upward and aside, to cover as much as a speck."""
    rest = rest_control_points(plan, 1.0, 0.0)
    has = np.array([True, plan.dorsal is not None, plan.ventral is not None])
    factors = []
    for axis in (1, 2):
        (finer, fork), (body, tail) = (
            _covered(rest[shape.points][:, [0, axis]], shape, has) for shape in (speck(), dot())
        )
        factors.append(0.5 + 0.5 * (finer + fork - tail) / body)
    return factors[0], factors[1]


def _covered(points: Array, shape: Speck, has: Bools) -> tuple[float, float]:
    """Measure the areas of body with fins, and of the tail, of points (n, 2) seen from a side.

    Between its highest and lowest edges a body with fins has no gap. `has` tells for each value of
    `Speck.fin` whether it is there.
    """
    tail = (shape.thin & (shape.fin == 0))[shape.triangles].all(axis=1)
    drawn = has[shape.fin][shape.triangles].all(axis=1) & ~tail
    ends = points[shape.triangles[drawn][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)]
    (x0, y0), (x1, y1) = ends[:, 0].T, ends[:, 1].T
    rear, front = ends[..., 0].min(), ends[..., 0].max()
    along = rear + (front - rear) * (np.arange(COLUMNS) + 0.5) / COLUMNS
    share = (along[:, None] - x0) / np.where(x0 == x1, np.nan, x1 - x0)
    height = np.where((share >= 0.0) & (share <= 1.0), y0 + share * (y1 - y0), np.nan)
    extent = np.nanmax(height, axis=1) - np.nanmin(height, axis=1)
    a, b, c = (points[shape.triangles[tail, k]] for k in range(3))
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    # A triangle has half the area of the parallelogram, and is listed on both sides.
    return float(extent.mean() * (front - rear)), 0.25 * float(np.abs(ux * vy - uy * vx).sum())
