"""The mesh of a fish at every level of detail, the same for all species (SMC §7.2).

All species have the same control points, so they share one set of vertices: the weights are the
same, and only the place on the skin differs (`outfit`). A fin that a species
lacks has vertices too, which are hidden.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.core.arrays import Array, Ints
from subsea.fish import sheet_layout
from subsea.fish.surface import (
    DORSAL,
    FIN_U,
    FIN_V,
    LEFT,
    RIGHT,
    VENTRAL,
    PaddlePlan,
    SurfacePlan,
    U,
    V,
    rest_control_points,
)
from subsea.geometry.spline import DEGREE, Table, basis_table, decimated

BODY, FIN, PECTORAL, PELVIC = range(4)  # parts, as the shaders know them
HEAD = 9  # samples of the finest table along a body that are in its head
ABSENT = -1.0  # instead of a control point: this species has no such fin

VERTEX_FORMAT = "3f4 3f4 3f4 3f4 4f4"
VERTEX_ATTRIBUTES = ("a_u", "a_v", "a_du", "a_dv", "a_part")
VERTEX_COLUMNS = 16


class Detail(NamedTuple):
    """The sampling of one level."""

    body: int  # number of times its samples were thinned: `kept`
    fins: int
    paddles: tuple[int, int]  # samples along and across a paired fin


# As `view.levels.LEVELS` has them, but specks, which are none of this surface (`fish_speck.py`).
DETAILS = (
    Detail(0, 0, (7, 6)),
    Detail(1, 0, (7, 6)),
    Detail(1, 1, (4, 3)),
    Detail(2, 2, (2, 2)),
)


class Mesh(NamedTuple):
    """Vertices of one level, and the triangles over them."""

    vertices: Array  # (n, 16) float32, columns as VERTEX_FORMAT
    base: Ints  # (n,) the first control point that has a part
    v: Array  # (n,) place along the patch; of a paired fin across it
    upper: NDArray[np.bool_]  # (n,) whether it belongs to the upper side of a half of the body
    triangles: Ints  # (m, 3) int32: of the closed body, of the fins, and of their other sides
    body: int  # number of the first ...
    fins: int  # ... and of the second, equal to that of the last


@cache
def finest(controls: int) -> Table:
    """The one basis that is evaluated: at the knots and at each quarter of the way between two.

    Halfway is where a control point pulls most, so that coarser levels are among these samples.
    """
    degree = min(DEGREE, controls - 1)
    return basis_table(controls, controls if degree == 1 else 4 * (controls - degree) + 1, degree)


def kept(controls: int, thinned: int) -> Ints:
    """Return the samples of the finest table that a level uses.

    Not thinned: every second, and along the body all in the head, where a mouth opens. Once: one
    per control point, where that pulls most. Twice: every second of these.
    """
    every = np.arange(len(finest(controls).first))
    if controls == 2:
        return every
    if thinned == 0:
        return every[(every % 2 == 0) | ((controls == V) & (every < HEAD))]
    pulling = np.concatenate([every[:1], every[2::4], every[-1:]])
    if thinned == 1:
        return pulling
    return pulling[np.round(np.linspace(0, controls - 1, (controls + 1) // 2)).astype(int)]


def fish_mesh(detail: Detail) -> Mesh:
    """The vertices and triangles of a level, body first, then fins, then paired fins."""
    parts: list[tuple[Mesh, bool]] = []
    rows, columns = kept(U, detail.body), kept(V, detail.body)
    middle = len(finest(U).first) // 2
    for start, side in ((LEFT.start, -1.0), (RIGHT.start, 1.0)):
        # Both sides have the row at the edge of a wing, where the skin is cut.
        for above, those in ((True, rows[rows <= middle]), (False, rows[rows >= middle])):
            patch = _patch(start, (U, V), (those, columns), BODY, side)
            parts.append((patch._replace(upper=np.full(len(patch.v), above)), True))
    left = len(parts[0][0].v) + len(parts[1][0].v)
    along = kept(FIN_V, detail.fins)
    for start, side in ((DORSAL.start, 1.0), (VENTRAL.start, -1.0)):
        parts.append((_patch(start, (FIN_U, FIN_V), (kept(FIN_U, 0), along), FIN, side), False))
    for side in (-1.0, 1.0):
        parts += [(_paddle(detail.paddles, part, side), False) for part in (PECTORAL, PELVIC)]
    starts = np.cumsum([0] + [len(part.v) for part, _ in parts])
    placed = [
        (part.triangles + start, body) for (part, body), start in zip(parts, starts, strict=False)
    ]
    vertices, base, v, upper = (np.concatenate([part[k] for part, _ in parts]) for k in range(4))
    snout = np.flatnonzero((vertices[:left, 12] == BODY) & (v[:left] == 0.0))
    bodies = [_lips(snout, left), *(triangles for triangles, body in placed if body)]
    fins = [triangles for triangles, body in placed if not body]
    backs = [triangles[:, ::-1] for triangles in fins]
    return Mesh(
        vertices.astype("f4"),
        base,
        v,
        upper,
        np.concatenate([*bodies, *fins, *backs]).astype("i4"),
        sum(map(len, bodies)),
        sum(map(len, fins)),
    )


def outfit(plan: SurfacePlan, mesh: Mesh, detail: Detail) -> Array:
    """Return the vertex data (n, 4) that differ between species.

    On body and fins: the place on the skin, behind the snout and up, in body lengths. On paired
    fins: how far along and across the fin. Then the first control point or ABSENT, and v.
    """
    rest = rest_control_points(plan, 1.0, 0.0)
    part, side = mesh.vertices[:, 12], mesh.vertices[:, 14]
    base, v = mesh.base.copy(), mesh.v.copy()
    fins = (plan.dorsal, DORSAL.start, 1.0), (plan.ventral, VENTRAL.start, -1.0)
    if detail.fins == 2:
        for fin, start, sign in fins:
            if fin:
                edge = rest[start + FIN_V : start + 2 * FIN_V]
                mine = (part == FIN) & (side == sign)
                base[mine], v[mine] = (
                    np.tile(x, FIN_U) for x in _telling_samples(edge, start, mine.sum() // FIN_U)
                )
    out = np.zeros((len(v), 4))
    smooth = part <= FIN
    spots = surface_points(rest, mesh.vertices[smooth], base[smooth])
    out[smooth, 0], out[smooth, 1] = -spots[:, 0], spots[:, 1]
    if plan.wing:
        body = part[smooth] == BODY
        out[part == BODY, 1] = sheet_layout.unfolded(plan, spots[body, 2], mesh.upper[part == BODY])
    out[:, 2], out[:, 3] = base, v
    for fin, _, sign in fins:
        if not fin:
            out[(part == FIN) & (side == sign), 2] = ABSENT
    for paddle, number in ((plan.pectoral, PECTORAL), (plan.pelvic, PELVIC)):
        for patch, sign in ((LEFT, -1.0), (RIGHT, 1.0)):
            mine = (part == number) & (side == sign)
            if paddle:
                along, across = mesh.vertices[mine, 13], 2.0 * v[mine] - 1.0
                out[mine, :2] = _outline(paddle, along, across)
                out[mine, 2] = patch.start + _root(paddle, rest[patch])
            else:
                out[mine, 2] = ABSENT
    return out


def surface_points(control: Array, vertices: Array, base: Ints) -> Array:
    """Points (n, 3) of the patches with `control` points (426, 3) at `vertices` (n, 16)."""
    tap = np.arange(3)
    stride = vertices[:, 15].astype(int)[:, None, None]
    points = base[:, None, None] + tap[:, None] * stride + tap
    weight = vertices[:, :3, None] * vertices[:, None, 3:6]
    # A linear patch has a third row of weight zero, which may lie beyond the last point.
    near = control[np.minimum(points, len(control) - 1)]
    return np.asarray(np.einsum("nab,nabx->nx", weight, near))


def _patch(
    start: int, controls: tuple[int, int], samples: tuple[Ints, Ints], part: int, side: float
) -> Mesh:
    """One patch of u×v control points that begin at `start`, at samples of the finest tables."""
    tables = [finest(n) for n in controls]
    u, v = (decimated(table, those) for table, those in zip(tables, samples, strict=True))
    rows, columns = (len(those) for those in samples)
    k, j = (a.ravel() for a in np.meshgrid(range(rows), range(columns), indexing="ij"))
    at = [those / (len(table.first) - 1.0) for table, those in zip(tables, samples, strict=True)]
    out = np.zeros((len(k), VERTEX_COLUMNS))
    out[:, 0:3], out[:, 3:6] = u.weight[k], v.weight[j]
    out[:, 6:9], out[:, 9:12] = u.slope[k], v.slope[j]
    out[:, 12], out[:, 13], out[:, 14], out[:, 15] = part, at[0][k], side, controls[1]
    base = start + u.first[k] * controls[1] + v.first[j]
    triangles = _grid(rows, columns)
    # Counter-clockwise from outside.
    return _bare(out, base, at[1][j], triangles if side < 0 else triangles[:, ::-1])


def _paddle(samples: tuple[int, int], part: int, side: float) -> Mesh:
    """A paired fin: the shader turns it about its root (Tu appendix B)."""
    along, across = (
        a.ravel() for a in np.meshgrid(*(np.linspace(0.0, 1.0, n) for n in samples), indexing="ij")
    )
    out = np.zeros((len(along), VERTEX_COLUMNS))
    out[:, 12], out[:, 13], out[:, 14] = part, along, side
    return _bare(out, np.zeros(len(out), int), across, _grid(*samples))


def _bare(vertices: Array, base: Ints, v: Array, triangles: Ints) -> Mesh:
    return Mesh(vertices, base, v, np.zeros(len(v), bool), triangles, 0, 0)


def _outline(plan: PaddlePlan, along: Array, across: Array) -> Array:
    """Places (n, 2) along and across a paired fin, body lengths; `across` from -1 to 1."""
    if plan.wing:
        # Its front edge bends back to the tip, its rear one is hollow; its root lies in the body.
        chord = (1.0 - along) ** 1.4 + 0.04
        x = plan.length * (1.15 * along - 0.15)
        y = plan.width * (0.5 - 0.2 * along**2 - chord * (0.5 - 0.5 * across))
    else:
        # Narrow at the root, widest at two thirds, rounded at the end.
        x = plan.length * (along - 0.3 * along**2 * across**2)
        y = 0.5 * plan.width * across * (0.25 + 0.75 * np.sin(0.76 * np.pi * along))
    return np.stack([x, y], axis=1)


def _root(plan: PaddlePlan, flank: Array) -> int:
    """The control point of a flank (189, 3) nearest to where a paired fin is to be."""
    return int(np.argmin(np.hypot(flank[:, 0] + plan.at, flank[:, 1] - plan.height)))


def _lips(left: Ints, half: int) -> Ints:
    """Triangles between the foremost vertices of both halves; without them a snout is a pipe.

    `left` are the vertices of the left half, those of the right one lie `half` behind.
    """
    a, b = left[:-1], left[1:]
    return np.concatenate([np.stack([a, a + half, b], 1), np.stack([b, a + half, b + half], 1)])


def _telling_samples(edge: Array, start: int, count: int) -> tuple[Ints, Array]:
    """First control points and places of those `count` samples that show most of a fin's edge.

    `edge` (12, 3) are its control points. A sample in the middle of a spline weighs three control
    points like any other there, so a species may choose for itself which of them these are.
    """
    table, pulling = finest(FIN_V), kept(FIN_V, 1)
    points = np.array([w @ edge[k : k + 3] for k, w in zip(table.first, table.weight, strict=True)])
    chosen = pulling[_telling(points[pulling], count, (2, len(pulling) - 3))]
    return start + table.first[chosen], chosen / (len(table.first) - 1.0)


def _telling(line: Array, count: int, inner: tuple[int, int]) -> Ints:
    """Indices of the `count` points (n, 3) that show most of a line: both ends, then the farthest.

    So a far fin keeps its tip, which every second point may miss (Ramer, Douglas and Peucker).
    Those between the ends lie in `inner`, the first and last index.
    """
    last = [0, len(line) - 1]
    while len(last) < count:
        share = np.interp(np.arange(len(line)), last, np.arange(len(last)))
        cell = np.minimum(share.astype(int), len(last) - 2)
        a, b = line[last][cell], line[last][cell + 1]
        along = ((line - a) * (b - a)).sum(axis=1) / np.maximum(((b - a) ** 2).sum(axis=1), 1e-12)
        off = np.linalg.norm(line - a - np.clip(along, 0.0, 1.0)[:, None] * (b - a), axis=1)
        off[last], off[: inner[0]], off[inner[1] + 1 :] = -1.0, -1.0, -1.0
        last = sorted([*last, int(off.argmax())])
    return np.array(last)


def _grid(rows: int, columns: int) -> Ints:
    """Two triangles per cell of a grid of vertices."""
    k, j = (a.ravel() for a in np.meshgrid(range(rows - 1), range(columns - 1), indexing="ij"))
    a = k * columns + j
    b, c, d = a + 1, a + columns, a + columns + 1
    return np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])
