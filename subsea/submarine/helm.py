"""Commands of the pilot: the ten manoeuvres of SMC §8.2."""

from typing import NamedTuple


class Helm(NamedTuple):
    """Commands in [-1, 1]: shares of full thrust.

    =============  ==========================  ============================
    field          positive                    negative
    =============  ==========================  ============================
    ``surge``      accelerate ahead            decelerate, then reverse
    ``yaw``        turn left                   turn right
    ``pitch``      nose up                     nose down
    ``heave``      rise                        dive
    =============  ==========================  ============================

    ``full_stop`` overrides all: the hull brakes, levels and holds its heading.
    """

    surge: float = 0.0
    yaw: float = 0.0
    pitch: float = 0.0
    heave: float = 0.0
    full_stop: bool = False


NEUTRAL = Helm()
STATION = Helm(full_stop=True)
