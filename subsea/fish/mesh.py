"""The fish mesh at every level of detail (SMC §7.2).

All species share one set of vertices and weights; only the texture coordinates differ
(`species_vertices`). Vertices of missing fins are hidden.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Ints
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
from subsea.geometry.curves import DEGREE, Table, basis_table, decimated

BODY, FIN, PECTORAL, PELVIC = range(4)  # parts, as the shaders know them
HEAD = 9  # samples of the finest table along the body that belong to the head
ROOT_SAMPLES = 129  # across and along a flank, among which the root of a paired fin is chosen
ABSENT = -1.0  # in place of a control point: the species lacks this fin

VERTEX_FORMAT = "3f4 3f4 3f4 3f4 4f4"
VERTEX_ATTRIBUTES = ("a_u", "a_v", "a_du", "a_dv", "a_part")
VERTEX_COLUMNS = 16


class Detail(NamedTuple):
    """The sampling of one level of detail."""

    body: int  # how often its samples were thinned: `sample_indices`
    fins: int
    paddles: tuple[int, int]  # samples along and across a paired fin


# Those of `view.levels.LEVELS` except specks (`fish_speck.py`).
DETAILS = (
    Detail(0, 0, (7, 6)),
    Detail(1, 0, (7, 6)),
    Detail(1, 1, (4, 3)),
    Detail(2, 2, (2, 2)),
)


class Mesh(NamedTuple):
    """Vertices and triangles of one level."""

    vertices: Array  # (n, 16) float32, columns as VERTEX_FORMAT
    base: Ints  # (n,) index of the first control point
    v: Array  # (n,) parameter along the patch; across a paired fin
    upper: NDArray[np.bool_]  # (n,) on the upper side of a half of the body
    triangles: Ints  # (m, 3) int32: closed body, fins, back sides of the fins
    body: int  # triangles of the body
    fins: int  # triangles of the fins, of one side


@cache
def finest_basis(controls: int) -> Table:
    """The basis at the knots and at each quarter between two; coarser levels are subsets."""
    degree = min(DEGREE, controls - 1)
    return basis_table(controls, controls if degree == 1 else 4 * (controls - degree) + 1, degree)


def sample_indices(controls: int, thinned: int) -> Ints:
    """Samples of the finest table that a level uses.

    0: every second, and all along the head, where the mouth opens. 1: one for each control point,
    where its weight is greatest. 2: every second of these.
    """
    every = np.arange(len(finest_basis(controls).first))
    if controls == 2:
        return every
    if thinned == 0:
        return every[(every % 2 == 0) | ((controls == V) & (every < HEAD))]
    peaks = np.concatenate([every[:1], every[2::4], every[-1:]])
    if thinned == 1:
        return peaks
    return peaks[np.round(np.linspace(0, controls - 1, (controls + 1) // 2)).astype(int)]


def fish_mesh(detail: Detail) -> Mesh:
    """The vertices and triangles of a level: body, fins, paired fins."""
    parts: list[Mesh] = []
    rows, columns = sample_indices(U, detail.body), sample_indices(V, detail.body)
    middle = len(finest_basis(U).first) // 2
    for start, side in ((LEFT.start, -1.0), (RIGHT.start, 1.0)):
        # Both sides have the row at the edge of a wing, where the texture is cut.
        for above, half in ((True, rows[rows <= middle]), (False, rows[rows >= middle])):
            patch = _patch(start, (U, V), (half, columns), BODY, side)
            parts.append(patch._replace(upper=np.full(len(patch.v), above)))
    left = len(parts[0].v) + len(parts[1].v)
    across, along = sample_indices(FIN_U, 0), sample_indices(FIN_V, detail.fins)
    for start, side in ((DORSAL.start, 1.0), (VENTRAL.start, -1.0)):
        parts.append(_patch(start, (FIN_U, FIN_V), (across, along), FIN, side))
    for side in (-1.0, 1.0):
        parts += [_paddle(detail.paddles, part, side) for part in (PECTORAL, PELVIC)]
    starts = np.cumsum([0] + [len(part.v) for part in parts])
    triangles = [part.triangles + start for part, start in zip(parts, starts, strict=False)]
    vertices, base, v, upper = (np.concatenate([part[k] for part in parts]) for k in range(4))
    bodies = [_snout_cap(np.flatnonzero(v[:left] == 0.0), left), *triangles[:4]]
    fins = triangles[4:]
    backs = [one[:, ::-1] for one in fins]
    return Mesh(
        vertices.astype("f4"),
        base,
        v,
        upper,
        np.concatenate([*bodies, *fins, *backs]).astype("i4"),
        sum(map(len, bodies)),
        sum(map(len, fins)),
    )


def species_vertices(plan: SurfacePlan, mesh: Mesh, detail: Detail) -> Array:
    """Vertex data (n, 4) that differ between species.

    Two coordinates in body lengths: behind the snout and up on body and fins, along and across on
    paired fins. Then the first control point or ABSENT, and v.
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
                    np.tile(x, FIN_U) for x in _salient_samples(edge, start, mine.sum() // FIN_U)
                )
    out = np.zeros((len(v), 4))
    smooth = part <= FIN
    points = surface_points(rest, mesh.vertices[smooth], base[smooth])
    out[smooth, 0], out[smooth, 1] = -points[:, 0], points[:, 1]
    if plan.wing:
        body = part == BODY
        out[body, 1] = sheet_layout.unfold(plan, points[body[smooth], 2], mesh.upper[body])
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
                out[mine, 2] = patch.start + root_point(paddle, rest[patch])
            else:
                out[mine, 2] = ABSENT
    return out


