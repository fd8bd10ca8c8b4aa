import numpy as np
import pytest

from subsea.scenario.load import load_scenario
from subsea.sound.soundtrack import Soundtrack
from subsea.sound.space import LAYOUTS, Listener, listener_of
from subsea.submarine.vessel import NEUTRAL
from subsea.world.build import create_world
from subsea.world.step import step

AHEAD = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def ears(place=(0.0, 0.0, -300.0), velocity=(0.0, 0.0, 0.0), aboard=False):
    """A listener who looks along x."""
    return Listener(np.array(place), AHEAD, np.array(velocity), aboard)


@pytest.fixture(scope="session")
def heard():
    """The bay, and what is heard in its first five seconds aboard."""
    world, track = create_world(load_scenario("peaceful")[0]), Soundtrack(LAYOUTS["stereo"])
    for _ in range(150):
        step(world, NEUTRAL)
        track.listen(world, listener_of(world))
    return world, track
