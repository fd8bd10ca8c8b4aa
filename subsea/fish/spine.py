"""The spine-driven swimmer: motion from rules instead of from muscles and water (KS part II).

Four factors decide how a spine moves: the function by which it swings, the places of its
inflection points, the rule by which the swing propagates from the central inflection point to
both ends, and how far each part of the spine gives way (KS's stiffness factors). Together they
give the direction of every unit of the spine; the places follow by laying the units end to end,
so that the spine never changes its length. The same rules move a wing, whose units run from the
spine to its tip and swing up and down. The surface keeps its distance to the units (KS III.B).

Lengths are in body lengths and time in beats; plans are in degrees, all other angles in radians.
Bodies at rest have the axes (distance behind the snout, up, right).
"""

from itertools import pairwise
from typing import Annotated, Literal, NamedTuple

import msgspec
import numpy as np

from subsea.core.arrays import Array
from subsea.fish.surface import along

UNITS = 240  # of a spine: too fine to be seen
WING_UNITS = 32  # from the spine to any point of a wing
MODEL_LENGTHS = (10.0, 300.0)  # cm, of the fish that is recorded
RUN_IN = 0.4  # body lengths that a sharp turn takes at least, besides the fish's own length

Share = Annotated[float, msgspec.Meta(ge=0, le=1)]
Angle = Annotated[float, msgspec.Meta(ge=0, le=90)]
Place = Annotated[float, msgspec.Meta(ge=-5, le=5)]
Give = Annotated[float, msgspec.Meta(ge=0, le=3)]
Beat = Annotated[int, msgspec.Meta(ge=8, le=200)]


