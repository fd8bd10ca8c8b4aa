"""Hunting by predators, and suction by an open mouth."""

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.behavior import eating
from subsea.behavior.chasing import mouth_of
from subsea.behavior.hunting import (
    ALMOST_S,
    ATTENTION_TICKS,
    CHASE_BL,
    CHEW_S,
    FITS,
    LEAD,
    LOST_S,
    LULL_S,
    MOUTH_BL,
    OPEN_BL,
    PATIENT_S,
    PURSUIT,
    READY_S,
    RECOVER_S,
    RUSH_BL,
    RUSH_S,
    SNAP_BL,
    STALK,
    STALK_S,
    SUCK_BL,
    SUCK_BL_S,
    advance_hunts,
    attended,
    companions,
    inhale,
    suction,
)
from subsea.behavior.patrolling import SHADOW_BL, SHADOWS, patrol
from subsea.behavior.table import BEHAVIORS, TABLE
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Shoal
from subsea.state import (
    AVOID,
    CHEWING,
    EAT,
    ESCAPE,
    HUNGER,
    PACIFIST,
    PATROLLING,
    PREDATOR,
    PREY,
    RECOVERING,
    RUSHING,
    STALKING,
    WANDER,
    Clock,
    Fishes,
    Minds,
    empty,
)
from subsea.world.build import create_world
from subsea.world.populate import heading_quaternion

LENGTH, SNOUT = 100.0, 30.0
MOUTH = np.array([SNOUT, 0.0, -300.0])
DT = 0.033
CLOCK = Clock(1, 1000, DT)


@pytest.fixture
def around(tank):
    """A sea and its constants of perception and behavior."""
    one = tank(0, specks=1)
    one.sea.plankton[0] = 1e4, 0.0, -300.0
    return one.sea, one.nature


def _hunter(*prey, kind=PREY, length=20.0, gape=1.0):
    """A hungry hunter that heads along x, and fishes at places relative to its mouth."""
    n = 1 + len(prey)
    fishes, minds = empty(Fishes, n=n), empty(Minds, n=n, b=len(BEHAVIORS), d=len(TABLE.desires))
    fishes.length[:] = length
    fishes.length[0], fishes.snout[0] = LENGTH, SNOUT
    fishes.position[0] = 0.0, 0.0, -300.0
    for j, place in enumerate(prey, start=1):
        fishes.position[j] = MOUTH + place
    fishes.orientation[:] = heading_quaternion(0.0)
    fishes.gape[0] = gape
    minds.kind[:] = kind
    minds.kind[0] = PREDATOR
    minds.quarry[:] = 0, n, -1
    minds.mental[0, HUNGER] = 1.0
    minds.appetite[0] = 3.0
    minds.intention[0] = EAT
    minds.food[0] = minds.target[0] = 1 if prey else -1
    minds.pause[:] = DT
    return fishes, minds


def _act(fishes, minds, around):
    fishes.gape[0] = 0.0
    eating.act(np.array([0]), fishes, minds, *around, CLOCK)


FAR = (1.5 * CHASE_BL * LENGTH, 0.0, 0.0)


@pytest.mark.parametrize(
    ("place", "phase"),
    [
        (FAR, STALKING),  # comes up
        ((0.9 * RUSH_BL * LENGTH, 0, 0), RUSHING),  # from behind
        ((0.2 * RUSH_BL * LENGTH, 0, 0.8 * RUSH_BL * LENGTH), STALKING),  # too steep
        ((0.2 * RUSH_BL * LENGTH, 0.8 * RUSH_BL * LENGTH, 0), STALKING),  # has to turn first
    ],
)
def test_a_hunter_stalks_and_rushes_once_it_is_near(around, place, phase):
    fishes, minds = _hunter(place)
    fishes.burst[:] = 3.0
    minds.fatigue[EAT, 0] = 5.0
    _act(fishes, minds, around)
    assert minds.hunt[0] == phase
    assert fishes.goal_speed[0] == pytest.approx(3.0 if phase == RUSHING else STALK)
    assert fishes.gape[0] == 0.0
    assert minds.fatigue[EAT, 0] == pytest.approx(5.0 - DT)


