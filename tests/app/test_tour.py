"""The autopilot finds the fishes and keeps its distance."""

import numpy as np
import pytest

from subsea.app.start import start_world
from subsea.app.tour import tour_helm
from subsea.ocean import step
from subsea.state import digest


@pytest.fixture(scope="module")
def world():
    return start_world("peaceful", seed=1)


def test_it_comes_near_the_largest_shoal_and_looks_at_it(world):
    largest = np.bincount(world.state.fishes.species).argmax()
    seen = []
    for tick in range(900):
        step(world, tour_helm(world))
        if tick > 300:
            boat, fishes = world.state.submarine, world.state.fishes
            middle = np.median(fishes.position[fishes.species == largest], axis=0)
            offset = middle - boat.position
            heading = boat.angles[0]
            ahead = offset[0] * np.cos(heading) + offset[1] * np.sin(heading)
            seen.append(ahead > 0.75 * np.hypot(*offset[:2]))
            assert np.linalg.norm(offset) < 900.0
    assert np.mean(seen) > 0.8


def test_the_same_tour_each_time():
    digests = []
    for _ in range(2):
        world = start_world("peaceful", seed=5, fish=10)
        for _ in range(30):
            step(world, tour_helm(world))
        digests.append(digest(world.state))
    assert digests[0] == digests[1]
