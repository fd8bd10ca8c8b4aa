"""The spine-driven swimmer: motion from rules instead of from muscles and water (KS part II).

Four factors decide how a spine moves: the function by which it swings, the places of its
inflection points, the rule by which the swing propagates from the central inflection point to
both ends, and how far each part of the spine gives way (KS's stiffness factors). Everything is a
direction of each unit of the spine; places follow by adding the units up, so its length never
changes.
"""

from itertools import pairwise
from typing import Annotated, Any, Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]

Share = Annotated[float, msgspec.Meta(ge=0, le=1)]
Angle = Annotated[float, msgspec.Meta(ge=0, le=90)]
Place = Annotated[float, msgspec.Meta(ge=-5, le=5)]
Give = Annotated[float, msgspec.Meta(ge=0, le=3)]
Beat = Annotated[int, msgspec.Meta(ge=8, le=200)]

MODEL_LENGTHS = (10.0, 300.0)
"""cm, of the fish that is recorded; those in the water may be smaller or larger."""


class Swing(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How one chain of units swings, with places as shares of its length.

    ``inflections`` are where the bend changes sides when the central one swings its farthest:
    half a wave lies between two of them, and they may lie beyond the ends. ``flexibility``
    (place, share) is how much of the swing each part takes: 0 is rigid, above 1 amplifies.
    """

    angle: Angle  # degrees, the farthest that a part of flexibility 1 swings at amplitude 1
    function: Literal["sinusoidal", "linear"] = "sinusoidal"
    inflections: tuple[Place, Place, Place]
    propagation: Literal["tailward", "outward", "at once"] = "tailward"
    flexibility: Annotated[tuple[tuple[Share, Give], ...], msgspec.Meta(min_length=2)]

    def __post_init__(self) -> None:
        """Refuse places that run forwards."""
        if any(b - a < 0.05 for a, b in pairwise(self.inflections)):
            raise ValueError("inflections must follow one another by 0.05 or more")
        if any(b <= a for (a, _), (b, _) in pairwise(self.flexibility)):
            raise ValueError("the places of flexibility must follow one another")

    @property
    def wavelength(self) -> float:
        """Length of the wave, twice the mean distance of the inflection points."""
        return self.inflections[2] - self.inflections[0]


class Wings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A pair of wings: chains of units from the spine to the tips that swing up and down.

    ``swing`` counts its places in half spans, 0 on the spine and 1 at a tip. ``chord_lag`` is the
    share of a beat by which the rear of the wings follows their front.
    """

    swing: Swing
    chord_lag: Share
    raised: Annotated[float, msgspec.Meta(ge=-30, le=30)] = 0.0  # degrees about which they beat


class Gait(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One grade of swimming. Nothing but these numbers decides how fast the fish is.

    ``slip`` is the speed of the fish over that of the wave that runs along it.
    """

    ticks_per_beat: Beat  # of 0.033 s
    amplitude: Annotated[float, msgspec.Meta(ge=0, le=1)]  # of the swing
    slip: Annotated[float, msgspec.Meta(gt=0, lt=1)]


class Turn(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How the fish turns, at the gait of grade medium: its body follows the path that bends."""

    gradual: Annotated[float, msgspec.Meta(gt=0, le=60)]  # degrees each beat
    sharp: Annotated[float, msgspec.Meta(gt=0, le=90)]  # degrees in all
    sharp_beats: Annotated[int, msgspec.Meta(ge=1, le=20)]
    bank: Annotated[float, msgspec.Meta(ge=0, le=60)] = 0.0  # degrees, leaning into a sharp turn


class SpinePlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How a species moves that has a spine but no muscles: the [spine] table of its file."""

    length: Annotated[float, msgspec.Meta(ge=MODEL_LENGTHS[0], le=MODEL_LENGTHS[1])]  # cm
    centre: Annotated[float, msgspec.Meta(ge=0.05, le=0.95)]  # share of the length; keeps the path
    swing: Swing
    wings: Wings | None = None
    slow: Gait
    medium: Gait
    fast: Gait
    turn: Turn
