import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.biomechanics.body import build_body
from subsea.biomechanics.controllers import LEFT, RIGHT, steering, swim_amplitude, turn_beats
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK
from subsea.biomechanics.trial import (
    CLOSURE_GOAL,
    MIN_WARM_UP,
    beat_contraction,
    beat_phase,
    displacement,
    loop_error,
    sharp_turn,
    speed_map,
    steady_beat,
)
from subsea.fish.species import load_species


@pytest.fixture(scope="module", params=["emperor_angelfish", "fusilier"])
def species(request):
    return load_species(request.param)


def test_a_right_turning_fish_is_half_a_beat_ahead(species):
    left = beat_phase(species.swim, 2, LEFT)
    np.testing.assert_allclose(beat_phase(species.swim, 2, RIGHT) - left, np.pi)
    assert left[0] == 0
    assert len(left) == 12


def test_warm_up_lasts_until_the_loop_closes(species):
    trial = steady_beat(build_body(species.body), beat_contraction(species.swim, 1.0))
    assert len(trial.frames) == species.swim.ticks_per_beat + 1
    assert trial.warm_up_beats >= MIN_WARM_UP
    assert loop_error(trial.frames) <= CLOSURE_GOAL * species.body.length
    np.testing.assert_array_equal(trial.frames[-1], trial.state.x)


def test_a_body_that_buckles_is_a_fault_of_the_plan(species):
    bent = beat_contraction(species.swim, 1.0, (0.6, 0.6))
    with pytest.raises(UserError, match="lost its shape"):
        steady_beat(build_body(species.body), bent)


def test_a_sharp_turn_starts_where_swimming_ends_and_leaves_it_alone(species):
    body = build_body(species.body)
    swimming = steady_beat(body, beat_contraction(species.swim, species.swim.medium)).state
    before = swimming.x.copy()
    trial = sharp_turn(body, species.swim, species.turn, 45.0, LEFT, swimming)
    np.testing.assert_array_equal(swimming.x, before)
    np.testing.assert_array_equal(trial.frames[0], before)
    beats = turn_beats(species.swim, steering(species.turn, 45.0))
    assert len(trial.frames) == beats * species.swim.at("medium").ticks_per_beat + 1


@pytest.mark.nightly
def test_swimming_speed_follows_the_desired_speed(species):
    """swim-MC: any speed within reach, between the amplitudes that were measured too."""
    body, swim = build_body(species.body), species.swim
    speeds = speed_map(body, swim)
    assert (np.diff(speeds.speed) > 0).all()
    asked = np.linspace(0.15, 1.0, 7) * speeds.speed[-1]
    beat_tu = swim.ticks_per_beat * STEPS_PER_TICK * STEP
    swum = [
        np.linalg.norm(displacement(steady_beat(body, beat_contraction(swim, amplitude)).frames))
        / beat_tu
        for amplitude in map(float, swim_amplitude(speeds, asked))
    ]
    assert (np.diff(swum) > 0).all()
    np.testing.assert_allclose(swum, asked, atol=0.03 * speeds.speed[-1])
    assert swim_amplitude(speeds, 2 * speeds.speed[-1]) == 1
