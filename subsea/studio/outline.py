"""Edits of more than one point: points that come and go, fins, total mass, model length."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from subsea.biomechanics.body_plan import NODES_AT_STATION
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
from subsea.studio.handles import CM_DIGITS, CURVES, FINS, LEAST_GAP, View, handles, tail_heights

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


def with_fin(draft: SpeciesDraft, name: str, there: bool) -> SpeciesDraft:
    """Add or remove a fin; a new one is plain, in the colour of the flank."""
    surface, skin = draft.content["surface"], draft.content["skin"]
    if not there:
        return with_value(draft, ("surface", name), None)
    if surface.get(name):
        return draft
    values: dict[KeyPath, Any] = {}
    if name in FINS:
        ridge, sign = (surface["back"], 1.0) if name == "dorsal" else (surface["belly"], -1.0)
        x = np.array([0.35, 0.4, 0.5, 0.6, 0.65]) if sign > 0 else np.linspace(0.55, 0.72, 5)
        tall = np.array([0.0, 0.06, 0.07, 0.05, 0.0]) - 0.005
        edge = np.clip(along(ridge, x) + sign * tall, -1.0, 1.0)
        values["surface", name] = {
            "base": [round_length(x[0]), round_length(x[-1])],
            "edge": [[round_length(a), round_length(b)] for a, b in zip(x, edge, strict=True)],
        }
        colours = name
    else:
        at, height = (0.28, 0.25) if name == "pectoral" else (0.36, 0.75)
        level = float(along(surface["belly"], np.array([at]))[0])
        values["surface", name] = {
            "at": at, "height": clip_height(height * level), "length": 0.12, "width": 0.07,
            "droop": 15.0 if name == "pectoral" else 35.0,
        }  # fmt: skip
        colours = "paddles"
    if colours not in skin:
        values["skin", colours] = {"colour": list(skin["flank"])}
    return with_values(draft, values)


def with_mass(draft: SpeciesDraft, grams: float) -> SpeciesDraft:
    """Scale all masses to a total in grams."""
    masses = draft.content["body"]["masses"]
    now = sum(m * n for m, n in zip(masses, NODES_AT_STATION, strict=True))
    return with_value(draft, ("body", "masses"), [float(f"{m * grams / now:.3g}") for m in masses])


def with_length(draft: SpeciesDraft, cm: float) -> SpeciesDraft:
    """Scale the scaffold to another model length, cm; masses scale as the volume."""
    body = draft.content["body"]
    times = cm / body["stations"][-1]
    scaled: dict[KeyPath, Any] = {
        ("body", key): [round(times * x, CM_DIGITS) for x in body[key]]
        for key in ("stations", "half_widths", "half_heights", "spans")
        if key in body
    }
    scaled["body", "tail_half_height"] = round(times * body["tail_half_height"], CM_DIGITS)
    scaled["body", "masses"] = [float(f"{times**3 * m:.3g}") for m in body["masses"]]
    return with_values(draft, scaled)
