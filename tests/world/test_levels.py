"""Levels of motion and mind by the distance to the submarine."""

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.dive.start import ready_world
from subsea.dive.timeline import Timeline
from subsea.scenario.load import load_scenario
from subsea.state import CIRCLING, ESCAPE, FEAR, RUSHING, WANDER, Clock
from subsea.submarine.vessel import Helm
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.levels import FINS_CM, MANY, find_turns
from subsea.world.step import step
from subsea.world.world import TICK_S

AHEAD = Helm(surge=0.4, yaw=0.1)
VISIBILITY_CM, ALARMED = 3000.0, 0.5
NOBODY_AWAKE = np.zeros(0, np.int64)
# Distance to the submarine, cm; ticks between two thoughts, and between two feelings.
PLACES = (
    (100.0, 1, 1), (300.0, 1, 1), (500.0, 4, 2), (900.0, 8, 4), (1700.0, 16, 8), (4000.0, 16, 8),
)  # fmt: skip


def made(name="schooling", fish=24, levels=True, seed=3):
    world = create_world(load_scenario(name)[0], seed, fish)
    world.levels = levels
    return world


@pytest.fixture
def placed():
    """A world whose fishes are at the distances of PLACES in turn, and calm."""
    state = made().state
    distance = np.array([PLACES[i % len(PLACES)][0] for i in range(24)])
    angle = 2.0 * np.pi * np.arange(24) / 24
    state.fishes.position[:] = state.sea.submarine[:3]
    state.fishes.position[:, 0] += distance * np.cos(angle)
    state.fishes.position[:, 1] += distance * np.sin(angle)
    state.minds.intention[:], state.minds.mental[:, FEAR] = WANDER, 0.0
    return state


def turns_of(state, ticks=16, awake=NOBODY_AWAKE):
    """Find the ticks in which fishes think (T, n), and for how many they feel (T, n)."""
    n = len(state.fishes.species)
    thinks, feels = np.zeros((ticks, n), bool), np.zeros((ticks, n))
    for t in range(ticks):
        turn = find_turns(state, VISIBILITY_CM, ALARMED, awake, Clock(0, t + 1, TICK_S))
        thinks[t, turn.thinking] = True
        for clock, who in turn.parts:
            feels[t, who] = clock.dt / TICK_S
        np.testing.assert_array_equal(turn.feeling, np.flatnonzero(feels[t]))
    return thinks, feels


def test_far_fishes_take_turns(placed):
    thinks, feels = turns_of(placed)
    for i in range(24):
        _, thought, level = PLACES[i % len(PLACES)]
        assert thinks[:, i].sum() == 16 // thought
        assert set(np.round(feels[:, i])) == ({level} if level == 1 else {0, level})
        assert feels[:, i].sum() == pytest.approx(16)  # no time is lost
    assert (feels[thinks] > 0.0).all()  # a fish acts in the tick in which it decides


