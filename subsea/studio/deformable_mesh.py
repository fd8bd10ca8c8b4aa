"""Deformable meshes that snap to outlines in a picture (Tu §5.2.1, appendix A).

A mesh of m×n nodes is m contours along and n contours across that share their nodes. Springs
between neighbours resist stretching (tension), second differences resist bending (rigidity). Border
nodes climb the gradient of the picture. The mouse pulls a node by a spring, an anchor holds one.
Motion is overdamped: γ dx/dt is the sum of the forces, by explicit Euler steps.

Tu's mesh is a regular grid at rest; here any shape may be the rest shape. The sign of A.2, which
as printed drives nodes apart, is reversed.

The body is one mesh. Dorsal and ventral fin are meshes of two rows: a root on the border of the
body, which takes its forces, and a free edge. Needs the extra `skin` (OpenCV).

Arrays may be changed between two steps: pixels, x to the right and y down, float64.
"""

from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array
from subsea.kernels import kernel

BODY, DORSAL, VENTRAL = "body", "dorsal", "ventral"  # parts
HALF = 0.25  # of the steepest edge: an edge this steep attracts half as much as possible


class MeshParameters(NamedTuple):
    """Strengths of the forces, in pixels; a step moves a node by `step` × force."""

    tension: float = 0.25  # a, for each pixel of stretch
    rigidity: float = 0.1  # b, for each pixel of second difference
    picture: float = 6.0  # for a slope of the field of 1
    mouse: float = 0.6  # for each pixel of distance
    anchor: float = 2.0  # λ, the same
    step: float = 0.2  # Δt/γ; explicit steps need it below 2 / (8a + 32b + λ)


class DeformableMesh(NamedTuple):
    """A mesh of m×n nodes."""

    nodes: Array  # (m, n, 2)
    along: Array  # (m, n-1) rest lengths between neighbours in a row
    across: Array  # (m-1, n) and in a column
    bend_along: Array  # (m, n, 2) second differences at rest, of rows ...
    bend_across: Array  # (m, n, 2) ... and of columns; zero at their ends
    edge_weight: Array  # (m, n) how much the picture attracts a node: 1 on the border, 0 inside
    anchors: Array  # (m, n, 2) where a node is held; NaN: free
    mouse: Array  # (m, n, 2) where the mouse pulls a node to; NaN: nowhere


class FinMesh(NamedTuple):
    """A mesh of two rows whose first lies on the border of the body."""

    mesh: DeformableMesh
    row: int  # of the body: 0 the back, its last the belly
    root_weights: Array  # (k, n of the body) of the nodes of that row, for each root node


class FishMeshes(NamedTuple):
    """The meshes over a fish."""

    body: DeformableMesh
    fins: dict[str, FinMesh]  # by DORSAL and VENTRAL, where the species has them

    @property
    def parts(self) -> dict[str, DeformableMesh]:
        """All meshes by the names of their parts."""
        return {BODY: self.body} | {name: fin.mesh for name, fin in self.fins.items()}

    @property
    def length(self) -> float:
        """Distance from the snout to the end of the tail in the middle row, pixels."""
        return float(np.hypot(*(self.body.nodes[4, 0] - self.body.nodes[4, -1])))


class EdgeField(NamedTuple):
    """The potential of a picture that attracts nodes."""

    height: Array  # (h, w) float32: G_σ * ‖∇I‖, compressed to 0..1, times σ
    slope: Array  # (h, w, 2) float32: its gradient, x and y, at most about 0.6


DEFAULT = MeshParameters()


def make_mesh(nodes: Array) -> DeformableMesh:
    """Make a mesh at rest from `nodes` (m, n, 2); the picture attracts its border."""
    nodes = np.array(nodes, np.float64)
    m, n, _ = nodes.shape
    edge_weight = np.ones((m, n))
    edge_weight[1:-1, 1:-1] = 0.0
    free = np.full((m, n, 2), np.nan)
    made = DeformableMesh(
        nodes, np.empty((m, n - 1)), np.empty((m - 1, n)), np.zeros((m, n, 2)),
        np.zeros((m, n, 2)), edge_weight, free, free.copy(),
    )  # fmt: skip
    _rest(made)
    return made


def make_fin(body: DeformableMesh, row: int, places: Array, edge: Array) -> FinMesh:
    """Make a fin with `edge` (k, 2), rooted at node indices `places` (k,) along a row of the body.

    Indices may be fractions. The picture attracts only the edge, and no longer the nodes of the
    body under the fin.
    """
    n = body.nodes.shape[1]
    places = np.clip(places, 0.0, n - 1.0)
    share = np.maximum(1.0 - np.abs(places[:, None] - np.arange(n)), 0.0)
    body.edge_weight[row, (np.arange(n) > places[0]) & (np.arange(n) < places[-1])] = 0.0
    made = make_mesh(np.stack([share @ body.nodes[row], edge]))
    made.edge_weight[0] = 0.0
    return FinMesh(made, row, share)


def set_rest_shape(meshes: FishMeshes) -> None:
    """Make the present shape of every mesh its rest shape."""
    for one in meshes.parts.values():
        _rest(one)


def transform(meshes: FishMeshes, matrix: Array, about: Array, shift: Array | float) -> None:
    """Apply `matrix` (2, 2) about a point, then a shift, to meshes and rest shapes.

    Anchors and mouse targets stay.
    """
    matrix = np.asarray(matrix, np.float64)
    scale = np.sqrt(abs(np.linalg.det(matrix)))
    for one in meshes.parts.values():
        one.nodes[:] = (one.nodes - about) @ matrix.T + about + shift
        one.bend_along[:] = one.bend_along @ matrix.T
        one.bend_across[:] = one.bend_across @ matrix.T
        one.along[:] *= scale
        one.across[:] *= scale


