"""`subsea/Escape-v0`: a prey fish before the nose of a shark."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import subsea.lab.environments  # noqa: F401 registers
from subsea.base.errors import UserError
from subsea.behavior.chasing import mouth_of
from subsea.geometry.rotation import x_axis
from subsea.lab.environments.living_sea import NAMES
from subsea.lab.environments.steered_fish import START_CM, EscapeEnv
from subsea.perception.vision import FIELD_COS
from subsea.state import PREY
from tests.support.scenes import BARE

LEAN = ["water.plankton=0", "seaweed=[]", "reef=[]"]
STILL = np.zeros(3, np.float32)


@pytest.fixture(scope="module")
def env():
    return EscapeEnv(changes=LEAN, max_steps=150)


def test_it_keeps_the_convention(env, display):
    hunted = ['fish.0.kind="prey"', 'fish.1.kind="predator"']  # of a sea that is quickly made
    made = gymnasium.make("subsea/Escape-v0", scenario=str(BARE), changes=hunted)
    check_env(made.unwrapped)


def test_it_begins_near_the_predator_and_sees_it_unless_it_is_behind(env):
    found = []
    for seed in range(6):
        seen, info = env.reset(seed=seed)
        fishes = env.sea.world.state.fishes
        assert env.sea.world.state.minds.kind[info["fish"]] == PREY
        shark = int(env._predators[0])
        way = fishes.position[shark] - fishes.position[info["fish"]]
        gap = np.linalg.norm(way)
        assert START_CM[0] - 60.0 < gap < START_CM[1] + 60.0
        found.append(seen[NAMES.index("predator 0 nearness")] > 0.0)
        # Perception comes before motion.
        way = fishes.previous_position[shark] - fishes.previous_position[info["fish"]]
        ahead = x_axis(fishes.previous_orientation[info["fish"]])
        assert found[-1] == (way @ ahead > FIELD_COS * np.linalg.norm(way))
        again, same = env.reset(seed=seed)
        np.testing.assert_array_equal(seen, again)
        assert info == same
    assert sum(found) > 3


@pytest.mark.nightly
def test_a_fish_that_never_moves_is_caught_and_stays_dead():
    """The shark may pass it at its first strikes, with its mouth still shut."""
    env = EscapeEnv(changes=LEAN, max_steps=1500)
    _, info = env.reset(seed=1)
    fishes, shark = env.sea.world.state.fishes, int(env._predators[0])
    # Nobody else whom it would have to avoid, or who would confuse it.
    fishes.alive[:] = np.isin(np.arange(len(fishes.alive)), (shark, info["fish"]))
    for _ in range(10):
        env.step(STILL)
    ahead = np.array(x_axis(fishes.orientation[shark]))
    fishes.position[info["fish"]] = mouth_of(fishes, shark) + 0.3 * fishes.length[shark] * ahead
    rewards, dead, late = [], False, False
    while not dead and not late:
        seen, reward, dead, late, _ = env.step(STILL)
        rewards.append(reward)
    assert dead
    assert not late
    assert rewards[:-1] == pytest.approx([0.1 * 3 * 0.033] * (len(rewards) - 1))
    assert rewards[-1] == -1.0
    assert not seen.any()
    with pytest.raises(ValueError, match="dead"):
        env.step(STILL)


def test_a_sea_without_prey_or_predators_is_refused():
    with pytest.raises(UserError, match="it has no prey fishes"):
        EscapeEnv(str(BARE), changes=['fish.0.kind="pacifist"', 'fish.1.kind="pacifist"'])
    with pytest.raises(UserError, match="it has no predator"):
        EscapeEnv(str(BARE), changes=['fish.0.kind="prey"'])
    with pytest.raises(UserError, match="expected one of the prey fishes"):
        EscapeEnv(changes=LEAN, fish="blacktip_reef_shark")