@pytest.mark.parametrize(
    ("heading", "fled", "aside_deg"),
    [
        (0.0, False, 0.0),  # it swims away: straight after it
        (0.5, False, -10.0),  # it closes in, to the tail
        (np.pi / 2, False, -51.0),  # across: it rounds it to the tail
        (-np.pi / 2, False, 51.0),
        (np.pi / 2, True, -14.0),  # it has seen the hunter, so there is no need to hide
    ],
)
def test_it_rounds_the_prey_to_a_place_below_and_behind(around, heading, fled, aside_deg):
    fishes, minds = _hunter(FAR)
    fishes.orientation[1] = heading_quaternion(heading)
    minds.intention[1] = ESCAPE if fled else WANDER
    _act(fishes, minds, around)
    way = minds.urge[0] / np.linalg.norm(minds.urge[0])
    assert np.degrees(np.arctan2(way[1], way[0])) == pytest.approx(aside_deg, abs=5.0)
    assert way[2] < -0.1


def test_it_rushes_from_ahead_and_above_only_after_a_while_or_at_prey_that_flees(around):
    place = (0.9 * RUSH_BL * LENGTH, 0.0, 0.0)
    for spell, fled, phase in (
        (0.0, False, STALKING), (1.1 * PATIENT_S, False, RUSHING), (0.0, True, RUSHING)
    ):  # fmt: skip
        fishes, minds = _hunter(place)
        fishes.orientation[1] = heading_quaternion(np.pi)  # it faces the hunter
        minds.hunt[0], minds.hunt_time[0] = STALKING, spell
        minds.intention[1] = ESCAPE if fled else WANDER
        _act(fishes, minds, around)
        assert minds.hunt[0] == phase


@pytest.mark.parametrize(("spent", "phase"), [(0.9 * READY_S, RUSHING), (1.1 * READY_S, STALKING)])
def test_a_rush_begins_with_strength(around, spent, phase):
    fishes, minds = _hunter((0.8 * RUSH_BL * LENGTH, 0, 0))
    fishes.burst[:] = 3.0
    minds.spent[0] = spent
    _act(fishes, minds, around)
    assert minds.hunt[0] == phase


def test_a_rush_is_one_burst_of_under_two_seconds(around):
    """It goes on while the hunter tires, and misses when time is up or the prey is behind it."""
    fishes, minds = _hunter((100.0, 0, 0))
    fishes.burst[:] = 3.0
    minds.hunt[0], minds.spent[0] = RUSHING, 1.1 * READY_S
    _act(fishes, minds, around)
    assert (minds.hunt[0], minds.target[0]) == (RUSHING, 1)
    assert fishes.goal_speed[0] > 2.0
    advance(minds, fishes, 0.9 * RUSH_S)
    assert minds.hunt[0] == RUSHING
    advance(minds, fishes, 0.2 * RUSH_S)
    assert (minds.hunt[0], minds.target[0], minds.misses[0]) == (RECOVERING, -1, 1.0)
    low, high = RECOVER_S + LULL_S[0]
    assert low <= minds.lull[0] <= high
    assert RUSH_S < 2.0


def test_a_rush_past_the_prey_has_missed(around):
    for place, speed, phase in (
        ((60, 60, 0), 3.0, RUSHING), ((-60, 20, 0), 3.0, RECOVERING)
    ):  # fmt: skip
        fishes, minds = _hunter(place)
        fishes.burst[:] = 3.0
        minds.hunt[0] = RUSHING
        _act(fishes, minds, around)
        assert minds.hunt[0] == phase
        assert fishes.goal_speed[0] == pytest.approx(speed)


