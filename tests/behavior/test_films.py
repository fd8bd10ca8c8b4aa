"""Tu's films of hunting and of the hook, at reduced length (Tu §10.1, §10.3)."""

from functools import cache

import numpy as np
import pytest

from subsea.behavior.chasing import mouth_of
from subsea.geometry.rotation import rotate
from subsea.scenario.load import load_scenario
from subsea.state import BAIT, EAT, ESCAPE, FEAR, GRAZE, HOOKED, LANDED, NOBODY, PACIFIST, PREY
from subsea.submarine.vessel import NEUTRAL
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.step import step
from tests.support.daily import only

STRAGGLER = 6


@pytest.fixture(params=only([1], [1, 2, 3]))
def hunt(request):
    return twelve_seconds(request.param)


def sea_of_prey(seed):
    """`preying` without its seaweed, which is slow, and irrelevant here."""
    scenario = load_scenario("preying", ["seaweed=[]"]).scenario
    return create_world(scenario, seed=seed)


@cache
def twelve_seconds(seed):
    """Of `preying`: the world, targets of the hunter, and fear and intentions."""
    world = sea_of_prey(seed)
    target, fear, intention = [], [], []
    for _ in range(370):
        step(world, NEUTRAL)
        target.append(int(world.state.minds.target[0]))
        fear.append(world.state.minds.mental[:, FEAR].copy())
        intention.append(world.state.minds.intention.copy())
    return world, np.array(target), np.array(fear), np.array(intention)


def test_the_hunter_patrols_first_and_then_hunts_prey(hunt):
    world, target, _, intention = hunt
    hunts = intention[:, 0] == EAT
    assert not hunts[:60].any()
    assert hunts.any()
    picked = target[hunts & (target != NOBODY)]
    assert (world.state.minds.kind[picked] == PREY).all()


@pytest.mark.nightly
def test_some_prey_before_the_hunter_is_caught_and_some_escapes():
    caught = []
    for seed in range(1, 4):
        world = sea_of_prey(seed)
        fishes, minds = world.state.fishes, world.state.minds
        step(world, NEUTRAL)
        minds.lull[0] = 0.0
        start = snapshot.take(world)
        for gap in (1.0, 2.0, 3.0):
            snapshot.restore(world, start)
            ahead = np.array(rotate(fishes.orientation[0], (gap * fishes.length[0], 0.0, 0.0)))
            fishes.position[STRAGGLER] = mouth_of(fishes, 0) + ahead
            for _ in range(120):
                step(world, NEUTRAL)
            caught += [not fishes.alive[STRAGGLER]]
            dead = np.flatnonzero(~fishes.alive)
            assert (minds.kind[dead] == PREY).all()
            assert minds.eaten[0] == len(dead)
            assert minds.target[0] not in dead
    assert 2 <= sum(caught) <= 7


def test_fear_precedes_each_escape(hunt):
    world, _, fear, intention = hunt
    flees = intention == ESCAPE
    begins = flees[1:] & ~flees[:-1]
    assert begins.any()
    assert (fear[1:][begins] > world.nature.alarmed).all()


def test_pacifists_feed_on_untroubled(hunt):
    world, _, fear, intention = hunt
    peaceful = world.state.minds.kind == PACIFIST
    assert (fear[:, peaceful] == 0).all()
    assert np.isin(intention[:, peaceful], (EAT, GRAZE)).mean() > 0.3
    assert not (intention[:, peaceful] == ESCAPE).any()


@pytest.mark.nightly
def test_the_first_to_bite_is_drawn_up():
    world = create_world(load_scenario("go-fish")[0])
    sea, fishes, minds = world.state.sea, world.state.fishes, world.state.minds
    came, strained, rise = 0, [], []
    for _ in range(2000):
        step(world, NEUTRAL)
        came = max(came, int((minds.target == BAIT).sum()))
        caught = sea.catch[1]
        if sea.catch[0] == HOOKED and caught != NOBODY:
            strained.append(minds.intention[caught])
            rise.append(fishes.position[caught, 2])
        if sea.catch[0] == LANDED:
            break
    assert world.state.tick * 0.033 < 60
    assert came > 1  # others wanted it too, ...
    assert not (minds.target == BAIT).any()  # ... and have given it up
    assert (~fishes.alive).sum() == 1
    assert len(set(strained[10:])) == 1
    assert (np.diff(rise)[30:] > 0).mean() > 0.9
