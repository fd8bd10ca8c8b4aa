"""The two views of the builder."""

import numpy as np
import pytest

from subsea.fish.species import load_species
from subsea.studio.builder.views import OutlineViews, outlines


def test_fit_shows_the_whole_fish_in_both_views():
    """The wings of a ray reach beyond the first view, and a view may have been moved."""
    views = OutlineViews()
    views._shapes = outlines(load_species("spotted_eagle_ray"))
    views.side.size, views.top.size = (500.0, 300.0), (500.0, 200.0)
    views.top._middle, views.top._fits = (0.5, 0.9), False
    views.fit()
    views.top.follow(views.side)
    assert views.top._middle[1] == pytest.approx(0.0)
    left, low, right, high = views.side.box
    for name, points in views._shapes.items():
        share = 1.0 if name.startswith("side") else 200.0 / 300.0  # of the height, at one scale
        assert left <= points[:, 0].min() and points[:, 0].max() <= right
        assert np.abs(points[:, 1]).max() <= share * high + 1e-9 and low == -high
