"""Teleoperation: commands of a pilot or a program replace the intentions of fishes.

The fish still senses and feels, and others react to it as before; its intention is to wander, or
to eat what is before its mouth if it may feed. The command is kept clear of solids and of the
bounds of the sea, and the motor system turns it into segments, tempo and thrust.
"""

from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.behavior.chasing import set_urge
from subsea.behavior.eating import snap
from subsea.behavior.steering import keep_clear
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import dot, times, vector
from subsea.kernels import kernel
from subsea.state import WANDER, Clock, Fishes, Minds, Sea

# Angle of a full turn: a fusilier turns by about 110° a second, which can still be steered.
ASIDE_RAD = np.radians(40.0)
STEEP_RAD = np.radians(38.0)  # steepest command: that of a burst


class TeleopCommand(NamedTuple):
    """The command to a fish for a tick, each in [-1, 1]; all zero: hover."""

    fish: int
    turn: float = 0.0  # left positive
    rise: float = 0.0
    speed: float = 0.0  # share of its fastest; below 0 it backs off


class TeleopCommands(NamedTuple):
    """Commands to k different fishes for a tick."""

    fish: Ints  # (k,)
    turn: Array  # (k,), these three as in `TeleopCommand`
    rise: Array
    speed: Array
    feeds: Bools  # (k,) whether it eats what is before its mouth

    def taken(self, chosen: Any) -> "TeleopCommands":
        """Choose commands by an index or mask."""
        return TeleopCommands(*(part[chosen] for part in self))


def as_commands(command: TeleopCommand) -> TeleopCommands:
    """Make the commands that steer one fish, which does not feed."""
    turn, rise, speed = np.array(command[1:], np.float64)[:, None]
    return TeleopCommands(np.array([command.fish]), turn, rise, speed, np.array([False]))


@kernel
def follow_commands(
    commands: TeleopCommands, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock
) -> None:
    """Steer the commanded fishes, which must be alive."""
    for k, i in enumerate(commands.fish):
        turn, rise, speed = commands.turn[k], commands.rise[k], commands.speed[k]
        follow_command(i, turn, rise, speed, fishes, minds, sea)
        if commands.feeds[k]:
            snap(i, fishes, minds, sea, clock)


@kernel
def follow_command(
    i: int, turn: float, rise: float, speed: float, fishes: Fishes, minds: Minds, sea: Sea
) -> None:
    """Set the urge and the goal speed of fish i, and clear its intention and memory.

    It slows down to a halt before obstacles, ahead or astern.
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
