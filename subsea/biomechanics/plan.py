"""The numbers that make one species' body and motion: the [body], [swim] and [turn] tables."""

from itertools import pairwise
from typing import Annotated

import msgspec

Positive = Annotated[float, msgspec.Meta(gt=0)]
Fraction = Annotated[float, msgspec.Meta(ge=0, le=0.6)]


class BodyPlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Geometry and material of a fish body (Tu §4.2-4.3): cm, g and tu (0.1 s).

    ``stations`` are the distances behind the nose tip of nose, five rings and tail tips; their
    last is the body length. ``masses`` are grams per node at the same seven stations.
    """

    stations: tuple[float, float, float, float, float, float, float]
    half_widths: tuple[Positive, Positive, Positive, Positive, Positive]
    half_heights: tuple[Positive, Positive, Positive, Positive, Positive]
    tail_half_height: Positive
    masses: tuple[Positive, Positive, Positive, Positive, Positive, Positive, Positive]
    cross_stiffness: Positive = 38.0
    muscle_stiffness: Positive = 28.0
    other_stiffness: Positive = 30.0
    viscosity: Positive = 0.1
    water_drag: Positive = 1.0

    def __post_init__(self) -> None:
        """Refuse stations that do not run from 0 at the nose backwards."""
        if self.stations[0] != 0 or any(b <= a for a, b in pairwise(self.stations)):
            raise ValueError("stations must begin with 0 and increase from nose to tail")

    @property
    def length(self) -> float:
        """Body length, nose to tail tips, in cm."""
        return self.stations[-1]


class SwimPlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The swim controller (Tu §4.6.1): contractions are fractions of a muscle's rest length.

    ``contraction`` holds those of the anterior and posterior swimming segment at grade fast;
    ``slow`` and ``medium`` are the amplitudes of the other grades relative to it. ``lag`` is the
    phase in radians by which the posterior segment follows the anterior one.
    """

    ticks_per_beat: Annotated[int, msgspec.Meta(ge=4)]
    contraction: tuple[Fraction, Fraction]
    lag: Annotated[float, msgspec.Meta(ge=0, le=3.2)]
    slow: Annotated[float, msgspec.Meta(gt=0, lt=1)]
    medium: Annotated[float, msgspec.Meta(gt=0, lt=1)]


class Steering(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One row of the steering map (Tu fig. 4.9): how to turn by ``angle`` degrees.

    The anterior and posterior turning segment contract to ``contraction`` within ``bend_ticks``,
    hold it for ``hold_ticks`` and relax over ``restore_ticks``.
    """

    angle: Annotated[float, msgspec.Meta(gt=0, le=90)]
    contraction: tuple[Fraction, Fraction]
    bend_ticks: Annotated[float, msgspec.Meta(gt=0)]
    hold_ticks: Annotated[float, msgspec.Meta(ge=0)]
    restore_ticks: Annotated[float, msgspec.Meta(gt=0)]


class TurnPlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The turn controllers (Tu §4.6.1): contractions on the inner side of the turn.

    A gradual turn adds the constant ``gradual`` to the two turning segments while the fish
    swims at grade medium. A sharp turn by ``sharp`` degrees follows the steering map; while it
    lasts the tail beats with ``amplitude`` relative to grade fast.
    """

    gradual: tuple[Fraction, Fraction]
    sharp: Annotated[float, msgspec.Meta(gt=0, le=90)]
    amplitude: Annotated[float, msgspec.Meta(ge=0, le=1)]
    steering: Annotated[tuple[Steering, ...], msgspec.Meta(min_length=2)]

    def __post_init__(self) -> None:
        """Refuse a steering map whose angles do not increase."""
        angles = [row.angle for row in self.steering]
        if any(b <= a for a, b in pairwise(angles)):
            raise ValueError("the angles of the steering map must increase")
