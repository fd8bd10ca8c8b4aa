import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from capture.inspection.gait import muscle_work, tension_work
from subsea.base.system import resource_path
from subsea.base.toml_files import load_toml
from subsea.biomechanics.body import NODES, UNITS, build_body
from subsea.biomechanics.controllers import muscle_lengths
from subsea.biomechanics.fins import contraction_step, straightness, sweep
from subsea.biomechanics.simulation import NO_FORCE, STILL, copy_state
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK, advance
from subsea.biomechanics.trial import beat_contraction, steady_beat
from subsea.biomechanics.water import add_water_force
from subsea.fish.species import Species

STEPS = 400


@given(
    stiffness=st.floats(1.0, 200.0),
    stroke=st.floats(0.01, 1.0),
    contraction=st.floats(0.0, 1.0),
    lag=st.floats(-np.pi, np.pi),
)
def test_the_work_of_a_muscle_is_the_area_of_its_work_loop(stiffness, stroke, contraction, lag):
    """Length a cos φ, rest b cos(φ + lag): tension over length has the area π c a b sin lag."""
    ends = 2 * np.pi * np.arange(STEPS + 1) / STEPS
    lengths = 4.0 + stroke * np.cos(ends)[:, None]
    rests = 4.0 + contraction * np.cos((ends[:-1] + ends[1:]) / 2 + lag)[:, None]
    work = tension_work(np.array([stiffness]), lengths, rests)
    area = np.pi * stiffness * stroke * contraction * np.sin(lag)
    np.testing.assert_allclose(work, area, atol=1e-3 * stiffness * stroke)


def test_a_muscle_that_shortens_against_a_load_does_work():
    lengths, rests = np.array([[4.0], [3.0]]), np.array([[2.0]])
    assert tension_work(np.array([10.0]), lengths, rests) == pytest.approx(15.0)


def lost(body, state, contraction):
    """Losses to water and viscosity in g cm²/tu², step by step."""
    total = 0.0
    i, j = UNITS.T
    for rest in muscle_lengths(body, contraction):
        x, v, _ = copy_state(state)
        advance(state.x, state.v, body.material, rest[None], STILL, NO_FORCE, STEP, state.watch)
        force = np.zeros((NODES, 3))
        add_water_force(x, v, STILL, body.drag, force)
        middle = (v + state.v) / 2
        along = (x[j] - x[i]) / np.linalg.norm(x[j] - x[i], axis=1)[:, None]
        rate = ((middle[j] - middle[i]) * along).sum(axis=1)
        total += STEP * ((body.viscosity * rate * rate).sum() - (force * middle).sum())
    return total


def test_water_and_viscosity_dissipate_the_work_of_muscles(name):
    species = load_toml(resource_path(f"docs/tu_{name}.toml"), Species)
    body = build_body(species.body)
    beat = beat_contraction(species.swim, 1.0)
    steady = steady_beat(body, beat).state
    work = muscle_work(body, copy_state(steady), beat)
    # The rest of it is what the semi-implicit step damps.
    used = lost(body, copy_state(steady), beat)
    assert used < work < 1.08 * used


def test_the_contraction_step_is_the_steepest_of_the_beat(species):
    """A sine of contraction c over N steps is steepest at c l π / N."""
    body, swim = build_body(species.body), species.swim
    steps = swim.ticks_per_beat * STEPS_PER_TICK
    longest = max(swim.contraction[0] * body.length[4], swim.contraction[1] * body.length[8])
    step = contraction_step(body, beat_contraction(swim, 1.0))
    assert step == pytest.approx(longest * np.pi / steps, 1e-3)


def test_straightness_and_sweep_of_a_known_path():
    """A fish on a circle turns by the same angle each beat and strays by the circle's sagitta."""
    angle, radius = 0.01, 100.0
    turns = angle * np.arange(11)
    centre = radius * np.stack([np.sin(turns), 0 * turns, 1 - np.cos(turns)], axis=1)
    frames = np.repeat(centre[:, None], NODES, axis=1)
    drift, aside = straightness(frames, 1)
    assert drift == pytest.approx(np.degrees(9 * angle))
    assert aside == pytest.approx(radius * (1 - np.cos(5 * angle)), rel=1e-6)
    waved = np.zeros((13, NODES, 3))
    waved[:, :, 0] = np.arange(13)[:, None]
    waved[:, 0, 2] = 3.0 * np.sin(2 * np.pi * np.arange(13) / 12)
    assert sweep(waved, [0]) == pytest.approx(6.0)
