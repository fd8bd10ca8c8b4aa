"""One swimming body as an environment."""

import ctypes
import gc
import weakref

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import subsea.lab.environments  # noqa: F401  registers the environments
from subsea.base.errors import UserError
from subsea.base.system import resource_path
from subsea.biomechanics.body import MUSCLES, NODES, body_frame, build_body, to_body
from subsea.biomechanics.controllers import swim_contraction
from subsea.biomechanics.fins import EDGE_ON, pectoral_force
from subsea.biomechanics.simulation import BodyState, at_rest, simulate
from subsea.fish.species import load_species
from subsea.lab.environments.swim import SwimEnv
from subsea.lab.environments.swim_bodies import (
    ACTIONS,
    ANGLES,
    FIN_SWEEP,
    SWEEPS,
    add_fins,
    make_bodies,
    swim,
)
from subsea.lab.environments.swim_school import TASKS
from subsea.repertoire.files import read_repertoire

RELAXED = np.array([-1.0] * MUSCLES + [0.0] * (ACTIONS - MUSCLES), np.float32)
WHO = np.zeros(1, np.int64)


@pytest.fixture
def fusilier():
    return load_species("fusilier")


def gait(bodies, muscles, ticks):
    """Actions (ticks, 16) that contract as the species' fast swim does at the end of each tick."""
    phase = 2 * np.pi * np.arange(1, ticks + 1) / muscles.swim.ticks_per_beat
    actions = np.tile(RELAXED, (ticks, 1))
    actions[:, :MUSCLES] = 2 * swim_contraction(muscles.swim, phase) / bodies.strength - 1
    return actions


@pytest.mark.parametrize("task", TASKS)
@pytest.mark.filterwarnings("error")
def test_gymnasium_finds_no_fault(task):
    check_env(gymnasium.make("subsea/Swim-v0", task=task).unwrapped, skip_render_check=True)


@pytest.mark.nightly
@pytest.mark.filterwarnings("error")
def test_gymnasium_finds_no_fault_in_pictures(display):
    env = gymnasium.make("subsea/Swim-v0", render_mode="rgb_array")
    check_env(env.unwrapped)
    env.close()


def test_the_same_seed_is_the_same_episode():
    episodes = []
    for _ in range(2):
        env = SwimEnv(task="place")
        env.action_space.seed(3)
        seen = [env.reset(seed=5)[0]]
        rewards = []
        for _ in range(20):
            observation, reward, *_ = env.step(env.action_space.sample())
            seen.append(observation)
            rewards.append(reward)
        episodes.append((np.array(seen).tobytes(), rewards))
    assert episodes[0] == episodes[1]
    other = SwimEnv(task="place").reset(seed=6)[0]
    assert other.tobytes() != episodes[0][0][: other.nbytes]


def test_an_observation_has_pose_velocity_attitude_commands_and_goal(fusilier):
    env = SwimEnv(task="heading")
    env.reset(seed=1)
    for _ in range(10):
        seen, *_ = env.step(env.action_space.sample())
    bodies = env._school.bodies
    length = fusilier.body.length
    origin, axes = body_frame(bodies.x[0])
    pose = to_body(bodies.x[0], origin, axes) - bodies.rest
    parts = [
        pose.ravel() / (0.1 * length),
        10 * (bodies.v[0] @ axes).ravel() / length,
        axes[1],
        2 * bodies.command[0, :MUSCLES] / bodies.strength - 1,
        bodies.command[0, ANGLES] / (np.pi / 2),
        bodies.command[0, SWEEPS] / (FIN_SWEEP * length),
        bodies.goal[0] @ axes,
    ]
    np.testing.assert_allclose(seen, np.concatenate(parts), atol=1e-5)
    assert np.linalg.norm(bodies.goal[0]) == pytest.approx(1.0)


def bending(x, v):
    """Greatest speed of a node beside the motion of the body as a whole; gliding bodies yaw."""
    arm, through = x - x.mean(axis=0), v - v.mean(axis=0)
    inertia = np.sum(arm**2) * np.eye(3) - arm.T @ arm
    spin = np.linalg.solve(inertia, np.cross(arm, through).sum(axis=0))
    return np.abs(through - np.cross(spin, arm)).max()


