"""Companions that a schooling fish sees or feels, and schools of blind fishes."""

import numpy as np
import pytest

from subsea.perception.companions import clarity, keep_perceived
from subsea.perception.leader_tracking import schools_of, watch_schools
from subsea.scenario.load import load_scenario
from subsea.scenario.school_rules import USUAL
from subsea.state import NOBODY, SCHOOL
from subsea.state.school_rules import BLIND_COS, LATERAL_LINE_BL, SIGHT_BL
from subsea.submarine.vessel import NEUTRAL
from subsea.world.build import create_world
from subsea.world.step import step

LENGTH = 20.0


def _perceived(tank, *places_bl, light=1.0, vision_cm=500.0, **rules):
    """Which of some companions at places ahead, to the left and above of a fish it perceives."""
    t = tank(len(places_bl) + 1, vision_cm=vision_cm)
    t.fishes.position[1:] += LENGTH * np.array(places_bl, float)
    t.minds.schools[:], t.minds.light[:] = True, light
    t.minds.neighbour[0, : len(places_bl)] = np.arange(1, len(places_bl) + 1)
    for column, value in rules.items():
        t.minds.rules[0, int(column[1:])] = value
    keep_perceived(np.array([0]), t.fishes, t.minds, t.nature)
    kept = t.minds.neighbour[0]
    assert (kept[np.argmax(kept == NOBODY) :] == NOBODY).all()
    return [k for k in kept.tolist() if k != NOBODY]


def test_it_sees_ahead_and_aside_and_feels_behind(tank):
    near, far = USUAL.lateral_line_bl - 0.1, USUAL.lateral_line_bl + 0.1
    places = (-near, 0, 0), (-far, 0, 0), (far, 0, 0), (0, far, 0), (-far, far, 0)
    assert _perceived(tank, *places) == [1, 3, 4, 5]


def test_a_wider_blind_angle_hides_more(tank):
    places = (5, 0, 0), (0.5, 5, 0), (-0.5, 5, 0)
    assert _perceived(tank, *places, **{f"c{BLIND_COS}": 0.0}) == [1, 2]
    assert _perceived(tank, *places, **{f"c{BLIND_COS}": 1.0}) == []


@pytest.mark.parametrize(
    ("light", "reach_bl"), [(1.0, 20.0), (0.1, 20.0), (0.01, 40 / 3), (0.001, 20 / 3), (1e-5, 0.0)]
)
def test_dim_water_shortens_sight(tank, light, reach_bl):
    """By a third for a tenth of the light, down from the range of `sight_bl`."""
    places = [(gap, 0, 0) for gap in (2.0, 6.0, 7.0, 13.0, 14.0, 19.0, 21.0)]
    seen = _perceived(tank, *places, light=light, **{f"c{SIGHT_BL}": 20.0})
    assert len(seen) == sum(place[0] < reach_bl for place in places)


def test_the_range_of_vision_limits_sight(tank):
    assert _perceived(tank, (4, 0, 0), (6, 0, 0), vision_cm=100.0) == [1]


def test_clarity_is_full_in_daylight_and_none_in_the_dark():
    assert [clarity(light) for light in np.float32([0.0, 1e-4, 0.1, 1.0])] == [0, 0, 1, 1]


def test_a_blind_fish_does_not_know_the_middle_of_its_school(tank):
    t = tank(3)
    t.minds.schools[:], t.minds.leader[1:], t.minds.leads[0] = True, 0, True
    t.fishes.position[1:, 0] = 20.0, 60.0
    t.minds.neighbour[:, 0] = 1, 0, 1
    t.minds.light[:] = 1.0, 1e-6, 1.0
    schools = schools_of(t.fishes, t.minds)
    watch_schools(np.arange(3), t.fishes, t.minds, t.nature, schools, t.clock)
    assert np.isfinite(t.minds.leader_seen).tolist() == [True, False, True]


def _dark_school(line_bl):
    """A school on its way, after 25 s without light."""
    loaded = load_scenario(
        "schooling",
        ("water.light_depth_cm=20", f"school.lateral_line_bl={line_bl}", "fish.0.number=24",
         "seaweed=[]"),
    )  # fmt: skip
    world = create_world(loaded.scenario, seed=1)
    for _ in range(750):
        step(world, NEUTRAL)
    return world


@pytest.mark.nightly
def test_blind_fishes_school_by_the_lateral_line_only():
    """Without it each swims alone; with it those that feel each other school."""
    alone, felt = (_dark_school(line_bl) for line_bl in (0.0, 3.0))
    for world, line_bl in ((alone, 0.0), (felt, 3.0)):
        fishes, minds = world.state.fishes, world.state.minds
        assert not np.isfinite(minds.leader_seen).any()
        for i in range(24):
            for j in minds.neighbour[i][minds.neighbour[i] >= 0]:
                gap = np.linalg.norm(fishes.position[i] - fishes.position[j])
                assert gap < (line_bl + 0.5) * fishes.length[i]  # since its last turn
    assert (alone.state.minds.neighbour == NOBODY).all()
    assert (felt.state.minds.neighbour[:, 0] >= 0).mean() > 0.5
    assert (alone.state.minds.intention != SCHOOL).all()
    assert (felt.state.minds.intention == SCHOOL).mean() > 0.5


def test_the_column_of_the_lateral_line_is_that_of_the_rules(tank):
    assert tank(1).minds.rules[0, LATERAL_LINE_BL] == USUAL.lateral_line_bl
