"""Body and motion parameters of a species: the [body], [swim] and [turn] tables."""

from itertools import pairwise
from operator import mul
from typing import Annotated, Literal, NamedTuple

import msgspec

NODES_AT_STATION = (1, 4, 4, 4, 4, 4, 2)  # nose, five rings of four, two tail tips
MODEL_LENGTHS = (10.0, 40.0)  # cm; far from Tu's 20 cm his time step and muscle speed fit no fish
SHORTEST_SECTION = 0.02
HALF_SIZES = (0.005, 0.45)
"""Least and greatest half-width or half-height of a ring, in body lengths."""
LONGEST = 1000.0  # longest part of a turn in ticks: half a minute
DENSITIES = (0.3, 6.0)  # g per cm³ between the nodes: water, with room for tissue around the nodes

Positive = Annotated[float, msgspec.Meta(gt=0)]
Modulus = Annotated[float, msgspec.Meta(gt=0, le=1e5)]
MAX_CONTRACTION = 0.6
Fraction = Annotated[float, msgspec.Meta(ge=0, le=MAX_CONTRACTION)]
Ticks = Annotated[int, msgspec.Meta(ge=4, le=60)]  # of a beat
Lag = Annotated[float, msgspec.Meta(ge=0, le=3.2)]  # rad
GRADES = ("slow", "medium", "fast", "burst")


def _check(name: str, value: float, limits: tuple[float, float], scale: float, unit: str) -> None:
    """Raise ValueError where a value lies outside ``limits`` times ``scale``."""
    low, high = (limit * scale for limit in limits)
    if not low <= value <= high:
        raise ValueError(f"{name} = {value:g}; expected {low:.3g} to {high:.3g} {unit}")


class BodyPlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Geometry and material of a fish body (Tu §4.2-4.3): cm, g and tu (0.1 s).

    ``stations`` are the distances behind the nose tip of nose, five rings and tail tips; their
    last is the body length. ``masses`` are grams per node at the same seven stations.

    ``water`` is Tu's (eq. 4.3, with ``water_drag`` as its µ) or that of a slender body (Lighthill
    1971). The latter takes the heights of the outline at the rings and of the tail's edge
    (``spans``, cm; by default those of the nodes), the friction coefficient ``skin_drag`` on the
    wetted area, and the cross-flow coefficient ``cross_drag``.

    Model any species at about 20 cm, the length of Tu's constants: playback scales motion to the
    individual (SMC §4.4).
    """

    stations: tuple[float, float, float, float, float, float, float]
    half_widths: tuple[Positive, Positive, Positive, Positive, Positive]
    half_heights: tuple[Positive, Positive, Positive, Positive, Positive]
    tail_half_height: Positive
    masses: tuple[Positive, Positive, Positive, Positive, Positive, Positive, Positive]
    cross_stiffness: Modulus = 38.0
    muscle_stiffness: Modulus = 28.0
    other_stiffness: Modulus = 30.0
    viscosity: Modulus = 0.1
    water_drag: Modulus = 1.0
    water: Literal["tu", "elongated"] = "tu"
    spans: tuple[Positive, Positive, Positive, Positive, Positive, Positive] | None = None
    skin_drag: Annotated[float, msgspec.Meta(ge=0, le=0.1)] = 0.012
    cross_drag: Annotated[float, msgspec.Meta(ge=0, le=3)] = 1.0

    def __post_init__(self) -> None:
        """Reject a body that is implausible or that the simulation cannot carry."""
        if self.stations[0] != 0 or not all(a < b for a, b in pairwise(self.stations)):
            raise ValueError("stations must begin with 0 and increase from nose to tail")
        length = self.length
        _check("stations[6]", length, MODEL_LENGTHS, 1.0, "cm")
        for place, (front, back) in enumerate(pairwise(self.stations), start=1):
            if back - front < SHORTEST_SECTION * length:
                raise ValueError(
                    f"stations[{place}] is {back - front:.3g} cm behind the one before; "
                    f"expected {SHORTEST_SECTION * length:.3g} cm or more at this length"
                )
        sizes = [
            *((f"half_widths[{ring}]", size) for ring, size in enumerate(self.half_widths)),
            *((f"half_heights[{ring}]", size) for ring, size in enumerate(self.half_heights)),
            ("tail_half_height", self.tail_half_height),
            *((f"spans[{k}]", 0.5 * span) for k, span in enumerate(self.spans or ())),
        ]
        for name, size in sizes:
            _check(name, size, HALF_SIZES, length, "cm at this length")
        _check("sum of masses", self.mass, DENSITIES, self.hull_volume, "g in this hull")

    @property
    def section_heights(self) -> tuple[float, ...]:
        """Heights (6,) in cm of the rings and of the tail's edge, for the water."""
        if self.spans is not None:
            return self.spans
        return (*(2.0 * half for half in self.half_heights), 2.0 * self.tail_half_height)

    @property
    def length(self) -> float:
        """Body length in cm, from nose to tail tips."""
        return self.stations[-1]

    @property
    def mass(self) -> float:
        """Total mass of the body in g."""
        return sum(map(mul, self.masses, NODES_AT_STATION))

    @property
    def hull_volume(self) -> float:
        """Volume between the nodes in cm³, cross-sections varying linearly between stations.

        The drawn fish is somewhat larger, as nodes lie inside its skin.
        """
        areas = [
            0.0,
            *(4 * w * h for w, h in zip(self.half_widths, self.half_heights, strict=True)),
            0.0,
        ]
        return sum(
            (back - front) * (a + b) / 2
            for (front, back), (a, b) in zip(pairwise(self.stations), pairwise(areas), strict=True)
        )


