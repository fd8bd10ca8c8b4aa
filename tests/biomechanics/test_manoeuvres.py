"""Escapes, tight turns, starts and stops: angles, durations, symmetry and where they end."""

import numpy as np
import pytest

from capture.inspection.simulated import replay
from subsea.biomechanics.body import build_body
from subsea.biomechanics.fins import headings
from subsea.biomechanics.manoeuvres import BENT_DEG, body_bend, mirrored
from subsea.biomechanics.simulation import at_rest, copy_state, simulate
from subsea.biomechanics.trial import Trial
from subsea.fish.species import load_species, repertoire_file
from subsea.repertoire import read_repertoire
from subsea.repertoire.segments import run_trial

LATENCY_TICKS = 2  # in which the head has begun to turn
BENT_TICKS = 27  # in which it has turned most: 0.15 s at pace 2 and three times that tempo


@pytest.fixture(scope="module", params=["emperor_angelfish", "fusilier"])
def name(request):
    return request.param


@pytest.fixture
def species(name):
    return load_species(name)


@pytest.fixture(scope="module")
def repertoire(name):
    """The repertoire that is shipped: tests/repertoire shows that it would be recorded again."""
    return read_repertoire(repertoire_file(name))


def played(repertoire, name):
    """World nodes (t, 23, 3) of a segment."""
    return replay(repertoire.segments[name], np.zeros(3), np.eye(3), 1)


@pytest.mark.parametrize(
    ("segment", "least", "most"),
    [
        ("cstart_left_moderate", 45, 90),
        ("cstart_left_wide", 50, 140),
        ("turn_left_rest", 45, 110),
        ("turn_left_sharp", 60, 105),
        ("turn_left_glide", 60, 110),
    ],
)
def test_turns_have_their_angle_and_bend_into_it(repertoire, segment, least, most):
    """Domenici and Blake 1997 for escapes; the last frames sway about the course."""
    path = played(repertoire, segment)
    heading, bend = headings(path), body_bend(path)
    assert least < heading[-20:].mean() < most
    turning = bend[: int(np.argmax(heading > 0.9 * heading[-20:].mean()))]
    assert (turning > BENT_DEG).sum() > 2 and not (turning < -BENT_DEG).any()


@pytest.mark.parametrize("angle", [-70.0, -20.0, 0.0, 35.0, 100.0])
def test_the_bend_is_the_angle_of_the_head_to_the_left(angle):
    body = build_body(load_species("fusilier").body).rest.copy()
    middle = body[9:13].mean(axis=0)
    turn = np.radians(angle)
    ahead = np.array([np.cos(turn), 0.0, -np.sin(turn)])  # z is right
    body[0] = middle + 8.0 * ahead
    assert body_bend(body[None]) == pytest.approx(angle)


def test_an_escape_turns_at_once_and_ends_fast(repertoire):
    for grade in ("moderate", "wide"):
        path = played(repertoire, f"cstart_left_{grade}")
        heading = headings(path)
        assert heading[2 * LATENCY_TICKS] > 5
        late = heading[BENT_TICKS:].mean()
        assert heading[:BENT_TICKS].max() > 0.7 * late
        end = np.linalg.norm(path[-1].mean(axis=0) - path[-8].mean(axis=0)) / 7
        begin = np.linalg.norm(path[3].mean(axis=0) - path[0].mean(axis=0)) / 3
        assert end > 2 * begin


def test_a_turn_from_rest_is_tight(repertoire):
    """The path of the centre while it turns, over the angle, in body lengths per radian."""
    path = played(repertoire, "turn_left_rest")
    heading = headings(path)
    turned = int(np.argmax(heading > 0.9 * heading[-1]))
    centre = path[: turned + 1].mean(axis=1)
    way = np.linalg.norm(np.diff(centre, axis=0), axis=1).sum() / repertoire.body_length_cm
    assert way / np.radians(heading[turned] - heading[0]) < 0.4


def test_the_mirror_image_of_a_motion_is_a_motion(species):
    """The muscles of the other side make it, to rounding."""
    body = build_body(species.body)
    rng = np.random.default_rng(1)
    steps = np.clip(0.02 * rng.normal(size=(36, 12)).cumsum(axis=0), 0.0, 0.2)
    state, other = at_rest(body), at_rest(body)
    trial = Trial(simulate(body, state, steps), state)
    swapped = steps.reshape(36, 3, 4)[:, :, [1, 0, 3, 2]].reshape(36, 12)
    frames = simulate(body, other, swapped)
    np.testing.assert_allclose(mirrored(trial).frames, frames, atol=1e-9)
    np.testing.assert_allclose(mirrored(trial).state.v, other.v, atol=1e-9)


def test_a_start_ends_at_medium_and_a_stop_at_rest(species, repertoire):
    medium = repertoire.segments["swim_medium"].speed_cm_s * repertoire.tick_s
    beat = species.swim.at("medium").ticks_per_beat
    begun = played(repertoire, "swim_start").mean(axis=1)
    speed = np.linalg.norm(begun[-1] - begun[-1 - beat]) / beat
    assert 0.7 * medium < speed < 1.3 * medium
    ended = played(repertoire, "swim_stop").mean(axis=1)
    assert np.linalg.norm(ended[-1] - ended[-2]) < 0.2 * medium
    bent = np.abs(repertoire.segments["swim_stop"].nodes[-1] - repertoire.rest_nodes).max()
    assert bent < 0.02 * repertoire.body_length_cm


def test_a_stop_coasts_on_where_the_swim_ended(species):
    """Its first frame is steady swimming, so nothing jumps on entering."""
    trial = run_trial(species.muscles, "swim_stop")
    steady = run_trial(species.muscles, "swim_medium")
    np.testing.assert_array_equal(trial.frames[0], copy_state(steady.state).x)
