"""Fishes in the shell of free water around stone stay off the drawn stone."""

import numpy as np
import pytest

from subsea.geometry.vector import vector
from subsea.habitat.formations import drawn_distance, formations
from subsea.world.shell import keep_off_drawn
from tests.support.scenes import everyone

PILLARS = np.array([[40.0, 0.0, 30.0, -100.0]])


@pytest.fixture
def beside(tank):
    """A tank with a drawn pillar, and the nodes (1, 23, 3) of a straight fish beside it."""
    nodes = np.zeros((1, 23, 3), np.float32)
    nodes[0, 0, 0], nodes[0, 21:, 0] = 7.0, -13.0
    t = tank(1, pillars=PILLARS)
    stones = np.concatenate(formations(PILLARS, np.zeros((0, 7))))
    t.fishes.shell[:] = 20.0
    t.fishes.previous_position[:] = -20.0, 0.0, -300.0
    t.fishes.previous_orientation[:] = t.fishes.orientation
    return t._replace(sea=t.sea._replace(stones=stones)), nodes


def snout_gap(t):
    place = t.fishes.position[0].astype(np.float64) + [7.0, 0.0, 0.0]
    return drawn_distance(t.sea.stones, vector(place))


def test_a_snout_in_the_drawn_stone_is_moved_out(beside):
    t, nodes = beside
    t.fishes.position[:] = -20.0, 0.0, -300.0
    while snout_gap(t) > -2.0:
        t.fishes.position[0, 0] += 0.5
    inside = t.fishes.position[0].copy()
    keep_off_drawn(everyone(t.fishes), t.fishes, nodes, t.sea, 0.033)
    assert snout_gap(t) >= 0.0
    assert np.linalg.norm(t.fishes.position[0] - inside) < 8.0
    way = (t.fishes.position[0] - t.fishes.previous_position[0]) / 0.033
    np.testing.assert_allclose(t.fishes.velocity[0], way, atol=0.01)


def test_a_fish_out_of_the_shell_is_left_to_other_barriers(beside):
    t, nodes = beside
    t.fishes.position[:], t.fishes.shell[:] = (40.0, 0.0, -300.0), 0.0
    keep_off_drawn(everyone(t.fishes), t.fishes, nodes, t.sea, 0.033)
    assert t.fishes.position[0].tolist() == [40.0, 0.0, -300.0]