class SwimPlan(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True, omit_defaults=True
):
    """The swim controller (Tu §4.6.1): contractions are fractions of a muscle's rest length.

    ``contraction`` holds those of the anterior and posterior swimming segment at grade fast,
    ``ticks_per_beat`` its beat, and ``lag`` the phase in radians by which the posterior segment
    follows the anterior one. Other grades have ``..._contraction``, ``..._ticks`` and ``..._lag``,
    by default those of fast; ``slow``, ``medium`` and ``burst`` scale their contractions.
    """

    ticks_per_beat: Ticks
    contraction: tuple[Fraction, Fraction]
    lag: Lag
    slow: Annotated[float, msgspec.Meta(gt=0, le=1)]
    medium: Annotated[float, msgspec.Meta(gt=0, le=1)]
    burst: Annotated[float, msgspec.Meta(gt=0, le=2)] | None = None  # None: no such grade
    slow_ticks: Ticks | None = None
    medium_ticks: Ticks | None = None
    burst_ticks: Ticks | None = None
    slow_contraction: tuple[Fraction, Fraction] | None = None
    medium_contraction: tuple[Fraction, Fraction] | None = None
    burst_contraction: tuple[Fraction, Fraction] | None = None
    slow_lag: Lag | None = None
    medium_lag: Lag | None = None
    burst_lag: Lag | None = None

    def __post_init__(self) -> None:
        """Reject a slow grade that is not slower than medium, and an impossible burst."""
        alike = self.slow_ticks == self.medium_ticks
        if alike and self.slow_contraction == self.medium_contraction and self.slow >= self.medium:
            raise ValueError(f"slow = {self.slow:g} must be less than medium = {self.medium:g}")
        for key in ("burst_ticks", "burst_contraction", "burst_lag"):
            if self.burst is None and getattr(self, key) is not None:
                raise ValueError(f"{key} needs burst, the amplitude of that grade")
        most = max(self.burst_contraction or self.contraction)
        if self.burst is not None and most * self.burst > MAX_CONTRACTION:
            raise ValueError(f"burst = {self.burst:g} contracts muscles over {MAX_CONTRACTION:g}")

    @property
    def grades(self) -> tuple[str, ...]:
        """Names of the grades, slowest first; burst is the last where there is one."""
        return GRADES[: 3 if self.burst is None else 4]

    def amplitude(self, grade: str) -> float:
        """Share of its contractions with which a grade beats."""
        given = {"slow": self.slow, "medium": self.medium, "fast": 1.0, "burst": self.burst}[grade]
        return 1.0 if given is None else given

    def at(self, grade: str) -> "SwimPlan":
        """This plan with the beat of a grade as that of fast: apply once."""
        if grade == "fast":
            return self
        own = {
            key: value
            for key, suffix in (("ticks_per_beat", "ticks"), ("contraction",) * 2, ("lag",) * 2)
            if (value := getattr(self, f"{grade}_{suffix}")) is not None
        }
        if all(getattr(self, key) == value for key, value in own.items()):
            return self
        if self.burst is not None:  # its contractions stay those of fast
            own.setdefault("burst_contraction", self.burst_contraction or self.contraction)
        return msgspec.structs.replace(self, **own)


class Steering(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One row of the steering map (Tu fig. 4.9): how to turn by ``angle`` degrees.

    The anterior and posterior turning segment contract to ``contraction`` within ``bend_ticks``,
    hold it for ``hold_ticks`` and relax over ``restore_ticks``.
    """

    angle: Annotated[float, msgspec.Meta(gt=0, le=90)]
    contraction: tuple[Fraction, Fraction]
    bend_ticks: Annotated[float, msgspec.Meta(ge=1, le=LONGEST)]
    hold_ticks: Annotated[float, msgspec.Meta(ge=0, le=LONGEST)]
    restore_ticks: Annotated[float, msgspec.Meta(ge=1, le=LONGEST)]


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
        """Reject a steering map whose angles do not increase."""
        angles = [row.angle for row in self.steering]
        if any(b <= a for a, b in pairwise(angles)):
            raise ValueError("the angles of the steering map must increase")
        if self.sharp > angles[-1]:
            raise ValueError(
                f"sharp = {self.sharp:g} lies beyond the steering map, which ends at "
                f"{angles[-1]:g} degrees"
            )


class Muscles(NamedTuple):
    """The three plans of a muscle-driven fish."""

    body: BodyPlan
    swim: SwimPlan
    turn: TurnPlan