def surface_points(control: Array, vertices: Array, base: Ints) -> Array:
    """Points (n, 3) of the patches with `control` points (426, 3) at `vertices` (n, 16)."""
    tap = np.arange(3)
    stride = vertices[:, 15].astype(int)[:, None, None]
    points = base[:, None, None] + tap[:, None] * stride + tap
    weight = vertices[:, :3, None] * vertices[:, None, 3:6]
    # The third row of a linear patch has weight zero and may lie beyond the last point.
    near = control[np.minimum(points, len(control) - 1)]
    return np.asarray(np.einsum("nab,nabx->nx", weight, near))


def _patch(
    start: int, controls: tuple[int, int], samples: tuple[Ints, Ints], part: int, side: float
) -> Mesh:
    """A patch of u×v control points from `start` on, at samples of the finest tables."""
    tables = [finest_basis(n) for n in controls]
    u, v = (decimated(table, chosen) for table, chosen in zip(tables, samples, strict=True))
    rows, columns = map(len, samples)
    k, j = (a.ravel() for a in np.meshgrid(range(rows), range(columns), indexing="ij"))
    at = [chosen / (len(table.first) - 1.0) for table, chosen in zip(tables, samples, strict=True)]
    out = np.zeros((len(k), VERTEX_COLUMNS))
    out[:, 0:3], out[:, 3:6] = u.weight[k], v.weight[j]
    out[:, 6:9], out[:, 9:12] = u.slope[k], v.slope[j]
    out[:, 12], out[:, 13], out[:, 14], out[:, 15] = part, at[0][k], side, controls[1]
    base = start + u.first[k] * controls[1] + v.first[j]
    triangles = _grid(rows, columns)
    # Counter-clockwise from outside.
    return _part(out, base, at[1][j], triangles if side < 0 else triangles[:, ::-1])


def _paddle(samples: tuple[int, int], part: int, side: float) -> Mesh:
    """A paired fin, which the shader turns about its root (Tu appendix B)."""
    along, across = (
        a.ravel() for a in np.meshgrid(*(np.linspace(0.0, 1.0, n) for n in samples), indexing="ij")
    )
    out = np.zeros((len(along), VERTEX_COLUMNS))
    out[:, 12], out[:, 13], out[:, 14] = part, along, side
    return _part(out, np.zeros(len(out), int), across, _grid(*samples))


def _part(vertices: Array, base: Ints, v: Array, triangles: Ints) -> Mesh:
    return Mesh(vertices, base, v, np.zeros(len(v), bool), triangles, 0, 0)


