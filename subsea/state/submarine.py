"""The submarine's hull."""

from typing import Annotated

from subsea.core.arrays import Array
from subsea.state.declaration import BOOL, F64, starts, submarine, written_by


class Submarine:
    """The hull. Angles are heading (left positive) and pitch (up positive)."""

    position: Annotated[F64, submarine(3, unit="cm"), "centre of the hull"]
    velocity: Annotated[F64, submarine(3, unit="cm/s"), "world axes"]
    angles: Annotated[F64, submarine(2, unit="rad"), "heading and pitch"]
    rates: Annotated[F64, submarine(2, unit="rad/s"), "of heading and pitch"]
    previous_position: Annotated[F64, submarine(3, unit="cm"), "one tick ago"]
    previous_angles: Annotated[F64, submarine(2, unit="rad"), "one tick ago"]
    lights: Annotated[BOOL, written_by("the pilot, directing")(1), "whether the lights are on"]

    def __init__(self, **given: Array) -> None:
        """Arrays that are not given start as zeros."""
        vars(self).update(starts(Submarine, given, {}))
