"""`subsea/Forage-v0`: conventions, episodes that repeat, and meals."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import subsea.lab.environments  # noqa: F401 registers
from subsea.base.errors import UserError
from subsea.behavior.chasing import mouth_of
from subsea.geometry.rotation import x_axis
from subsea.lab.environments.living_sea import NAMES, barrier_place
from subsea.lab.environments.steered_fish import ForageEnv
from subsea.state import SEABED, SURFACE, WALL
from subsea.world.snapshot import checksum
from tests.support.scenes import BARE

SMALL = {"scenario": str(BARE), "changes": ["water.plankton=300"]}
STILL, AHEAD = np.zeros(3, np.float32), np.array([0.0, 0.0, 0.3], np.float32)


@pytest.fixture(scope="module")
def env():
    env = ForageEnv(**SMALL)
    yield env
    env.close()


def test_it_keeps_the_convention(display):
    env = gymnasium.make("subsea/Forage-v0", max_steps=3, **SMALL)
    check_env(env.unwrapped)  # a warning would be an error here
    env.reset(seed=1)
    ends = [env.step(env.action_space.sample())[2:4] for _ in range(3)]
    assert ends == [(False, False), (False, False), (False, True)]


def test_equal_seeds_are_equal_episodes_and_others_are_not(env):
    def lived(seed):
        seen = [env.reset(seed=seed)[0]]
        seen += [env.step([np.sin(k), 0.2, 0.8])[0] for k in range(5)]
        return np.array(seen), checksum(env.sea.world)

    (first, whole), (again, same), (other, _) = lived(5), lived(5), lived(6)
    np.testing.assert_array_equal(first, again)
    assert whole == same
    assert not np.array_equal(first, other)
    seeds_fish = {env.reset(seed=seed)[1]["fish"] for seed in range(8)}
    assert len(seeds_fish) > 1


def test_a_meal_is_a_reward(env):
    _, info = env.reset(seed=2)
    fish, fishes, sea = info["fish"], env.sea.world.state.fishes, env.sea.world.state.sea
    hungry = env.step(STILL)[1]
    assert -0.02 < hungry <= 0.0
    ahead = np.array(x_axis(fishes.orientation[fish]))
    sea.absent[:], sea.absent[0] = 1e3, 0.0
    sea.plankton[0] = mouth_of(fishes, fish) + 0.2 * fishes.length[fish] * ahead
    told = [env.step(AHEAD) for _ in range(6)]
    assert sum(reward for _, reward, *_ in told) == pytest.approx(1.0, abs=0.05)
    assert [info["meals"] for *_, info in told].count(1.0) == 1


def test_the_senses_name_what_is_seen_in_body_axes(env):
    _, info = env.reset(seed=3)
    world, fish = env.sea.world, info["fish"]
    fishes, minds, sea = world.state.fishes, world.state.minds, world.state.sea
    sense = dict(zip(NAMES, env.step(STILL)[0], strict=True))
    assert sense["hunger"] == minds.mental[fish, 0]
    assert sense["depth"] == pytest.approx(-fishes.position[fish, 2] / 500.0, abs=1e-6)
    gap = sea.plankton[minds.food[fish]] - np.array(mouth_of(fishes, fish))
    length = fishes.length[fish]
    near = length / (length + np.linalg.norm(gap))
    assert sense["food 0 nearness"] == pytest.approx(near, rel=1e-4)
    cosine = gap @ np.array(x_axis(fishes.orientation[fish])) / np.linalg.norm(gap)
    assert sense["food 0 ahead"] == pytest.approx(cosine, abs=1e-4)
    assert sense["food 0 right"] ** 2 + sense["food 0 up"] ** 2 == pytest.approx(
        1.0 - cosine**2, abs=1e-3
    )
    assert sense["predator 0 nearness"] == 0.0
    assert len(NAMES) == len(set(NAMES)) == env.observation_space.shape[0]


def test_the_place_of_a_barrier(env):
    sea, spot = env.sea.world.state.sea, np.array([100.0, 300.0, -100.0])
    np.testing.assert_allclose(barrier_place(sea, SURFACE, spot), [100.0, 300.0, 0.0])
    assert np.hypot(*barrier_place(sea, WALL, spot)[:2]) == pytest.approx(sea.radius)
    assert barrier_place(sea, SEABED, spot)[2] < -400.0
    rock = barrier_place(sea, 0, spot)
    assert 100.0 < np.linalg.norm(rock - spot) < 250.0
    np.testing.assert_array_equal(barrier_place(sea, -1, spot), spot)


def test_faulty_actions_and_options_are_one_line(env):
    env.reset(seed=1)
    for action in (np.zeros(2), [0.0, np.nan, 0.0], "left", None):
        with pytest.raises(ValueError, match="expected 3 finite numbers") as fault:
            env.step(action)
        assert "\n" not in str(fault.value)
    with pytest.raises(ValueError, match="call reset"):
        ForageEnv(**SMALL).step(STILL)
    for faulty, line in (
        ({"observation": "smell"}, "unknown observation 'smell'"),
        ({"render_mode": "humane"}, "unknown render_mode 'humane'; did you mean 'human'"),
        ({"tick": 3}, "unknown option 'tick'; did you mean 'ticks'"),
        ({"ticks": 0}, "whole numbers from 1"),
        ({"fish": "blue_tang"}, "unknown fish 'blue_tang'"),
    ):
        with pytest.raises(UserError, match=line):
            ForageEnv(**SMALL | faulty)


def test_the_retina_and_a_picture_from_behind():
    env = ForageEnv(
        **SMALL, observation="retina", retina_size=(16, 12), render_mode="rgb_array",
        picture_size=(80, 60),
    )  # fmt: skip
    seen, _ = env.reset(seed=4)
    assert env.observation_space.contains(seen)
    assert seen.shape == (12, 32, 3)
    assert seen.std() > 2.0
    np.testing.assert_array_equal(seen, env.reset(seed=4)[0])
    picture = env.render()
    assert (picture.shape, picture.dtype) == ((60, 80, 3), np.uint8)
    assert picture.std() > 2.0
    env.close()
    env.close()  # twice does no harm


def test_another_reward_replaces_the_usual_one():
    env = ForageEnv(**SMALL, reward=lambda outcome: outcome.seconds * np.ones(1), ticks=2)
    env.reset(seed=1)
    assert env.step(STILL)[1] == pytest.approx(2 * 0.033)
    assert env.render() is None
