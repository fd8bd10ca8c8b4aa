"""The seabed."""

import msgspec
import numpy as np
import pytest

from subsea.habitat.terrain import crest, half_width, make_terrain
from subsea.kinematics.heightfield import height_at
from subsea.scenario import load_scenario


@pytest.fixture
def scenario():
    return load_scenario("peaceful")[0]


def test_a_seed_is_a_seabed(scenario):
    np.testing.assert_array_equal(make_terrain(scenario), make_terrain(scenario))
    other = msgspec.structs.replace(
        scenario, terrain=msgspec.structs.replace(scenario.terrain, seed=99)
    )
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
