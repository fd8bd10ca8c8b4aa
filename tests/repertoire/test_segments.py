from itertools import pairwise

import numpy as np
import pytest

from capture.inspection.simulated import replay
from capture.recording.record import motion_of
from subsea.biomechanics.body import body_frame
from subsea.fish.skinning import Coupling
from subsea.fish.species import load_species
from subsea.geometry.rotation import about, matrix
from subsea.repertoire.segments import heading_change, make_segment, run_trial

TURNED = matrix(np.array([0.5, -0.5, 0.1, 0.7]) / np.linalg.norm([0.5, -0.5, 0.1, 0.7]))
MOVED = np.array([10.0, -20.0, 30.0])


@pytest.fixture(scope="module", params=["emperor_angelfish", "fusilier"])
def species(request, known_turns):
    return load_species(request.param)


def test_replay_retraces_the_trial_at_any_attitude(species):
    for action in ("swim_fast", "turn_left_gradual", "turn_right_sharp"):
        frames = run_trial(motion_of(species), action).frames
        segment = make_segment(frames, species.body.length, "forward", "fast", True)
        elsewhere = frames @ TURNED.T + MOVED
        played = replay(segment, *body_frame(elsewhere[0]), 1)
        np.testing.assert_allclose(played, elsewhere[1:], atol=1e-9, err_msg=action)


def test_the_printed_world_axes_increment_would_fail_at_another_attitude(species):
    """SMC eq. 6 puts M = Rᵏ⁺¹(Rᵏ)ᵀ on the left: right at the recorded attitude alone."""
    frames = run_trial(motion_of(species), "turn_left_sharp").frames
    recorded = body_frame(frames)[1]
    elsewhere = body_frame(frames @ TURNED.T)[1]
    rotation = elsewhere[0]
    for before, after in pairwise(recorded):
        rotation = after @ before.T @ rotation
    assert np.abs(rotation - elsewhere[-1]).max() > 0.1


def test_control_points_follow_every_frame(species):
    frames = run_trial(motion_of(species), "swim_slow").frames
    weights = np.zeros((2, 23))
    weights[0, 3], weights[1, [21, 22]] = 1.0, 0.5
    coupling = Coupling(weights, np.zeros(2, np.int32), np.zeros((2, 3)))
    segment = make_segment(frames, species.body.length, "forward", "slow", True, coupling)
    assert segment.control_points is not None
    np.testing.assert_allclose(segment.control_points[:, 0], segment.nodes[:, 3])
    np.testing.assert_allclose(segment.control_points[:, 1], segment.nodes[:, 21:].mean(axis=1))


def test_headings_count_left_as_positive():
    start = matrix(about(1.0, 0.0, 0.0, 0.3))
    for degrees in (-120.0, -30.0, 0.0, 45.0, 90.0):
        after = matrix(about(*start[:, 1].tolist(), np.radians(degrees))) @ start
        assert heading_change(start, after) == pytest.approx(degrees)