def test_the_head_snaps_round_to_the_prey_once_and_gapes(around):
    for gap, snaps, gape in ((1.2 * SNAP_BL, False, 0), (0.9 * OPEN_BL, True, 1)):
        side = np.array([0.8, 0.6, 0.0])
        fishes, minds = _hunter(gap * LENGTH * side)
        minds.hunt[0] = RUSHING
        _act(fishes, minds, around)
        assert fishes.goal_direction[0] == pytest.approx(side, abs=1e-5)
        assert fishes.startle[0] == pytest.approx(np.arctan2(0.6, 0.8) if snaps else 0.0)
        assert fishes.gape[0] == gape
        fishes.startle[0] = 0.0
        _act(fishes, minds, around)
        assert fishes.startle[0] == 0.0


def test_it_heads_off_a_prey_that_crosses_its_way(around):
    fishes, minds = _hunter((120.0, 0.0, 0.0))
    fishes.fast[0], fishes.burst[0] = 60.0, 3.0
    fishes.velocity[1] = 0.0, 25.0, 0.0
    minds.hunt[0] = RUSHING
    _act(fishes, minds, around)
    meeting = 120.0 / (LEAD * 180.0)
    ahead = np.array([120.0, 25.0 * meeting, 0.0])
    assert minds.urge[0] == pytest.approx(ahead / np.linalg.norm(ahead), abs=1e-5)


def advance(minds, fishes, seconds):
    """Let time pass at once."""
    minds.pause[0] = seconds
    advance_hunts(np.array([0]), fishes, minds, CLOCK)
    minds.pause[0] = DT


def test_the_phases_follow_one_another(around):
    fishes, minds = _hunter((100.0, 0.0, 0.0))
    out = np.zeros(2, np.float32)

    def wants():
        eating.desire(np.array([0]), fishes, minds, *around, CLOCK, out)
        return out[0] > 0

    minds.hunt[0], minds.lull[0] = RECOVERING, RECOVER_S + 5.0
    assert not wants()
    advance(minds, fishes, 1.1 * RECOVER_S)
    assert minds.hunt[0] == PATROLLING
    assert not wants()  # it rests
    advance(minds, fishes, 5.0)
    assert minds.lull[0] == 0.0
    assert wants()
    _act(fishes, minds, around)
    minds.hunt[0], minds.hunt_time[0] = STALKING, 0.0
    minds.intention[0] = WANDER  # it lost interest
    advance(minds, fishes, DT)
    assert (minds.hunt[0], minds.lull[0]) == (PATROLLING, LOST_S)
    assert not wants()
    minds.hunt[0], minds.intention[0], minds.memory[0] = STALKING, AVOID, EAT
    advance(minds, fishes, DT)
    assert minds.hunt[0] == STALKING  # a moment's interruption
    minds.hunt[0], minds.memory[0] = CHEWING, -1
    assert wants()
    advance(minds, fishes, 1.1 * CHEW_S)
    assert minds.hunt[0] == PATROLLING


def test_it_gives_up_a_long_stalk(around):
    fishes, minds = _hunter(FAR)
    minds.hunt[0], minds.hunt_time[0] = STALKING, 1.01 * STALK_S
    _act(fishes, minds, around)
    assert minds.hunt[0] == PATROLLING
    assert minds.lull[0] >= LULL_S[0, 0]


@pytest.mark.parametrize(("over", "phase"), [(0.9, STALKING), (1.1, PATROLLING)])
@pytest.mark.parametrize("fled", [False, True])
def test_it_stalks_on_for_a_while_at_prey_within_range_of_a_rush(around, over, phase, fled):
    fishes, minds = _hunter((0.2 * RUSH_BL * LENGTH, 0.8 * RUSH_BL * LENGTH, 0))  # it has to turn
    minds.intention[1] = ESCAPE if fled else WANDER
    minds.hunt[0], minds.hunt_time[0] = STALKING, STALK_S + over * ALMOST_S
    _act(fishes, minds, around)
    assert minds.hunt[0] == phase


def test_a_hunter_that_rests_begins_no_stalk(around):
    """Its intention to eat may outlast a meal or a stalk that failed."""
    fishes, minds = _hunter((0.9 * RUSH_BL * LENGTH, 0, 0))
    minds.waypoint[0], minds.patience[0] = (0.0, 500.0, -300.0), 100.0
    minds.lull[0] = 1.0
    _act(fishes, minds, around)
    assert minds.hunt[0] == PATROLLING
    minds.lull[0] = 0.0
    _act(fishes, minds, around)
    assert minds.hunt[0] == RUSHING


