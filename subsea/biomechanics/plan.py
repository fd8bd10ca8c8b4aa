"""The numbers that make one species' body and motion: the [body], [swim] and [turn] tables."""

from typing import Annotated

import msgspec

Positive = Annotated[float, msgspec.Meta(gt=0)]
Fraction = Annotated[float, msgspec.Meta(ge=0, le=0.6)]
Ticks = Annotated[int, msgspec.Meta(ge=1)]


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
        ahead = (0.0, *self.stations)
        if self.stations[0] != 0 or any(
            b <= a for a, b in zip(ahead[1:], self.stations[1:], strict=False)
        ):
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


class TurnPlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The turn controllers (Tu §4.6.1): contractions on the inner side of the turn.

    A gradual turn adds the constant ``gradual`` to the two turning segments while the fish
    swims. A sharp turn, entered from a glide of ``glide_ticks``, contracts them to ``sharp``
    within ``bend_ticks``, holds them ``hold_ticks`` and relaxes them over ``restore_ticks``.
    """

    gradual: tuple[Fraction, Fraction]
    sharp: tuple[Fraction, Fraction]
    glide_ticks: Ticks
    bend_ticks: Ticks
    hold_ticks: Annotated[int, msgspec.Meta(ge=0)]
    restore_ticks: Ticks