def test_a_relaxed_body_straightens_and_slows_down():
    env = SwimEnv()
    env.reset(seed=2)
    bodies = env._school.bodies
    bodies.v[0] += (2.0, 0.0, 0.0)
    speeds = []
    for _ in range(200):
        seen, *_, info = env.step(RELAXED)
        speeds.append(np.abs(bodies.v).max())
    # Drag is that of the square of the speed, which falls as 1/t.
    assert speeds[-1] < 0.75 * speeds[100] < 0.6 * speeds[0]
    assert bending(bodies.x[0], bodies.v[0]) < 0.03 * speeds[-1]
    assert np.abs(seen[: 3 * NODES]).max() < 0.05
    assert not info["burst"]


@pytest.mark.parametrize("species", ["fusilier", "clownfish"])
def test_the_recorded_gait_reaches_the_recorded_speed(species):
    kind = load_species(species)
    recorded = read_repertoire(resource_path(f"repertoires/{species}.h5")).segments["swim_fast"]
    bodies = make_bodies(kind.muscles, 1)
    beat = kind.muscles.swim.ticks_per_beat
    moved = 0.0
    for tick, action in enumerate(gait(bodies, kind.muscles, 26 * beat)):
        swim(WHO, bodies, action[None], 1)
        assert bodies.sound[0]
        if tick >= 20 * beat:
            moved += bodies.moved[0]
    speed = np.linalg.norm(moved) / (6 * beat * 0.033)
    assert speed == pytest.approx(recorded.speed_cm_s, rel=0.06)


def test_a_step_is_six_steps_of_the_simulator(fusilier):
    """With fins edge-on, and contractions that rise evenly."""
    bodies = make_bodies(fusilier.muscles, 1)
    action = RELAXED.copy()
    action[4:6] = -0.9
    swim(WHO, bodies, action[None], 1)
    share = np.zeros((6, MUSCLES))
    share[:, 4:6] = np.outer(np.arange(1, 7) / 6, 0.05 * bodies.strength[4:6])
    body = build_body(fusilier.body)
    state = at_rest(body)
    simulate(body, state, share)
    np.testing.assert_allclose(bodies.x[0], state.x, atol=1e-6)
    np.testing.assert_allclose(bodies.command[0, :MUSCLES], share[-1], rtol=1e-6)


def test_no_muscle_is_faster_than_its_limit(fusilier):
    bodies = make_bodies(fusilier.muscles, 1)
    swim(WHO, bodies, np.ones((1, ACTIONS), np.float32), 1)
    np.testing.assert_allclose(bodies.command[0, :MUSCLES], 6 * bodies.quickness)
    # That of Tu §4.6.1: 0.075 cm a step.
    assert (bodies.length[4:12] * bodies.quickness[4:]).max() <= 0.075 + 1e-12


def test_fins_push_as_in_equation_4_16(fusilier):
    bodies = make_bodies(fusilier.muscles, 1)
    x, v = bodies.x[0], np.tile([1.5, 0.2, 0.1], (NODES, 1))
    for rowing in (0.0, 0.7):
        command = np.zeros(ACTIONS)
        command[ANGLES] = 0.4, -0.9
        force = np.zeros((NODES, 3))
        add_fins(bodies, x, v, command, np.full(2, rowing), force)
        state = BodyState(x, v, np.zeros(3))
        angles = EDGE_ON + command[ANGLES]
        expected = pectoral_force(state, bodies.fin_area, *angles, np.zeros(3), rowing)
        np.testing.assert_allclose(force, expected, atol=1e-12)


def test_both_fins_swept_back_broadside_push_ahead_and_cost_work(fusilier):
    bodies = make_bodies(fusilier.muscles, 1)
    action = RELAXED.copy()
    action[ANGLES], action[SWEEPS] = 1.0, -1.0
    swim(WHO, bodies, action[None], 2)
    assert bodies.moved[0, 0] > 0.01
    assert abs(bodies.moved[0, 2]) < 1e-6
    assert bodies.work[0] > 0
    assert (np.abs(bodies.command[0, SWEEPS]) <= FIN_SWEEP * fusilier.body.length).all()


