"""Inspection of a calm predator by bold fishes of a school."""

import numpy as np
import pytest

from subsea.behavior.inspecting import (
    EAGERNESS,
    INSPECTED_BL_S,
    INSPECTS_S,
    NEAREST,
    RESTS_S,
    act,
    advance_inspections,
    desire,
    is_shy,
    undaunted_desire,
)
from subsea.state import FEAR, PREDATOR, PREY

SHARK = 60


@pytest.fixture
def school(tank):
    """Sixty prey in a school, and a calm predator beside it that heads along x."""
    t = tank(SHARK + 1)
    t.minds.kind[:SHARK], t.minds.kind[SHARK] = PREY, PREDATOR
    t.minds.schools[:SHARK], t.minds.neighbour[:SHARK, 0] = True, 1
    t.fishes.length[SHARK], t.fishes.position[SHARK] = 150.0, (0.0, 450.0, -300.0)
    t.fishes.velocity[SHARK] = 0.5 * INSPECTED_BL_S * 150.0, 0.0, 0.0
    t.minds.predator[:SHARK], t.minds.startled[:] = SHARK, np.inf
    t.minds.menace[:SHARK] = t.minds.menaces[:SHARK] = t.minds.mental[:SHARK, FEAR] = 0.44
    return t


def _wants(t):
    """Count the time, and return the desires."""
    advance_inspections(np.arange(SHARK + 1), t.fishes, t.minds, t.nature, t.clock)
    return t.desire(desire)


def _bold(t):
    return np.flatnonzero([not is_shy(i, t.clock) for i in range(SHARK)])


def test_a_few_fishes_are_bold(school):
    bold = _bold(school)
    assert 3 <= len(bold) <= 18
    wants = _wants(school)
    np.testing.assert_array_equal(np.flatnonzero(wants), bold)
    assert wants[bold[0]] == np.float32(EAGERNESS)


@pytest.mark.parametrize(
    "change",
    [
        lambda t, i: t.fishes.velocity.__setitem__((SHARK, 0), 1.1 * INSPECTED_BL_S * 150.0),
        lambda t, i: t.fishes.position.__setitem__((SHARK, slice(0, 2)), (-450.0, 20.0)),  # noticed
        lambda t, i: t.minds.mental.__setitem__((i, FEAR), 0.2),
        lambda t, i: t.minds.menace.__setitem__(i, 0.85),
        lambda t, i: t.minds.startled.__setitem__(i, 3.0),
        lambda t, i: t.minds.neighbour.__setitem__((i, 0), -1),
    ],
)
def test_none_inspects_a_hunting_predator_or_one_that_has_noticed_it(school, change):
    bold = int(_bold(school)[0])
    change(school, bold)
    assert _wants(school)[bold] == 0.0


def test_it_comes_near_from_the_side_once_and_then_rests(school):
    bold = int(_bold(school)[0])
    assert _wants(school)[bold] > 0.0
    act(np.array([bold]), *school)
    # Beside the predator at the distance where fear is still below f1.
    reach = 200.0 / (NEAREST * school.nature.panicked)
    toward = np.array((0.0, 450.0 - reach, -300.0)) - school.fishes.position[bold]
    assert np.dot(school.minds.urge[bold], toward) > 0.6 * np.linalg.norm(toward) * np.linalg.norm(
        school.minds.urge[bold]
    )
    assert school.minds.inspection[bold] < INSPECTS_S
    school.fishes.position[bold] = 0.0, 450.0 - reach, -300.0
    act(np.array([bold]), *school)
    assert school.minds.inspection[bold] == INSPECTS_S
    assert _wants(school)[bold] == 0.0
    assert school.minds.inspection[bold] == -RESTS_S
    school.minds.pause[bold] = RESTS_S
    assert _wants(school)[bold] == 0.0
    assert _wants(school)[bold] > 0.0  # rested


def test_it_goes_on_above_f0_and_stays_with_a_school_on_an_errand(school):
    bold = int(_bold(school)[0])
    for fear, daunted in ((0.45, True), (0.6, False)):
        school.minds.mental[bold, FEAR] = fear
        _wants(school)
        assert (school.desire(undaunted_desire)[bold] == 0.0) == daunted
    school.minds.leader[bold], school.minds.errand[1] = 1, 0.5
    assert _wants(school)[bold] == 0.0
    assert school.desire(undaunted_desire)[bold] == 0.0
