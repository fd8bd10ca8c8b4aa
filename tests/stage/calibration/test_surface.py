"""Surfaces of screens: places, points and rays agree."""

import numpy as np
import pytest

from subsea.stage.calibration.surface import LitSurface
from subsea.stage.theatre.screens import Curved, Flat
from subsea.view.surround import Surround, directions

FLAT = Flat(np.array([-200.0, -80.0, 300.0]), np.array([400.0, 0, 50.0]), np.array([0, 180.0, 0]))
SURFACES = {
    "flat": LitSurface(FLAT),
    "cylinder": LitSurface(Curved((20.0, -30.0), 300.0, -0.9, 0.8, -90.0, 100.0)),
    "sphere": LitSurface(FLAT, 500.0),
    "dome": LitSurface(None, 500.0, 25.0, 200 / 180),
}


@pytest.mark.parametrize("kind", SURFACES)
def test_rays_from_anywhere_meet_the_points(kind):
    surface = SURFACES[kind]
    places = np.random.default_rng(1).uniform(0.25, 0.75, (100, 2))
    points = surface.points(places)
    np.testing.assert_allclose(surface.places(points), places, atol=1e-9)
    start = np.array([40.0, -20.0, 60.0])
    ways = points - start
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    np.testing.assert_allclose(surface.meet(start, ways), points, atol=1e-6)


def test_a_dome_is_the_square_that_a_dive_draws():
    pixels = np.random.default_rng(2).uniform(20, 80, (50, 2))
    rays = directions("dome", (100, 100), Surround(tilt_deg=25.0, dome_deg=200.0), pixels)
    points = SURFACES["dome"].points(pixels / 100)
    np.testing.assert_allclose(points, 500.0 * rays, atol=1e-6)


def test_surfaces_are_told_apart():
    beside = LitSurface(Flat(FLAT.corner + 0.5 * FLAT.along, FLAT.along, FLAT.up))
    behind = LitSurface(Flat(FLAT.corner + [0.0, 0.0, 5.0], FLAT.along, FLAT.up))
    assert SURFACES["flat"].same(beside) and beside.same(SURFACES["flat"])
    assert not SURFACES["flat"].same(behind)
    kinds = list(SURFACES.values())
    for k, one in enumerate(kinds[:3]):
        assert [one.same(other) for other in kinds[:3]] == [k == j for j in range(3)]
