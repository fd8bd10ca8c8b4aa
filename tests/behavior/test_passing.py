"""On which side a fish of a school passes what stands in its way."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.behavior.passing import BERTH_BL, LOOK_BL, past
from subsea.kinematics.vector import ZERO

LENGTH = 20.0
BERTH = BERTH_BL * LENGTH
AHEAD = (1.0, 0.0, 0.0)
NONE = np.zeros((0, 7))


def way_past(pillar, heading=AHEAD, wish=AHEAD, here=(0.0, 0.0, -200.0)):
    return past(wish, heading, here, LENGTH, np.array([pillar]), NONE)


@pytest.mark.parametrize(
    ("pillar", "why"),
    [
        ((150.0, 40.0 + BERTH + 1.0, 40.0, -50.0), "aside"),
        ((-100.0, 0.0, 40.0, -50.0), "behind"),
        ((41.0 + LOOK_BL * LENGTH, 0.0, 40.0, -50.0), "far"),
        ((150.0, 0.0, 40.0, -201.0), "below"),
    ],
)
def test_what_is_not_in_the_way_does_not_matter(pillar, why):
    assert way_past(pillar) == ZERO
    assert way_past((150.0, 0.0, 40.0, -50.0)) != ZERO


@given(
    x=st.floats(70.0, 250.0), y=st.floats(-60.0, 60.0),
    turn=st.floats(-0.5, 0.5), radius=st.floats(20.0, 60.0),
)  # fmt: skip
def test_the_way_is_the_tangent_on_the_side_that_the_fish_heads_to(x, y, turn, radius):
    heading = (np.cos(turn), np.sin(turn), 0.0)
    way = way_past((x, y, radius, -50.0), heading)
    if way == ZERO:
        assert abs(y) >= radius + BERTH or x - radius > LOOK_BL * LENGTH - 60.0
        return
    assert np.linalg.norm(way) == pytest.approx(1.0)
    left = heading[0] * y - heading[1] * x  # the middle is to the left if this is positive
    passes = way[0] * y - way[1] * x
    assert passes * left >= -1e-9
    assert abs(passes) == pytest.approx(min(radius + BERTH, np.hypot(x, y)), rel=1e-6)


def test_a_fish_beside_an_obstacle_is_not_drawn_back_in_front_of_it():
    """Its leader is on the other side: the wish leads through, the heading past on the right."""
    way = way_past((60.0, 30.0, 40.0, -50.0), heading=(0.7, -0.7, 0.0), wish=(0.5, 0.9, 0.0))
    assert way[1] < 0.0


def test_of_two_fishes_abreast_each_takes_its_own_side():
    left = way_past((150.0, 0.0, 40.0, -50.0), here=(0.0, 5.0, -200.0))
    right = way_past((150.0, 0.0, 40.0, -50.0), here=(0.0, -5.0, -200.0))
    assert left[1] > 0.0 > right[1]
    assert left[1] == pytest.approx(-right[1])


def test_the_nearest_of_several_counts_rocks_among_them():
    pillars = np.array([[200.0, 5.0, 30.0, -50.0]])
    rock = np.array([[100.0, -5.0, -200.0, 40.0, 20.0, 30.0, 0.0]])
    assert past(AHEAD, AHEAD, (0.0, 0.0, -200.0), LENGTH, pillars, NONE)[1] < 0.0
    assert past(AHEAD, AHEAD, (0.0, 0.0, -200.0), LENGTH, pillars, rock)[1] > 0.0
    over = rock.copy()
    over[0, 2] = -240.0  # its top is below the fish
    assert past(AHEAD, AHEAD, (0.0, 0.0, -200.0), LENGTH, pillars, over)[1] < 0.0
