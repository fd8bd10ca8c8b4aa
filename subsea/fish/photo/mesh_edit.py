"""What hands do to the meshes over a photograph: each act makes another net, none changes one.

Places are pixels of the photograph, x to the right and y down.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from subsea.core.arrays import Array, Bools
from subsea.fish.photo.deformable_mesh import (
    BODY,
    Field,
    Law,
    Net,
    copied,
    meshes,
    root,
    settle,
    step,
    transform,
)
from subsea.fish.photo.side_view import Rest
from subsea.fish.surface import EyePlan

SURE = 0.9  # of the longest step that is stable
FIRM = 4.0  # how many times stronger than in `Law` the mouse is where nothing else pulls
AROUND = 0.06  # how far the frame stands off the meshes, share of its height
KNOB = 0.25  # how far its knob stands above it, share of its height
LEAST = 0.05  # of what it was a thing may be scaled to at once


class Node(NamedTuple):
    """A node of a net."""

    part: str
    row: int
    column: int


@dataclass(frozen=True, eq=False)
class Pose:
    """A net that stays as it is: a state for undo, equal to nothing but itself."""

    name: str  # of the species
    net: Net


class Frame(NamedTuple):
    """A rectangle about all meshes, along the fish: what moves, turns and scales them as one."""

    corners: Array  # (4, 2) before the back, behind it, behind the belly, before it
    sides: Array  # (4, 2) the middles of back, tail, belly and snout
    knob: Array  # (2,) beyond the back
    middle: Array  # (2,)
    ahead: Array  # (2,) unit vector from the tail to the snout
    up: Array  # (2,) and from the belly to the back


def border(net: Net, parts: tuple[str, ...]) -> list[Node]:
    """The nodes of parts that are on an outline: not inside, and no root of a fin."""
    found = []
    for name, one in meshes(net).items():
        m, n, _ = one.nodes.shape
        if name not in parts:
            continue
        if name == BODY:
            found += [Node(name, k, j) for k in (0, m - 1) for j in range(n)]
            found += [Node(name, k, j) for k in range(1, m - 1) for j in (0, n - 1)]
        else:
            found += [Node(name, m - 1, j) for j in range(n)]
    return found


def inside(net: Net, parts: tuple[str, ...]) -> list[Node]:
    """The nodes within the body, if that is among the parts."""
    m, n, _ = net.body.nodes.shape
    both = [Node(BODY, k, j) for k in range(1, m - 1) for j in range(1, n - 1)]
    return both if BODY in parts else []


def places(net: Net, nodes: list[Node]) -> Array:
    """Where nodes are, (n, 2)."""
    all_of = meshes(net)
    where = [all_of[node.part].nodes[node.row, node.column] for node in nodes]
    return np.array(where, float).reshape(-1, 2)


def eye(net: Net, rest: Rest, at: EyePlan) -> Array:
    """The rim (25, 2) of where the eye of the species lies in a photograph."""
    around = np.linspace(0.0, 2.0 * np.pi, 25)
    spot = np.array([at.at, at.height]) + at.radius * np.stack([np.cos(around), np.sin(around)], 1)
    row = rest.body[len(rest.body) // 2, :, 0]
    column = np.interp(spot[:, 0], row, np.arange(len(row)))
    top, low = (np.interp(spot[:, 0], rest.body[k, :, 0], rest.body[k, :, 1]) for k in (0, -1))
    up = (top - spot[:, 1]) / np.maximum(top - low, 1e-9) * (len(rest.body) - 1)
    j = np.clip(column.astype(int), 0, net.body.nodes.shape[1] - 2)
    k = np.clip(up.astype(int), 0, len(rest.body) - 2)
    t, s = (column - j)[:, None], (up - k)[:, None]
    x = net.body.nodes
    upper, lower = (x[n, j] * (1.0 - t) + x[n, j + 1] * t for n in (k, k + 1))
    return np.asarray(upper * (1.0 - s) + lower * s)


def anchored(net: Net, node: Node) -> bool:
    """Whether a node is held by an anchor."""
    return not np.isnan(meshes(net)[node.part].anchors[node.row, node.column, 0])


def with_anchor(net: Net, node: Node, place: tuple[float, float] | None) -> Net:
    """The net with a node held at a place, or let go of."""
    other = copied(net)
    meshes(other)[node.part].anchors[node.row, node.column] = np.nan if place is None else place
    return other


def without_anchors(net: Net) -> Net:
    """The net with all anchors lifted."""
    other = copied(net)
    for one in meshes(other).values():
        one.anchors[:] = np.nan
    return other


def anchors(net: Net) -> list[Node]:
    """All nodes that are held."""
    return [
        Node(name, int(k), int(j))
        for name, one in meshes(net).items()
        for k, j in np.argwhere(~np.isnan(one.anchors[..., 0]))
    ]


def stable(law: Law) -> Law:
    """The law with a step that is as long as it may be, and no longer than usual."""
    most = 2.0 / (8.0 * law.tension + 32.0 * law.rigidity + max(law.anchor, law.mouse))
    return law._replace(step=min(Law().step, SURE * most))


def beyond(net: Net, place: Array, reach: float) -> dict[str, Bools]:
    """Which nodes of each part are farther than `reach` from a place."""
    return {
        name: np.hypot(*(one.nodes - place).transpose(2, 0, 1)) > reach
        for name, one in meshes(net).items()
    }


def pull(
    net: Net, node: Node, to: tuple[float, float], held: dict[str, Bools], law: Law, times: int
) -> None:
    """Pull a node of a net, which changes, for some steps; those that are `held` stay.

    The picture has no part in that. An anchor goes with its node.
    """
    before = {name: one.nodes.copy() for name, one in meshes(net).items()}
    tug(net, node, to)
    firm = stable(law._replace(mouse=FIRM * Law().mouse))
    for _ in range(times):
        step(net, None, firm)
        for name, one in meshes(net).items():
            one.nodes[held[name]] = before[name][held[name]]
        root(net)
    tug(net, node, None)


def tug(net: Net, node: Node, to: tuple[float, float] | None) -> None:
    """Have the mouse pull a node of a net, which changes, to a place, or let go of it."""
    one = meshes(net)[node.part]
    one.pulls[node.row, node.column] = np.nan if to is None else to
    if to is not None and anchored(net, node):
        one.anchors[node.row, node.column] = to


def kept(net: Net) -> Net:
    """The net with the shape that it has now as the one that it rests in."""
    other = copied(net)
    settle(other)
    return other


def relaxed(net: Net, field: Field, law: Law, times: int) -> float:
    """Let a net, which changes, move for some steps; how far its fastest node went in the last."""
    return step(net, field, stable(law), times)


def frame(net: Net) -> Frame:
    """The rectangle about a net."""
    body = net.body.nodes
    middle_row = body[len(body) // 2]
    ahead = middle_row[0] - middle_row[-1]
    ahead = ahead / max(float(np.hypot(*ahead)), 1e-9)
    up = np.array([-ahead[1], ahead[0]])
    if (body[0].mean(axis=0) - body[-1].mean(axis=0)) @ up < 0.0:
        up = -up
    every = np.concatenate([one.nodes.reshape(-1, 2) for one in meshes(net).values()])
    along, across = every @ ahead, every @ up
    gap = AROUND * float(np.ptp(across)) + 2.0
    front, rear = along.max() + gap, along.min() - gap
    top, low = across.max() + gap, across.min() - gap
    corners = np.array(
        [a * ahead + u * up for a, u in ((front, top), (rear, top), (rear, low), (front, low))]
    )
    sides = (corners + np.roll(corners, -1, axis=0)) / 2
    return Frame(
        corners, sides, sides[0] + KNOB * (top - low) * up, corners.mean(axis=0), ahead, up
    )  # fmt: skip


def within(outline: Frame, place: tuple[float, float]) -> bool:
    """Whether a place is in a frame."""
    off = np.asarray(place) - outline.middle
    half = np.abs((outline.corners - outline.middle) @ np.stack([outline.ahead, outline.up], 1))
    return bool(abs(off @ outline.ahead) <= half[0, 0] and abs(off @ outline.up) <= half[0, 1])


def moved(net: Net, shift: Array) -> Net:
    """The whole net elsewhere."""
    return _transformed(net, np.eye(2), np.zeros(2), shift)


def turned(net: Net, about: Array, angle: float) -> Net:
    """The whole net turned by `angle`, rad, from x to y."""
    c, s = np.cos(angle), np.sin(angle)
    return _transformed(net, np.array([[c, -s], [s, c]]), about, np.zeros(2))


def scaled(net: Net, about: Array, times: float) -> Net:
    """The whole net larger or smaller."""
    return _transformed(net, np.eye(2) * max(times, LEAST), about, np.zeros(2))


def stretched(net: Net, about: Array, way: Array, times: float) -> Net:
    """The whole net longer or shorter along a unit vector."""
    return _transformed(
        net, np.eye(2) + (max(times, LEAST) - 1.0) * np.outer(way, way), about, np.zeros(2)
    )


def flipped(net: Net) -> Net:
    """The fish heads the other way, in the same place."""
    shown = frame(net)
    return _transformed(
        net, np.eye(2) - 2.0 * np.outer(shown.ahead, shown.ahead), shown.middle, np.zeros(2)
    )


def placed_by(start: Net, outline: Frame, grip: int, begin: Array, to: Array) -> Net:
    """The net `start` after a grip of its frame was dragged from a place to another.

    Grips 0 to 3 are its corners, which scale, 4 to 7 its sides, which stretch, 8 the knob, which
    turns, 9 the middle, which moves.
    """
    if grip < 4:
        about = outline.corners[(grip + 2) % 4]
        out = (outline.corners[grip] - about) / _length(outline.corners[grip] - about)
        whole = _length(outline.corners[grip] - about)
        return scaled(start, about, float((to - about) @ out) / whole)
    if grip < 8:
        side = grip - 4
        about = outline.sides[(side + 2) % 4]
        whole = _length(outline.sides[side] - about)
        way = (outline.sides[side] - about) / whole
        return stretched(start, about, way, float((to - about) @ way) / whole)
    if grip == 8:
        angles = [np.arctan2(*(place - outline.middle)[::-1]) for place in (begin, to)]
        return turned(start, outline.middle, float(angles[1] - angles[0]))
    return moved(start, to - begin)


def _transformed(net: Net, matrix: Array, about: Array, shift: Array) -> Net:
    other = copied(net)
    transform(other, matrix, about, shift)
    return other


def _length(vector: Array) -> float:
    return max(float(np.hypot(*vector)), 1e-9)
