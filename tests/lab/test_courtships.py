"""Courtships: states, success and rejection."""

import numpy as np
import pytest

from subsea.lab.measures import courtships
from subsea.state import APPROACHING, ASCENDING, CIRCLING, LOOPING, NUZZLING
from tests.support.records import EAST, NORTH, a_record, still

COMPLETE = (APPROACHING, LOOPING, CIRCLING, ASCENDING, NUZZLING)


def courting(states, heading=EAST, ticks=120):
    """A male that goes through `states`, each for two seconds from 1 s on."""
    codes = np.zeros((ticks, 2), int)
    for k, state in enumerate(states):
        codes[10 + 20 * k : 30 + 20 * k, 0] = state
    partner = np.full((ticks, 2), -1)
    partner[30:, 0] = 1
    return a_record(
        still(ticks, (0, 0, -9), (50, 0, -9)), heading, courtship=codes, partner=partner,
        male=np.array([True, False]),
    )  # fmt: skip


def test_a_complete_courtship_has_its_states_in_order():
    (found,) = courtships(courting(COMPLETE))
    assert found.states == COMPLETE
    assert found.complete and not found.rejected
    assert (found.male, found.partner) == (0, 1)
    assert (found.start, found.duration) == pytest.approx((1.1, 10.0))


def test_the_wrong_order_or_no_end_is_not_complete():
    (found,) = courtships(courting((LOOPING, ASCENDING, CIRCLING, NUZZLING)))
    assert not found.complete
    (found,) = courtships(courting(COMPLETE, ticks=100))
    assert not found.complete and not found.rejected


@pytest.mark.parametrize("turns", [True, False])
def test_a_rejected_male_turns_away(turns):
    heading = np.tile(EAST, (120, 2, 1))
    if turns:
        heading[65:, 0] = NORTH  # 1.5 s after the end
    (found,) = courtships(courting((APPROACHING, LOOPING), heading))
    assert found.rejected
    assert found.turned_away == turns


def test_shorter_courtships_do_not_count():
    codes = np.zeros((40, 1), int)
    codes[5:14] = LOOPING
    record = a_record(still(40, (0, 0, -9)), courtship=codes, male=np.array([True]))
    assert courtships(record) == []