@pytest.mark.parametrize(
    ("share", "hungry", "errand", "turns"),
    [(1.1, 1.0, 0.0, 1.0), (1.1, 0.2, 0.0, 0.2), (0.9, 1.0, 0.0, 0.0), (1.1, 1.0, 0.5, 0.0)],
)
def test_a_hungry_hunter_on_patrol_shadows_prey(around, share, hungry, errand, turns):
    fishes, minds = _hunter((share * SHADOW_BL * LENGTH - SNOUT, 0, 0))
    minds.foods[0, 0], minds.mental[0, HUNGER], minds.errand[0] = 1, hungry, errand
    way = patrol(fishes, minds, 0, (0.0, 1.0, 0.0))
    assert way == pytest.approx((turns * SHADOWS, 1.0, 0.0), abs=1e-5)


def test_it_closes_the_gap_to_prey_that_flees(around):
    fishes, minds = _hunter(FAR)
    minds.intention[1] = ESCAPE
    _act(fishes, minds, around)
    assert minds.hunt[0] == STALKING
    assert fishes.goal_speed[0] == pytest.approx(PURSUIT)


def test_a_sated_hunter_rests_longer_and_one_that_missed_often_less(around):
    def lull(hunger, misses):
        fishes, minds = _hunter((100.0, 0, 0))
        minds.hunt[0], minds.hunt_time[0] = RUSHING, RUSH_S
        minds.mental[0, HUNGER], minds.misses[0] = hunger, misses
        advance(minds, fishes, DT)
        return float(minds.lull[0]) - RECOVER_S

    assert lull(0.5, 0) == pytest.approx(2.0 * lull(1.0, 0), rel=1e-3)
    assert lull(1.0, 3) == pytest.approx(lull(1.0, 0) / 2.5, rel=1e-3)


def test_two_hunters_of_one_prey_part(around):
    """The smaller turns away from the larger, and does not rush with it before it."""
    fishes, minds = _hunter((0.9 * RUSH_BL * LENGTH, 0, 0), (10.0, 20.0, 0.0))
    fishes.length[2], minds.kind[2] = 1.2 * LENGTH, PREDATOR
    minds.rival[0] = 2
    _act(fishes, minds, around)
    assert minds.hunt[0] == STALKING
    assert minds.urge[0, 1] < 0.0
    fishes.length[2] = 0.8 * LENGTH
    _act(fishes, minds, around)
    assert minds.hunt[0] == RUSHING


def test_without_a_living_prey_it_cruises(around):
    fishes, minds = _hunter((50.0, 0.0, 0.0))
    fishes.alive[1] = False
    minds.waypoint[0], minds.patience[0] = (0.0, 500.0, -300.0), 100.0
    _act(fishes, minds, around)
    assert minds.urge[0] == pytest.approx([0.0, 1.0, 0.0], abs=1e-5)


def test_hunger_decides_whether_it_hunts(around):
    fishes, minds = _hunter((50.0, 0.0, 0.0))
    out = np.zeros(2, np.float32)

    def wants():
        eating.desire(np.array([0]), fishes, minds, *around, CLOCK, out)
        return out[0] > 0

    assert wants()
    minds.mental[0, HUNGER] = 0.9 * around[1].keen
    assert not wants()
    minds.hunt[0] = STALKING
    assert wants()  # a hunt is finished
    minds.hunt[0], minds.mental[0, HUNGER] = PATROLLING, 1.0
    minds.food[0] = -1
    assert not wants()


@given(
    place=st.tuples(*[st.floats(-60, 60)] * 3).filter(lambda p: np.linalg.norm(p) > 0.1),
    length=st.floats(20, 150),
)
def test_the_vacuum_falls_with_distance_and_never_overshoots(place, length):
    place = np.array(place)
    distance = np.linalg.norm(place)
    flow = np.array(suction(tuple(-place), np.float32(length), DT))
    full = SUCK_BL_S * length * max(1 - distance / (SUCK_BL * length), 0)
    assert np.linalg.norm(flow) == pytest.approx(min(full, distance / DT))
    assert flow @ place <= 0


