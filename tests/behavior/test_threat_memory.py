"""Fear that fades, alarm that spreads, and habituation to the submarine."""

import numpy as np
import pytest

from subsea.behavior.threat_memory import (
    ALARMING,
    LEAST_CALM_S,
    LEAST_DREAD,
    RUSH_CM_S,
    WARNED_S,
    felt_fear,
    flees_from_memory,
    grow_used,
    is_warned,
    knows_threat,
    wariness,
)
from subsea.state import FEAR, NEIGHBOURS, NOBODY, PREDATOR, PREY, SUBMARINE
from subsea.state.feelings import dread_of

SECOND = 1.0


@pytest.fixture
def sea(tank):
    """Eight prey and fish 8, a predator at which the first prey looks, 100 cm ahead."""
    t = tank(9)
    t.minds.kind[:8], t.minds.kind[8] = PREY, PREDATOR
    t.fishes.position[8] = 100.0, 0.0, -300.0
    t.minds.predator[0], t.minds.menace[0], t.minds.menaces[0] = 8, 0.9, 0.9
    t.minds.neighbour[0] = np.arange(1, 1 + NEIGHBOURS)
    t.minds.startled[:], t.minds.pause[:] = np.inf, SECOND
    return t


def _feels(t):
    t.minds.mental[0, FEAR] = felt_fear(t.fishes, t.minds, 0, t.sea, t.nature)
    return float(t.minds.mental[0, FEAR])


def _loses_sight(t):
    t.minds.predator[0], t.minds.menace[0], t.minds.menaces[0] = NOBODY, 0.0, 0.0


def test_fear_rises_at_once_and_fades_with_its_time_constant(sea):
    assert _feels(sea) == pytest.approx(0.9)
    assert sea.minds.unseen[0] == 0.0
    _loses_sight(sea)
    for k in range(1, 4):
        assert _feels(sea) == pytest.approx(0.9 * np.exp(-k * SECOND / sea.nature.fear_s), rel=1e-5)
        assert sea.minds.unseen[0] == pytest.approx(k * SECOND)
    np.testing.assert_allclose(sea.minds.threat_place[0], (100.0, 0.0, -300.0))
    assert knows_threat(sea.minds, 0, sea.nature)
    assert not knows_threat(sea.minds, 1, sea.nature)


def test_alarm_lasts_even_if_the_threat_was_slight(sea):
    for menaces, fear in ((0.49, 0.49), (0.51, ALARMING * 0.5), (0.9, 0.9)):
        sea.minds.mental[0, FEAR] = 0.0
        sea.minds.menace[0] = sea.minds.menaces[0] = menaces
        assert _feels(sea) == pytest.approx(fear)


def test_fear_fades_as_slowly_in_sight_of_a_predator_that_leaves(sea):
    _feels(sea)
    sea.minds.menace[0] = sea.minds.menaces[0] = 0.6
    sea.fishes.position[8] = 300.0, 0.0, -300.0
    assert _feels(sea) == pytest.approx(0.9 * np.exp(-SECOND / sea.nature.fear_s), rel=1e-5)
    assert sea.minds.threat_place[0, 0] == 300.0
    assert not flees_from_memory(sea.minds, 0)


def test_a_lesser_threat_does_not_replace_the_one_remembered(sea):
    _feels(sea)
    sea.minds.predator[0], sea.minds.menace[0], sea.minds.menaces[0] = SUBMARINE, 0.2, 0.2
    _feels(sea)
    assert sea.minds.threat_place[0, 0] == 100.0
    assert flees_from_memory(sea.minds, 0)


@pytest.mark.parametrize(
    ("fear", "starts", "alarmed"),
    [(0.0, 2, False), (0.0, 3, True), (0.5, 1, False), (0.5, 2, True), (0.95, 1, True)],
)
def test_starts_of_companions_alarm_a_fish_the_more_it_is_afraid(sea, fear, starts, alarmed):
    _loses_sight(sea)
    sea.minds.mental[0, FEAR] = fear
    sea.minds.startled[1 : 1 + starts] = 0.03
    sea.minds.predator[1] = 8
    assert _feels(sea) >= (ALARMING * sea.nature.alarmed if alarmed else 0.0)
    assert is_warned(sea.minds, 0) == alarmed
    if alarmed:  # it learns where the predator is
        assert sea.minds.threat_place[0, 0] == 100.0
        assert knows_threat(sea.minds, 0, sea.nature)


def test_a_fish_that_has_just_started_does_not_start_again(sea):
    _loses_sight(sea)
    sea.minds.startled[1:4] = 0.03
    sea.minds.startled[0] = 0.9 * LEAST_CALM_S
    assert _feels(sea) == 0.0
    sea.minds.startled[0], sea.minds.alert[0] = np.inf, WARNED_S
    sea.minds.startled[1:4] = 5.0
    _feels(sea)
    assert not is_warned(sea.minds, 0)  # the warning is over


def test_wariness_grows_from_half_of_f0_to_f0(sea):
    for fear, wary in ((0.1, 0.0), (0.25, 0.0), (0.375, 0.5), (0.5, 1.0), (0.9, 1.0)):
        sea.minds.mental[:, FEAR] = fear
        assert wariness(sea.minds, 0, sea.nature) == pytest.approx(wary, abs=1e-5)
    assert wariness(sea.minds, 8, sea.nature) == 0.0


@pytest.fixture
def visited(sea):
    """The same with the submarine 100 cm away, which fish 0 sees."""
    sea.sea.submarine[:6] = 100.0, 0.0, -300.0, 0.0, 0.0, 0.0
    sea.minds.predators[0, 0] = SUBMARINE
    return sea


def _visit(t, seconds):
    t.minds.pause[:] = seconds
    grow_used(t.fishes, t.minds, 0, t.sea, t.nature)
    return dread_of(t.minds, 0, SUBMARINE, t.nature) / t.nature.submarine_cm


def test_a_harmless_submarine_is_let_nearer(visited):
    half = visited.nature.habituation_s
    assert dread_of(visited.minds, 0, SUBMARINE, visited.nature) == visited.nature.submarine_cm
    assert _visit(visited, half) == pytest.approx(0.5)
    assert _visit(visited, 100 * half) == pytest.approx(LEAST_DREAD)


def test_a_fast_approach_renews_the_fear(visited):
    _visit(visited, visited.nature.habituation_s)
    visited.sea.submarine[3] = -0.9 * RUSH_CM_S
    assert _visit(visited, 1.0) < 0.5
    visited.sea.submarine[3] = -1.1 * RUSH_CM_S
    assert _visit(visited, 5.0) > 0.95


def test_habituation_is_forgotten_within_minutes(visited):
    _visit(visited, visited.nature.habituation_s)
    visited.minds.predators[0, 0] = visited.minds.predator[0] = NOBODY
    assert 0.5 < _visit(visited, 60.0) < 0.7
    assert _visit(visited, 1200.0) > 0.99


def test_a_submarine_out_of_reach_or_sight_makes_no_fish_used_to_it(visited):
    visited.minds.predator[0] = SUBMARINE
    visited.sea.submarine[0] = 1000.0
    assert _visit(visited, 60.0) == 1.0
    visited.sea.submarine[0], visited.minds.predators[0, 0] = 100.0, NOBODY
    assert _visit(visited, 60.0) == 1.0
