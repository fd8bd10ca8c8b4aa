"""Edge blending of projectors that light the same part of a screen.

At every point of the screen the shares of all projectors add up to one. A projector's share falls
smoothly to zero toward those of its edges that lie within another one's picture.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.stage.theatre.screens import Screen, places_on, points_on

WITHIN = 1e-6  # of a screen: tolerance at its edges
LEAST = 1e-4  # of a screen: least distance from the edges where one projector shines alone
EDGE = np.linspace(0.02, 0.98, 49)  # places along an edge to test for other projectors


class Projector(NamedTuple):
    """A projector: its screen and its light."""

    screen: Screen
    gamma: float
    black: float  # share of its white that it shines when dark


def light_shares(projectors: Sequence[Projector], number: int, places: Array) -> Array:
    """The share (n,) of the light that projector `number` gives to places (n, 2) of its screen."""
    points = points_on(projectors[number].screen, places)
    seen = [places_on(one.screen, points) for one in projectors]
    seen[number] = places
    weights = np.stack([_blend_weight(projectors, k, own) for k, own in enumerate(seen)])
    total = weights.sum(axis=0)
    return np.where(total > 0.0, weights[number] / np.where(total > 0.0, total, 1.0), 1.0)


def overlap_count(projectors: Sequence[Projector], number: int, places: Array) -> Ints:
    """The number (n,) of projectors that light places (n, 2) of projector `number`'s screen."""
    points = points_on(projectors[number].screen, places)
    return np.sum(
        [_within(places_on(one.screen, points)) for one in projectors], axis=0, dtype=np.int_
    )


def blend_mask(projectors: Sequence[Projector], number: int, places: Array) -> Array:
    """Factors and offsets (n, 4) at places (n, 2) of the screen of projector `number`.

    The projector gets value · factor + offset. Where fewer projectors shine than elsewhere, their
    black is raised to that of the places where most do.
    """
    one = projectors[number]
    light = light_shares(projectors, number, places)
    here = overlap_count(projectors, number, places)
    most = max(_most_overlap(projectors), int(here.max(initial=1)))
    lifted = one.black * (most - here) / np.maximum(here, 1)
    added = lifted ** (1.0 / one.gamma)
    # Exact for black and white; with a raised black level grey is slightly too dark.
    factor = (light * (1.0 - lifted) + lifted) ** (1.0 / one.gamma) - added
    return np.column_stack([factor, factor, factor, added])


def _blend_weight(projectors: Sequence[Projector], number: int, places: Array) -> Array:
    """The weight of a projector at places (n, 2) of its screen; 0 beyond its edges."""
    s, t = places.T
    weight = _within(places).astype(np.float64)
    edges = _blended_edges(projectors, number)
    for blended, inside in zip(edges, (s, 1 - s, t, 1 - t), strict=True):
        if blended:
            weight *= np.square(np.clip(np.nan_to_num(inside), LEAST, 1.0))
    return weight


def _blended_edges(projectors: Sequence[Projector], number: int) -> tuple[bool, ...]:
    """True for each edge (left, right, lower, upper) that lies within another's picture."""
    one = projectors[number].screen
    zero, whole = np.zeros_like(EDGE), np.ones_like(EDGE)
    edges = (zero, EDGE), (whole, EDGE), (EDGE, zero), (EDGE, whole)
    others = [other.screen for k, other in enumerate(projectors) if k != number]
    points = [points_on(one, np.column_stack(edge)) for edge in edges]
    return tuple(
        any(bool(_within(places_on(other, own), -1e-3).any()) for other in others) for own in points
    )


def _most_overlap(projectors: Sequence[Projector]) -> int:
    """The largest number of projectors that light one place."""
    steps = np.stack(np.meshgrid(EDGE, EDGE), axis=-1).reshape(-1, 2)
    return max(int(overlap_count(projectors, k, steps).max()) for k in range(len(projectors)))


def _within(places: Array, beyond: float = WITHIN) -> Bools:
    with np.errstate(invalid="ignore"):
        return np.asarray(((places >= -beyond) & (places <= 1.0 + beyond)).all(axis=1))
