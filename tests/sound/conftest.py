import numpy as np
import pytest

from subsea.scenario.load import load_scenario
from subsea.sound.mixer import Mixer, SoundLevels
from subsea.sound.moment import hear, sources_of
from subsea.sound.space import LAYOUTS, Listener, listener_of
from subsea.submarine.vessel import NEUTRAL
from subsea.world.build import create_world
from subsea.world.step import step

FULL = SoundLevels(volume=1.0)
AHEAD = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def ears(place=(0.0, 0.0, -300.0), velocity=(0.0, 0.0, 0.0), aboard=False):
    """A listener who looks along x."""
    return Listener(np.array(place), AHEAD, np.array(velocity), aboard)


def mixed(*moments, layout=LAYOUTS["stereo"], levels=FULL):
    """The samples (n, c) of consecutive moments."""
    mixer = Mixer(layout)
    return np.concatenate([mixer.mix(one, levels) for one in moments])


@pytest.fixture(scope="session")
def heard():
    """The bay, and the moments of its first five seconds aboard."""
    world = create_world(load_scenario("peaceful")[0])
    sources, moments = sources_of(world), []
    for _ in range(150):
        step(world, NEUTRAL)
        moments.append(hear(world, listener_of(world), sources))
    return world, moments
