"""Culling and levels of detail."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from subsea.view.culling import HIDDEN, classify
from subsea.view.rigs import pose, views_for

EYE = np.array([0.0, 0.0, -300.0])


def _views(heading=0.0, pitch=0.0, display="mono"):
    return views_for(display, (640, 360), pose(EYE, heading, pitch))


def _levels(centres, views, *, radius=15.0, culling=True, lod=True):
    centres = np.atleast_2d(np.asarray(centres, np.float32))
    n = len(centres)
    radii, lengths = np.full(n, radius, np.float32), np.full(n, 20.0, np.float32)
    return classify(centres, radii, lengths, views, culling, lod)


@given(
    seed=st.integers(0, 2**32 - 1), heading=st.floats(-3, 3), pitch=st.floats(-1, 1),
    display=st.sampled_from(["mono", "side-by-side"]),
)  # fmt: skip
@settings(max_examples=60)
def test_whatever_could_show_is_kept(seed, heading, pitch, display):
    """No fish of which a point on its sphere is in a view is culled."""
    rng = np.random.default_rng(seed)
    views = _views(heading, pitch, display)
    centres = EYE + rng.normal(0, 200, (200, 3))
    levels = _levels(centres, views)
    spots = rng.normal(size=(60, 3))
    spots *= 15.0 / np.linalg.norm(spots, axis=1, keepdims=True)
    for view in views:
        matrix = view.projection.astype(float) @ view.view.astype(float)
        points = (
            np.concatenate([centres[:, None] + spots, np.ones((200, 60, 1))], axis=2) @ matrix.T
        )
        seen = (np.abs(points[..., :3]) < points[..., 3:]).all(axis=2).any(axis=1)
        assert (levels[seen] != HIDDEN).all()


def test_most_of_what_cannot_show_is_culled():
    rng = np.random.default_rng(1)
    levels = _levels(EYE + rng.normal(0, 500, (5000, 3)), _views())
    assert (levels == HIDDEN).mean() > 0.8  # the frustum is about a ninth of all directions


def test_nearer_is_finer():
    distances = np.array([30, 100, 200, 400, 800, 1600])
    levels = _levels([EYE + [d, 0, 0] for d in distances], _views())
    assert levels[0] == 0
    assert levels[-1] == 2
    assert (np.diff(levels.astype(int)) >= 0).all()


def test_switches_turn_it_off():
    behind, far = EYE - [100, 0, 0], EYE + [1600, 0, 0]
    assert _levels(behind, _views())[0] == HIDDEN
    assert _levels(behind, _views(), culling=False)[0] != HIDDEN
    assert _levels(far, _views(), lod=False)[0] == 0


@pytest.mark.parametrize("display", ["side-by-side", "top-bottom"])
def test_several_views_cull_once_against_their_union(display):
    left, right = _views(display=display)
    rng = np.random.default_rng(2)
    centres = EYE + rng.normal(0, 150, (2000, 3))
    union = _levels(centres, (left, right)) != HIDDEN
    either = (_levels(centres, (left,)) != HIDDEN) | (_levels(centres, (right,)) != HIDDEN)
    np.testing.assert_array_equal(union, either)
