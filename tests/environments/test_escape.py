"""`subsea/Escape-v0`: a prey fish before the nose of a shark."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import subsea.environments  # noqa: F401 registers
from subsea.core.errors import UserError
from subsea.environments.escape import START_CM, EscapeEnv
from subsea.environments.fish_senses import NAMES
from subsea.state import PREY
from tests.support.scenes import BARE

LEAN = ["water.plankton=0", "seaweed=[]", "reef=[]"]
STILL = np.zeros(3, np.float32)


@pytest.fixture(scope="module")
def env():
    return EscapeEnv(changes=LEAN, max_steps=150)


def test_it_keeps_the_convention(env):
    made = gymnasium.make("subsea/Escape-v0", changes=LEAN)
    check_env(made.unwrapped)


def test_it_begins_near_the_predator_and_sees_it(env):
    for seed in range(3):
        seen, info = env.reset(seed=seed)
        fishes = env.sea.world.state.fishes
        assert env.sea.world.state.minds.kind[info["fish"]] == PREY
        shark = int(env._predators[0])
        gap = np.linalg.norm(fishes.position[shark] - fishes.position[info["fish"]])
        assert START_CM[0] - 60.0 < gap < START_CM[1] + 60.0
        assert seen[NAMES.index("predator 0 nearness")] > 0.0
        again, same = env.reset(seed=seed)
        np.testing.assert_array_equal(seen, again)
        assert info == same


def test_a_fish_that_holds_still_is_caught_and_stays_dead(env):
    ends = []
    for seed in range(3):
        env.reset(seed=seed)
        rewards, dead, late = [], False, False
        while not dead and not late:
            seen, reward, dead, late, _ = env.step(STILL)
            rewards.append(reward)
        ends.append(dead)
        assert rewards[0] == pytest.approx(0.1 * 3 * 0.033)
        if dead:
            assert rewards[-1] == -1.0
            assert not late
            assert not seen.any()
            with pytest.raises(ValueError, match="dead"):
                env.step(STILL)
    assert any(ends)


def test_a_sea_without_prey_or_predators_is_refused():
    with pytest.raises(UserError, match="it has no prey fishes"):
        EscapeEnv(str(BARE), changes=['fish.0.kind="pacifist"', 'fish.1.kind="pacifist"'])
    with pytest.raises(UserError, match="it has no predator"):
        EscapeEnv(str(BARE), changes=['fish.0.kind="prey"'])
    with pytest.raises(UserError, match="expected one of the prey fishes"):
        EscapeEnv(changes=LEAN, fish="blacktip_reef_shark")
