"""A school of agents, by the convention of PettingZoo."""

import numpy as np
import pytest
from pettingzoo.test import parallel_api_test, parallel_seed_test

from subsea.base.errors import UserError
from subsea.kernels.threads import use_threads
from subsea.lab.environments import school
from subsea.lab.environments.living_sea import Outcome
from subsea.lab.environments.rewards import school_reward
from subsea.world import step
from subsea.world.snapshot import checksum
from tests.support.scenes import BARE


def small(**options):
    return school.parallel_env(str(BARE), max_steps=5, **options)


@pytest.fixture
def env():
    return small()


def test_it_keeps_the_convention(capsys):
    parallel_api_test(small(), num_cycles=8)
    parallel_seed_test(small, num_cycles=6)


def test_all_fishes_are_agents_or_those_that_are_named(env):
    assert env.possible_agents == [
        "fusilier_0", "fusilier_1", "fusilier_2", "fusilier_3", "clownfish_0", "clownfish_1",
    ]  # fmt: skip
    assert small(agents=["clownfish"]).possible_agents == ["clownfish_0", "clownfish_1"]
    assert small(agents=["fusilier:2", 0]).possible_agents == ["fusilier_0", "fusilier_2"]
    with pytest.raises(UserError, match="unknown fish 'cod'"):
        small(agents=["cod"])


def test_the_others_keep_their_own_minds():
    env = small(agents=["fusilier"])
    env.reset(seed=1)
    for _ in range(3):
        env.step({agent: np.zeros(3) for agent in env.agents})
    speed = env.sea.world.state.fishes.goal_speed
    assert (speed[:4] == 0.0).all()
    assert (speed[4:] > 0.0).all()


def test_faulty_actions_are_one_line(env):
    env.reset(seed=1)
    still = {agent: np.zeros(3) for agent in env.agents}
    for faulty, line in (
        (still | {"cod_0": np.zeros(3)}, "agent cod_0 is unknown"),
        ({"fusilier_0": np.zeros(3)}, "has no action"),
        (still | {"fusilier_1": np.array([0.0, np.nan, 0.0])}, "fusilier_1: expected 3 finite"),
        (still | {"fusilier_1": np.zeros((3, 1))}, "fusilier_1: expected 3 finite"),
    ):
        with pytest.raises(ValueError, match=line):
            env.step(faulty)


def test_a_school_that_agrees_earns_most(env):
    env.reset(seed=1)
    world = env.sea.world
    fishes, minds = world.state.fishes, world.state.minds
    who = np.arange(3)
    minds.neighbour[who] = -1
    minds.neighbour[0, 0], minds.neighbour[1, 0] = 1, 0  # the third is alone
    fishes.orientation[who] = fishes.orientation[0]

    def earned(gap_bl):
        fishes.position[1] = fishes.position[0] + [gap_bl * fishes.length[:2].mean(), 0.0, 0.0]
        return school_reward(Outcome(world, who, np.zeros(3), np.array([True] * 3), 0.1))

    near, far, touching = earned(1.0), earned(4.0), earned(0.1)
    assert near[0] > far[0] > 1.0 > touching[0] - 0.1
    assert near[2] == 0.0
    fishes.orientation[1] = fishes.orientation[0] * [-1.0, 1.0, -1.0, 1.0]
    alive = np.array([True, True, False])
    assert school_reward(Outcome(world, who, np.zeros(3), alive, 0.1))[2] == -1.0


@pytest.fixture
def with_threads(monkeypatch):
    """Run ticks on a number of threads, which share also few fishes."""
    monkeypatch.setattr(step, "LEAST_PART", 4)
    monkeypatch.setattr(step, "LEAST_MINDS", 4)
    yield use_threads
    use_threads()


def test_the_number_of_threads_does_not_matter(with_threads):
    def run(threads):
        with_threads(threads)
        env = small(changes=["fish.0.number=40"])
        env.reset(seed=5)
        for k in range(5):
            env.step({agent: np.sin([k, n, 1.0]) for n, agent in enumerate(env.agents)})
        return checksum(env.sea.world)

    assert run(1) == run(2)
