"""Habits of light and temperature (Tu §7.3)."""

import numpy as np

from subsea.behavior import leaving
from subsea.state import BRIGHTNESS, COLD, DARKNESS, PREDATOR, WARMTH


def test_discontent_fishes_leave_in_the_right_direction(tank):
    t = tank(7)
    t.minds.light[:], t.minds.temperature[:] = 0.2, 26.0
    t.minds.likes[1, BRIGHTNESS] = True
    t.minds.likes[2, DARKNESS] = True  # content
    t.minds.likes[3, [BRIGHTNESS, DARKNESS]] = True  # indifferent
    t.minds.likes[4, COLD] = True
    t.minds.likes[5, WARMTH] = True  # content
    t.minds.likes[6, BRIGHTNESS] = True
    t.minds.kind[6] = PREDATOR  # cruises perpetually
    wants = t.desire(leaving.desire) > 0
    np.testing.assert_array_equal(wants, [False, True, False, False, True, False, False])
    t.run(leaving.act, 1, 4)
    assert t.minds.urge[1, 2] > 0 > t.minds.urge[4, 2]
