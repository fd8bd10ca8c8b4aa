"""Listeners in a world: the pilot of the submarine, or a fish."""

from collections.abc import Callable

import numpy as np

from subsea.geometry.rotation import rotate
from subsea.sound.space import Listener, listener_at
from subsea.view.display_rigs import cockpit
from subsea.view.rig import CameraPose
from subsea.world.world import World

Head = Callable[[CameraPose], CameraPose]


def at_rest(seat: CameraPose) -> CameraPose:
    """The pose of a head that looks straight ahead."""
    return seat


def listener_of(world: World, fish: int | None = None, head: Head = at_rest) -> Listener:
    """The pilot's ears at the end of the last tick, or those of a living fish.

    `head` gives the pose of the pilot's head on the pilot's seat.
    """
    fishes, submarine = world.state.fishes, world.state.submarine
    if fish is None or not fishes.alive[fish]:
        return listener_at(head(cockpit(submarine, 1.0)), submarine.velocity, aboard=True)
    turn = tuple(float(q) for q in fishes.orientation[fish])
    forward, up = (np.array(rotate(turn, axis)) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    place = fishes.position[fish].astype(np.float64)
    velocity = fishes.velocity[fish].astype(np.float64)
    return listener_at(CameraPose(place, forward, up), velocity, aboard=False)
