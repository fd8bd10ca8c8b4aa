"""Editing meshes over a photograph: pixels, x to the right and y down.

Functions return changed copies, except `pull_node` and `set_mouse_target`.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools
from subsea.fish.surface import EyePlan
from subsea.studio.deformable_mesh import (
    BODY,
    FishMeshes,
    MeshParameters,
    attach_fins,
    copy_meshes,
    set_rest_shape,
    step,
    transform,
)
from subsea.studio.side_view import SideView

SAFETY = 0.9  # of the longest stable step
MOUSE_GAIN = 4.0  # strength of the mouse relative to the default, without a picture
MARGIN = 0.06  # between meshes and transform box, of its height
KNOB = 0.25  # height of the rotation knob above the box, of its height
LEAST_SCALE = 0.05  # of one edit


class MeshNode(NamedTuple):
    """The address of a node."""

    part: str
    row: int
    column: int


@dataclass(frozen=True, eq=False)
class MeshSnapshot:
    """An immutable state for undo, equal only to itself."""

    name: str  # of the species
    meshes: FishMeshes


class TransformBox(NamedTuple):
    """A rectangle around all meshes, aligned with the fish, with grips to transform them."""

    corners: Array  # (4, 2) front and rear of the back, rear and front of the belly
    sides: Array  # (4, 2) middles of back, tail, belly and snout
    knob: Array  # (2,) beyond the back
    middle: Array  # (2,)
    ahead: Array  # (2,) unit vector from the tail to the snout
    up: Array  # (2,) unit vector from the belly to the back


def border_nodes(meshes: FishMeshes, parts: tuple[str, ...]) -> list[MeshNode]:
    """The nodes of parts on an outline: not inner ones, nor roots of fins."""
    found = []
    for name in parts:
        if name == BODY:
            m, n, _ = meshes.body.nodes.shape
            found += [MeshNode(name, k, j) for k in (0, m - 1) for j in range(n)]
            found += [MeshNode(name, k, j) for k in range(1, m - 1) for j in (0, n - 1)]
        elif name in meshes.fins:
            found += [MeshNode(name, 1, j) for j in range(meshes.parts[name].nodes.shape[1])]
    return found


def inner_nodes(meshes: FishMeshes, parts: tuple[str, ...]) -> list[MeshNode]:
    """The inner nodes of the body, if that is among the parts."""
    if BODY not in parts:
        return []
    m, n, _ = meshes.body.nodes.shape
    return [MeshNode(BODY, k, j) for k in range(1, m - 1) for j in range(1, n - 1)]


def node_places(meshes: FishMeshes, nodes: list[MeshNode]) -> Array:
    """The positions (n, 2) of nodes."""
    parts = meshes.parts
    where = [parts[node.part].nodes[node.row, node.column] for node in nodes]
    return np.array(where, float).reshape(-1, 2)


def eye_outline(meshes: FishMeshes, rest: SideView, at: EyePlan) -> Array:
    """The outline (25, 2) of the species' eye in the photograph."""
    around = np.linspace(0.0, 2.0 * np.pi, 25)
    spot = np.array([at.at, at.height]) + at.radius * np.stack([np.cos(around), np.sin(around)], 1)
    row = rest.body[len(rest.body) // 2, :, 0]
    column = np.interp(spot[:, 0], row, np.arange(len(row)))
    top, low = (np.interp(spot[:, 0], rest.body[k, :, 0], rest.body[k, :, 1]) for k in (0, -1))
    up = (top - spot[:, 1]) / np.maximum(top - low, 1e-9) * (len(rest.body) - 1)
    j = np.clip(column.astype(int), 0, meshes.body.nodes.shape[1] - 2)
    k = np.clip(up.astype(int), 0, len(rest.body) - 2)
    t, s = (column - j)[:, None], (up - k)[:, None]
    x = meshes.body.nodes
    upper, lower = (x[n, j] * (1.0 - t) + x[n, j + 1] * t for n in (k, k + 1))
    return np.asarray(upper * (1.0 - s) + lower * s)


def is_anchored(meshes: FishMeshes, node: MeshNode) -> bool:
    """True if a node is anchored."""
    return not np.isnan(meshes.parts[node.part].anchors[node.row, node.column, 0])


def with_anchor(
    meshes: FishMeshes, node: MeshNode, place: tuple[float, float] | None
) -> FishMeshes:
    """Anchor a node at a place; None frees it."""
    other = copy_meshes(meshes)
    other.parts[node.part].anchors[node.row, node.column] = np.nan if place is None else place
    return other


def without_anchors(meshes: FishMeshes) -> FishMeshes:
    """Remove all anchors."""
    other = copy_meshes(meshes)
    for one in other.parts.values():
        one.anchors[:] = np.nan
    return other


def anchored_nodes(meshes: FishMeshes) -> list[MeshNode]:
    """All anchored nodes."""
    return [
        MeshNode(name, int(k), int(j))
        for name, one in meshes.parts.items()
        for k, j in np.argwhere(~np.isnan(one.anchors[..., 0]))
    ]


def stable_parameters(params: MeshParameters) -> MeshParameters:
    """Shorten the step if the forces need it to be stable."""
    most = 2.0 / (8.0 * params.tension + 32.0 * params.rigidity + max(params.anchor, params.mouse))
    return params._replace(step=min(MeshParameters().step, SAFETY * most))


def nodes_beyond(meshes: FishMeshes, place: Array, reach: float) -> dict[str, Bools]:
    """Mark the nodes of each part farther than `reach` from a place."""
    return {
        name: np.hypot(*(one.nodes - place).transpose(2, 0, 1)) > reach
        for name, one in meshes.parts.items()
    }


def pull_node(
    meshes: FishMeshes,
    node: MeshNode,
    to: tuple[float, float],
    held: dict[str, Bools],
    params: MeshParameters,
    times: int,
) -> None:
    """Pull a node and its anchor in place for some steps; `held` nodes stay."""
    before = {name: one.nodes.copy() for name, one in meshes.parts.items()}
    set_mouse_target(meshes, node, to)
    firm = stable_parameters(params._replace(mouse=MOUSE_GAIN * MeshParameters().mouse))
    for _ in range(times):
        step(meshes, None, firm)
        for name, one in meshes.parts.items():
            one.nodes[held[name]] = before[name][held[name]]
        attach_fins(meshes)
    set_mouse_target(meshes, node, None)


def set_mouse_target(meshes: FishMeshes, node: MeshNode, to: tuple[float, float] | None) -> None:
    """Set in place where the mouse pulls a node and its anchor; None releases it."""
    one = meshes.parts[node.part]
    one.mouse[node.row, node.column] = np.nan if to is None else to
    if to is not None and is_anchored(meshes, node):
        one.anchors[node.row, node.column] = to


def with_rest_shape(meshes: FishMeshes) -> FishMeshes:
    """Make the present shape the rest shape."""
    other = copy_meshes(meshes)
    set_rest_shape(other)
    return other


def transform_box(meshes: FishMeshes) -> TransformBox:
    """The transform box of the meshes."""
    body = meshes.body.nodes
    middle_row = body[len(body) // 2]
    ahead = middle_row[0] - middle_row[-1]
    ahead = ahead / max(float(np.hypot(*ahead)), 1e-9)
    up = np.array([-ahead[1], ahead[0]])
    if (body[0].mean(axis=0) - body[-1].mean(axis=0)) @ up < 0.0:
        up = -up
    every = np.concatenate([one.nodes.reshape(-1, 2) for one in meshes.parts.values()])
    along, across = every @ ahead, every @ up
    gap = MARGIN * float(np.ptp(across)) + 2.0
    front, rear = along.max() + gap, along.min() - gap
    top, low = across.max() + gap, across.min() - gap
    corners = np.array(
        [a * ahead + u * up for a, u in ((front, top), (rear, top), (rear, low), (front, low))]
    )
    sides = (corners + np.roll(corners, -1, axis=0)) / 2
    return TransformBox(
        corners, sides, sides[0] + KNOB * (top - low) * up, corners.mean(axis=0), ahead, up
    )  # fmt: skip


def is_inside(box: TransformBox, place: tuple[float, float]) -> bool:
    """True if a place lies in the box."""
    off = np.asarray(place) - box.middle
    half = np.abs((box.corners - box.middle) @ np.stack([box.ahead, box.up], 1))
    return bool(abs(off @ box.ahead) <= half[0, 0] and abs(off @ box.up) <= half[0, 1])


def rotate(meshes: FishMeshes, about: Array, angle: float) -> FishMeshes:
    """Turn all meshes by `angle`, rad, from x to y."""
    c, s = np.cos(angle), np.sin(angle)
    return _transformed(meshes, np.array([[c, -s], [s, c]]), about)


def flip(meshes: FishMeshes) -> FishMeshes:
    """Mirror the fish in place, so that it heads the other way."""
    box = transform_box(meshes)
    return _transformed(meshes, np.eye(2) - 2.0 * np.outer(box.ahead, box.ahead), box.middle)


def drag_grip(
    start: FishMeshes, box: TransformBox, grip: int, begin: Array, to: Array
) -> FishMeshes:
    """Transform `start` by a grip of its box that was dragged from `begin` to `to`.

    Grips 0 to 3 are the corners, which scale, 4 to 7 the sides, which stretch, 8 the knob, which
    turns, 9 the middle, which moves.
    """
    if grip < 8:
        grips = (box.corners, box.sides)[grip // 4]
        about = grips[(grip + 2) % 4]
        way = grips[grip % 4] - about
        whole = max(float(np.hypot(*way)), 1e-9)
        way = way / whole
        times = max(float((to - about) @ way) / whole, LEAST_SCALE)
        stretched = np.eye(2) + (times - 1.0) * np.outer(way, way)
        return _transformed(start, np.eye(2) * times if grip < 4 else stretched, about)
    if grip == 8:
        angles = [np.arctan2(*(place - box.middle)[::-1]) for place in (begin, to)]
        return rotate(start, box.middle, float(angles[1] - angles[0]))
    return _transformed(start, np.eye(2), np.zeros(2), to - begin)


def _transformed(
    meshes: FishMeshes, matrix: Array, about: Array, shift: Array | float = 0.0
) -> FishMeshes:
    other = copy_meshes(meshes)
    transform(other, matrix, about, shift)
    return other
