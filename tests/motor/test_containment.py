"""Bodies are in free water after every tick, whatever the motion."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.geometry.rotation import about, multiply, quaternion, rotate
from subsea.motor.containment import GAP_CM, SWING, contain, deepest
from subsea.motor.pose import ends
from tests.support.scenes import everyone

DT = 0.033
PILLARS = [[300.0, 0.0, 50.0, -100.0]]
ROCKS = [[0.0, 60.0, -300.0, 70.0, 50.0, 80.0, 0.0], [0.0, -60.0, -300.0, 70.0, 50.0, 80.0, -0.3]]
PLACES = {  # just outside each barrier, with the way that leads into it
    "wall": ((970.0, 0.0, -300.0), (1.0, 0.0, 0.0)),
    "surface": ((0.0, 500.0, -20.0), (0.0, 0.0, 1.0)),
    "seabed": ((0.0, 500.0, -580.0), (0.0, 0.0, -1.0)),
    "pillar": ((230.0, 0.0, -300.0), (1.0, 0.0, 0.0)),
    "rock": ((0.0, 130.0, -300.0), (0.0, -1.0, 0.0)),
}


@pytest.fixture(scope="module")
def straight():
    """Rows of nodes (1, 23, 3) of a straight fish of 20 cm: snout 7 cm ahead, tail 13 behind."""
    nodes = np.zeros((1, 23, 3), np.float32)
    nodes[0, 0, 0] = 7.0
    nodes[0, 21:, 0] = -13.0
    return nodes


def moved(tank, place, step, angle=0.0):
    """A tank whose fish has just moved by `step` from a place, turned by `angle` rad."""
    t = tank(1, pillars=PILLARS, rocks=ROCKS)
    t.fishes.previous_position[0] = place
    t.fishes.previous_orientation[0] = t.fishes.orientation[0]
    t.fishes.position[0] = np.asarray(place) + step
    before = quaternion(t.fishes.orientation[0].astype(np.float64))
    t.fishes.orientation[0] = multiply(about(0.0, 0.0, 1.0, angle), before)
    return t


def gap(t, straight):
    """The least gap of snout, middle and tail to any barrier."""
    q = quaternion(t.fishes.orientation[0].astype(np.float64))
    nose, edge = (rotate(q, end) for end in ends(t.fishes, straight, 0))
    middle = tuple(t.fishes.position[0].astype(np.float64))
    return deepest(middle, nose, edge, t.sea, np.float32(0.0))[0]


@pytest.mark.parametrize("barrier", PLACES)
def test_what_reaches_beyond_a_barrier_is_moved_back(tank, straight, barrier):
    place, way = PLACES[barrier]
    step = 45.0 * np.array(way)
    t = moved(tank, place, step)
    assert gap(t, straight) < 0.0
    contain(everyone(t.fishes), t.fishes, straight, t.sea, DT)
    assert 0.0 <= gap(t, straight) < 10 * GAP_CM
    # Along the barrier nothing changes, and the velocity is that of the corrected motion.
    back = t.fishes.position[0] - np.asarray(place) - step
    assert np.linalg.norm(np.cross(back, way)) < 1e-3
    np.testing.assert_allclose(
        t.fishes.velocity[0], (t.fishes.position[0] - np.asarray(place)) / DT, atol=0.01
    )


def test_free_fishes_and_those_on_the_hook_are_left_alone(tank, straight):
    t = moved(tank, (500.0, 0.0, -300.0), (3.0, 0.0, 0.0))
    before = t.fishes.velocity[0].copy()
    contain(everyone(t.fishes), t.fishes, straight, t.sea, DT)
    assert t.fishes.position[0].tolist() == [503.0, 0.0, -300.0]
    assert t.fishes.velocity[0].tolist() == before.tolist()
    t = moved(tank, (0.0, 500.0, -20.0), (0.0, 0.0, 45.0))
    t.sea.catch[1] = 0
    contain(everyone(t.fishes), t.fishes, straight, t.sea, DT)
    assert t.fishes.position[0, 2] == 25.0


def test_a_fish_that_a_panel_put_into_stone_comes_out_gently(tank, straight):
    t = moved(tank, (0.0, 60.0, -300.0), (0.1, 0.0, 0.0))
    contain(everyone(t.fishes), t.fishes, straight, t.sea, DT)
    assert np.linalg.norm(t.fishes.position[0] - [0.0, 60.0, -300.0]) < SWING * 20.0 + 0.3


@given(
    st.sampled_from(sorted(PLACES)), st.floats(-np.pi, np.pi), st.floats(-1.0, 1.0),
    st.floats(0.0, 25.0),
)  # fmt: skip
def test_no_motion_from_free_water_ends_outside(tank, straight, barrier, heading, climb, far):
    """A turn and a leap in any direction, also into the cleft between two rocks."""
    place = PLACES[barrier][0]
    step = far * np.array([np.cos(heading), np.sin(heading), climb])
    t = moved(tank, place, step, heading)
    contain(everyone(t.fishes), t.fishes, straight, t.sea, DT)
    assert gap(t, straight) >= 0.0
