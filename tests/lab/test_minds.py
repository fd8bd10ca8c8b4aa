"""Minds in records: bouts of intention, fear after a predator is gone, time budgets."""

import numpy as np
import pytest

from subsea.lab.minds import (
    NEAR_CM,
    SHORT_S,
    bouts,
    each_bout,
    fear,
    joined_bouts,
    joined_budget,
    joined_fear,
    median_survival,
    shares_of,
    time_budgets,
)
from subsea.state import AVOID, EAT, ESCAPE, FEAR, MATE, PREDATOR, PREY, SCHOOL, WANDER
from tests.support.records import INTENTIONS, TICK_S, a_record, still

HERE = (0.0, 0.0, -200.0)


def doing(*stretches):
    """Intentions (T, 1) in stretches of (code, ticks)."""
    return np.concatenate([[code] * ticks for code, ticks in stretches])[:, None]


def minded(codes, **changed):
    return a_record(still(len(codes), *[HERE] * codes.shape[1]), intention=codes, **changed)


def test_bouts_are_stretches_of_one_intention_with_both_ends():
    each = each_bout(minded(doing((WANDER, 9), (EAT, 3), (WANDER, 7), (AVOID, 2), (WANDER, 9))))
    assert each.code.tolist() == [EAT, WANDER, AVOID]
    assert each.later.tolist() == [WANDER, AVOID, WANDER]
    assert each.seconds == pytest.approx([0.3, 0.7, 0.2])
    assert each.start.tolist() == [9, 12, 19]
    assert each.danger.tolist() == [False, True, False]


def test_a_bout_is_short_below_half_a_second_and_calm_if_no_danger_ends_it():
    half = round(SHORT_S / TICK_S)
    codes = doing((WANDER, 9), (EAT, half - 1), (AVOID, half), (EAT, half - 1), (WANDER, 9))
    found = bouts(minded(codes))
    assert (found.whole[EAT], found.short[EAT], found.calm[EAT], found.calm_short[EAT]) == (
        2, 2, 1, 1,
    )  # fmt: skip
    assert (found.whole[AVOID], found.short[AVOID]) == (1, 0)
    assert found.whole.sum() == 3
    twice = joined_bouts([found, found])
    assert twice.short[EAT] == 4


def test_alarm_that_closes_the_ranks_ends_a_bout_by_danger():
    codes = doing((SCHOOL, 9), (EAT, 3), (SCHOOL, 9))
    mental = np.zeros((21, 1, 3))
    assert bouts(minded(codes, mental_state=mental)).calm_short[EAT] == 1
    mental[12:, :, FEAR] = 0.6
    assert bouts(minded(codes, mental_state=mental)).calm[EAT] == 0


def test_a_death_cuts_a_bout_off():
    codes = doing((WANDER, 9), (EAT, 3), (WANDER, 9))
    alive = np.ones((21, 1), bool)
    alive[11:] = False
    assert bouts(minded(codes, alive=alive)).whole.sum() == 0


def hunted(apart, frightened, ticks=100, **changed):
    """A prey that looks north past a predator at `apart` (T,) cm east of it."""
    place = np.zeros((ticks, 2, 3)) + HERE
    place[:, 1, 0] += apart
    mental = np.zeros((ticks, 2, 3))
    mental[:, 0, FEAR] = np.where(frightened, 0.9, 0.1)
    kind = np.array([PREY, PREDATOR], np.uint8)
    return a_record(place, mental_state=mental, kind=kind, **changed)


TICKS = np.arange(100)
PASSED = np.where(TICKS < 20, 100.0, 2 * NEAR_CM)  # out of sight from tick 20


@pytest.mark.parametrize(("until", "lasts"), [(20, 0.0), (23, 0.3), (80, 6.0)])
def test_fear_lasts_from_the_last_sight(until, lasts):
    found = fear(hunted(PASSED, until > TICKS))
    assert found.lasted == pytest.approx([lasts])
    assert found.ended.tolist() == [True]
    assert found.flips == 1
    assert found.minutes == pytest.approx(10.0 / 60.0)


