"""Mating colours."""

import numpy as np
import pytest

from subsea.behavior.courtship import ease_display
from subsea.state import CIRCLING, LOOPING, NO_COURTSHIP, PREDATOR, Clock
from tests.support.scenes import everyone


def _wait(t, seconds, dt=0.033):
    for tick in range(round(seconds / dt)):
        ease_display(everyone(t.fishes), t.fishes, t.minds, t.sea, Clock(0, tick, dt))


@pytest.fixture
def four(tank):
    """A courting male, a courting female, a male that does not court, a dead one that did."""
    t = tank(4)
    t.minds.male[:] = True, False, True, True
    t.minds.courtship[:] = LOOPING, LOOPING, NO_COURTSHIP, CIRCLING
    t.fishes.alive[3] = False
    return t


def test_only_a_courting_male_grows_colourful_within_two_seconds(four):
    _wait(four, 0.3)
    assert 0.2 < four.fishes.display[0] < 0.6
    _wait(four, 1.7)
    assert four.fishes.display[0] == pytest.approx(1.0, abs=0.06)
    np.testing.assert_array_equal(four.fishes.display[1:], 0.0)


def test_he_fades_when_it_is_over_and_stays_in_range(four):
    _wait(four, 60.0)
    assert 0.99 < four.fishes.display[0] <= 1.0
    four.minds.courtship[:] = NO_COURTSHIP
    before = four.fishes.display[0]
    _wait(four, 0.033)
    assert before - 0.06 < four.fishes.display[0] < before
    _wait(four, 4.0)
    assert 0.0 <= four.fishes.display[0] < 0.01


def test_the_ease_does_not_depend_on_the_step(four):
    _wait(four, 0.9, 0.01)
    finely = four.fishes.display[0]
    four.fishes.display[:] = 0.0
    _wait(four, 0.9, 0.09)
    assert four.fishes.display[0] == pytest.approx(finely, abs=1e-4)


def test_fishes_turn_pale_by_night_but_not_hunters_nor_a_courting_male(four):
    four.sea.sky[1] = 0.0
    four.minds.kind[2] = PREDATOR
    _wait(four, 5.0)
    np.testing.assert_allclose(four.fishes.display, [1.0, -1.0, 0.0, -1.0], atol=0.01)
    assert (four.fishes.raised >= 0.0).all()


def test_fishes_raise_their_fins_to_mates_and_predators(four):
    four.minds.menace[:] = 0.0, 0.4, 0.0, 0.0
    _wait(four, 2.0)
    assert four.fishes.raised == pytest.approx([four.fishes.display[0], 0.4, 0.0, 0.0])
