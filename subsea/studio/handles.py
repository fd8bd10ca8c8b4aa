"""Handles of the side and top view, and edits by dragging them.

Points are (distance behind the snout, height or half-width) in body lengths, also those of the
scaffold, which the file has in cm.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, Literal, NamedTuple

import numpy as np

from subsea.biomechanics.body_plan import HALF_SIZES, SHORTEST_SECTION
from subsea.fish.surface import along
from subsea.studio.draft import (
    EditError,
    KeyPath,
    SpeciesDraft,
    clip_height,
    clip_share,
    round_length,
    value_at,
    with_value,
    with_values,
)

View = Literal["side", "top"]
Box = tuple[float, float, float, float]  # left, low, right, high

CURVES = ("back", "belly", "width")
FINS = ("dorsal", "ventral")
RIDGES = {"back": "dorsal", "belly": "ventral"}  # and the fins on them
PAIRED_FINS = ("pectoral", "pelvic")
SOFT_REACH = 0.12  # body lengths from a dragged point at which neighbours move by 1/e of its way
LEAST_GAP = 0.004  # body lengths between two points of a curve
LIMITS = {"back": (0.001, 1.0), "belly": (-1.0, -0.001), "width": (0.0005, 1.0)}  # of values
CM_DIGITS = 3
BISECTIONS = 9  # to find how far toward an invalid place a point can go


class DragHandle(NamedTuple):
    """A point of a view that can be dragged."""

    path: KeyPath  # the value of the draft that it sets
    at: tuple[float, float]  # behind the snout, and up or aside; body lengths
    mirrored: bool = False  # it has a twin on the other side of the spine


def handles(draft: SpeciesDraft, view: View) -> list[DragHandle]:
    """The points of a view that can be dragged, the scaffold's first."""
    surface, found = draft.content["surface"], _ring_handles(draft, view)

    def add_line(*keys: str, mirrored: bool = False) -> None:
        path = ("surface", *keys)
        points = enumerate(value_at(draft, path))
        found.extend(DragHandle((*path, k), tuple(p), mirrored) for k, p in points)

    if view == "top":
        add_line("width", mirrored=True)
        if surface.get("wing"):
            add_line("wing", "outline", mirrored=True)
        return found
    for name in RIDGES:
        add_line(name)
    for ridge, name in RIDGES.items():
        if fin := surface.get(name):
            for k, x in enumerate(fin["base"]):
                y = float(along(surface[ridge], np.array([x]))[0])
                found.append(DragHandle(("surface", name, "base", k), (x, y)))
            add_line(name, "edge")
    tail = surface["tail"]
    found.append(DragHandle(("surface", "tail", "begin"), (tail["begin"], 0.0)))
    middle, radius = tail_heights(draft)
    for k, (share, x) in enumerate(tail["edge"]):
        found.append(DragHandle(("surface", "tail", "edge", k), (x, middle + share * radius)))
    for name in PAIRED_FINS:
        if fin := surface.get(name):
            root = fin["at"], fin["height"]
            droop = np.radians(fin["droop"])
            tip = root[0] + fin["length"] * np.cos(droop), root[1] - fin["length"] * np.sin(droop)
            found.append(DragHandle(("surface", name, "at"), root))
            found.append(DragHandle(("surface", name, "length"), (float(tip[0]), float(tip[1]))))
    eye = surface["eye"]
    if not surface.get("wing"):
        found.append(DragHandle(("surface", "eye"), (eye["at"], eye["height"])))
    return found


def _ring_handles(draft: SpeciesDraft, view: View) -> list[DragHandle]:
    body = draft.content.get("body")
    if not body:
        return []
    length = body["stations"][-1]
    sizes = body["half_heights"] if view == "side" else body["half_widths"]
    found = [
        DragHandle(("body", "ring", k), (x / length, size / length), True)
        for k, (x, size) in enumerate(zip(body["stations"][1:6], sizes, strict=True))
    ]
    if view == "side":
        found.append(
            DragHandle(("body", "ring", 5), (1.0, body["tail_half_height"] / length), True)
        )
    return found


def tail_heights(draft: SpeciesDraft) -> tuple[float, float]:
    """Middle and half height of the tail's edge, body lengths."""
    surface = draft.species.surface
    edge = surface.tail.edge_at(np.array([-1.0, 1.0]))
    top, bottom = (
        float(along(curve, np.array([x]))[0])
        for curve, x in ((surface.back, edge[1]), (surface.belly, edge[0]))
    )
    return (top + bottom) / 2, max((top - bottom) / 2, 1e-6)


def drag_handle(
    draft: SpeciesDraft, view: View, path: KeyPath, to: tuple[float, float], soft: bool = False
) -> SpeciesDraft:
    """Drag a point, between its neighbours, to a place or as far as the species stays valid.

    The same draft is returned if the point cannot move. With `soft` the neighbours on back, belly
    or width follow by a Gaussian of their distance.
    """
    after = _drag_alone(draft, view, path, to)
    name, k = path[1], path[-1]
    if soft and name in CURVES and isinstance(k, int):
        curve, ridge = value_at(draft, path[:-1]), [*value_at(after, path[:-1])]
        rise = ridge[k][1] - curve[k][1]
        for j, (x, y) in enumerate(curve):
            if j != k:
                share = np.exp(-(((x - curve[k][0]) / SOFT_REACH) ** 2))
                ridge[j] = [x, round_length(np.clip(y + share * rise, *LIMITS[name]))]
        with suppress(EditError):
            return with_values(draft, {path[:-1]: ridge} | _moved_fin(draft, str(name), ridge))
    return after