def test_the_return_of_economy_is_distance_per_work(fusilier):
    env = SwimEnv(task="economy")
    env.reset(seed=1)
    total = 0.0
    for action in gait(env._school.bodies, fusilier.muscles, 60):
        *_, reward, _, _, info = env.step(action)
        total += reward
    assert info["toward"] > 0.4
    assert total == pytest.approx(info["toward"] / (info["work"] + 0.1 * 60 * 0.033))


def test_a_place_is_approached_and_then_replaced():
    env = SwimEnv(task="place")
    env.reset(seed=1)
    bodies = env._school.bodies
    near = 0.5 * (bodies.x[0, 5] + bodies.x[0, 7]) + (0.3 * bodies.body_length, 0.0, 0.0)
    bodies.goal[0] = near
    seen, *_ = env.step(RELAXED)
    assert np.linalg.norm(bodies.goal[0] - near) > bodies.body_length
    assert 0.3 < np.linalg.norm(seen[-3:]) < 1.2
    rewards = [env.step(RELAXED)[1] for _ in range(3)]
    assert np.isfinite(rewards).all()


def test_a_body_that_bursts_ends_the_episode():
    env = SwimEnv()
    env.reset(seed=0)
    env._school.bodies.v[0, 3] = 200.0, 0.0, 0.0
    seen, reward, terminated, truncated, info = env.step(RELAXED)
    assert terminated
    assert info["burst"]
    assert not truncated
    assert reward == 0.0
    assert env.observation_space.contains(seen)
    assert not env.reset()[1]["burst"]


def test_a_reward_may_be_any_function():
    env = SwimEnv(reward=lambda step: step.bodies.v[:, 0, 0] * 0 + 7.0)
    env.reset(seed=0)
    assert env.step(RELAXED)[1] == 7.0


def test_a_step_may_last_several_ticks():
    env, slow = SwimEnv(), SwimEnv(frame_skip=5)
    env.reset(seed=4)
    slow.reset(seed=4)
    for _ in range(5):
        once = env.step(RELAXED)
    at_once = slow.step(RELAXED)
    np.testing.assert_array_equal(once[0], at_once[0])
    assert at_once[4]["toward"] == pytest.approx(once[4]["toward"])


@pytest.mark.parametrize(
    ("action", "told"),
    [
        (np.zeros(3, np.float32), "shape (3,); expected (16,)"),
        (np.full(ACTIONS, np.nan, np.float32), "not finite"),
        ([0.0] * 15 + [np.inf], "not finite"),
        ("left", "not an array of numbers"),
        (None, "has shape (1,)"),
    ],
)
def test_a_bad_action_is_a_value_error_of_one_line(action, told):
    env = SwimEnv()
    env.reset(seed=0)
    with pytest.raises(ValueError, match="the action") as fault:
        env.step(action)
    assert told in str(fault.value)
    assert "\n" not in str(fault.value)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"species": "ribbon_eel"}, "has no muscles; expected one of"),
        ({"species": "fusilierr"}, "fusilier"),
        ({"task": "sleep"}, "unknown task 'sleep'; expected one of speed"),
        ({"frame_skip": 0}, "frame_skip = 0; expected 1 or more"),
        ({"render_mode": "ansi"}, "unknown render_mode 'ansi'"),
    ],
)
def test_a_bad_parameter_is_a_user_error(given, told):
    with pytest.raises(UserError) as fault:
        SwimEnv(**given)
    assert told in str(fault.value)


def test_an_environment_that_is_dropped_is_freed_at_once():
    env = SwimEnv(species="clownfish", render_mode="rgb_array")
    gone = weakref.ref(env)
    gc.disable()  # it would free a context while another one draws
    try:
        del env
        assert gone() is None
    finally:
        gc.enable()


def test_a_picture_shows_the_body():
    env = SwimEnv(species="clownfish", render_mode="rgb_array")
    env.reset(seed=0)
    picture = env.render()
    assert picture.shape == (360, 640, 3)
    assert picture.dtype == np.uint8
    fish = (np.abs(picture.astype(int) - picture[0, 0]) > 20).any(axis=2)
    assert 0.02 < fish.mean() < 0.5
    current = ctypes.CDLL("libEGL.so.1").eglGetCurrentContext
    current.restype = ctypes.c_void_p
    assert not current()  # else Xlib would end the process when it opens a window
    env.close()
    assert not current()