def test_turns_are_spread_over_ticks(placed):
    placed.fishes.position[:] = placed.sea.submarine[:3]
    placed.fishes.position[:, 0] += 1700.0
    _, feels = turns_of(placed)
    assert ((feels > 0.0).sum(axis=1) == 24 // 8).all()


@pytest.mark.parametrize(
    "what", ["flees", "rushes", "is hunted", "is near", "courts", "is steered"]
)
def test_a_busy_fish_feels_the_water_in_every_tick(placed, what):
    i, other, calm, minds = 4, 10, 16, placed.minds  # all at 1700 cm
    awake = NOBODY_AWAKE
    if what == "flees":
        minds.intention[i] = ESCAPE
    elif what == "rushes":
        minds.hunt[i], minds.target[i] = RUSHING, -1
    elif what == "is hunted":
        minds.hunt[other], minds.target[other] = RUSHING, i
    elif what == "is near":
        minds.hunt[other] = RUSHING
        placed.fishes.position[i] = placed.fishes.position[other]
        placed.fishes.position[i, 2] += 2.0 * placed.fishes.length[other]
    elif what == "courts":
        minds.courtship[i] = CIRCLING
    else:
        awake = np.array([i])
    _, feels = turns_of(placed, awake=awake)
    np.testing.assert_allclose(feels[:, i], 1.0)
    assert (feels[:, calm] != 1.0).all()


def test_a_fish_that_is_alarmed_thinks_as_without_levels(placed):
    placed.minds.mental[:, FEAR] = 0.4
    placed.minds.mental[[3, 4, 5], FEAR] = 0.6
    thinks, feels = turns_of(placed)
    assert thinks[:, 3:6].sum(axis=0).tolist() == [4, 4, 2]
    assert (feels[thinks] > 0.0).all()


def test_a_fast_fish_feels_the_water_more_often(placed):
    placed.fishes.velocity[[4, 10], 1] = 50.0, 300.0  # 1.7 and 10 cm in a tick
    _, feels = turns_of(placed)
    assert (feels > 0.0).sum(axis=0)[[4, 10, 16]].tolist() == [4, 16, 2]


def test_fins_of_far_fishes_move_in_every_fourth_tick(placed):
    moves = np.zeros(24)
    for t in range(16):
        moves += find_turns(placed, VISIBILITY_CM, ALARMED, NOBODY_AWAKE, Clock(0, t + 1, TICK_S))[
            3
        ]
    assert moves.tolist() == [16.0 if PLACES[i % 6][0] < FINS_CM else 4.0 for i in range(24)]


def test_fins_change_nothing_but_the_picture(monkeypatch):
    """The world is the same, bit for bit, if the fins of all fishes move in every tick."""
    world, other = made(), made()
    for _ in range(40):
        step(world, AHEAD)
    assert (world.state.fishes.rested > 0).any()

    def restless(*given):
        return find_turns(*given)._replace(flapping=np.ones(24, bool))

    monkeypatch.setattr("subsea.world.step.find_turns", restless)
    for _ in range(40):
        step(other, AHEAD)
    assert (other.state.fishes.rested == 0).all()
    beats = ("fins", "previous_fins", "fin_phase", "breath", "rested")
    for group in ("fishes", "minds"):
        calm, moved = getattr(world.state, group), getattr(other.state, group)
        for name in calm._fields:
            if name not in beats:
                np.testing.assert_array_equal(getattr(calm, name), getattr(moved, name))


def test_the_dead_have_no_turn(placed):
    placed.fishes.alive[4] = False
    thinks, feels = turns_of(placed)
    assert not thinks[:, 4].any()
    assert not feels[:, 4].any()


def test_a_world_with_levels_restored_from_a_snapshot_continues_equally():
    world, other = made("open-ocean", 60), made("open-ocean", 60)
    for _ in range(45):
        step(world, AHEAD)
    snapshot.restore(other, snapshot.take(world))
    for _ in range(20):
        step(world, AHEAD)
        step(other, AHEAD)
    assert snapshot.checksum(other) == snapshot.checksum(world)


@pytest.mark.nightly
def test_rewinding_a_world_with_levels_restores_it():
    world = made("open-ocean", 60)
    time, sums = Timeline(world), []
    for _ in range(70):
        time.make(AHEAD)
        sums.append(snapshot.checksum(world))
    for tick in (41, 8, 63):
        time.go(tick)
        assert snapshot.checksum(world) == sums[tick - 1]


def test_only_a_dive_has_levels_unless_its_scenario_says_no():
    assert not create_world(load_scenario("schooling")[0], fish=2).levels
    for changes, levels in (([], True), (["levels=false"], False)):
        loaded = load_scenario("schooling", changes)
        assert not ready_world(loaded, fish=MANY).levels
        assert ready_world(loaded, fish=MANY, levels=True).levels == levels
        assert not ready_world(loaded, fish=MANY - 1, levels=True).levels


def test_levels_is_true_or_false():
    with pytest.raises(UserError, match="levels") as fault:
        load_scenario("schooling", ["levels=2"])
    assert "\n" not in str(fault.value)
