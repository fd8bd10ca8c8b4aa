"""Shadows of low fishes: displaced along the sun's rays, softer and paler with height."""

import numpy as np
import pytest

from subsea.frame.packet import FADE, FISH, INSTANCE_COLUMNS
from subsea.habitat.stone import SUN
from subsea.rendering.fish.soft_shadows import (
    COLUMNS,
    FADING_CM,
    FARTHEST_CM,
    HIGHEST_CM,
    MOST,
    Sand,
    cast,
)

WIDTH, SAND = 900.0, -300.0
HEIGHTS = np.full((31, 31), SAND, np.float32)
FAR = np.array([0.0, 0.0, 500.0])  # an eye that casts none


def shadows(fishes, eye=(0.0, 0.0, -90.0), heights=HEIGHTS, fades=0.0, vessel=None, numbers=None):
    """Shadows of 20 cm fishes (x, y, z, heading), last one first, without the submarine's."""
    records = np.zeros((len(fishes), INSTANCE_COLUMNS), np.float32)
    for record, (x, y, z, heading) in zip(records, fishes, strict=True):
        record[:4] = x, y, z, 1.0
        record[4:8] = np.cos(heading / 2), 0.0, 0.0, np.sin(heading / 2)
    records[:, FADE] = fades
    records[:, FISH] = range(len(fishes)) if numbers is None else numbers
    out = np.zeros((MOST, COLUMNS), np.float32)
    places = (np.array(place, float) for place in (eye, vessel or eye))
    number = cast(records, np.array([20.0]), Sand(heights, WIDTH), *places, out)
    return out[:number].astype(float)


def test_a_shadow_lies_where_the_ray_of_the_sun_meets_the_sand():
    (one,) = shadows([(50.0, 20.0, SAND + 94.5, 0.6)])
    np.testing.assert_allclose(one[:3], (50 - 100 * SUN[0], 20 - 100 * SUN[1], SAND), atol=0.01)
    np.testing.assert_allclose(one[5:7], (np.cos(0.6), np.sin(0.6)), atol=1e-5)
    np.testing.assert_allclose(one[3:5], 0.0, atol=1e-6)


def test_it_is_softer_and_paler_with_height():
    high, low = shadows([(0, 0, SAND + 5, 0), (0, 100, SAND + 120, 0)])
    assert high[9] < 0.5 * low[9]
    assert (high[7:9] > low[7:9] + 10.0).all()
    assert low[7] > 2.0 * low[8]


@pytest.mark.parametrize(
    ("place", "number"),
    [((0, 0, SAND + 1.1 * HIGHEST_CM, 0), 0), ((0, 0, SAND + 20, 0), 1),
     ((FARTHEST_CM + 50, 0, SAND + 20, 0), 0)],
)  # fmt: skip
def test_a_high_or_far_fish_casts_no_shadow(place, number):
    assert len(shadows([place])) == number


def test_the_vessel_casts_one_when_low():
    (one,) = shadows([], eye=(10.0, 0.0, SAND + 60.0))
    assert one[7] > 30.0
    assert 0.0 < one[9] < 1.0
    # An eye elsewhere sees the shadow at the same place.
    (other,) = shadows([], eye=(300.0, 0.0, -90.0), vessel=(10.0, 0.0, SAND + 60.0))
    np.testing.assert_array_equal(one, other)


def test_on_a_slope_it_lies_along_it():
    axis = np.linspace(-WIDTH, WIDTH, 31)
    slope = (SAND + 0.2 * axis[None, :] + 0.0 * axis[:, None]).astype(np.float32)
    (one,) = shadows([(0.0, 0.0, SAND + 30.0, 0.0)], heights=slope)
    np.testing.assert_allclose(one[3:5], (0.2, 0.0), atol=1e-4)
    assert one[2] == pytest.approx(SAND + 0.2 * one[0], abs=0.01)


def test_there_are_never_more_than_fit_and_the_first_listed_go_without():
    """These are the coarsest and farthest of a packet."""
    many = [(0.5 * (k - 325), 0.0, SAND + 10, 0.0) for k in range(MOST + 50)]
    found = shadows(many)
    assert len(found) == MOST
    everyone = np.concatenate([shadows(many[:50]), shadows(many[50:])])
    np.testing.assert_array_equal(found, everyone[50:])


def test_a_fading_fish_casts_one_shadow():
    twice = [(30.0, 0.0, SAND + 10, 0.4)] * 2
    one = shadows(twice, fades=[0.3, -0.7], numbers=[5, 5])
    np.testing.assert_array_equal(one, shadows(twice[:1]))


def test_a_fish_in_several_views_casts_one_shadow():
    a, b, c = ((30.0 * k, 0.0, SAND + 10, 0.4) for k in range(3))
    seen = shadows([a, b, b, c, a], numbers=[0, 1, 1, 2, 0])
    np.testing.assert_array_equal(seen, shadows([b, c, a]))


def test_a_shadow_fades_before_it_is_too_far():
    eye = (0.0, 0.0, SAND + 2.0)
    near, begins, middle, ends = (
        shadows([(x, 0, SAND + 2, 0)], eye)[-1, 9]
        for x in FARTHEST_CM - FADING_CM * np.array([1.5, 1.0, 0.5, 0.01])
    )
    assert near == pytest.approx(begins) and near > 0.4
    assert middle == pytest.approx(0.5 * near, rel=1e-3)
    assert 0.0 < ends < 0.02 * near


def test_the_sand_is_darker_there(drawn, scene, make_packet, fish):
    sand = scene.terrain[len(scene.terrain) // 2, len(scene.terrain) // 2]
    eye = (0.0, -70.0, float(sand) + 90.0)
    # The fish that is seen is elsewhere; the sun comes from ahead and aside.
    low, high = (
        drawn(make_packet([fish(0, (0.0, 0.0, float(z)))], eye=eye, pitch=-0.9, size=(160, 90)))
        for z in (sand + 12.0, sand + 1000.0)
    )
    assert (high - low).mean(axis=2).max() > 8
