"""Deformable meshes that float over a picture and take hold of outlines (Tu §5.2.1, appendix A).

A mesh of m×n nodes is m contours that run along and n that run across and share their nodes. Each
contour has springs between its nodes that resist being stretched (tension) and a stiffness that
resists being bent (rigidity). The border feels the picture: it climbs to where that changes most.
The mouse pulls a node by a spring, and an anchor holds one. What is inside follows by elasticity.
All moves through syrup: γ dx/dt is the sum of the forces, by Euler's explicit steps.

Tu's mesh is a regular grid at rest. Here any shape may be: rest lengths and second differences are
those of the shape that the mesh was made with, so that a fish laid down in the right shape stays
so. A.2 as printed drives nodes apart; its sign is turned here, so that springs resist.

The body is one mesh. The dorsal and the ventral fin are meshes of two rows: the root lies on the
border of the body and moves with it (what pulls at it pulls at the body), the edge is free.

Every array may be written to between two steps: pixels, x to the right and y down, float64.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.core.arrays import Array
from subsea.core.kernels import kernel

BODY, DORSAL, VENTRAL = "body", "dorsal", "ventral"  # parts of a net
HALF = 0.25  # of the steepest change of a picture; one so steep attracts half as much as any can


class Law(NamedTuple):
    """How strong everything is. Forces are in pixels; a step moves a node by `step` × force."""

    tension: float = 0.25  # a, for each pixel of stretch
    rigidity: float = 0.1  # b, for each pixel of second difference
    picture: float = 6.0  # for a slope of the field of 1
    mouse: float = 0.6  # for each pixel of distance
    anchor: float = 2.0  # λ, the same
    step: float = 0.2  # Δt/γ; explicit steps need it below 2 / (8a + 32b + λ)


class Mesh(NamedTuple):
    """A mesh of m×n nodes."""

    nodes: Array  # (m, n, 2)
    along: Array  # (m, n-1) rest lengths between neighbours in a row
    across: Array  # (m-1, n) and in a column
    bend_along: Array  # (m, n, 2) second differences at rest, of rows ...
    bend_across: Array  # (m, n, 2) ... and of columns; zero at their ends
    feels: Array  # (m, n) how much a node feels the picture: 1 on the border, 0 inside
    anchors: Array  # (m, n, 2) where a node is held; nan: it is not
    pulls: Array  # (m, n, 2) where the mouse pulls a node to; nan: it does not


class Fin(NamedTuple):
    """A mesh of two rows whose first lies on the border of the body."""

    mesh: Mesh
    row: int  # of the body: 0 the back, its last the belly
    share: Array  # (k, n of the body) what each node of the root takes of the nodes of that row


class Net(NamedTuple):
    """The meshes over a fish."""

    body: Mesh
    fins: dict[str, Fin]  # DORSAL, VENTRAL or neither


class Field(NamedTuple):
    """What a picture does to nodes."""

    height: Array  # (h, w) float32: G_σ * ‖∇I‖, pressed to 0..1 and times σ
    slope: Array  # (h, w, 2) float32: its gradient, x and y, at most about 0.6


LAW = Law()


def mesh(nodes: Array) -> Mesh:
    """A mesh that rests as it is, at `nodes` (m, n, 2); its border feels the picture."""
    nodes = np.array(nodes, np.float64)
    m, n, _ = nodes.shape
    feels = np.ones((m, n))
    feels[1:-1, 1:-1] = 0.0
    free = np.full((m, n, 2), np.nan)
    made = Mesh(
        nodes, np.empty((m, n - 1)), np.empty((m - 1, n)), np.zeros((m, n, 2)),
        np.zeros((m, n, 2)), feels, free, free.copy(),
    )  # fmt: skip
    _rest(made)
    return made


def fin(body: Mesh, row: int, places: Array, edge: Array) -> Fin:
    """A fin with `edge` (k, 2), rooted at `places` (k,) along a row of the body.

    Places count its nodes: 2.5 is halfway between the third and the fourth. The picture is felt
    by the edge alone, and no longer by those nodes of the body that lie under the fin.
    """
    n = body.nodes.shape[1]
    places = np.clip(places, 0.0, n - 1.0)
    share = np.maximum(1.0 - np.abs(places[:, None] - np.arange(n)), 0.0)
    body.feels[row, (np.arange(n) > places[0]) & (np.arange(n) < places[-1])] = 0.0
    made = mesh(np.stack([share @ body.nodes[row], edge]))
    made.feels[0] = 0.0
    return Fin(made, row, share)


def settle(net: Net) -> None:
    """Let every mesh rest as it is now."""
    for one in meshes(net).values():
        _rest(one)


def meshes(net: Net) -> dict[str, Mesh]:
    """All meshes by the names of their parts."""
    return {BODY: net.body} | {name: one.mesh for name, one in net.fins.items()}


def transform(net: Net, matrix: Array, about: Array, shift: Array) -> None:
    """Turn, scale or mirror the whole net by `matrix` (2, 2) about a place, then shift it.

    What it rests as goes with it, anchors and pulls stay where they are in the picture.
    """
    matrix = np.asarray(matrix, np.float64)
    scale = np.sqrt(abs(np.linalg.det(matrix)))
    for one in meshes(net).values():
        one.nodes[:] = (one.nodes - about) @ matrix.T + about + shift
        one.bend_along[:] = one.bend_along @ matrix.T
        one.bend_across[:] = one.bend_across @ matrix.T
        one.along[:] *= scale
        one.across[:] *= scale


def copied(net: Net) -> Net:
    """The same net in arrays of its own: for undo."""

    def own(one: Mesh) -> Mesh:
        return Mesh(*(part.copy() for part in one))

    return Net(own(net.body), {k: f._replace(mesh=own(f.mesh)) for k, f in net.fins.items()})


def nearest(net: Net, place: Array, border: bool = False) -> tuple[str, int, int, float]:
    """Part, row and column of the node nearest to a place, and how far it is in pixels.

    With `border` only those that may be on an outline: not inside, and no root of a fin.
    """
    best = (BODY, 0, 0, np.inf)
    for name, one in meshes(net).items():
        far = np.hypot(*(one.nodes - place).transpose(2, 0, 1))
        if name != BODY:
            far[0] = np.inf
        elif border:
            far[1:-1, 1:-1] = np.inf
        k, j = np.unravel_index(far.argmin(), far.shape)
        if far[k, j] < best[3]:
            best = (name, int(k), int(j), float(far[k, j]))
    return best


def field(picture: NDArray[Any], sigma: float) -> Field:
    """The field of a picture (h, w) or (h, w, channels), of any numbers.

    P = G_σ * ‖∇I‖ (Tu appendix A); with several channels ‖∇I‖ is over all of them, so that an edge
    between two colours of one brightness counts. P is pressed to P / (P + P₀), P₀ a quarter of its
    greatest: a faint outline holds too, next to a glaring one.
    """
    channels = np.atleast_3d(np.asarray(picture, np.float32))
    slopes = np.gradient(channels, axis=(0, 1)) if min(channels.shape[:2]) > 1 else []
    steep = np.zeros(channels.shape[:2], np.float32)
    for slope in slopes:
        steep += (slope * slope).sum(axis=2)
    high = smoothed(np.sqrt(steep), sigma)
    half = max(HALF * float(high.max()), 1e-6)
    height = np.float32(sigma) * high / (high + np.float32(half))
    down, right = np.gradient(height)
    return Field(height, np.ascontiguousarray(np.stack([right, down], axis=2), np.float32))


def smoothed(values: Array, sigma: float) -> Array:
    """Values (h, w) convolved with a Gaussian of `sigma` pixels; the border goes on outside."""
    reach = max(1, round(3.0 * sigma))
    weight = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2).astype(np.float32)
    weight /= weight.sum()
    for axis in (0, 1):
        around = [(0, 0), (0, 0)]
        around[axis] = (reach, reach)
        wide = np.pad(values, around, "edge")
        count = values.shape[axis]
        out = np.zeros(values.shape, np.float32)
        for k, w in enumerate(weight):
            out += w * (wide[k : k + count] if axis == 0 else wide[:, k : k + count])
        values = out
    return np.asarray(values)


def forces(net: Net, picture: Field | None, law: Law = LAW) -> dict[str, Array]:
    """The force on every node, (m, n, 2) by part; a root has none: its body has it."""
    out = {name: _forces(one, _seen(picture), law) for name, one in meshes(net).items()}
    for name, one in net.fins.items():
        out[BODY][one.row] += one.share.T @ out[name][0]
        out[name][0] = 0.0
    return out


def step(net: Net, picture: Field | None, law: Law = LAW, times: int = 1) -> float:
    """Move all nodes for some steps; how far the fastest one went in the last, in pixels.

    Without a picture the meshes only relax. A step takes some 50 µs.
    """
    moved = 0.0
    for _ in range(times):
        moved = 0.0
        pushed = forces(net, picture, law)
        for name, one in meshes(net).items():
            go = law.step * pushed[name]
            one.nodes[:] += go
            moved = max(moved, float(np.abs(go).max()))
        root(net)
    return moved


def root(net: Net) -> None:
    """Lay the roots of the fins on the border of the body, after its nodes were moved by hand."""
    for one in net.fins.values():
        one.mesh.nodes[0] = one.share @ net.body.nodes[one.row]


def relax(
    net: Net, picture: Field | None, law: Law = LAW, still: float = 0.01, most: int = 3000
) -> int | None:
    """Step until no node moves by `still` pixels a step: the number of steps, or None if `most`
    were not enough, as where two outlines pull at one node.
    """
    for done in range(10, most + 1, 10):
        if step(net, picture, law, 10) < still:
            return done
    return None


def energy(net: Net, picture: Field | None, law: Law = LAW) -> float:
    """What the forces let fall: of springs, bends, picture, mouse and anchors, in pixels²."""
    return sum(_energy(one, _seen(picture), law) for one in meshes(net).values())


def _seen(picture: Field | None) -> Field:
    return picture or Field(np.zeros((1, 1), np.float32), np.zeros((1, 1, 2), np.float32))


def _rest(one: Mesh) -> None:
    x = one.nodes
    one.along[:] = np.linalg.norm(np.diff(x, axis=1), axis=2)
    one.across[:] = np.linalg.norm(np.diff(x, axis=0), axis=2)
    one.bend_along[:, 1:-1] = np.diff(x, 2, axis=1)
    one.bend_across[1:-1] = np.diff(x, 2, axis=0)


@kernel
def _sampled(values: Any, x: float, y: float) -> float:
    """Values (h, w) at a place, linear between the middles of pixels, level outside."""
    h, w = values.shape
    x = min(max(x, 0.0), w - 1.0)
    y = min(max(y, 0.0), h - 1.0)
    i = min(int(x), max(w - 2, 0))
    j = min(int(y), max(h - 2, 0))
    right, down = min(i + 1, w - 1), min(j + 1, h - 1)
    s, t = x - i, y - j
    upper = values[j, i] * (1.0 - s) + values[j, right] * s
    lower = values[down, i] * (1.0 - s) + values[down, right] * s
    return upper * (1.0 - t) + lower * t


@kernel
def _forces(mesh: Any, field: Any, law: Any) -> Any:
    nodes = mesh.nodes
    m, n, _ = nodes.shape
    out = np.zeros((m, n, 2))
    for k in range(m):
        for j in range(n):
            # A.2: each spring once, pulling at both of its ends.
            for turn in range(2):
                k1, j1 = (k, j + 1) if turn == 0 else (k + 1, j)
                if k1 == m or j1 == n:
                    continue
                rest = mesh.along[k, j] if turn == 0 else mesh.across[k, j]
                dx = nodes[k1, j1, 0] - nodes[k, j, 0]
                dy = nodes[k1, j1, 1] - nodes[k, j, 1]
                length = np.sqrt(dx * dx + dy * dy)
                if length > 1e-9:
                    pull = law.tension * (length - rest) / length
                    out[k, j, 0] += pull * dx
                    out[k, j, 1] += pull * dy
                    out[k1, j1, 0] -= pull * dx
                    out[k1, j1, 1] -= pull * dy
            for axis in range(2):
                # A.3: each second difference once, with its share for all three nodes.
                if 0 < j < n - 1:
                    bent = nodes[k, j + 1, axis] - 2.0 * nodes[k, j, axis] + nodes[k, j - 1, axis]
                    bent = law.rigidity * (bent - mesh.bend_along[k, j, axis])
                    out[k, j - 1, axis] -= bent
                    out[k, j, axis] += 2.0 * bent
                    out[k, j + 1, axis] -= bent
                if 0 < k < m - 1:
                    bent = nodes[k + 1, j, axis] - 2.0 * nodes[k, j, axis] + nodes[k - 1, j, axis]
                    bent = law.rigidity * (bent - mesh.bend_across[k, j, axis])
                    out[k - 1, j, axis] -= bent
                    out[k, j, axis] += 2.0 * bent
                    out[k + 1, j, axis] -= bent
                if not np.isnan(mesh.anchors[k, j, axis]):
                    out[k, j, axis] += law.anchor * (mesh.anchors[k, j, axis] - nodes[k, j, axis])
                if not np.isnan(mesh.pulls[k, j, axis]):
                    out[k, j, axis] += law.mouse * (mesh.pulls[k, j, axis] - nodes[k, j, axis])
                if mesh.feels[k, j] != 0.0:
                    here = _sampled(field.slope[:, :, axis], nodes[k, j, 0], nodes[k, j, 1])
                    out[k, j, axis] += law.picture * mesh.feels[k, j] * here
    return out


@kernel
def _energy(mesh: Any, field: Any, law: Any) -> float:
    nodes = mesh.nodes
    m, n, _ = nodes.shape
    total = 0.0
    for k in range(m):
        for j in range(n):
            for turn in range(2):
                k1, j1 = (k, j + 1) if turn == 0 else (k + 1, j)
                if k1 < m and j1 < n:
                    rest = mesh.along[k, j] if turn == 0 else mesh.across[k, j]
                    dx = nodes[k1, j1, 0] - nodes[k, j, 0]
                    dy = nodes[k1, j1, 1] - nodes[k, j, 1]
                    total += 0.5 * law.tension * (np.sqrt(dx * dx + dy * dy) - rest) ** 2
            for axis in range(2):
                if 0 < j < n - 1:
                    bent = nodes[k, j + 1, axis] - 2.0 * nodes[k, j, axis] + nodes[k, j - 1, axis]
                    total += 0.5 * law.rigidity * (bent - mesh.bend_along[k, j, axis]) ** 2
                if 0 < k < m - 1:
                    bent = nodes[k + 1, j, axis] - 2.0 * nodes[k, j, axis] + nodes[k - 1, j, axis]
                    total += 0.5 * law.rigidity * (bent - mesh.bend_across[k, j, axis]) ** 2
                if not np.isnan(mesh.anchors[k, j, axis]):
                    total += 0.5 * law.anchor * (mesh.anchors[k, j, axis] - nodes[k, j, axis]) ** 2
                if not np.isnan(mesh.pulls[k, j, axis]):
                    total += 0.5 * law.mouse * (mesh.pulls[k, j, axis] - nodes[k, j, axis]) ** 2
            total -= (
                law.picture
                * mesh.feels[k, j]
                * _sampled(field.height, nodes[k, j, 0], nodes[k, j, 1])
            )
    return total
