"""A fish that is steered: its brain yields, its body obeys through its own repertoire.

It goes on sensing and feeling, yet has no intention but to wander where it is asked to. Others
take it for the fish that it is. What it is asked for is held clear of what stands in the sea and
of its bounds; the motor system turns the rest into segments, tempo and thrust as ever.
"""

from typing import NamedTuple

import numpy as np

from subsea.behavior.chasing import set_urge
from subsea.behavior.steering import keep_clear
from subsea.core.kernels import kernel
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import dot, times, vector
from subsea.state import WANDER, Fishes, Minds, Sea

# So far aside a full turn asks for. There a fish bends its beat and aligns itself at once; farther
# aside it would throw itself round, which takes a while to begin and is no faster in the end.
ASIDE_RAD = np.radians(50.0)
STEEP_RAD = np.radians(38.0)  # as steep as fishes swim


class TeleopCommand(NamedTuple):
    """What is asked of a fish for a tick, in [-1, 1]; no turn, rise and speed: it hovers."""

    fish: int
    turn: float = 0.0  # left positive
    rise: float = 0.0
    speed: float = 0.0  # share of its fastest; below 0 it backs off


@kernel
def follow_command(
    i: int, turn: float, rise: float, speed: float, fishes: Fishes, minds: Minds, sea: Sea
) -> None:
    """Set the urge and the goal speed of fish i; what was on its mind is forgotten.

    The nearer something is in its way, ahead or astern, the slower it goes, down to a halt.
    """
    minds.intention[i], minds.target[i] = WANDER, -1
    minds.memory[i], minds.resumed[i] = -1, False
    minds.preference[i] = 0.0
    fishes.gape[i] = 0.0
    one = np.array([i])
    ahead = x_axis(fishes.orientation[i])
    way = ahead if speed >= 0.0 else times(-1.0, ahead)
    set_urge(minds, i, way)
    keep_clear(one, fishes, minds, sea)
    fishes.goal_speed[i] = speed * max(dot(vector(minds.urge[i]), way), 0.0)
    heading = np.arctan2(ahead[1], ahead[0]) + turn * ASIDE_RAD
    climb = rise * STEEP_RAD
    level = np.cos(climb)
    set_urge(minds, i, (level * np.cos(heading), level * np.sin(heading), np.sin(climb)))
    keep_clear(one, fishes, minds, sea)
