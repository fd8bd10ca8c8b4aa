"""A hunt of agents, by the convention of PettingZoo."""

import numpy as np
import pytest
from pettingzoo.test import parallel_api_test, parallel_seed_test

from subsea.base.errors import UserError
from subsea.behavior.chasing import mouth_of
from subsea.geometry.rotation import x_axis
from subsea.lab.environments import predator_prey
from tests.support.scenes import BARE

LEAN = ["water.plankton=0", "seaweed=[]", "reef=[]"]


def lean():
    return predator_prey.parallel_env(changes=LEAN, max_steps=6)


def test_it_keeps_the_convention(capsys):
    parallel_api_test(lean(), num_cycles=8)
    parallel_seed_test(lean, num_cycles=6)


def test_a_shark_catches_an_agent_which_does_not_return():
    env = lean()
    env.reset(seed=1)
    shark, prey = "blacktip_reef_shark_0", "fusilier_3"
    assert len(env.agents) == 98
    fishes = env.sea.world.state.fishes
    hunter, victim = env.fish_of(shark), env.fish_of(prey)
    ahead = np.array(x_axis(fishes.orientation[hunter]))
    fishes.position[victim] = mouth_of(fishes, hunter) + 0.04 * fishes.length[hunter] * ahead
    still = {agent: np.zeros(3) for agent in env.agents}
    total = dict.fromkeys(env.agents, 0.0)
    while prey in env.agents:
        _, rewards, dead, late, infos = env.step({agent: still[agent] for agent in env.agents})
        for agent, reward in rewards.items():
            total[agent] += reward
        assert set(dead) == set(rewards) == set(infos) == set(late)
    assert dead[prey]
    assert not late[prey]
    assert rewards[prey] == -1.0
    assert total[shark] == 1.0
    assert infos[shark]["meals"] == 1.0
    assert total["fusilier_0"] > 0.0
    with pytest.raises(ValueError, match="agent fusilier_3 is not alive"):
        env.step(still)
    while env.agents:
        env.step({agent: still[agent] for agent in env.agents})
    assert env.step({}) == ({}, {}, {}, {}, {})
    env.reset()
    assert prey in env.agents


def test_a_sea_without_hunters_and_prey_is_refused():
    pacific = ['fish.0.kind="pacifist"', 'fish.1.kind="pacifist"']
    with pytest.raises(UserError, match="no fish for an agent"):
        predator_prey.parallel_env(str(BARE), changes=pacific)
