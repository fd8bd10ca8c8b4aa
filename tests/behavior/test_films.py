"""Tu's films of hunting and of the hook, at reduced length (Tu §10.1, §10.3)."""

import numpy as np
import pytest

from subsea.scenario.load import load_scenario
from subsea.state import BAIT, EAT, ESCAPE, FEAR, HOOKED, LANDED, NOBODY, PACIFIST, PREY
from subsea.submarine.helm import NEUTRAL
from subsea.world.build import create_world
from subsea.world.step import step


@pytest.fixture(scope="module", params=[1, 2, 3])
def hunt(request):
    """Twelve seconds of `preying`: the world, and fear, intention and life of all at each tick."""
    world = create_world(load_scenario("preying")[0], seed=request.param)
    fear, intention, alive = [], [], []
    for _ in range(370):
        step(world, NEUTRAL)
        fear.append(world.state.minds.mental[:, FEAR].copy())
        intention.append(world.state.minds.intention.copy())
        alive.append(world.state.fishes.alive.copy())
    return world, np.array(fear), np.array(intention), np.array(alive)


def test_the_hunter_catches_a_straggler_first(hunt):
    world, _, intention, alive = hunt
    dead = ~alive[-1]
    assert dead.any()
    first = np.argmin(alive[:, dead], axis=0).argmin()
    minds = world.state.minds
    assert not minds.schools[np.flatnonzero(dead)[first]]
    assert (minds.kind[dead] == PREY).all()
    assert intention[0, 0] == EAT
    assert minds.eaten[0] >= dead.sum()
    assert minds.target[0] not in np.flatnonzero(dead)


def test_fear_precedes_each_escape(hunt):
    world, fear, intention, _ = hunt
    flees = intention == ESCAPE
    begins = flees[1:] & ~flees[:-1]
    assert begins.any()
    assert (fear[1:][begins] > world.nature.alarmed).all()


def test_pacifists_feed_on_untroubled(hunt):
    world, fear, intention, _ = hunt
    peaceful = world.state.minds.kind == PACIFIST
    assert (fear[:, peaceful] == 0).all()
    assert (intention[:, peaceful] == EAT).mean() > 0.3
    assert not (intention[:, peaceful] == ESCAPE).any()


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
