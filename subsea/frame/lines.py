"""Lines in the world, for diagrams."""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.view.camera import View

ROUND = 48  # pieces of a circle


class Lines(NamedTuple):
    """k straight lines in the world."""

    ends: Array  # (k, 2, 3) float32, cm
    colours: Array  # (k, 4) float32: sRGB as on the screen; opacity
    # (k,) float32, cm by which the depth test moves a line toward the eye, so that lines within a
    # body show.
    lift: Array


NO_LINES = Lines(
    np.zeros((0, 2, 3), np.float32), np.zeros((0, 4), np.float32), np.zeros(0, np.float32)
)


def join_lines(parts: Iterable[Lines]) -> Lines:
    """The lines of all parts."""
    return Lines(*(np.concatenate(column) for column in zip(NO_LINES, *parts, strict=True)))


def make_lines(ends: Any, colours: Any, lift: Any = 0.0) -> Lines:
    """Opaque lines of one colour or of (…, 3) colours."""
    placed = np.asarray(ends, np.float32).reshape(-1, 2, 3)
    tinted = np.ones((len(placed), 4), np.float32)
    tinted[:, :3] = np.asarray(colours, np.float32).reshape(-1, 3)
    lifted = np.broadcast_to(np.asarray(lift, np.float32), len(placed))
    return Lines(placed, tinted, lifted)


def faded(parts: Iterable[Lines], opacity: float) -> list[Lines]:
    """Parts with their opacity multiplied."""
    share = np.array([1.0, 1.0, 1.0, opacity], np.float32)
    return [part._replace(colours=part.colours * share) for part in parts]


def arc(middle: Array, radius: float, a: Array, b: Array, low: float, high: float) -> Array:
    """An arc of lines (ROUND, 2, 3) from `low` to `high` rad, from unit vector a toward b."""
    turn = np.linspace(low, high, ROUND + 1)[:, None]
    points = middle + radius * (np.cos(turn) * a + np.sin(turn) * b)
    return np.stack([points[:-1], points[1:]], axis=1)


def frustum_edges(view: View, reach_cm: float) -> Array:
    """Edges (8, 2, 3), cm, of a frustum: four from the eye, four around its end at `reach_cm`."""
    inverse = np.linalg.inv(view.projection.astype(np.float64) @ view.view.astype(np.float64))
    corners = np.array([(-1, -1, 1, 1), (1, -1, 1, 1), (1, 1, 1, 1), (-1, 1, 1, 1)]) @ inverse.T
    rays = corners[:, :3] / corners[:, 3:] - view.eye
    ahead = -view.view[2, :3].astype(np.float64)
    ends = view.eye + reach_cm * rays / (rays @ ahead)[:, None]
    edges = [(view.eye, end) for end in ends]
    return np.array(edges + [(ends[k - 1], ends[k]) for k in range(4)])
