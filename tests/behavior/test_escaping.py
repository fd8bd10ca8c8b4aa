"""The eleven rules of escape."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.behavior.escaping import (
    CAUTIOUS,
    CLOSE,
    COMMITTED_S,
    DODGE_RAD,
    EDGE_RAD,
    FLIGHT_S,
    FROZEN,
    LATENCY_S,
    LOOMS_RAD_S,
    MOST_START,
    REFRACTORY_S,
    STEEP,
    TURN_BACK_RAD,
    Danger,
    act,
    danger_of,
    desire,
    looming,
    rule_of,
    turn_of,
)
from subsea.behavior.table import BEHAVIORS, TABLE
from subsea.behavior.threat_memory import WARNED_S
from subsea.state import (
    ESCAPE,
    FEAR,
    NOBODY,
    PACIFIST,
    PREDATOR,
    PREY,
    SCHOOL,
    SUBMARINE,
    Clock,
    Fishes,
    Minds,
    empty,
)
from subsea.world.populate import heading_quaternion

DREAD = 200.0
FAR, NEAR = -0.5, 0.4
CLOCK = Clock(1, 0, 0.033)
ONE = np.zeros(1, np.int64)


@pytest.fixture(scope="module")
def around(tank):
    """A sea and its constants of perception and behavior."""
    return tank(0).sea, tank(0).nature


def _pair(place, heading=0.0, speed=40.0):
    """A fish at the origin that heads along x, and a predator at `place` with its heading, rad."""
    fishes, minds = empty(Fishes, n=2), empty(Minds, n=2, b=len(BEHAVIORS), d=len(TABLE.desires))
    fishes.length[:] = 20.0, 60.0
    fishes.position[0] = 0.0, 0.0, -300.0
    fishes.position[1] = np.array(place) + (0.0, 0.0, -300.0)
    fishes.orientation[0] = heading_quaternion(0.0)
    fishes.orientation[1] = heading_quaternion(heading)
    fishes.velocity[0] = 20.0, 0.0, 0.0
    fishes.velocity[1] = speed * np.array([np.cos(heading), np.sin(heading), 0.0])
    minds.kind[:] = PREY, PREDATOR
    minds.dread[:] = DREAD
    minds.predator[0] = 1
    return fishes, minds


# bearing, course of the predator (degrees, left positive), near, approaching; rule, turn (degrees)
DODGE = float(np.degrees(DODGE_RAD[0] + NEAR * (DODGE_RAD[1] - DODGE_RAD[0])))
BACK = float(np.degrees(TURN_BACK_RAD))
RULES = [
    # Far: in front, behind, to the left, to the right.
    (10, 180, FAR, True, 1, -130),
    (-10, 180, FAR, True, 1, 130),
    (170, 0, FAR, True, 2, 0),
    (-170, 90, FAR, True, 2, 0),
    (100, 0, FAR, True, 3, -40),
    (-60, 0, FAR, True, 4, 80),
    # Close, in front: heading to my left or right, or else.
    (20, 80, NEAR, True, 5, -100),
    (20, -100, NEAR, True, 5, 80),
    (20, 170, NEAR, True, 6, -BACK),
    (-20, 10, NEAR, False, 6, BACK),
    # Close, behind: same heading and approaching, perpendicular, or else.
    (160, 10, NEAR, True, 7, -DODGE),
    (-160, 10, NEAR, True, 7, DODGE),
    (160, 80, NEAR, True, 8, -50),
    (160, -80, NEAR, True, 8, 50),
    (160, 10, NEAR, False, 9, 0),
    (-160, 170, NEAR, True, 9, 0),
    # Close, to the side.
    (90, 0, NEAR, True, 10, -90),
    (120, -90, NEAR, True, 10, -60),
    (-90, 0, NEAR, True, 11, 90),
]


@pytest.mark.parametrize(("bearing", "course", "near", "approaches", "rule", "turn"), RULES)
def test_each_rule(bearing, course, near, approaches, rule, turn):
    danger = Danger(near, np.radians(bearing), np.radians(course), approaches, 0.0)
    assert rule_of(danger) == rule
    assert np.degrees(turn_of(rule, danger)) == pytest.approx(turn)


def test_every_rule_is_tried():
    assert {row[4] for row in RULES} == set(range(1, 12))


angles = st.floats(-np.pi, np.pi).filter(lambda a: abs(a) > 1e-6)


@given(near=st.floats(-3, 1), bearing=angles, course=angles, approaches=st.booleans())
def test_the_mirrored_danger_is_fled_from_mirrored(near, bearing, course, approaches):
    danger = Danger(near, bearing, course, approaches, 0.0)
    mirrored = Danger(near, -bearing, -course, approaches, 0.0)
    turn = turn_of(rule_of(danger), danger)
    assert turn_of(rule_of(mirrored), mirrored) == pytest.approx(-turn)
    assert abs(turn) <= np.pi


@given(near=st.floats(-3, 1), bearing=angles)
def test_a_turn_from_one_that_is_not_behind_leads_away_from_it(near, bearing):
    danger = Danger(near, bearing, bearing + np.pi, True, 0.0)
    if abs(bearing) < np.radians(134):
        after = bearing - turn_of(rule_of(danger), danger)
        assert np.cos(after) < -0.6


@given(angle=angles, course=angles, distance=st.floats(5, 600), height=st.floats(-100, 100))
def test_danger_of_a_predator_against_closed_forms(around, angle, course, distance, height):
    place = distance * np.cos(angle), distance * np.sin(angle), height
    fishes, minds = _pair(place, course)
    danger = danger_of(fishes, minds, 0, *around)
    off = np.linalg.norm(place)
    assert danger.near == pytest.approx(1 - off / (CLOSE * DREAD), abs=1e-4)
    assert np.cos(danger.bearing - angle) == pytest.approx(1, abs=1e-4)
    assert np.cos(danger.course - course) == pytest.approx(1, abs=1e-4)
    assert danger.above == pytest.approx(height / off, abs=1e-4)
    closing = np.dot(place, fishes.velocity[1] - fishes.velocity[0])
    if abs(closing) > 0.1:
        assert danger.approaches == (closing < 0)


@pytest.mark.parametrize(("height", "climb"), [(30.0, -0.5), (-5.0, 0.1), (0.0, 0.0)])
def test_a_fish_flees_at_full_speed_and_away_in_height(around, height, climb):
    side = np.sqrt(50.0**2 - height**2)
    fishes, minds = _pair((0.0, side, height))
    act(np.array([0]), fishes, minds, *around, CLOCK)
    assert fishes.goal_speed[0] == 1
    assert minds.urge[0, :2] == pytest.approx([0, -1], abs=1e-5)
    assert minds.urge[0, 2] == pytest.approx(np.clip(climb, -STEEP, STEEP), abs=1e-5)


def test_the_submarine_heads_where_it_goes_and_at_rest_for_the_fish(around):
    sea, nature = around
    fishes, minds = _pair((0.0, 0.0, 0.0))
    minds.predator[0] = SUBMARINE
    sea.submarine[:6] = -60.0, 0.0, -300.0, 0.0, 50.0, 0.0
    danger = danger_of(fishes, minds, 0, sea, nature)
    assert danger.near == pytest.approx(1 - 60 / (CLOSE * nature.submarine_cm))
    assert danger.course == pytest.approx(np.pi / 2)
    sea.submarine[3:6] = 0.0
    assert danger_of(fishes, minds, 0, sea, nature).course == pytest.approx(0.0)


def test_schoolmates_on_either_side_of_the_hunter_part(around):
    """A school ahead of its hunter spreads like a fan."""
    for side in (-12.0, 12.0):
        fishes, minds = _pair((-40.0, -side, 0.0))
        danger = danger_of(fishes, minds, 0, *around)
        assert rule_of(danger) == 7
        act(np.array([0]), fishes, minds, *around, CLOCK)
        assert np.sign(minds.urge[0, 1]) == np.sign(side)


def test_desire_to_escape(around):
    fishes, minds = _pair((100.0, 0.0, 0.0))
    nature = around[1]

    def wants():
        out = np.zeros(2, np.float32)
        desire(np.arange(2), fishes, minds, *around, CLOCK, out)
        return float(out[0])

    minds.mental[:, FEAR] = nature.alarmed + 0.1
    assert wants() == pytest.approx(nature.alarmed + 0.1)  # likes no school
    minds.schools[0] = True
    assert wants() > 0  # without a leader
    minds.leader[0] = 1
    assert wants() > 0  # lost sight of it
    minds.leader_seen[0] = 0.0
    assert wants() == 0  # schools more closely instead
    minds.menace[0] = nature.panicked
    assert wants() > 0
    minds.predator[0] = NOBODY
    assert wants() == 0
    minds.predator[0] = 1
    minds.mental[:, FEAR] = nature.alarmed
    assert wants() == 0
    minds.mental[:, FEAR] = 1.0
    minds.kind[0] = PACIFIST
    assert wants() == 0


def test_an_attack_in_the_open_scatters_a_school(around):
    """A fish that closes ranks with its school at a distant hunter flees one that rushes at it."""
    nature = around[1]
    for speed, wanted in ((5.0, False), (150.0, True)):
        fishes, minds = _attacked(40.0, speed)
        minds.mental[:, FEAR], minds.schools[0] = nature.alarmed + 0.1, True
        minds.leader[0], minds.leader_seen[0] = 1, 0.0
        out = np.zeros(2, np.float32)
        desire(np.arange(2), fishes, minds, *around, CLOCK, out)
        assert bool(out[0] > 0.0) == wanted
    minds.predator[0] = NOBODY  # it has nobody to flee from
    desire(np.arange(2), fishes, minds, *around, CLOCK, out)
    assert out[0] == 0.0
    minds.startled[0] = 0.5 * COMMITTED_S  # but sees through a flight that has begun
    desire(np.arange(2), fishes, minds, *around, CLOCK, out)
    assert out[0] == 1.0


def test_panic_ends_later_than_it_began(around):
    nature = around[1]
    fishes, minds = _pair((250.0, 0.0, 0.0))
    minds.schools[0], minds.leader[0], minds.leader_seen[0] = True, 1, 0.0
    minds.mental[:, FEAR] = minds.menace[:] = 0.97 * nature.panicked
    out = np.zeros(2, np.float32)
    for intention, wanted in ((SCHOOL, False), (ESCAPE, True)):
        minds.intention[0] = intention
        desire(np.arange(2), fishes, minds, *around, CLOCK, out)
        assert bool(out[0] > 0.0) == wanted


def _remembering(place, fear=0.7):
    """A fish at the origin that heads along x and last perceived a threat at `place`."""
    fishes, minds = _pair((500.0, 0.0, 0.0))
    minds.predator[0], minds.unseen[0], minds.startled[:] = NOBODY, 1.0, np.inf
    minds.threat_place[0] = np.array(place) + (0.0, 0.0, -300.0)
    minds.mental[0, FEAR], fishes.burst[:] = fear, 5.0
    return fishes, minds


@pytest.mark.parametrize("angle", [-170, -140, -60, 20, 90, 145, 179])
def test_a_fish_turns_to_see_whether_a_remembered_threat_comes_after_it(around, angle):
    bearing = np.radians(angle)
    fishes, minds = _remembering((100 * np.cos(bearing), 100 * np.sin(bearing), 0.0))
    out = np.zeros(2, np.float32)
    desire(np.arange(2), fishes, minds, *around, CLOCK, out)
    assert out[0] == pytest.approx(0.7)
    act(ONE, fishes, minds, *around, CLOCK)
    after = bearing - np.arctan2(minds.urge[0, 1], minds.urge[0, 0])
    assert np.cos(after) == pytest.approx(np.cos(EDGE_RAD), abs=1e-4)
    assert after * angle > 0 or abs(after) > np.pi  # it stays on the same side
    assert CAUTIOUS < fishes.goal_speed[0] < 1.0


def test_a_flight_goes_on_out_of_sight_and_slows_down_with_the_fear(around):
    fishes, minds = _remembering((-50.0, 10.0, 0.0), 0.9)
    minds.startled[0] = 0.5 * COMMITTED_S
    act(ONE, fishes, minds, *around, CLOCK)
    assert fishes.goal_speed[0] == pytest.approx(5.0)
    speeds = []
    for fear in (0.9, 0.7, 0.5):
        minds.startled[0], minds.mental[0, FEAR] = 2.0 * COMMITTED_S, fear
        act(ONE, fishes, minds, *around, CLOCK)
        speeds.append(float(fishes.goal_speed[0]))
    assert 1.0 > speeds[0] > speeds[1] > speeds[2] == pytest.approx(CAUTIOUS)


@pytest.mark.parametrize(("distance", "pursued"), [(50.0, False), (300.0, True), (300.0, False)])
def test_it_flees_slowly_from_a_far_predator_that_leaves(around, distance, pursued):
    fishes, minds = _pair((distance, 0.0, 0.0), np.pi if pursued else 0.0)
    minds.mental[0, FEAR] = minds.menace[0] = minds.menaces[0] = 0.7
    act(ONE, fishes, minds, *around, CLOCK)
    assert (fishes.goal_speed[0] < 1.0) == (distance > CLOSE * DREAD and not pursued)


def test_a_fish_without_a_school_freezes_in_cover(tank):
    t = tank(1, rocks=[(30.0, 0.0, -300.0, 20.0, 20.0, 20.0, 0.0)])
    t.minds.kind[0], t.minds.unseen[0], t.minds.startled[0] = PREY, 1.0, np.inf
    t.minds.mental[0, FEAR], t.minds.threat_place[0] = 0.7, (-200.0, 0.0, -300.0)
    for x, schools, frozen in ((0.0, False, True), (0.0, True, False), (-300.0, False, False)):
        t.fishes.position[0, 0], t.minds.schools[0] = x, schools
        t.run(act)
        assert bool(t.fishes.goal_speed[0] == np.float32(FROZEN)) == frozen


def test_starts_of_companions_are_followed_in_many_directions(around):
    bends = []
    for tick in range(40):
        fishes, minds = _remembering((-50.0, 60.0, 0.0))
        minds.alert[0] = WARNED_S
        act(ONE, fishes, minds, *around, Clock(1, tick, 0.033))
        assert minds.startled[0] == minds.alert[0] == 0.0
        bends.append(float(fishes.startle[0]))
    assert np.ptp(bends) > np.radians(60.0)


def _attacked(distance, speed, heading=np.pi):
    """A fish with a predator before it that rushes at it, 10 cm wide, `distance` cm away."""
    fishes, minds = _pair((distance, 0.0, 0.0), heading, speed)
    fishes.girth[1], fishes.velocity[0], fishes.burst[:] = 10.0, 0.0, 5.0
    minds.pause[:], minds.startled[:] = CLOCK.dt, np.inf
    return fishes, minds


def test_looming_is_the_growth_of_the_angle_that_the_predator_subtends(around):
    for distance in (15.0, 60.0, 200.0):
        fishes, minds = _attacked(distance, 100.0)
        step = 1e-3
        now, later = (2 * np.arctan(5.0 / (d - 0.0)) for d in (distance, distance - 100.0 * step))
        assert looming(fishes, minds, 0, around[0]) == pytest.approx((later - now) / step, rel=0.02)


@pytest.mark.parametrize(("excess", "ticks"), [(0.9, None), (1.1, 3), (20.0, 1)])
def test_the_latency_is_shorter_for_a_stronger_stimulus(around, excess, ticks):
    """d² = v s / rate; a predator that comes at the threshold is answered after 0.1 s."""
    distance = np.sqrt(100.0 * 10.0 / (excess * LOOMS_RAD_S) - 25.0)
    fishes, minds = _attacked(distance, 100.0)
    calm = []
    for _ in range(9):
        act(ONE, fishes, minds, *around, CLOCK)
        calm.append(bool(minds.startled[0] > 0.0))
    assert calm.index(False) + 1 == ticks if ticks else all(calm)
    assert ticks is None or ticks * CLOCK.dt <= LATENCY_S + CLOCK.dt


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_escape_begins_with_one_c_start_away_from_the_attack(around, side):
    fishes, minds = _attacked(12.0, 150.0)
    fishes.position[1, 1] = 5.0 * side
    act(ONE, fishes, minds, *around, CLOCK)
    assert 1.5 < -side * fishes.startle[0] <= MOST_START
    assert fishes.goal_speed[0] == pytest.approx(5.0)
    fishes.startle[0], minds.startled[0] = 0.0, 0.5 * FLIGHT_S
    act(ONE, fishes, minds, *around, CLOCK)
    assert (fishes.startle[0], fishes.goal_speed[0]) == (0.0, 5.0)
    minds.startled[0] = REFRACTORY_S + 0.1
    act(ONE, fishes, minds, *around, CLOCK)
    assert fishes.startle[0] != 0.0


def test_a_slow_or_leaving_predator_does_not_startle(around):
    for speed, heading in ((5.0, np.pi), (150.0, 0.0)):
        fishes, minds = _attacked(40.0, speed, heading)
        for _ in range(20):
            act(ONE, fishes, minds, *around, CLOCK)
        assert fishes.startle[0] == 0.0
        assert fishes.goal_speed[0] == 1.0


def test_a_fish_with_a_home_flees_there(around):
    fishes, minds = _attacked(100.0, 40.0)
    minds.home[0], minds.home_range[0] = (0.0, 50.0, -300.0), 100.0
    act(ONE, fishes, minds, *around, CLOCK)
    assert minds.urge[0] == pytest.approx([0.0, 50.0, 0.0])
