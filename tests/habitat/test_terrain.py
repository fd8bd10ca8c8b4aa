"""The seabed."""

import numpy as np
import pytest
from msgspec.structs import replace

from subsea.geometry.solids import height_at
from subsea.habitat.terrain import MOAT_CM, MOUND_CM, crest, drifted, half_width, make_terrain
from subsea.scenario.load import load_scenario


@pytest.fixture
def scenario():
    return load_scenario("peaceful")[0]


def test_a_seed_is_a_seabed(scenario):
    np.testing.assert_array_equal(make_terrain(scenario), make_terrain(scenario))
    other = replace(scenario, terrain=replace(scenario.terrain, seed=99))
    assert np.abs(make_terrain(other) - make_terrain(scenario)).max() > 10


def test_dunes_have_the_asked_height_and_leave_water_above(scenario):
    heights = make_terrain(scenario)
    n = len(heights)
    middle = heights[n // 3 : -n // 3, n // 3 : -n // 3]
    height = np.sqrt(8) * middle.std()
    assert height == pytest.approx(scenario.terrain.dune_height_cm, rel=0.4)
    assert heights.max() <= -0.5 * scenario.bounds.depth_cm


def test_no_cliffs(scenario):
    """No step between samples is steeper than sand lies (34°)."""
    heights = make_terrain(scenario)
    step = 2 * 1.6 * scenario.bounds.radius_cm / (len(heights) - 1)
    slope = np.hypot(*np.gradient(heights, step))
    assert slope.max() < np.tan(np.radians(34.0))


def test_no_part_of_the_sea_is_above_the_crest(scenario):
    heights, width, radius = make_terrain(scenario), half_width(scenario), scenario.bounds.radius_cm
    top = crest(heights, width, radius)
    rng = np.random.default_rng(1)
    angle, away = rng.uniform(0, 2 * np.pi, 5000), radius * np.sqrt(rng.uniform(0, 1, 5000))
    inside = [
        height_at(heights, width, a * np.cos(b), a * np.sin(b))
        for a, b in zip(away, angle, strict=True)
    ]
    assert top - 30.0 < max(inside) <= top


def test_dunes_are_steep_in_their_lee(scenario):
    """Along the wind that made them the slopes down are steeper than those up."""
    heights = make_terrain(scenario)
    slope = np.diff(heights[60:-60, 60:-60], axis=1).ravel()
    assert abs((slope**3).mean()) > 0.1 * slope.std() ** 3


def test_the_current_digs_about_a_rock_and_heaps_up_behind_it():
    flat = np.full((161, 161), -300.0, np.float32)
    rocks = np.array([[0.0, 0.0, -290.0, 60.0, 60.0, 50.0, 0.0]])
    made = drifted(flat, 800.0, np.zeros((0, 4)), rocks, (5.0, 0.0))
    beside, lee, luff, far = (height_at(made, 800.0, x, 0.0) for x in (68.0, 135.0, -135.0, 400.0))
    assert beside == pytest.approx(-300.0 - MOAT_CM, abs=2.0)
    assert lee == pytest.approx(-300.0 + MOUND_CM, abs=2.5)
    assert -299.5 < luff < lee - 4.0
    assert far == -300.0
    np.testing.assert_array_equal(drifted(flat, 800.0, np.zeros((0, 4)), rocks[:0], (5, 0)), flat)
    # Not below a rock that hangs high above.
    high = rocks + [0.0, 0.0, 390.0, 0.0, 0.0, 0.0, 0.0]
    made = drifted(flat, 800.0, np.zeros((0, 4)), high, (5.0, 0.0))
    np.testing.assert_allclose(made, flat, atol=0.1)
