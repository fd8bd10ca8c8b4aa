"""Hunting by predators, and suction by an open mouth."""

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.behavior import eating
from subsea.behavior.chasing import mouth_of
from subsea.behavior.hunting import (
    ATTENTION_TICKS,
    BRAKED,
    BURST_BL,
    FITS,
    MOUTH_BL,
    OPEN_BL,
    READY_S,
    RESTED_S,
    STALK,
    STRAIN,
    SUCK_BL,
    SUCK_BL_S,
    attended,
    companions,
    inhale,
    suction,
)
from subsea.behavior.table import BEHAVIORS, DESIRES
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Shoal
from subsea.state import (
    AVOID,
    EAT,
    HUNGER,
    PACIFIST,
    PREDATOR,
    PREY,
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
    fishes, minds = empty(Fishes, n=n), empty(Minds, n=n, b=len(BEHAVIORS), d=len(DESIRES))
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


@pytest.mark.parametrize(
    ("place", "speed", "gape"),
    [
        ((1.5 * BURST_BL * LENGTH, 0, 0), STALK, 0),  # comes up
        ((0.8 * BURST_BL * LENGTH, 0, 0), 1.0, 0),  # bursts forward
        ((20, 150, 0), BRAKED, 0),  # turns
        ((0.5 * OPEN_BL * LENGTH, 0, 0), 1.0, 1),  # gapes
    ],
)
def test_a_hunter_comes_up_and_bursts_forward(around, place, speed, gape):
    fishes, minds = _hunter(place)
    minds.fatigue[EAT, 0] = 5.0
    _act(fishes, minds, around)
    assert fishes.goal_speed[0] == pytest.approx(speed)
    assert fishes.gape[0] == gape
    toward = minds.urge[0] / np.linalg.norm(minds.urge[0])
    assert toward @ (np.array(place) / np.linalg.norm(place)) > 0.999
    strain = STRAIN if speed == 1 else 0.0
    assert minds.fatigue[EAT, 0] == pytest.approx(5.0 + (strain - 1) * DT)


@pytest.mark.parametrize(
    ("spent", "speed_before", "strikes"),
    [(0.9 * READY_S, 0.5, True), (1.1 * READY_S, 0.5, False), (1.1 * READY_S, 1.5, True)],
)
def test_a_strike_is_begun_with_strength_and_gone_on_with(around, spent, speed_before, strikes):
    fishes, minds = _hunter((0.8 * BURST_BL * LENGTH, 0, 0))
    fishes.burst[:] = 3.0
    fishes.goal_speed[0], minds.spent[0] = speed_before, spent
    _act(fishes, minds, around)
    assert (fishes.goal_speed[0] > 1.0) == strikes


def test_it_heads_off_a_prey_that_crosses_its_way(around):
    fishes, minds = _hunter((120.0, 0.0, 0.0))
    fishes.velocity[0] = 60.0, 0.0, 0.0
    fishes.velocity[1] = 0.0, 25.0, 0.0
    _act(fishes, minds, around)
    # They meet in two seconds.
    assert minds.urge[0] == pytest.approx([120.0, 50.0, 0.0])


def test_without_a_living_prey_it_cruises(around):
    fishes, minds = _hunter((50.0, 0.0, 0.0))
    fishes.alive[1] = False
    minds.waypoint[0], minds.patience[0] = (0.0, 500.0, -300.0), 100.0
    _act(fishes, minds, around)
    assert minds.urge[0] == pytest.approx([0.0, 1.0, 0.0], abs=1e-5)


def test_hunger_and_fatigue_decide_whether_it_hunts(around):
    fishes, minds = _hunter((50.0, 0.0, 0.0))
    out = np.zeros(2, np.float32)

    def wants():
        eating.desire(np.array([0]), fishes, minds, *around, CLOCK, out)
        return out[0] > 0

    assert wants()
    minds.fatigue[EAT, 0] = RESTED_S + 1
    assert wants()  # a chase is finished ...
    minds.intention[0], minds.memory[0] = AVOID, EAT
    assert wants()  # ... even when it was interrupted, ...
    minds.memory[0] = -1
    assert not wants()  # ... but one that gave up rests
    minds.fatigue[EAT, 0] = RESTED_S - 1
    assert wants()
    minds.mental[0, HUNGER] = 0.9 * around[1].keen
    assert not wants()  # it has eaten its fill
    minds.mental[0, HUNGER] = 1.0
    minds.food[0] = -1
    assert not wants()


@given(
    place=st.tuples(*[st.floats(-60, 60)] * 3).filter(lambda p: np.linalg.norm(p) > 0.1),
    length=st.floats(20, 150),
)
def test_the_vacuum_falls_with_distance_and_never_overshoots(place, length):
    place = np.array(place)
    distance = np.linalg.norm(place)
    flow = np.array(suction(tuple(-place), length, DT))
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


def test_in_a_crowd_attention_is_divided_evenly(around):
    """Among a prey and two near companions; the third is too far away, and a lone one keeps it."""
    fishes, minds = _hunter((60, 0, 0), (60, 20, 0), (60, -30, 0), (60, 200, 0))
    minds.neighbour[1, :3] = 2, 3, 4
    ticks = ATTENTION_TICKS * np.arange(600)

    def chosen(tick):
        crowd = companions(fishes, minds, 1)
        return attended(fishes, minds, 0, 1, crowd, CLOCK._replace(tick=int(tick)))

    seen = [chosen(tick) for tick in ticks]
    assert np.bincount([fish for fish, _ in seen], minlength=5) / 600 == pytest.approx(
        [0, 1, 1, 1, 0] / np.float64(3), abs=0.08
    )
    assert all(sure == (fish == 1) for fish, sure in seen)
    # It is unsure for the whole spell, and passes to another at its first decision in it.
    assert [chosen(tick + 1) for tick in ticks] == [(1, sure) for _, sure in seen]
    minds.pause[0] = 8 * DT
    assert [chosen(tick + 7) for tick in ticks] == seen
    minds.quarry[0] = 0, 3, -1  # directed
    assert {fish for fish, _ in map(chosen, ticks)} == {1, 2}
    minds.neighbour[1] = -1
    assert {chosen(tick) for tick in ticks} == {(1, True)}


def test_a_hunter_that_is_not_sure_keeps_its_mouth_shut(around):
    """It goes on bursting, and tires."""
    near = 0.5 * OPEN_BL * LENGTH
    seen = set()
    for tick in ATTENTION_TICKS * np.arange(40) + 1:
        fishes, minds = _hunter((near, 0, 0), (near, 2, 0), (near, -2, 0))
        fishes.burst[:] = 3.0
        minds.neighbour[1, :2] = 2, 3
        fishes.gape[0] = 0.0
        clock = CLOCK._replace(tick=int(tick))
        _, sure = attended(fishes, minds, 0, 1, 2, clock)
        eating.act(np.array([0]), fishes, minds, *around, clock)
        assert fishes.goal_speed[0] > 1.0
        assert fishes.gape[0] == (1.0 if sure else 0.0)
        seen.add(sure)
    assert seen == {True, False}
