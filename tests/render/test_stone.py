"""Shapes of pillars and rocks: within what the fishes avoid, and closed above the sand."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from subsea.habitat.solids import clearances
from subsea.render.stone import (
    ABOVE,
    BURIED_CM,
    NOTHING,
    RELIEF,
    RINGS,
    SECTORS,
    SHELTER,
    SUN,
    pillar_shape,
    rock_shape,
    shadow,
)

SIZE = st.floats(8.0, 150.0)
PILLAR = np.array([30.0, -20.0, 55.0, -250.0])
ROCK = np.array([30.0, -20.0, -580.0, 60.0, 45.0, 40.0, 0.5])


def floor(x, y):
    return -600.0 + 0.1 * x - 0.05 * y


def triangles_of(shape):
    return shape.vertices[:, :3].astype(np.float64)[shape.triangles]


@given(SIZE, st.floats(20.0, 500.0), st.integers(0, 2))
@settings(max_examples=25)
def test_a_pillar_fills_its_cylinder_but_never_leaves_it(radius, height, level):
    pillar = np.array([70.0, 10.0, radius, floor(70.0, 10.0) + height])
    places = pillar_shape(pillar, floor, level).vertices[:, :3].astype(np.float64)
    away = np.hypot(places[:, 0] - 70.0, places[:, 1] - 10.0)
    assert away.max() <= radius + 1e-3
    assert places[:, 2].max() <= pillar[3] + 1e-3
    # Its sides lie at most the relief inside; its worn shoulder a little more.
    side = places[:, 2] < pillar[3] - 0.31 * radius - 0.05 * height
    side = side & (places[:, 2] < pillar[3] - 0.5 * height)
    assert (away[side] >= (1.0 - RELIEF) * radius - 1e-3).all()
    assert -clearances(pillar[None], NOTHING, places).min() <= (RELIEF + 0.08) * radius


@given(SIZE, SIZE, SIZE, st.floats(-3, 3), st.integers(0, 2))
@settings(max_examples=25)
def test_a_rock_fills_its_ellipsoid_but_never_leaves_it(a, b, c, yaw, level):
    rock = np.array([70.0, 10.0, floor(70.0, 10.0) + 0.4 * c, a, b, c, yaw])
    places = rock_shape(rock, floor, level).vertices[:, :3].astype(np.float64) - rock[:3]
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    share = np.linalg.norm(places @ turn / rock[3:6], axis=1)
    assert share.max() <= 1.0 + 1e-5
    assert share.min() >= 1.0 - RELIEF - 1e-5
    assert share.max() - share.min() > 0.3 * RELIEF  # it is no smooth egg


@pytest.mark.parametrize("level", [0, 1, 2])
@pytest.mark.parametrize(("make", "solid"), [(pillar_shape, PILLAR), (rock_shape, ROCK)])
def test_outside_is_where_normals_and_triangles_say(make, solid, level):
    shape = make(solid, floor, level)
    corners = triangles_of(shape)
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = shape.vertices[:, 3:6]
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-5)
    mean = normals[shape.triangles].mean(axis=1)
    real = np.linalg.norm(facing, axis=1) > 1e-3  # round a top's middle some have no area
    assert ((facing * mean).sum(axis=1)[real] > 0.0).mean() > 0.97
    middle = corners.mean(axis=(0, 1))
    outward = corners.mean(axis=1) - middle
    assert ((facing * outward).sum(axis=1)[real] > 0.0).mean() > 0.99


@pytest.mark.parametrize(("make", "solid"), [(pillar_shape, PILLAR), (rock_shape, ROCK)])
def test_each_level_has_fewer_triangles_and_goes_on_below_the_sand(make, solid):
    shapes = [make(solid, floor, level) for level in (0, 1, 2)]
    numbers = [len(shape.triangles) for shape in shapes]
    assert 1000 < numbers[0] < 8000
    assert numbers[1] < 0.4 * numbers[0]
    assert numbers[2] < 0.4 * numbers[1]
    for shape in shapes:
        assert -60.0 < shape.vertices[:, ABOVE].min() < -0.5 * BURIED_CM
        assert shape.vertices[:, SHELTER].min() >= 0.0
        assert shape.vertices[:, SHELTER].max() <= 1.0


def test_two_stones_differ_and_one_stays_as_it_is():
    one, again = rock_shape(ROCK, floor), rock_shape(ROCK, floor)
    other = rock_shape(ROCK + [200.0, 0, 0, 0, 0, 0, 0], floor)
    np.testing.assert_array_equal(one.vertices, again.vertices)
    assert np.abs(one.vertices[:, SHELTER] - other.vertices[:, SHELTER]).max() > 0.3


@pytest.mark.parametrize(
    ("pillars", "rocks"), [(PILLAR[None], NOTHING), (np.zeros((0, 4)), ROCK[None])]
)
def test_a_shadow_lies_on_the_sand_away_from_the_sun(pillars, rocks):
    places = shadow(pillars, rocks, floor).vertices.astype(np.float64)
    np.testing.assert_allclose(places[:, 2], floor(places[:, 0], places[:, 1]), atol=1e-3)
    assert np.ptp(places[: SECTORS + 1], axis=0).max() < 1e-3  # no hole, in which sand would shine
    dark = places[:, 3].reshape(RINGS, SECTORS + 1)
    assert dark.min() == 0.0
    assert (dark[-1] == 0.0).all()
    assert 0.7 < dark.max() <= 1.0
    free = clearances(pillars, rocks, places[:, :3])
    beside = (free > 12.0) & (free < 25.0)
    toward_sun = (places[:, :2] - (30.0, -20.0)) @ SUN[:2] > 0.0
    assert places[beside & ~toward_sun, 3].mean() > 1.1 * places[beside & toward_sun, 3].mean()
