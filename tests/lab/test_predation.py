"""Attacks and captures of one predator among prey."""

import numpy as np
import pytest

from subsea.lab.measures import PERIOD_S, joined, predation
from subsea.state import EAT, PREDATOR, PREY, WANDER
from tests.support.records import LENGTH, TICK_S, a_record, still


def a_hunt(gap, dies=None, target=1, ticks=200):
    """A predator with its prey `gap` (ticks,) lengths before its snout."""
    places = np.array(still(ticks, [0, 0, -200.0], [0, 0, -200.0], [0, 300.0, -200.0]))
    places[:, 1, 0] = LENGTH * (0.4 + np.asarray(gap))
    alive = np.ones((ticks, 3), bool)
    if dies is not None:
        alive[dies:, 1] = False
    doing = np.full((ticks, 3), WANDER)
    doing[:, 0] = EAT
    return a_record(
        places, alive=alive, intention=doing, kind=np.array([PREDATOR, PREY, PREY], np.uint8),
        target=np.full((ticks, 3), target),
    )  # fmt: skip


def approaches(*times, ticks=200):
    """Gaps of 5 lengths that fall to half a length for a second at each time, s."""
    time = TICK_S * np.arange(ticks)
    return np.where(np.any([(time >= t) & (time < t + 1) for t in times], axis=0), 0.5, 5.0)


def test_attacks_close_together_are_one():
    assert predation(a_hunt(approaches(2, 10, 15))).attacks == 3
    assert predation(a_hunt(approaches(2, 4.5, 15))).attacks == 2
    assert predation(a_hunt(approaches(2), target=2)).attacks == 0
    assert predation(a_hunt(approaches(2), target=-1)).attacks == 0


def test_prey_that_dies_in_an_attack_was_caught():
    found = predation(a_hunt(approaches(2, 10), dies=108))
    assert (found.attacks, found.captures) == (2, 1)
    seconds = 200 * TICK_S
    assert (found.catches, found.seconds) == ([1], pytest.approx(seconds))
    assert found.rates() == [pytest.approx(PERIOD_S / seconds, abs=0.05)]
    found = predation(a_hunt(approaches(2, 10), dies=70))  # 4 s after the attack
    assert (found.captures, len(found.catches)) == (0, 1)


def test_a_sea_without_predators_has_no_attacks():
    found = predation(a_record(still(20, [0, 0, -200.0])))
    assert found == (0, 0, [], pytest.approx(20 * TICK_S))


def test_parts_of_a_dive_count_as_one():
    """Catches add up, and only those of the first three minutes count."""
    part = predation(a_hunt(approaches(2, 10), dies=108))
    record = a_hunt(approaches(2, 10), dies=108)
    late = predation(record._replace(time=record.time + PERIOD_S))
    assert (late.captures, late.catches) == (1, [0])
    whole = joined([part, part, late])
    assert (whole.attacks, whole.captures, whole.catches) == (6, 3, [2])
    assert whole.seconds == pytest.approx(3 * part.seconds)
