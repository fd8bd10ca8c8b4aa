"""Many swimming bodies at once."""

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

import subsea.lab.environments  # noqa: F401  registers the environments
from subsea.base.errors import UserError
from subsea.kernels.lanes import LANES
from subsea.lab.environments.swim import SwimEnv, SwimVectorEnv
from subsea.lab.environments.swim_bodies import ACTIONS, swim
from subsea.lab.environments.swim_school import Exercise, SwimSchool, whole_lanes

STEPS = 12


def random_actions(number, steps=STEPS, seed=1):
    return np.random.default_rng(seed).uniform(-1, 1, (steps, number, ACTIONS)).astype(np.float32)


@pytest.mark.parametrize("task", ["economy", "place"])
def test_each_body_swims_as_in_a_single_environment(task):
    """Through the end of an episode, after which a body begins again in the next step."""
    number, limit = 3, 5
    many = SwimVectorEnv(number, max_episode_steps=limit, task=task)
    actions = random_actions(number)
    seen = [many.reset(seed=7)[0]]
    results = [many.step(action) for action in actions]
    for i in range(number):
        env = gymnasium.make("subsea/Swim-v0", max_episode_steps=limit, task=task)
        first = env.reset(seed=7 + i)[0]
        assert first.tobytes() == seen[0][i].tobytes()
        over = False
        for action, (observed, rewards, terminated, truncated, infos) in zip(
            actions, results, strict=True
        ):
            if over:
                one, reward, ended, cut = env.reset()[0], 0.0, False, False
            else:
                one, reward, ended, cut, info = env.step(action[i])
                assert info["work"] == infos["work"][i]
            assert one.tobytes() == observed[i].tobytes()
            assert (reward, ended, cut) == (rewards[i], terminated[i], truncated[i])
            over = ended or cut
    assert truncated is not None
    many.close()


def test_the_number_of_threads_changes_nothing():
    number = 100
    runs = []
    for threads in (1, 2, 3):
        env = SwimVectorEnv(number, threads=threads, task="place")
        env.reset(seed=3)
        steps = [env.step(action) for action in random_actions(number, 4)]
        runs.append([(seen.tobytes(), rewards.tobytes()) for seen, rewards, *_ in steps])
        env.close()
    assert runs[0] == runs[1] == runs[2]


@pytest.mark.parametrize(("number", "parts"), [(100, 3), (64, 2), (33, 2), (1024, 8)])
def test_parts_of_threads_fill_their_lanes(number, parts):
    cut = whole_lanes(np.arange(number), parts)
    assert len(cut) == parts
    np.testing.assert_array_equal(np.concatenate(cut), np.arange(number))
    sizes = [len(part) for part in cut]
    assert not any(size % LANES for size in sizes[:-1])
    assert max(sizes) - min(sizes) < 2 * LANES


def test_gymnasium_makes_it():
    env = gymnasium.make_vec(
        "subsea/Swim-v0", num_envs=4, vectorization_mode="vector_entry_point", task="heading"
    )
    assert isinstance(env, SwimVectorEnv)
    assert env.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    assert env.spec.max_episode_steps == 300
    seen, infos = env.reset(seed=1)
    assert seen in env.observation_space
    assert set(infos) == {
        f"{mark}{key}" for mark in ("", "_") for key in ("burst", "toward", "work")
    }
    env.action_space.seed(0)
    seen, rewards, terminated, truncated, infos = env.step(env.action_space.sample())
    assert seen in env.observation_space
    assert rewards.shape == terminated.shape == truncated.shape == (4,)
    env.close()


def test_a_body_that_bursts_begins_anew_and_leaves_the_others_alone():
    number = 3
    env, other = SwimVectorEnv(number), SwimVectorEnv(number)
    env.reset(seed=1)
    other.reset(seed=1)
    env._school.bodies.v[1, 3] = 200.0, 0.0, 0.0
    rests = np.zeros((number, ACTIONS), np.float32)
    seen, rewards, terminated, truncated, infos = env.step(rests)
    expected = other.step(rests)[0]
    assert terminated.tolist() == infos["burst"].tolist() == [False, True, False]
    assert not truncated.any()
    np.testing.assert_array_equal(seen[[0, 2]], expected[[0, 2]])
    seen, rewards, terminated, _, infos = env.step(rests)
    assert not terminated.any()
    assert rewards[1] == infos["toward"][1] == 0.0
    assert np.abs(env._school.bodies.x[1] - env._school.bodies.rest).max() == 0.0


def test_seeds_may_be_given_one_by_one():
    env = SwimVectorEnv(2, task="heading")
    seen = env.reset(seed=[9, 4])[0]
    single = SwimEnv(task="heading")
    for i, seed in enumerate((9, 4)):
        assert single.reset(seed=seed)[0].tobytes() == seen[i].tobytes()
    again = env.reset()[0]
    assert again.tobytes() != seen.tobytes()
    with pytest.raises(UserError, match="1 seeds for 2 bodies; expected one for each"):
        env.reset(seed=[1])


@pytest.mark.parametrize(
    ("shape", "value", "told"),
    [((16,), 0.0, r"shape \(16,\); expected \(2, 16\)"), ((2, 16), np.nan, "not finite")],
)
def test_bad_actions_are_a_value_error_of_one_line(shape, value, told):
    env = SwimVectorEnv(2)
    env.reset(seed=0)
    with pytest.raises(ValueError, match=told):
        env.step(np.full(shape, value, np.float32))


@pytest.mark.parametrize("given", [{"num_envs": 0}, {"threads": 0}])
def test_a_bad_number_is_a_user_error(given):
    with pytest.raises(UserError, match="expected 1 or more"):
        SwimVectorEnv(**given)


@pytest.mark.parametrize(
    ("species", "task", "ticks"),
    [
        ("fusilier", "speed", 1),
        ("emperor_angelfish", "place", 3),
        ("blacktip_reef_shark", "heading", 2),
    ],
)
def test_bodies_in_lanes_swim_as_each_does_alone(species, task, ticks):
    """In any order and number, beside bodies that burst."""
    number, random = 2 * LANES + 3, np.random.default_rng(3)
    lanes, alone = (SwimSchool(number, Exercise(species, task, None, ticks)) for _ in range(2))
    for school in (lanes, alone):
        school.begin(np.arange(number), [np.random.default_rng(i) for i in range(number)])
        school.bodies.v[4] *= 500.0
        school.bodies.v[9, 3] = np.nan
    for size in (number, LANES, LANES + 1, 3, 2, 1):
        who = random.permutation(number)[:size]
        actions = random.uniform(-1.2, 1.2, (number, ACTIONS)).astype(np.float32)
        swim(who, lanes.bodies, actions, ticks)
        for i in who:
            swim(np.array([i]), alone.bodies, actions, ticks)
    assert lanes.bodies.sound.sum() == number - 2
    for name, found, expected in zip(lanes.bodies._fields, lanes.bodies, alone.bodies, strict=True):
        np.testing.assert_array_equal(found, expected, name)
