"""Adding and removing points of outlines."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from subsea.fish.editing.draft import (
    EditError,
    KeyPath,
    SpeciesDraft,
    clip_share,
    round_length,
    value_at,
    with_value,
)
from subsea.fish.editing.handles import CURVES, LEAST_GAP, View, handles, tail_heights
from subsea.fish.surface import along

FEWEST = {"back": 3, "belly": 3, "width": 3, "dorsal": 3, "ventral": 3, "tail": 2, "wing": 5}


def add_point(
    draft: SpeciesDraft, view: View, at: tuple[float, float]
) -> tuple[SpeciesDraft, KeyPath]:
    """Add a point to the nearest line of a view; return its path too.

    EditError if a point of the line is too close already. Both sides of the top view count as one.
    """
    at = (at[0], abs(at[1])) if view == "top" else at
    path = nearest_line(draft, view, at)[0]
    _, k, place = _distance(dict(_lines(draft, view))[path], at)
    name = path[1]
    curve = list(value_at(draft, path))
    if name in CURVES:
        x = clip_share(at[0])
        k = int(np.searchsorted([p[0] for p in curve], x)) - 1
        y = round_length(along(curve, np.array([x]))[0])
        point, around = [x, y], [abs(p[0] - x) for p in curve]
    elif name == "tail":
        middle, radius = tail_heights(draft)
        share = round_length((place[1] - middle) / radius)
        if curve[0][0] == 0.0:
            share = abs(share)
        shares = [p[0] for p in curve]
        k = int(np.searchsorted(shares, share)) - 1
        x = float(draft.species.surface.tail.edge_at(np.array([share]))[0])
        point, around = [share, round_length(x)], [abs(s - share) for s in shares]
    else:
        point = [round_length(place[0]), round_length(place[1])]
        around = [float(np.hypot(p[0] - point[0], p[1] - point[1])) for p in curve]
    if min(around) < LEAST_GAP:
        raise EditError("There is a point already: drag it, or add one farther from it.")
    curve.insert(k + 1, point)
    return with_value(draft, path, curve), (*path, k + 1)


def nearest_line(draft: SpeciesDraft, view: View, at: tuple[float, float]) -> tuple[KeyPath, float]:
    """Return the line of a view nearest to a place, and its distance, body lengths."""
    at = (at[0], abs(at[1])) if view == "top" else at
    found = [(path, _distance(points, at)[0]) for path, points in _lines(draft, view)]
    return min(found, key=lambda pair: pair[1])


def remove_point(draft: SpeciesDraft, path: KeyPath) -> SpeciesDraft:
    """Remove a point of a line; EditError if the line needs it."""
    name = str(path[1])
    if path[0] != "surface" or not isinstance(path[-1], int) or path[2] == "base":
        raise EditError("Only points of outlines can be taken away: a scaffold has five rings.")
    curve = value_at(draft, path[:-1])
    if len(curve) <= FEWEST[name]:
        raise EditError(f"This line needs {FEWEST[name]} points at least.")
    return with_value(draft, path[:-1], [p for k, p in enumerate(curve) if k != path[-1]])


def _lines(draft: SpeciesDraft, view: View) -> list[tuple[KeyPath, list[tuple[float, float]]]]:
    """Return the lines of a view that take more points."""
    groups: dict[KeyPath, list[tuple[float, float]]] = {}
    for handle in handles(draft, view):
        if (
            handle.path[0] == "surface"
            and isinstance(handle.path[-1], int)
            and handle.path[2] != "base"
        ):
            groups.setdefault(handle.path[:-1], []).append(handle.at)
    return list(groups.items())


def _distance(
    points: Sequence[tuple[float, float]], at: tuple[float, float]
) -> tuple[float, int, tuple[float, float]]:
    """Return the distance from a line, the index of its nearest piece, and the foot on that."""
    best = (np.inf, 0, points[0])
    p = np.asarray(at)
    for k, (a, b) in enumerate(pairwise(points)):
        start, way = np.asarray(a), np.subtract(b, a)
        t = float(np.clip((p - start) @ way / max(way @ way, 1e-12), 0.0, 1.0))
        foot = start + t * way
        far = float(np.linalg.norm(p - foot))
        if far < best[0]:
            best = (far, k, (float(foot[0]), float(foot[1])))
    return best
