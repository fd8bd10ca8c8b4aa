"""The kinematic model of spine-driven fishes (KS part II).

Four factors determine the direction of each unit of a spine: the swing function, the inflection
points, the rule by which the swing propagates from the central one, and the flexibility of each
part (KS's stiffness factors). Units are joined end to end, so the spine keeps its length. Wings,
chains of units from the spine to the tip, follow the same rules. The surface keeps its distance to
the units (KS III.B).

Lengths are in body lengths and time in beats; plans are in degrees, all other angles in radians.
Bodies at rest have the axes (distance behind the snout, up, right).
"""

from itertools import pairwise
from typing import Annotated, Literal, NamedTuple

import msgspec
import numpy as np

from subsea.base.arrays import Array
from subsea.fish.surface import along

UNITS = 240  # of a spine
WING_UNITS = 32  # from the spine to any point of a wing
MODEL_LENGTHS = (10.0, 300.0)  # cm, of the recorded fish
RUN_IN = 0.4  # least path length of a sharp turn less the fish's own length, body lengths

Share = Annotated[float, msgspec.Meta(ge=0, le=1)]
Angle = Annotated[float, msgspec.Meta(ge=0, le=90)]
Place = Annotated[float, msgspec.Meta(ge=-5, le=5)]
Flexibility = Annotated[float, msgspec.Meta(ge=0, le=3)]
Contraction = Annotated[float, msgspec.Meta(ge=0, le=0.4)]
Beat = Annotated[int, msgspec.Meta(ge=8, le=200)]