def test_an_open_mouth_draws_all_that_is_near_and_large_fishes_less(around):
    sea, _ = around
    near = 0.6 * SUCK_BL * LENGTH
    fishes, minds = _hunter((near, 0, 0), (0, near, 0), (0, 2 * near, 0), kind=PACIFIST)
    fishes.length[2] = 90.0
    sea.plankton[0] = MOUTH + (0, 0, near)
    inhale(fishes, minds, sea, CLOCK)
    speed = 0.4 * SUCK_BL_S * LENGTH
    resists = (FITS * LENGTH / 90.0) ** 2
    assert fishes.drift[1] == pytest.approx([-speed, 0, 0], abs=1e-3)
    assert fishes.drift[2] == pytest.approx([0, -resists * speed, 0], abs=1e-3)
    assert fishes.drift[3] == pytest.approx([0, 0, 0])
    assert fishes.drift[0] == pytest.approx([0, 0, 0])  # not the hunter itself
    assert sea.plankton[0] == pytest.approx(MOUTH + (0, 0, near - DT * speed), abs=1e-3)
    assert fishes.alive.all()  # pacifists are drawn, not eaten


def test_many_mouths_draw_what_each_of_them_would_draw(around):
    """The sum is the same with sorted mouths and in a plain loop."""
    rng = np.random.default_rng(3)
    fishes, minds = _hunter(*rng.uniform(-120, 120, (80, 3)), kind=PACIFIST)
    hunters = [0, 11, 30, 52, 77]
    minds.kind[hunters] = PREDATOR
    minds.intention[hunters] = EAT
    fishes.length[hunters] = [100, 60, 140, 90, 30]
    fishes.gape[hunters] = 1.0
    inhale(fishes, minds, around[0], CLOCK)
    expected = np.zeros((81, 3))
    for j in range(81):
        for i in hunters:
            if i != j:
                toward = np.subtract(mouth_of(fishes, i), fishes.position[j])
                small = min(FITS * fishes.length[i] / fishes.length[j], 1.0) ** 2
                expected[j] += small * np.array(suction(tuple(toward), fishes.length[i], DT))
    assert np.abs(expected).max() > 1
    np.testing.assert_allclose(fishes.drift, expected, atol=1e-3)


def test_a_prey_in_the_mouth_is_eaten(around):
    within = MOUTH_BL * LENGTH
    fishes, minds = _hunter((within, 0, 0), (-200, 0, 0))
    minds.fatigue[EAT, 0] = 20.0
    inhale(fishes, minds, around[0], CLOCK)
    assert fishes.alive.tolist() == [True, False, True]
    assert minds.eaten[0] == 1
    assert minds.last_meal[0] == pytest.approx(CLOCK.tick * DT)
    assert minds.fatigue[EAT, 0] == 0
    assert minds.target[0] == minds.food[0] == -1
    assert (minds.hunt[0], minds.misses[0]) == (CHEWING, 0.0)
    low, high = CHEW_S + LULL_S[1]
    assert low <= minds.lull[0] <= high
    _act(fishes, minds, around)
    assert 0 < fishes.gape[0] < 0.5  # it chews


def test_a_strike_takes_one_of_those_in_the_mouth(around):
    """The mouth shuts on it, and stays shut while the hunter chews."""
    within = MOUTH_BL * LENGTH
    fishes, minds = _hunter((within, 0, 0), (0, within, 0), (0, 0, within))
    for _ in range(3):
        inhale(fishes, minds, around[0], CLOCK)
        assert fishes.alive.sum() == 3
        assert (minds.eaten[0], fishes.gape[0]) == (1.0, 0.0)


