"""Blends of measured projectors."""

import numpy as np

from subsea.stage.calibration.blending import footprints, light_share, mask_size, overlap_blacks
from subsea.stage.calibration.meshes import MeasuredProjector
from subsea.stage.calibration.surface import LitSurface
from subsea.stage.theatre.screens import Flat

SIZE = 240, 160
WALL = LitSurface(
    Flat(np.array([-200.0, -80.0, 300.0]), np.array([400.0, 0, 0]), np.array([0, 160.0, 0]))
)


def at(left, right, skew=0.0):
    """A projector that lights the wall from `left` to `right`, in shares; its sides are skew."""
    x, y = np.meshgrid(np.linspace(0, 1, 11), np.linspace(0, 1, 9))
    places = np.stack([left + (right - left) * x + skew * y, 1.0 - y], axis=-1)
    none = np.zeros((0, 2))
    return MeasuredProjector(WALL, SIZE, places, np.ones(x.shape, bool), none, none)


def light_on_the_wall(prints, values, places):
    """The sum (n,) of grids of values of all projectors at places (n, 2) of the wall."""
    total = np.zeros(len(places))
    for one, grid in zip(prints, values, strict=True):
        flat = one.places.reshape(-1, 2)
        apart = np.linalg.norm(flat[:, None] - places[None], axis=2)
        nearest = apart.argmin(axis=0)
        close = apart[nearest, np.arange(len(places))] < 0.004
        total += np.where(close, grid.ravel()[nearest], 0.0)
    return total


def test_shares_add_up_to_one_and_fade_to_the_edge():
    measured = [at(-0.02, 0.6, 0.03), at(0.45, 1.0, -0.02)]
    prints = footprints(measured, [WALL], [None, None])
    shares = [light_share(prints, k, [None, None]) for k in (0, 1)]
    assert shares[0].shape == mask_size(SIZE)[::-1]
    grid = np.stack(np.meshgrid(np.linspace(0.03, 0.97, 40), [0.2, 0.5, 0.8]), axis=-1)
    light = light_on_the_wall(prints, shares, grid.reshape(-1, 2))
    np.testing.assert_allclose(light, 1.0, atol=0.04)
    row = shares[0][len(shares[0]) // 2]
    assert row[-1] < 0.01 and row[len(row) // 2] == 1.0
    assert (np.diff(row[len(row) // 2 :]) < 1e-6).all()
    assert (shares[0][: len(shares[0]) // 2, 0] == 0).all()  # beyond the left edge of the wall


def test_projectors_for_two_eyes_do_not_share():
    measured = [at(0.0, 0.6), at(0.4, 1.0)]
    groups = ["left", "right"]
    prints = footprints(measured, [WALL], groups)
    assert (light_share(prints, 0, groups)[prints[0].lit] == 1.0).all()


def test_black_is_raised_where_one_projector_shines_alone():
    measured = [at(0.0, 0.6), at(0.4, 1.0)]
    groups = [None, None]
    prints = footprints(measured, [WALL], groups)
    blacks = [0.002, 0.003]
    added = overlap_blacks(prints, blacks, groups)
    own = [np.where(one.lit, black, 0.0) for one, black in zip(prints, blacks, strict=True)]
    places = np.array([[0.1, 0.5], [0.3, 0.2], [0.5, 0.5], [0.8, 0.7]])
    total = [one + more for one, more in zip(own, added, strict=True)]
    np.testing.assert_allclose(light_on_the_wall(prints, total, places), 0.005, atol=1e-4)
