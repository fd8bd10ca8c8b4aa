"""The lessons of the flat fish, its transitions, pictures and films."""

import numpy as np
import pytest

from capture.flat.controllers import WAYS, controller_at, distance, lengths, passage, run, turned
from capture.flat.drawing import Skin
from capture.flat.experiments import folded
from capture.flat.films import SIZE, FilmPanel, pictures
from capture.flat.lessons import Effort, FlatLearner
from subsea.base.errors import UserError


@pytest.mark.nightly
def test_it_learns_to_swim_farther_with_one_frequency(learner):
    rng = np.random.default_rng(5)
    body = learner.body
    unlearned = [distance(body, controller_at(body, rng.random(13))) for _ in range(12)]
    learned = np.median([run.best[-1] for run in learner.swims])
    assert learned > 5 * max(0.05, np.mean([far for far in unlearned if far > -1.0]))
    assert learned > 1.2 * np.median([run.best[-1] for run in learner.many])
    # The same seed finds the same again.
    again = FlatLearner(body, learner.effort).learn_swims(60, 1)
    assert (again[0].scores == learner.swims[0].scores).all()
    assert learner.swims[0].scores.max() == pytest.approx(2.96574359, rel=1e-6)
    # The mirrored fish swims the mirrored way.
    left, right = (
        run(body, lengths(body, controller, 300))[-1, 0]
        for controller in (learner.swimmer, learner.swimmer.mirrored(body))
    )
    other = np.array([0, *(k + 1 if k % 2 else k - 1 for k in range(1, 11)), 11])
    np.testing.assert_allclose(left, right[other] * [1, -1], atol=1e-6)


def test_it_learns_to_turn(learner):
    body = learner.body
    to_left = turned(body, learner.swum, learner.turner)
    assert to_left == learner.turns[0].scores.max()
    rng = np.random.default_rng(5)
    unlearned = [
        turned(body, learner.swum, controller_at(body, rng.random(13))) for _ in range(8)
    ]  # fmt: skip
    assert to_left > 15.0 + np.mean([degrees for degrees in unlearned if degrees > -180.0])


@pytest.mark.parametrize("way", WAYS)
def test_a_transition_leads_from_one_controller_to_the_other(learner, way):
    body = learner.body
    muscles = passage(body, learner.swimmer, learner.turner, 50.0, way)
    before = lengths(body, learner.swimmer, 1, 50.0)
    after = lengths(body, learner.turner, 1, 50.0 + 0.055 * (len(muscles) - 1))
    np.testing.assert_allclose(muscles[[0]], before, rtol=2e-2)
    np.testing.assert_allclose(muscles[[-1]], after, rtol=2e-2)


def test_great_amplitudes_fold_the_body(body):
    assert folded(body, 0.05, 6) == 0
    assert folded(body, 0.5, 6) > 0.8


def test_a_scaffold_that_always_folds_learns_nothing(body):
    soft = body._replace(stiffness=0.1 * body.stiffness * (np.arange(25) < 6), drag=20.0)
    with pytest.raises(UserError, match="every swim of 2 tries folds the scaffold; expected edges"):
        _ = FlatLearner(soft, Effort(1, 2)).swimmer


def test_the_outline_lies_in_the_scaffold_and_moves_with_it(body):
    skin = Skin(body)
    assert skin.shares.min() > -1e-9
    turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    np.testing.assert_allclose(
        skin.outline(body.rest @ turn + 3.0), skin.outline(body.rest) @ turn + 3.0, atol=1e-9
    )
    assert np.abs(skin.midline(body.rest)[:, 1]).max() < 1e-9


def test_a_film_shows_the_fish_where_it_is(body):
    """The blue body moves from left to right between two frames, the red goal stays."""
    ahead = body.at_rest() + np.array([[40.0, 0.0], [0.0, 0.0]])[:, None]
    scene = FilmPanel("ahead", np.stack([body.at_rest(), ahead]), (2.0, 0.0))
    places = []
    for picture in pictures(body, [scene]):
        assert picture.shape == (SIZE[1], SIZE[0], 3)
        blue = picture[:, :, 2].astype(int) - picture[:, :, 0] > 60
        places.append(np.argwhere(blue)[:, 1].mean())
        assert (picture == [192, 0, 0]).all(axis=2).sum() > 20
    assert places[1] > places[0] + 200
