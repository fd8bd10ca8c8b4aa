"""Moods of schooling fishes: what they feel, how they spread, and the noise of headings."""

import numpy as np
import pytest

from subsea.behavior import moods, schooling
from subsea.state import FEAR
from subsea.state.school_rules import CONTAGION, MOODS, NOISE_S, REST

ROW = 0


def _feel(tank, seconds=30.0, mood=0.0, company=0.0, rules=(), **felt):
    """The mood of a fish with a companion that has felt something for a while."""
    t = tank(2)
    t.minds.schools[:], t.minds.neighbour[:, 0] = True, (1, 0)
    t.minds.mood[:], t.minds.company_mood[:] = mood, company
    t.minds.mental[:, FEAR] = felt.get("fear", 0.0)
    t.minds.errand[:] = felt.get("errand", 0.0)
    for column, value in {CONTAGION: 0.0, REST: felt.get("rest", 0.0), **dict(rules)}.items():
        t.minds.rules[ROW, column] = value
    for _ in range(round(seconds / 0.033)):
        moods.update_moods(np.array([0]), t.fishes, t.minds, t.nature, t.clock)
    return float(t.minds.mood[0])


@pytest.mark.parametrize(
    ("felt", "mood"),
    [
        ({}, 0.0),
        ({"fear": 0.2}, 0.0),
        ({"fear": 0.35}, 0.5),
        ({"fear": 0.9}, 1.0),
        ({"rest": 1.0}, -1.0),
        ({"rest": 1.0, "errand": 0.5}, 0.0),
        ({"rest": 1.0, "fear": 0.35}, 0.0),
        ({"rest": 1.0, "fear": 0.9}, 1.0),
    ],
)
def test_fear_alarms_and_a_school_that_stays_feeds(tank, felt, mood):
    assert _feel(tank, **felt) == pytest.approx(mood, abs=0.02)


def test_alarm_rises_fast_and_fades_slowly(tank):
    assert _feel(tank, 0.5, fear=0.9) > 0.9
    assert _feel(tank, 2.0, mood=1.0) > 0.5
    assert _feel(tank, 30.0, mood=1.0) < 0.05


def test_a_fish_takes_over_the_mood_of_its_company(tank):
    """Though it feels nothing itself; without contagion it stays at ease."""
    assert _feel(tank, 5.0, company=1.0) == 0.0
    assert _feel(tank, 5.0, company=1.0, rules={CONTAGION: 0.5}) > 0.5


def test_moods_change_the_rules(tank):
    t = tank(4)
    t.minds.mood[:] = 0.0, 1.0, -1.0, 1.0
    t.minds.school_rule[3] = 1
    t.minds.rules[1, MOODS] = 0.0
    calm, alarmed, fed, numb = (moods.temper_of(t.minds, i) for i in range(4))
    assert calm == numb._replace(alarm=0.0) == (1.0, 1.0, 1.0, 1.0, 0.0)
    assert alarmed.alignment > 1 > fed.alignment
    assert alarmed.noise < 1 < fed.noise
    assert alarmed.spacing < 1 < fed.spacing
    assert fed.speed < 1


@pytest.mark.parametrize("rest", [0.0, 0.3, 1.0])
def test_a_school_rests_its_share_of_the_time(tank, rest):
    """All of its fishes within a few seconds, never at once from full speed to rest."""
    t = tank(1)
    clocks = [t.at(tick).clock for tick in range(0, 400_000, 30)]
    levels = np.array([moods.travel_drive(3, 7, rest, np.float32(0.5), clock) for clock in clocks])
    assert (levels < 0.4 * moods.LEAST_TRAVEL).mean() == pytest.approx(rest, abs=0.08)
    assert levels.min() >= 0.0 and levels.max() <= 1.0
    assert np.abs(np.diff(levels)).max() < 0.3
    late = [moods.travel_drive(4, 7, rest, np.float32(0.9), clock) for clock in clocks]
    assert np.mean(np.abs(levels - late) > 0.5) < 0.05


@pytest.mark.nightly
@pytest.mark.parametrize("stride", [1, 8])
def test_noise_has_unit_variance_and_the_time_constant_of_the_rules(tank, stride):
    """However often a fish thinks."""
    t = tank(1)
    rule = t.minds.rules[0]
    rule[NOISE_S] = 1.0
    t.minds.pause[:] = 0.033 * stride
    found = []
    for tick in range(0, 300_000, stride):
        moods.deviate(t.minds, 0, rule, t.at(tick).clock)
        found.append(t.minds.deviation[0].copy())
    noise = np.array(found)
    np.testing.assert_allclose(noise.mean(axis=0), 0.0, atol=0.08)
    np.testing.assert_allclose(noise.std(axis=0), 1.0, atol=0.06)
    lag = round(1.0 / (0.033 * stride))
    kept = np.corrcoef(noise[:-lag, 0], noise[lag:, 0])[0, 1]
    assert kept == pytest.approx(np.exp(-lag * 0.033 * stride), abs=0.06)
    assert abs(np.corrcoef(noise[:, 0], noise[:, 2])[0, 1]) < 0.06


def test_a_feeding_school_is_slow(tank):
    paces = []
    for mood in (0.0, -1.0):
        t = tank(2)
        t.minds.schools[:], t.minds.leader[1], t.minds.leads[0] = True, 0, True
        t.minds.rules[0, [schooling.NOISE_RAD, schooling.PACE_NOISE]] = 0.0
        t.minds.waypoint[0] = t.fishes.position[0] + (0.0, 900.0, 0.0)
        t.fishes.velocity[:], t.minds.mood[:] = 0.0, mood
        t.at(5000).run(schooling.act, 0)
        paces.append(float(t.fishes.goal_speed[0]))
    slower = schooling.TENDENCY * (1.0 - moods.FEEDING_SPEED) * schooling.CRUISING
    assert paces[0] - paces[1] == pytest.approx(slower, rel=0.02)