class Swing(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The swing of a chain of units; places are shares of its length.

    ``inflections`` are where the bend changes sides while the central one swings its farthest:
    half a wave lies between two of them, and they may lie beyond the ends. ``flexibility``
    (place, share) is how much of the swing each part takes: 0 is rigid, above 1 amplifies.
    """

    angle: Angle  # degrees, the farthest that a part of flexibility 1 swings at amplitude 1
    function: Literal["sinusoidal", "linear"] = "sinusoidal"
    inflections: tuple[Place, Place, Place]
    propagation: Literal["tailward", "outward", "at once"] = "tailward"
    flexibility: Annotated[tuple[tuple[Share, Give], ...], msgspec.Meta(min_length=2)]

    def __post_init__(self) -> None:
        """Refuse places that run forwards, and a wave that would."""
        if any(b - a < 0.05 for a, b in pairwise(self.inflections)):
            raise ValueError("inflections must follow one another by 0.05 or more")
        if any(b <= a for (a, _), (b, _) in pairwise(self.flexibility)):
            raise ValueError("the places of flexibility must follow one another")
        if (np.diff(phase(self, np.linspace(0.0, 1.0, 50))) <= 0).any():
            raise ValueError("inflections are spaced too unevenly: the wave would turn back")

    @property
    def wavelength(self) -> float:
        """Length of the wave: from the first inflection point to the last."""
        return self.inflections[2] - self.inflections[0]


class Wings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A pair of wings, each a chain of units from the spine to the tip that swings up and down.

    ``swing`` counts its places in half spans: 0 on the spine, 1 at the tip.
    """

    swing: Swing
    chord: tuple[Share, Share]  # from where to where they stand on the body
    chord_lag: Annotated[float, msgspec.Meta(ge=0.05, le=1)]  # beats, of their rear edge
    raised: Annotated[float, msgspec.Meta(ge=-30, le=30)] = 0.0  # degrees about which they beat

    def __post_init__(self) -> None:
        """Refuse wings without chord."""
        if self.chord[1] - self.chord[0] < 0.05:
            raise ValueError("the chord must run from front to rear, 0.05 or more")


class SpineGait(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One grade of swimming. These numbers alone decide how fast the fish is.

    ``slip`` is the speed of the fish over that of the wave that drives it.
    """

    ticks_per_beat: Beat  # of 0.033 s
    amplitude: Share  # of the swing
    slip: Annotated[float, msgspec.Meta(gt=0, lt=1)]


class Turn(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A turn at the gait of grade medium: the body follows a path that bends."""

    gradual: Annotated[float, msgspec.Meta(gt=0, le=60)]  # degrees each beat
    sharp: Annotated[float, msgspec.Meta(gt=0, le=120)]  # degrees in all
    sharp_beats: Annotated[int, msgspec.Meta(ge=1, le=20)]
    bank: Annotated[float, msgspec.Meta(ge=0, le=60)] = 0.0  # degrees, where the path bends most


class SpinePlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The motion of a species with a spine but no muscles: the [spine] table of its file."""

    length: Annotated[float, msgspec.Meta(ge=MODEL_LENGTHS[0], le=MODEL_LENGTHS[1])]  # cm
    centre: Annotated[float, msgspec.Meta(ge=0.1, le=0.7)]  # behind the snout; keeps to the path
    swing: Swing
    wings: Wings | None = None
    slow: SpineGait
    medium: SpineGait
    fast: SpineGait
    turn: Turn

    def __post_init__(self) -> None:
        """Refuse grades out of order, and a sharp turn that ends before the tail is round."""
        speeds = [self.stride(g) / g.ticks_per_beat for g in (self.slow, self.medium, self.fast)]
        if not speeds[0] < speeds[1] < speeds[2]:
            raise ValueError("slow, medium and fast must each be faster than the one before")
        way = self.turn.sharp_beats * self.stride(self.medium)
        if way < 1.0 + RUN_IN:
            raise ValueError(
                f"sharp_beats = {self.turn.sharp_beats} make a way of {way:.2f} body lengths; "
                f"expected {1.0 + RUN_IN:g} or more, for the tail to come round"
            )

    def stride(self, gait: SpineGait) -> float:
        """Body lengths that a beat takes the fish forward: its slip times a wavelength.

        The wave that drives a fish with wings runs along their chord, that of any other along
        its spine.
        """
        if self.wings:
            front, rear = self.wings.chord
            return gait.slip * (rear - front) / self.wings.chord_lag
        return gait.slip * self.swing.wavelength


def phase(swing: Swing, at: Array) -> Array:
    """Phase of the swing at the places `at`: 0 at the central inflection point, π at the next.

    It is the parabola through the three points.
    """
    front, middle, rear = swing.inflections
    a, b = front - middle, rear - middle
    bend = np.pi * (a + b) / (a * b * (b - a))
    x = np.asarray(at) - middle
    return np.asarray((bend * (x - b) + np.pi / b) * x)


def oscillation(swing: Swing, angle: Array) -> Array:
    """The swing function, -1 to 1, farthest aside at multiples of π."""
    if swing.function == "sinusoidal":
        return np.asarray(np.cos(angle))
    return np.asarray(2.0 * np.abs((angle / np.pi) % 2.0 - 1.0) - 1.0)


def swung(swing: Swing, at: Array, beat: Array, amplitude: float) -> Array:
    """Directions, rad, of the units at `at` at the times `beat`; both broadcast together.

    Where the bend is 0 the direction is farthest aside: with the linear function each unit
    between two inflection points differs by an equal angle from the one before (KS part II).
    """
    now, there = 2.0 * np.pi * np.asarray(beat), phase(swing, at)
    if swing.propagation == "tailward":
        share = oscillation(swing, now - there)
    elif swing.propagation == "outward":
        share = oscillation(swing, now - np.abs(there))
    else:
        share = oscillation(swing, now) * oscillation(swing, there)
    give = along(np.asarray(swing.flexibility), np.asarray(at))
    return np.asarray(np.radians(swing.angle) * amplitude * give * share)


def laid(direction: Array, length: Array | float = 1.0) -> Array:
    """Places (…, n + 1, 2) of the ends of n units laid end to end in `direction` (…, n), rad.

    The first lies at the origin; together they are `length` (…) long.
    """
    step = np.asarray(length)[..., None] / direction.shape[-1]
    steps = np.stack([step * np.cos(direction), step * np.sin(direction)], axis=-1)
    return np.concatenate([np.zeros_like(steps[..., :1, :]), np.cumsum(steps, axis=-2)], axis=-2)


class Spines(NamedTuple):
    """A spine at T times, in the axes (ahead, left) of its path at the fish's centre."""

    place: Array  # (T, n + 1, 2) of the ends of its units, from the snout on
    direction: Array  # (T, n) of the units, rad to the left


JOINTS = np.linspace(0.0, 1.0, UNITS + 1)
MIDDLES = 0.5 * (JOINTS[1:] + JOINTS[:-1])


def spines(plan: SpinePlan, beat: Array, amplitude: float, path: Array, mass: Array) -> Spines:
    """The spine at the times `beat` (T,), on a path that has the directions `path` (T, n).

    `path` is the direction where each unit lies, against that at the centre. As far as it gives
    way, the body follows its path as a train does; about that it swings. How the whole of it
    lies is left open by that; the water would let it neither sway nor yaw, so of all rigid
    motions the one is taken that brings the units, of `mass` (n,), nearest to the path.
    """
    give = np.minimum(along(np.asarray(plan.swing.flexibility), JOINTS[1:-1]), 1.0)
    bent = np.zeros_like(path)
    bent[:, 1:] = np.cumsum(give * np.diff(path, axis=1), axis=1)
    bent -= _at(bent, MIDDLES, plan.centre)[:, None]
    direction = bent + swung(plan.swing, MIDDLES, np.asarray(beat)[:, None], amplitude)
    place, goal = -laid(direction), -laid(path)
    goal -= _at(goal, JOINTS, plan.centre)[:, None]
    share = mass / mass.sum()
    (a, a_mean), (b, b_mean) = (_centred(ends, share) for ends in (place, goal))
    across = np.einsum("n,tn->t", share, a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
    turn = np.arctan2(across, np.einsum("n,tnk->t", share, a * b))
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.stack([np.stack([c, s], axis=-1), np.stack([-s, c], axis=-1)], axis=-2)
    return Spines((place - a_mean) @ rotation + b_mean, direction + turn[:, None])


def _centred(ends: Array, share: Array) -> tuple[Array, Array]:
    """Middles of the units (T, n, 2) about their centre of mass, and that centre (T, 1, 2)."""
    middles = 0.5 * (ends[:, 1:] + ends[:, :-1])
    mean = np.einsum("n,tnk->tk", share, middles)[:, None]
    return middles - mean, mean


def _at(values: Array, places: Array, at: float) -> Array:
    """Linear interpolation along axis 1 of `values` (T, n, …), known at `places` (n,)."""
    k = int(np.clip(np.searchsorted(places, at) - 1, 0, len(places) - 2))
    share = (at - places[k]) / (places[k + 1] - places[k])
    return np.asarray((1.0 - share) * values[:, k] + share * values[:, k + 1])


def carried(spine: Spines, points: Array) -> Array:
    """Points (T, p, 3) in path axes (ahead, up, right) that are at `points` on the fish at rest.

    `points` are (p, 3), or (T, p, 3) where they move on the body. Each lies on the normal of its
    place on the spine, as far from it as at rest (KS III.B).
    """
    at = np.broadcast_to(points[..., 0], (len(spine.place), points.shape[-2]))
    right = np.broadcast_to(points[..., 2], at.shape)
    out = np.empty((*at.shape, 3))
    for t, (place, direction) in enumerate(zip(*spine, strict=True)):
        theta = np.interp(at[t], MIDDLES, direction)
        beyond = at[t] - np.clip(at[t], 0.0, 1.0)  # parts beyond the ends continue straight
        ahead, left = (np.interp(at[t], JOINTS, place[:, k]) for k in range(2))
        out[t, :, 0] = ahead - beyond * np.cos(theta) + right[t] * np.sin(theta)
        out[t, :, 2] = -(left - beyond * np.sin(theta)) + right[t] * np.cos(theta)
    out[..., 1] = points[..., 1]
    return out


def flapped(wings: Wings, points: Array, span: float, beat: Array, amplitude: float) -> Array:
    """The points (p, 3) of a body at rest with its wings at the times `beat`: (T, p, 3).

    `span` is that of one wing. What weighs on the wings moves the body the other way: the mean
    of all points neither rises nor sinks.
    """
    x, up, right = points.T
    reach = np.abs(right)
    front, rear = wings.chord
    late = np.asarray(beat)[:, None] - wings.chord_lag * np.clip(
        (x - front) / (rear - front), 0.0, 1.0
    )
    out_to = (reach / span)[:, None] * (np.arange(WING_UNITS) + 0.5) / WING_UNITS  # (p, n)
    chain = laid(_lifted(wings, out_to, late[..., None], amplitude), reach)[..., -1, :]
    tilt = _lifted(wings, reach / span, late, amplitude)
    out = np.empty((len(late), *points.shape))
    out[..., 0] = x
    out[..., 1] = chain[..., 1] + up * np.cos(tilt)
    out[..., 2] = np.sign(right) * (chain[..., 0] - up * np.sin(tilt))
    out[..., 1] -= (out[..., 1] - up).mean(axis=1, keepdims=True)
    return out


def _lifted(wings: Wings, at: Array, beat: Array, amplitude: float) -> Array:
    """Directions, rad upward, of the units of a wing."""
    give = along(np.asarray(wings.swing.flexibility), at)
    return np.asarray(
        swung(wings.swing, at, beat, amplitude) + np.radians(wings.raised) * np.minimum(give, 1.0)
    )