def test_fear_that_goes_on_is_cut_off_by_the_next_sight_and_by_the_end():
    apart = np.where((TICKS >= 50) & (TICKS < 60), 100.0, PASSED)
    found = fear(hunted(apart, TICKS >= 0))
    assert found.lasted == pytest.approx([3.0, 4.0])
    assert found.ended.tolist() == [False, False]


def test_a_fish_without_alarm_at_the_last_sight_does_not_count():
    assert len(fear(hunted(PASSED, TICKS < 5)).lasted) == 0


def test_a_predator_behind_or_beyond_a_pillar_is_not_seen():
    behind = np.where(TICKS < 20, 100.0, -100.0)  # the fish heads for +x
    assert fear(hunted(behind, TICKS < 50)).lasted == pytest.approx([3.0])
    pillar = np.array([[60.0, 0.0, 20.0, -100.0]])
    assert len(fear(hunted(PASSED, TICKS < 50, pillars=pillar)).lasted) == 0
    assert len(fear(hunted(PASSED, TICKS < 50, pillars=pillar + [[0, 200, 0, 0]])).lasted) == 1


def test_seas_without_predators_have_no_fear():
    found = fear(a_record(still(9, HERE)))
    assert (found.flips, found.minutes, len(found.lasted)) == (0, 0.0, 0)
    both = joined_fear([found, fear(hunted(PASSED, TICKS < 80))])
    assert both.lasted == pytest.approx([6.0])


def test_the_median_of_durations_counts_those_that_are_cut_off():
    """With all ended the median; one that is cut off early counts for the time it was seen."""
    ended = np.ones(5, bool)
    assert median_survival(np.array([5.0, 1.0, 3.0, 2.0, 4.0]), ended) == 3.0
    # Shares that outlast 2, 6 and 9 s: 3/3 · 1/2 after the two short ones were cut off.
    assert median_survival(
        np.array([1.0, 1.0, 6.0, 9.0]), np.array([False, False, True, True])
    ) == pytest.approx(6.0)
    assert median_survival(np.array([1.0, 8.0]), np.array([False, False])) == 8.0
    assert np.isnan(median_survival(np.zeros(0), np.zeros(0, bool)))


def test_budgets_are_seconds_by_species_and_hour():
    codes = np.hstack([doing((WANDER, 6), (EAT, 4)), doing((MATE, 10))])
    alive = np.ones((10, 2), bool)
    alive[5:, 1] = False
    record = minded(
        codes, alive=alive, species=np.array([0, 1], np.uint8), species_names=["a", "b"]
    )
    budget = time_budgets(record, np.array([7.5] * 8 + [24.5] * 2))
    assert budget["a", 7] == pytest.approx({"wander": 0.6, "eat": 0.2})
    assert budget["a", 0] == pytest.approx({"eat": 0.2})
    assert budget["b", 7] == pytest.approx({"mate": 0.5})
    assert ("b", 0) not in budget
    twice = joined_budget([budget, budget])
    assert twice["a", 7] == pytest.approx({"wander": 1.2, "eat": 0.4})


def test_purposes_are_shares_of_active_time():
    shares = shares_of([{"eat": 2.0, "graze": 1.0, "wander": 3.0}, {"shelter": 4.0, "dance": 2.0}])
    assert shares["feeding"] == pytest.approx(3 / 8)
    assert shares["dance"] == pytest.approx(2 / 8)
    assert shares["rest"] == pytest.approx(4 / 12)
    assert shares["courting"] == 0.0
    assert set(INTENTIONS) >= {"eat", "mate", "avoid"}


def test_an_escape_is_a_reaction():
    found = bouts(minded(doing((WANDER, 9), (EAT, 2), (ESCAPE, 9), (WANDER, 2))))
    assert (found.calm[EAT], found.calm[ESCAPE]) == (0, 1)