def _drag_alone(
    draft: SpeciesDraft, view: View, path: KeyPath, to: tuple[float, float]
) -> SpeciesDraft:
    """Drag a point without its neighbours."""
    handle = next(one for one in handles(draft, view) if one.path == path)
    start = handle.at
    if handle.mirrored:
        to = to[0], abs(to[1])
    if to == start:
        return draft
    place = _setter(draft, view, path)
    for aim in (to, (to[0], start[1]), (start[0], to[1])):
        with suppress(EditError):
            there = place(*aim)
            if there.content != draft.content:
                return there
    low, high, best = 0.0, 1.0, draft
    for _ in range(BISECTIONS):
        share = 0.5 * (low + high)
        try:
            best = place(*(a + share * (b - a) for a, b in zip(start, to, strict=True)))
            low = share
        except EditError:
            high = share
    return best


def _setter(
    draft: SpeciesDraft, view: View, path: KeyPath
) -> Callable[[float, float], SpeciesDraft]:
    """The function that puts a point at a place; it may raise EditError."""
    surface = draft.content["surface"]
    part = path[:2]

    def shape(x: float, y: float) -> SpeciesDraft:
        curve = value_at(draft, path[:-1])
        k = path[-1]
        assert isinstance(k, int)
        name = str(path[1])
        if name in CURVES:
            x = _between(curve, k, x)
            y = float(np.clip(y, *LIMITS[name]))
        else:
            x, y = float(np.clip(x, 0.0, 1.0)), float(np.clip(y, -1.0, 1.0))
        if name == "wing":
            y = max(y, 0.0)
        point = [round_length(x), round_length(y)]
        if name not in RIDGES:
            return with_value(draft, path, point)
        ridge = [point if number == k else old for number, old in enumerate(curve)]
        return with_values(draft, {path[:-1]: ridge} | _moved_fin(draft, name, ridge))

    def base(x: float, y: float) -> SpeciesDraft:
        return with_value(draft, path, clip_share(x))

    def tail_edge(x: float, y: float) -> SpeciesDraft:
        edge, k = surface["tail"]["edge"], path[-1]
        assert isinstance(k, int)
        middle, radius = tail_heights(draft)
        share = (y - middle) / radius
        if k in (0, len(edge) - 1):
            share = edge[k][0]
        else:
            share = float(np.clip(share, edge[k - 1][0] + 0.02, edge[k + 1][0] - 0.02))
        return with_value(draft, path, [round_length(share), clip_share(x)])

    def root(x: float, y: float) -> SpeciesDraft:
        return with_values(draft, {(*part, "at"): clip_share(x), (*part, "height"): clip_height(y)})

    def tip(x: float, y: float) -> SpeciesDraft:
        plan = value_at(draft, part)
        dx, dy = x - plan["at"], plan["height"] - y
        droop = round(np.clip(float(np.degrees(np.arctan2(dy, max(dx, 1e-6)))), -90, 90), 1)
        length = clip_share(max(float(np.hypot(dx, dy)), 0.01))
        return with_values(draft, {(*part, "length"): length, (*part, "droop"): droop})

    def ring(x: float, y: float) -> SpeciesDraft:
        return _with_ring(draft, view, int(path[2]), x, y)

    if path[0] == "body":
        return ring
    if path[1] == "eye" or path[2] == "at":
        return root
    if path[1:] == ("tail", "begin") or path[2] == "base":
        return base
    if path[1] == "tail":
        return tail_edge
    return tip if path[2] == "length" else shape


def _moved_fin(draft: SpeciesDraft, name: str, ridge: list[Any]) -> dict[KeyPath, Any]:
    """The free edge of the fin on a ridge, moved with the ridge."""
    fin = draft.content["surface"].get(RIDGES.get(name, ""))
    if not fin:
        return {}
    edge = np.array(fin["edge"], float)
    if np.any(np.diff([p[0] for p in ridge]) <= 0):
        return {}
    edge[:, 1] += along(ridge, edge[:, 0]) - along(draft.content["surface"][name], edge[:, 0])
    return {("surface", RIDGES[name], "edge"): [[round_length(x), clip_height(y)] for x, y in edge]}


def _with_ring(draft: SpeciesDraft, view: View, k: int, x: float, y: float) -> SpeciesDraft:
    """Set station and size of ring `k`, or the height of the tail (5)."""
    body = draft.content["body"]
    length = body["stations"][-1]
    size = round(float(np.clip(y, *HALF_SIZES)) * length, CM_DIGITS)
    if k == 5:
        return with_value(draft, ("body", "tail_half_height"), size)
    room = SHORTEST_SECTION * length
    front, rear = body["stations"][k] + room, body["stations"][k + 2] - room
    station = round(float(np.clip(x * length, min(front, rear), rear)), CM_DIGITS)
    sizes = "half_heights" if view == "side" else "half_widths"
    return with_values(draft, {("body", "stations", k + 1): station, ("body", sizes, k): size})


def _between(curve: Sequence[Sequence[float]], k: int, x: float) -> float:
    """Clip `x` between the neighbours of point `k` of a curve."""
    low = curve[k - 1][0] + LEAST_GAP if k else 0.0
    high = curve[k + 1][0] - LEAST_GAP if k + 1 < len(curve) else 1.0
    return curve[k][0] if low > high else float(np.clip(x, low, high))
