"""The coarsest level of a fish, a few pixels large: 28 control points as vertices.

It has no spline weights, slopes or paired fins, and is lit per vertex. Its colours come from the
coarsest mipmap of the skin, so that it does not flicker.
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

RINGS = 3, 6, 9  # columns of the body with four vertices each
ROOT, EDGE = V - TAIL_COLUMNS - 1, V - 1  # first and last column of the tail fin
# Length of the normals on back and belly: shorter, because flanks bend only near them.
RIDGE = 0.6
FIN_COLUMNS = 3, 8  # of the free edge of a dorsal or ventral fin


class Speck(NamedTuple):
    """Vertices and triangles of a speck, common to all species."""

    points: Ints  # (n,) the control point of each vertex
    roots: Ints  # (n,) for the edge of a fin the point at its root, else the same
    normals: Array  # (n, 3) in body axes; on fins of either side
    thin: Bools  # (n,) True for vertices of fins
    fin: Ints  # (n,) 1 on the dorsal and 2 on the ventral fin, which a species may lack; else 0
    triangles: Ints  # (m, 3) int32, both sides of fins

    @property
    def vertices(self) -> Array:
        """(n, 6) float32, columns as LAYOUT."""
        return np.column_stack([self.normals, self.points, self.roots, self.thin]).astype("f4")


def speck() -> Speck:
    """Snout, three rings of back, flanks and belly, the root of the tail, and flat fins."""
    ahead, up, right = np.eye(3)
    back, flank, belly = 0, V * (U // 2), V * (U - 1)  # the first points of these rows
    points, normals = [flank], [ahead]
    for column in RINGS:
        points += [back + column, RIGHT.start + flank + column, belly + column, flank + column]
        normals += [RIDGE * up, right, -RIDGE * up, -right]
    points += [back + ROOT, belly + ROOT]
    normals += [RIDGE * up, -RIDGE * up]
    body = len(points)
    points += [row + ROOT for row in (back, belly)] + [row + EDGE for row in (back, flank, belly)]
    for fin in (DORSAL, VENTRAL):
        root, edge = fin.start, fin.start + FIN_V
        points += [root, *(edge + column for column in FIN_COLUMNS), root + FIN_V - 1]
    risen = np.isin(
        points, np.add.outer([DORSAL.start, VENTRAL.start], FIN_V + np.array(FIN_COLUMNS))
    )
    normals += [right] * (len(points) - body)
    count = np.arange(len(points))
    sides = [(k, (k + 1) % 4) for k in range(4)]  # all counter-clockwise from outside
    first = 1 + 4 * np.arange(len(RINGS))
    closed = [(0, first[0] + a, first[0] + b) for a, b in sides]
    for ring in first[:-1]:
        for a, b in sides:
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


def places(plan: SurfacePlan, shape: Speck) -> Array:
    """Texture coordinates of a species' vertices as shares of its cell, and ABSENT or 0, (n, 3)."""
    points = rest_control_points(plan, 1.0, 0.0)[shape.points]
    height = points[:, 1]
    if plan.wing:
        height = sheet_layout.unfold(
            plan, points[:, 2], np.where(shape.normals[:, 1] < 0.0, 0.0, 1.0)
        )
    front, rear = sheet_layout.borders(plan)
    top = sheet_layout.half_height(plan)
    out = np.zeros((len(points), 3))
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
    return out