def copy_meshes(meshes: FishMeshes) -> FishMeshes:
    """Copy all arrays."""

    def own(one: DeformableMesh) -> DeformableMesh:
        return DeformableMesh(*(part.copy() for part in one))

    return FishMeshes(
        own(meshes.body), {k: f._replace(mesh=own(f.mesh)) for k, f in meshes.fins.items()}
    )


def edge_field(picture: NDArray[Any], sigma: float) -> EdgeField:
    """The edge field of a picture (h, w) or (h, w, channels) of any type.

    P = G_σ * ‖∇I‖ over all channels (Tu appendix A), compressed to P / (P + P₀), where P₀ is a
    quarter of its maximum, so that faint edges count beside strong ones.
    """
    channels = np.atleast_3d(np.asarray(picture, np.float32))
    slopes = np.gradient(channels, axis=(0, 1)) if min(channels.shape[:2]) > 1 else []
    steep = np.zeros(channels.shape[:2], np.float32)
    for slope in slopes:
        steep += (slope * slope).sum(axis=2)
    size = 2 * max(1, round(3.0 * sigma)) + 1
    high = cv2.GaussianBlur(np.sqrt(steep), (size, size), sigma, borderType=cv2.BORDER_REPLICATE)
    half = max(HALF * float(high.max()), 1e-6)
    height = np.float32(sigma) * high / (high + np.float32(half))
    down, right = np.gradient(height)
    return EdgeField(height, np.ascontiguousarray(np.stack([right, down], axis=2), np.float32))


def forces(
    meshes: FishMeshes, picture: EdgeField | None, params: MeshParameters = DEFAULT
) -> dict[str, Array]:
    """The forces (m, n, 2) on the nodes of each part; those on roots act on the body."""
    if picture is None:
        picture = EdgeField(np.zeros((1, 1), np.float32), np.zeros((1, 1, 2), np.float32))
    out = {name: _forces(one, picture, params) for name, one in meshes.parts.items()}
    for name, one in meshes.fins.items():
        out[BODY][one.row] += one.root_weights.T @ out[name][0]
        out[name][0] = 0.0
    return out


def step(
    meshes: FishMeshes,
    picture: EdgeField | None,
    params: MeshParameters = DEFAULT,
    times: int = 1,
) -> float:
    """Make some steps; return the largest motion of a node in the last, pixels."""
    moved = 0.0
    for _ in range(times):
        moved = 0.0
        pushed = forces(meshes, picture, params)
        for name, one in meshes.parts.items():
            go = params.step * pushed[name]
            one.nodes[:] += go
            moved = max(moved, float(np.abs(go).max()))
        attach_fins(meshes)
    return moved


def attach_fins(meshes: FishMeshes) -> None:
    """Move the roots of the fins with the body."""
    for one in meshes.fins.values():
        one.mesh.nodes[0] = one.root_weights @ meshes.body.nodes[one.row]


def relax(
    meshes: FishMeshes,
    picture: EdgeField | None,
    params: MeshParameters = DEFAULT,
    still: float = 0.01,
    most: int = 3000,
) -> int | None:
    """Step until no node moves by `still` pixels; return the steps, None after `most`."""
    for done in range(10, most + 1, 10):
        if step(meshes, picture, params, 10) < still:
            return done
    return None


def _rest(one: DeformableMesh) -> None:
    x = one.nodes
    one.along[:] = np.linalg.norm(np.diff(x, axis=1), axis=2)
    one.across[:] = np.linalg.norm(np.diff(x, axis=0), axis=2)
    one.bend_along[:, 1:-1] = np.diff(x, 2, axis=1)
    one.bend_across[1:-1] = np.diff(x, 2, axis=0)


@kernel
def _sampled(values: Any, x: float, y: float) -> float:
    """Sample values (h, w) bilinearly, clamped at the border."""
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
def _forces(mesh: Any, field: Any, params: Any) -> Any:
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
                    pull = params.tension * (length - rest) / length
                    out[k, j, 0] += pull * dx
                    out[k, j, 1] += pull * dy
                    out[k1, j1, 0] -= pull * dx
                    out[k1, j1, 1] -= pull * dy
            for axis in range(2):
                # A.3: each second difference once, with its share for all three nodes.
                if 0 < j < n - 1:
                    bent = nodes[k, j + 1, axis] - 2.0 * nodes[k, j, axis] + nodes[k, j - 1, axis]
                    bent = params.rigidity * (bent - mesh.bend_along[k, j, axis])
                    out[k, j - 1, axis] -= bent
                    out[k, j, axis] += 2.0 * bent
                    out[k, j + 1, axis] -= bent
                if 0 < k < m - 1:
                    bent = nodes[k + 1, j, axis] - 2.0 * nodes[k, j, axis] + nodes[k - 1, j, axis]
                    bent = params.rigidity * (bent - mesh.bend_across[k, j, axis])
                    out[k - 1, j, axis] -= bent
                    out[k, j, axis] += 2.0 * bent
                    out[k + 1, j, axis] -= bent
                if not np.isnan(mesh.anchors[k, j, axis]):
                    out[k, j, axis] += params.anchor * (
                        mesh.anchors[k, j, axis] - nodes[k, j, axis]
                    )
                if not np.isnan(mesh.mouse[k, j, axis]):
                    out[k, j, axis] += params.mouse * (mesh.mouse[k, j, axis] - nodes[k, j, axis])
                if mesh.edge_weight[k, j] != 0.0:
                    here = _sampled(field.slope[:, :, axis], nodes[k, j, 0], nodes[k, j, 1])
                    out[k, j, axis] += params.picture * mesh.edge_weight[k, j] * here
    return out
