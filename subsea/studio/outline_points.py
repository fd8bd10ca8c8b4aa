"""Adding and removing points of outlines."""

from collections.abc import Sequence

import numpy as np

from subsea.fish.surface import along
from subsea.studio.draft import (
    EditError,
    KeyPath,
    SpeciesDraft,
    clip_share,
    round_length,
    value_at,
    with_value,
)
from subsea.studio.handles import CURVES, LEAST_GAP, View, handles, tail_heights

FEWEST = {"back": 3, "belly": 3, "width": 3, "dorsal": 3, "ventral": 3, "tail": 2, "wing": 5}


def add_point(
    draft: SpeciesDraft, view: View, at: tuple[float, float]
) -> tuple[SpeciesDraft, KeyPath]:
    """Add a point to the nearest line of a view; return its path too.

    EditError if a point of the line is too close already.
    """
    path = nearest_line(draft, view, at)[0]
    at = (at[0], abs(at[1])) if view == "top" else at
    _, k, place = _distance(_lines(draft, view)[path], at)
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
    """The line of a view nearest to a point, and its distance, body lengths.

    Both sides of the top view count as one.
    """
    at = (at[0], abs(at[1])) if view == "top" else at
    found = [(path, _distance(points, at)[0]) for path, points in _lines(draft, view).items()]
    return min(found, key=lambda pair: pair[1])


def remove_point(draft: SpeciesDraft, path: KeyPath) -> SpeciesDraft:
    """Remove a point of a line; EditError if the line needs it."""
    name = str(path[1])
    if not _on_outline(path):
        raise EditError("Only points of outlines can be taken away: a scaffold has five rings.")
    curve = value_at(draft, path[:-1])
    if len(curve) <= FEWEST[name]:
        raise EditError(f"This line needs {FEWEST[name]} points at least.")
    return with_value(draft, path[:-1], [p for k, p in enumerate(curve) if k != path[-1]])


def _on_outline(path: KeyPath) -> bool:
    return path[0] == "surface" and isinstance(path[-1], int) and path[2] != "base"


def _lines(draft: SpeciesDraft, view: View) -> dict[KeyPath, list[tuple[float, float]]]:
    """The lines of a view to which points can be added."""
    groups: dict[KeyPath, list[tuple[float, float]]] = {}
    for handle in handles(draft, view):
        if _on_outline(handle.path):
            groups.setdefault(handle.path[:-1], []).append(handle.at)
    return groups


def _distance(
    points: Sequence[tuple[float, float]], at: tuple[float, float]
) -> tuple[float, int, tuple[float, float]]:
    """Distance from a line, index of its nearest piece, and the foot on that piece."""
    line = np.asarray(points)
    start, way = line[:-1], np.diff(line, axis=0)
    t = ((at - start) * way).sum(axis=1) / np.maximum((way * way).sum(axis=1), 1e-12)
    feet = start + np.clip(t, 0.0, 1.0)[:, None] * way
    far = np.linalg.norm(at - feet, axis=1)
    k = int(far.argmin())
    return float(far[k]), k, (float(feet[k, 0]), float(feet[k, 1]))