def _outline(plan: PaddlePlan, along: Array, across: Array) -> Array:
    """Points (n, 2) along and across a paired fin, body lengths; `across` from -1 to 1."""
    if plan.wing:
        # The front edge bends back to the tip, the rear edge is concave, the root is in the body.
        chord = (1.0 - along) ** 1.4 + 0.04
        x = plan.length * (1.15 * along - 0.15)
        y = plan.width * (0.5 - 0.2 * along**2 - chord * (0.5 - 0.5 * across))
    else:
        # Narrow at the root, widest at two thirds, rounded at the end.
        x = plan.length * (along - 0.3 * along**2 * across**2)
        y = 0.5 * plan.width * across * (0.25 + 0.75 * np.sin(0.76 * np.pi * along))
    return np.stack([x, y], axis=1)


def root_point(plan: PaddlePlan, flank: Array) -> int:
    """Find the control point of a flank (189, 3) nearest to the root of a paired fin."""
    return int(np.argmin(np.hypot(flank[:, 0] + plan.at, flank[:, 1] - plan.height)))


def root_offset(plan: SurfacePlan, paddle: PaddlePlan | None) -> Array:
    """Compute the way (3,) from the control point of a right paired fin to its root on the flank.

    In body axes and body lengths; 0 without this fin.
    """
    if paddle is None:
        return np.zeros(3)
    flank = rest_control_points(plan, 1.0, 0.0)[RIGHT]
    grid = sampled(flank.reshape(U, V, 3), basis_table(U, ROOT_SAMPLES))
    surface = sampled(grid.swapaxes(0, 1), basis_table(V, ROOT_SAMPLES)).reshape(-1, 3)
    off = np.hypot(surface[:, 0] + paddle.at, surface[:, 1] - paddle.height)
    return np.asarray(surface[off.argmin()] - flank[root_point(paddle, flank)])


def sampled(control: Array, table: Table) -> Array:
    """Compute points (k, …) of splines with control points (n, …) at parameters of a table."""
    near = control[table.first[:, None] + np.arange(table.weight.shape[1])]
    return np.asarray(np.einsum("kj,kj...->k...", table.weight, near))


def _snout_cap(left: Ints, half: int) -> Ints:
    """Triangles that close the snout between vertices `left` and `left` + `half`."""
    a, b = left[:-1], left[1:]
    return np.concatenate([np.stack([a, a + half, b], 1), np.stack([b, a + half, b + half], 1)])


def _salient_samples(edge: Array, start: int, count: int) -> tuple[Ints, Array]:
    """First control points and parameters of `count` samples that approximate a fin's edge.

    `edge` (12, 3) are its control points. The inner samples of a spline all weigh three control
    points, so each species may choose its own.
    """
    table, peaks = finest_basis(FIN_V), sample_indices(FIN_V, 1)
    points = np.array([w @ edge[k : k + 3] for k, w in zip(table.first, table.weight, strict=True)])
    chosen = peaks[_simplify(points[peaks], count, (2, len(peaks) - 3))]
    return start + table.first[chosen], chosen / (len(table.first) - 1.0)


def _simplify(line: Array, count: int, inner: tuple[int, int]) -> Ints:
    """Indices of `count` points (n, 3) by Ramer, Douglas and Peucker: both ends, then the farthest.

    Points between the ends have indices within `inner`, first to last.
    """
    chosen = [0, len(line) - 1]
    while len(chosen) < count:
        share = np.interp(np.arange(len(line)), chosen, np.arange(len(chosen)))
        cell = np.minimum(share.astype(int), len(chosen) - 2)
        a, b = line[chosen][cell], line[chosen][cell + 1]
        along = ((line - a) * (b - a)).sum(axis=1) / np.maximum(((b - a) ** 2).sum(axis=1), 1e-12)
        off = np.linalg.norm(line - a - np.clip(along, 0.0, 1.0)[:, None] * (b - a), axis=1)
        off[chosen], off[: inner[0]], off[inner[1] + 1 :] = -1.0, -1.0, -1.0
        chosen = sorted([*chosen, int(off.argmax())])
    return np.array(chosen)


def _grid(rows: int, columns: int) -> Ints:
    """Two triangles for each cell of a grid of vertices."""
    k, j = (a.ravel() for a in np.meshgrid(range(rows - 1), range(columns - 1), indexing="ij"))
    a = k * columns + j
    b, c, d = a + 1, a + columns, a + columns + 1
    return np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])