class Swing(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The swing of a chain of units; positions are fractions of its length.

    ``inflections`` are half a wave apart and may lie beyond the ends. ``flexibility`` are
    (position, factor) of the swing: 0 is rigid, above 1 amplifies.
    """

    angle: Angle  # degrees, of a part of flexibility 1 at amplitude 1
    function: Literal["sinusoidal", "linear"] = "sinusoidal"
    inflections: tuple[Place, Place, Place]
    propagation: Literal["tailward", "outward", "at once"] = "tailward"
    flexibility: Annotated[tuple[tuple[Share, Flexibility], ...], msgspec.Meta(min_length=2)]

    def __post_init__(self) -> None:
        """Refuse positions out of order, and a wave that turns back."""
        if any(b - a < 0.05 for a, b in pairwise(self.inflections)):
            raise ValueError("inflections must follow one another by 0.05 or more")
        if any(b <= a for (a, _), (b, _) in pairwise(self.flexibility)):
            raise ValueError("the places of flexibility must follow one another")
        if (np.diff(phase(self, np.linspace(0.0, 1.0, 50))) <= 0).any():
            raise ValueError("inflections are spaced too unevenly: the wave would turn back")

    @property
    def wavelength(self) -> float:
        """From the first inflection point to the last."""
        return self.inflections[2] - self.inflections[0]


class WingMuscles(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The muscles on back and belly of wings: they and the water bend them in place of the swing.

    ``contraction`` are shares of a rest length, at the spine and at the tip, in the strongest beat.
    The wave of contractions runs to the rear and, late by ``tip_lag``, to the tip.
    """

    stiffness: Annotated[float, msgspec.Meta(ge=1e3, le=1e6)]  # g/tu², where the disc is thickest
    viscosity: Annotated[float, msgspec.Meta(gt=0, le=1e4)]  # g/tu
    contraction: tuple[Contraction, Contraction]
    wavelength: Annotated[float, msgspec.Meta(ge=0.3, le=10)]  # along the chord, body lengths
    tip_lag: Annotated[float, msgspec.Meta(ge=0, le=1)] = 0.0  # beats


class Wings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A pair of wings, each a chain of units from the spine (0) to the tip (1)."""

    swing: Swing
    chord: tuple[Share, Share]  # front and rear of their roots on the body
    chord_lag: Annotated[float, msgspec.Meta(ge=0.05, le=1)]  # beats, of their rear edge
    raised: Annotated[float, msgspec.Meta(ge=-30, le=30)] = 0.0  # degrees, mean of the beat
    muscles: WingMuscles | None = None

    def __post_init__(self) -> None:
        """Refuse wings without chord."""
        if self.chord[1] - self.chord[0] < 0.05:
            raise ValueError("the chord must run from front to rear, 0.05 or more")


class SpineMuscles(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The muscles on both sides of a spine: they and the water bend it in place of the swing.

    ``contraction`` are shares of a rest length, of the foremost and of the hindmost muscle, in
    the strongest beat.
    """

    rings: Annotated[int, msgspec.Meta(ge=8, le=40)] = 16
    stiffness: Annotated[float, msgspec.Meta(ge=100, le=1e5)]  # g/tu², where the body is tallest
    viscosity: Annotated[float, msgspec.Meta(gt=0, le=1e4)]  # g/tu
    contraction: tuple[Contraction, Contraction]
    wavelength: Annotated[float, msgspec.Meta(ge=0.3, le=3)]  # of the contractions, body lengths


class SpineGait(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One grade of swimming.

    ``slip`` is the speed of the fish over that of its wave; without it the water decides.
    """

    ticks_per_beat: Beat  # of 0.033 s
    amplitude: Share  # of the swing
    contraction: Share = 1.0  # of the muscles, over their strongest
    slip: Annotated[float, msgspec.Meta(gt=0, lt=1)] | None = None


class Turn(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A turn at grade medium along a curved path."""

    gradual: Annotated[float, msgspec.Meta(gt=0, le=60)]  # degrees per beat
    sharp: Annotated[float, msgspec.Meta(gt=0, le=120)]  # degrees in total
    sharp_beats: Annotated[int, msgspec.Meta(ge=1, le=20)]
    bank: Annotated[float, msgspec.Meta(ge=0, le=60)] = 0.0  # degrees, at the greatest curvature


class SpinePlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The motion of a spine-driven species: the [spine] table of its file.

    Muscles, where there are any, move the fish. Without them, and in previews, the swing does.
    """

    length: Annotated[float, msgspec.Meta(ge=MODEL_LENGTHS[0], le=MODEL_LENGTHS[1])]  # cm
    centre: Annotated[float, msgspec.Meta(ge=0.1, le=0.7)]  # behind the snout; follows the path
    swing: Swing
    muscles: SpineMuscles | None = None
    wings: Wings | None = None
    slow: SpineGait
    medium: SpineGait
    fast: SpineGait
    burst: SpineGait | None = None
    turn: Turn

    def __post_init__(self) -> None:
        """Refuse grades out of order, and a sharp turn that ends before the tail follows."""
        grades = [one for one in (self.slow, self.medium, self.fast, self.burst) if one]
        if len({one.slip is None for one in grades}) > 1:
            raise ValueError("either all gaits have a slip or none")
        if self.muscles and (self.wings or self.medium.slip is not None):
            raise ValueError("[spine.muscles] need a body without wings, and gaits without slip")
        if self.wings and self.wings.muscles and self.medium.slip is not None:
            raise ValueError("[spine.wings.muscles] need gaits without slip")
        speeds = [(one.slip or 1.0) / one.ticks_per_beat for one in grades]
        if any(b <= a for a, b in pairwise(speeds)):
            raise ValueError("slow, medium, fast and burst must each be faster than the one before")
        way = self.turn.sharp_beats * (self.medium.slip or 1.0) * self.wavelength
        if self.medium.slip and way < 1.0 + RUN_IN:
            raise ValueError(
                f"sharp_beats = {self.turn.sharp_beats} make a way of {way:.2f} body lengths; "
                f"expected {1.0 + RUN_IN:g} or more, for the tail to come round"
            )

    @property
    def wavelength(self) -> float:
        """Body lengths along wing chord or spine that the wave moves in a beat."""
        if self.wings:
            front, rear = self.wings.chord
            return (rear - front) / self.wings.chord_lag
        return self.swing.wavelength


def phase(swing: Swing, at: Array) -> Array:
    """Phase of the swing at positions `at`: a parabola through -π, 0, π at the inflections."""
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


def swing_angles(swing: Swing, at: Array, beat: Array, amplitude: float | Array) -> Array:
    """Directions, rad, of the units at `at` at times `beat`; both are broadcast (KS part II)."""
    now, there = 2.0 * np.pi * np.asarray(beat), phase(swing, at)
    if swing.propagation == "tailward":
        share = oscillation(swing, now - there)
    elif swing.propagation == "outward":
        share = oscillation(swing, now - np.abs(there))
    else:
        share = oscillation(swing, now) * oscillation(swing, there)
    give = along(np.asarray(swing.flexibility), np.asarray(at))
    return np.asarray(np.radians(swing.angle) * amplitude * give * share)


def chain_points(direction: Array, length: Array | float = 1.0) -> Array:
    """Ends (…, n + 1, 2) of n units in `direction` (…, n), rad, joined from the origin on.

    Their total is `length` (…).
    """
    step = np.asarray(length)[..., None] / direction.shape[-1]
    steps = np.stack([step * np.cos(direction), step * np.sin(direction)], axis=-1)
    return np.concatenate([np.zeros_like(steps[..., :1, :]), np.cumsum(steps, axis=-2)], axis=-2)


class Spines(NamedTuple):
    """A spine at T times, in axes (ahead, left) of the path at the fish's centre."""

    place: Array  # (T, n + 1, 2) ends of the units, from the snout on
    direction: Array  # (T, n) rad to the left


JOINTS = np.linspace(0.0, 1.0, UNITS + 1)
MIDDLES = 0.5 * (JOINTS[1:] + JOINTS[:-1])


def pose_spine(
    plan: SpinePlan, beat: Array, amplitude: float | Array, path: Array, mass: Array
) -> Spines:
    """The spine at times `beat` (T,), on a path with directions `path` (T, n) at its units.

    `amplitude` is a number or (T, 1). `path` is relative to the direction at the centre. Flexible
    parts follow the path and swing about it. As water prevents sway and yaw, the whole is then
    fitted to the path by the rigid motion of least squares, with `mass` (n,) of the units as
    weights.
    """
    give = np.minimum(along(np.asarray(plan.swing.flexibility), JOINTS[1:-1]), 1.0)
    bent = np.zeros_like(path)
    bent[:, 1:] = np.cumsum(give * np.diff(path, axis=1), axis=1)
    bent -= _at(bent, MIDDLES, plan.centre)[:, None]
    direction = bent + swing_angles(plan.swing, MIDDLES, np.asarray(beat)[:, None], amplitude)
    place, goal = -chain_points(direction), -chain_points(path)
    goal -= _at(goal, JOINTS, plan.centre)[:, None]
    share = mass / mass.sum()
    (a, a_mean), (b, b_mean) = (_centred(ends, share) for ends in (place, goal))
    across = np.einsum("n,tn->t", share, a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
    turn = np.arctan2(across, np.einsum("n,tnk->t", share, a * b))
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.stack([np.stack([c, s], axis=-1), np.stack([-s, c], axis=-1)], axis=-2)
    return Spines((place - a_mean) @ rotation + b_mean, direction + turn[:, None])


def _centred(ends: Array, share: Array) -> tuple[Array, Array]:
    """Middles of the units (T, n, 2) relative to their centre of mass, and that (T, 1, 2)."""
    middles = 0.5 * (ends[:, 1:] + ends[:, :-1])
    mean = np.einsum("n,tnk->tk", share, middles)[:, None]
    return middles - mean, mean


def _at(values: Array, places: Array, at: float) -> Array:
    """Linear interpolation along axis 1 of `values` (T, n, …), known at `places` (n,)."""
    k = int(np.clip(np.searchsorted(places, at) - 1, 0, len(places) - 2))
    share = (at - places[k]) / (places[k + 1] - places[k])
    return np.asarray((1.0 - share) * values[:, k] + share * values[:, k + 1])


def bend_points(spine: Spines, points: Array) -> Array:
    """Points (T, p, 3) of the bent body in path axes (ahead, up, right).

    `points` at rest are (p, 3), or (T, p, 3) if they move on the body. Each keeps its distance
    along the normal of the spine (KS III.B).
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


def flap_wings(
    wings: Wings, points: Array, span: float, beat: Array, amplitude: float | Array
) -> Array:
    """Points (T, p, 3) of a body with beating wings at times `beat`, from (p, 3) at rest.

    `span` is that of one wing, `amplitude` a number or (T, 1).
    """
    x, up, right = points.T
    reach = np.abs(right)
    front, rear = wings.chord
    late = np.asarray(beat)[:, None] - wings.chord_lag * np.clip(
        (x - front) / (rear - front), 0.0, 1.0
    )
    out_to = (reach / span)[:, None] * (np.arange(WING_UNITS) + 0.5) / WING_UNITS  # (p, n)
    far = np.asarray(amplitude)[..., None]
    chain = chain_points(_lifted(wings, out_to, late[..., None], far), reach)[..., -1, :]
    tilt = _lifted(wings, reach / span, late, amplitude)
    out = np.empty((len(late), *points.shape))
    out[..., 0] = x
    out[..., 1] = chain[..., 1] + up * np.cos(tilt)
    out[..., 2] = np.sign(right) * (chain[..., 0] - up * np.sin(tilt))
    return out


def keep_height(moved: Array, rest: Array) -> Array:
    """Move points (T, p, 3) up or down, so that their mean height is that of `rest` (p, 3)."""
    shift = (rest[:, 1] - moved[..., 1]).mean(axis=1)
    return np.asarray(moved + shift[:, None, None] * (0.0, 1.0, 0.0))


def _lifted(wings: Wings, at: Array, beat: Array, amplitude: Array | float) -> Array:
    """Directions, rad upward, of the units of a wing."""
    give = along(np.asarray(wings.swing.flexibility), at)
    return np.asarray(
        swing_angles(wings.swing, at, beat, amplitude)
        + np.radians(wings.raised) * np.minimum(give, 1.0)
    )