@pytest.mark.parametrize(
    ("length", "gape", "intention"),
    [(1.1 * FITS * LENGTH, 1, EAT), (20, 0.2, EAT), (20, 1, WANDER)],
)
def test_neither_large_prey_nor_by_a_shut_or_idle_mouth_is_swallowed(
    around, length, gape, intention
):
    fishes, minds = _hunter((3.0, 0, 0), gape=gape)
    fishes.length[1], minds.intention[0] = length, intention
    inhale(fishes, minds, around[0], CLOCK)
    assert fishes.alive.all()


def test_a_shoal_may_be_of_another_kind_than_its_species():
    scenario = load_scenario("peaceful").scenario
    shoal = Shoal(species="moon_wrasse", number=2, kind="predator")
    world = create_world(msgspec.structs.replace(scenario, fish=[shoal]))
    assert (world.state.minds.kind == PREDATOR).all()


@pytest.mark.parametrize(("crowd", "stays"), [(0, 1.0), (2, 0.64), (5, 0.49), (19, 0.30)])
def test_the_more_prey_the_less_sure_is_the_hunter_of_one(around, crowd, stays):
    """Neighbours of the prey are drawn alike; those out of reach and other kinds confuse nobody."""
    close = [(60, 3 * k, 0) for k in range(crowd + 1)]
    fishes, minds = _hunter(*close, (60, 200, 0), (60, 0, 10))
    minds.kind[-1] = PACIFIST
    near = min(crowd, minds.neighbour.shape[1])
    minds.neighbour[1] = -1
    minds.neighbour[1, :near] = 2 + np.arange(near)
    assert companions(fishes, minds, 1) == crowd
    seen = [attended(fishes, minds, 0, 1, CLOCK._replace(tick=int(tick)))
            for tick in ATTENTION_TICKS * np.arange(800)]  # fmt: skip
    assert np.mean([sure for _, sure in seen]) == pytest.approx(stays, abs=0.06)
    assert all(fish == 1 for fish, sure in seen if sure)
    if near == minds.neighbour.shape[1]:
        drawn = np.bincount([fish for fish, sure in seen if not sure], minlength=2 + near)[2:]
        assert drawn / drawn.sum() == pytest.approx(1 / near, abs=0.06)


def test_attention_passes_once_in_a_spell_and_to_allowed_prey(around):
    fishes, minds = _hunter((60, 0, 0), (60, 20, 0), (60, -30, 0))
    minds.neighbour[1] = -1
    minds.neighbour[1, :2] = 2, 3
    ticks = ATTENTION_TICKS * np.arange(300)

    def chosen(tick):
        return attended(fishes, minds, 0, 1, CLOCK._replace(tick=int(tick)))

    seen = [chosen(tick) for tick in ticks]
    assert {fish for fish, _ in seen} == {1, 2, 3}
    # It is unsure for the whole spell, and passes to another at its first decision in it.
    assert [chosen(tick + 1) for tick in ticks] == [(1, sure) for _, sure in seen]
    minds.pause[0] = 8 * DT
    assert [chosen(tick + 7) for tick in ticks] == seen
    minds.quarry[0] = 0, 3, -1  # directed
    assert {fish for fish, _ in map(chosen, ticks)} == {1, 2}


def test_a_hunter_that_is_not_sure_keeps_its_mouth_shut(around):
    """It goes on bursting."""
    near = 0.5 * OPEN_BL * LENGTH
    seen = set()
    for tick in ATTENTION_TICKS * np.arange(40) + 1:
        fishes, minds = _hunter((near, 0, 0), (near, 2, 0), (near, -2, 0))
        fishes.burst[:] = 3.0
        minds.neighbour[1, :2] = 2, 3
        fishes.gape[0], minds.hunt[0] = 0.0, RUSHING
        clock = CLOCK._replace(tick=int(tick))
        _, sure = attended(fishes, minds, 0, 1, clock)
        eating.act(np.array([0]), fishes, minds, *around, clock)
        assert fishes.goal_speed[0] > 1.0
        assert fishes.gape[0] == (1.0 if sure else 0.0)
        seen.add(sure)
    assert seen == {True, False}
