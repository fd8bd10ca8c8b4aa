"""Distances and rays against closed forms and against many points along the way."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.geometry.solids import (
    NEVER,
    RANGES_CM,
    REACHES_CM,
    far_from_rock,
    from_pillar,
    from_rock,
    height_at,
    is_far_from_rocks,
    is_over_all,
    misses_rocks,
    passes_over_all,
    ray_meets_pillar,
    ray_meets_rock,
    ray_meets_seabed,
    rock_tops,
    skyline_of,
)

PILLAR = np.array([10.0, -5.0, 8.0, 20.0])
ROCK = np.array([3.0, 4.0, -6.0, 12.0, 7.0, 5.0, 0.6])
SEEDS = st.integers(0, 2**32 - 1)
MANY = np.linspace(0.0, 1.0, 4001)


def _ends(seed, size):
    return np.random.default_rng(seed).uniform(-size, size, (2, 3))


def _check(found, above, a, b):
    """No point before the entry lies inside, and the entry lies on the border.

    `above` gives for points (n, 3) a number that is at most 0 inside.
    """
    values = above(a + MANY[:, None] * (b - a))
    if np.isfinite(found):
        assert 0.0 <= found <= 1.0
        assert (values[found - 1e-9 > MANY] > 0.0).all()
        here = above((a + found * (b - a))[None])[0]
        assert here <= 1e-6 if found == 0.0 else abs(here) < 1e-6
    else:
        assert (values > 0.0).all()


def _above_pillar(p, margin):
    away = np.hypot(p[:, 0] - PILLAR[0], p[:, 1] - PILLAR[1])
    return np.maximum(away - PILLAR[2] - margin, p[:, 2] - PILLAR[3] - margin)


def _above_rock(p, margin):
    c, s = np.cos(ROCK[6]), np.sin(ROCK[6])
    x, y, z = (p - ROCK[:3]).T
    turned = np.stack([c * x + s * y, c * y - s * x, z], axis=1)
    return ((turned / (ROCK[3:6] + margin)) ** 2).sum(axis=1) - 1.0


@given(SEEDS, st.sampled_from([0.0, 3.0]))
def test_a_ray_enters_a_pillar_where_its_first_point_does(seed, margin):
    a, b = _ends(seed, 30.0)
    found = ray_meets_pillar(PILLAR, margin, tuple(a), tuple(b))
    _check(found, lambda p: _above_pillar(p, margin), a, b)


@given(SEEDS, st.sampled_from([0.0, 2.0]))
def test_a_ray_enters_a_rock_where_its_first_point_does(seed, margin):
    a, b = _ends(seed, 15.0)
    found = ray_meets_rock(ROCK, margin, tuple(a), tuple(b))
    _check(found, lambda p: _above_rock(p, margin), a, b)


@given(SEEDS, st.sampled_from([0.0, 4.0]))
def test_a_ray_enters_the_seabed_where_its_first_point_does(seed, clearance):
    rng = np.random.default_rng(seed)
    heights = rng.uniform(-30.0, 0.0, (9, 9)).astype(np.float32)
    # Beyond the square too, where the edge goes on.
    a, b = rng.uniform((-60, -60, -35), (60, 60, 15), (2, 3))
    found = ray_meets_seabed(heights, 40.0, clearance, tuple(a), tuple(b))

    def above(points):
        return np.array([z - height_at(heights, 40.0, x, y) - clearance for x, y, z in points])

    _check(found, above, a, b)


def test_random_rays_meet_and_miss():
    """So that the tests above have both to tell apart."""
    ends = [tuple(map(tuple, _ends(seed, 30.0))) for seed in range(100)]
    hits = sum(np.isfinite(ray_meets_pillar(PILLAR, 0.0, a, b)) for a, b in ends)
    assert 10 < hits < 90


def test_rays_that_the_two_step_test_misses_meet_the_pillar():
    """Tu's test looks at the two points on the circle alone (Tu §6.4.1)."""
    middle = (10.0, -5.0)
    inside, over = (*middle, 0.0), (*middle, 30.0)
    assert ray_meets_pillar(PILLAR, 0.0, inside, over) == 0.0
    assert ray_meets_pillar(PILLAR, 0.0, over, inside) == pytest.approx(1 / 3)
    # In at the side of the circle but above the top, down through it, and ends inside.
    assert np.isfinite(ray_meets_pillar(PILLAR, 0.0, (0.0, -5.0, 30.0), (11.0, -5.0, 10.0)))
    # Over the top, all the way.
    assert ray_meets_pillar(PILLAR, 0.0, (-9.0, -5.0, 21.0), (40.0, -5.0, 21.0)) == NEVER
    # No length at all.
    assert ray_meets_pillar(PILLAR, 0.0, over, over) == NEVER
    assert ray_meets_pillar(PILLAR, 0.0, inside, inside) == 0.0


@pytest.mark.parametrize(
    ("p", "distance", "normal"),
    [
        ((30.0, -5.0, 0.0), 12.0, (1, 0, 0)),
        ((10.0, -5.0, 26.0), 6.0, (0, 0, 1)),
        ((10.0, -1.0, 23.0), 3.0, (0, 0, 1)),
        ((10.0, 1.0, 0.0), -2.0, (0, 1, 0)),
        ((10.0, 7.0, 23.0), 5.0, (0, 0.8, 0.6)),
        ((10.0, -5.0, 18.0), -2.0, (0, 0, 1)),
    ],
)
def test_distance_from_a_pillar(p, distance, normal):
    away, far = from_pillar(PILLAR, p)
    assert far == pytest.approx(distance)
    np.testing.assert_allclose(away, normal, atol=1e-12)


def test_a_round_rock_is_as_far_as_a_ball():
    ball = np.array([1.0, 2.0, 3.0, 5.0, 5.0, 5.0, 0.9])
    for p in np.random.default_rng(1).normal(0, 10, (50, 3)):
        away = p - ball[:3]
        normal, far = from_rock(ball, tuple(p))
        assert far == pytest.approx(np.linalg.norm(away) - 5.0)
        np.testing.assert_allclose(normal, away / np.linalg.norm(away), atol=1e-9)
    assert from_rock(ROCK, (3.0, 4.0, -6.0))[1] == -5.0


@given(SEEDS)
def test_beside_a_rock_the_distance_is_that_along_the_normal(seed):
    rng = np.random.default_rng(seed)
    u = rng.normal(size=3)
    u /= np.linalg.norm(u)
    c, s = np.cos(ROCK[6]), np.sin(ROCK[6])
    x, y, z = u * ROCK[3:6]
    surface = ROCK[:3] + (c * x - s * y, s * x + c * y, z)
    normal, far = from_rock(ROCK, tuple(surface))
    assert far == pytest.approx(0.0, abs=1e-9)
    gap = rng.uniform(-0.2, 0.2)
    assert from_rock(ROCK, tuple(surface + gap * np.array(normal)))[1] == pytest.approx(
        gap, abs=0.05
    )


def test_what_is_far_from_a_rock_is_farther_than_the_gap():
    """And most of what is farther is found to be."""
    found = near = 0
    for p in np.random.default_rng(2).uniform(-80.0, 80.0, (2000, 3)):
        for gap in (0.0, 3.0, 20.0):
            farther = from_rock(ROCK, tuple(p))[1] > gap
            far = far_from_rock(ROCK, tuple(p), gap)
            assert farther or not far
            found, near = found + far, near + farther
    assert found > 0.6 * near


def test_a_ray_beside_a_long_rock_meets_it_at_its_ends():
    """Where the box that is asked about first is as long as the rock."""
    long = np.array([0.0, 0.0, 0.0, 40.0, 2.0, 2.0, 0.0])
    over = ray_meets_rock(long, 0.0, (39.9, 0.0, 10.0), (39.9, 0.0, -10.0))
    assert over == pytest.approx(0.5, abs=0.01)
    assert ray_meets_rock(long, 0.0, (40.1, 0.0, 10.0), (40.1, 0.0, -10.0)) == NEVER
    assert np.isfinite(ray_meets_rock(long, 0.2, (40.1, 0.0, 10.0), (40.1, 0.0, -10.0)))


def _rocks(seed):
    rng = np.random.default_rng(seed)
    low, high = (-1500, -1500, -600, 10, 10, 10, 0), (1500, 1500, -300, 200, 120, 150, 6.28)
    return rng.uniform(low, high, (rng.integers(0, 12), 7))


@given(SEEDS)
def test_a_look_never_says_far_of_a_place_within_the_gap_of_a_rock(seed):
    rocks, rng = _rocks(seed), np.random.default_rng(seed + 1)
    tops = rock_tops(rocks, 1200.0)
    for p in rng.uniform((-1400, -1400, -600), (1400, 1400, 0), (200, 3)):
        gap = rng.uniform(0.0, 1.2 * RANGES_CM[-1])
        if is_far_from_rocks(tops, 1200.0, tuple(p), gap):
            assert all(far_from_rock(rock, tuple(p), gap) for rock in rocks)


@given(SEEDS)
def test_a_way_that_misses_all_rocks_by_a_look_meets_none(seed):
    rocks, rng = _rocks(seed), np.random.default_rng(seed + 1)
    tops = rock_tops(rocks, 1200.0)
    for a in rng.uniform((-1100, -1100, -600), (1100, 1100, 0), (100, 3)):
        b = a + rng.normal(0.0, 400.0, 3)
        if misses_rocks(tops, 1200.0, tuple(a), tuple(b)):
            assert all(ray_meets_rock(rock, 0.0, tuple(a), tuple(b)) == NEVER for rock in rocks)


def test_a_look_tells_places_far_from_stone_from_those_beside_it():
    rock = np.array([[100.0, -50.0, -400.0, 60.0, 40.0, 50.0, 0.4]])
    tops = rock_tops(rock, 1200.0)
    for gap in RANGES_CM:
        assert is_far_from_rocks(tops, 1200.0, (100.0, -50.0, 0.0), gap)
        assert is_far_from_rocks(tops, 1200.0, (-900.0, -50.0, -400.0), gap)
        assert not is_far_from_rocks(tops, 1200.0, (100.0, -50.0, -351.0 + 0.9 * gap), gap)
    assert misses_rocks(tops, 1200.0, (-900.0, -900.0, -400.0), (-900.0, 900.0, -400.0))
    assert not misses_rocks(tops, 1200.0, (-900.0, -50.0, -400.0), (900.0, -50.0, -400.0))
    # Nothing is known outside of the cells, nor of larger gaps.
    assert not is_far_from_rocks(tops, 1200.0, (1300.0, 0.0, -100.0), 1.0)
    assert not is_far_from_rocks(tops, 1200.0, (-900.0, 0.0, -100.0), RANGES_CM[-1] + 1.0)


def _landscape(seed):
    """A seabed with pillars, rocks and their skyline."""
    rng = np.random.default_rng(seed)
    rough = rng.uniform(-600.0, -450.0, (25, 25)).astype(np.float32)
    rough[rng.integers(25), rng.integers(25)] = -200.0
    low, high = (-1500, -1500, 5, -500), (1500, 1500, 150, -100)
    pillars = rng.uniform(low, high, (rng.integers(0, 4), 4))
    rocks = _rocks(seed)
    return rough, pillars, rocks, skyline_of(rough, 1200.0, pillars, rocks)


@given(SEEDS)
def test_a_way_over_the_skyline_meets_nothing(seed):
    heights, pillars, rocks, skyline = _landscape(seed)
    for a in np.random.default_rng(seed + 1).uniform(
        (-1100, -1100, -600), (1100, 1100, 0), (80, 3)
    ):
        for b in a + np.random.default_rng(seed + 2).normal(0.0, (400.0, 400.0, 150.0), (3, 3)):
            a, b = tuple(a), tuple(b)
            if not passes_over_all(skyline, 1200.0, a, b):
                continue
            assert all(ray_meets_pillar(pillar, 0.0, a, b) == NEVER for pillar in pillars)
            assert all(ray_meets_rock(rock, 0.0, a, b) == NEVER for rock in rocks)
            assert ray_meets_seabed(heights, 1200.0, 0.0, a, b) == NEVER


@given(SEEDS)
def test_nothing_is_within_reach_of_a_place_over_the_skyline(seed):
    heights, pillars, rocks, skyline = _landscape(seed)
    rng = np.random.default_rng(seed + 1)
    for p in rng.uniform((-1300, -1300, -600), (1300, 1300, 0), (80, 3)):
        reach = rng.uniform(0.0, 1.2 * REACHES_CM[-1])
        if not is_over_all(skyline, 1200.0, tuple(p), reach):
            continue
        way = rng.normal(size=(20, 3))
        for q in p + reach * way / np.linalg.norm(way, axis=1)[:, None]:
            assert all(from_pillar(pillar, tuple(q))[1] > 0.0 for pillar in pillars)
            assert all(from_rock(rock, tuple(q))[1] > 0.0 for rock in rocks)
            assert q[2] > height_at(heights, 1200.0, q[0], q[1])


def test_the_skyline_tells_open_water_from_what_is_beside_or_below_solids():
    level = np.full((25, 25), -500.0, np.float32)
    pillar = np.array([[600.0, 0.0, 50.0, -100.0]])
    rock = np.array([[-600.0, 0.0, -450.0, 60.0, 40.0, 80.0, 0.4]])
    skyline = skyline_of(level, 1200.0, pillar, rock)
    assert is_over_all(skyline, 1200.0, (0.0, 0.0, -400.0), 80.0)
    assert is_over_all(skyline, 1200.0, (-600.0, 0.0, -280.0), 80.0)
    for near in ((600.0, 100.0, -300.0), (-600.0, 0.0, -320.0), (0.0, 0.0, -430.0)):
        assert not is_over_all(skyline, 1200.0, near, 80.0)
    assert passes_over_all(skyline, 1200.0, (-600.0, -900.0, -360.0), (-600.0, 900.0, -360.0))
    assert passes_over_all(skyline, 1200.0, (100.0, -900.0, -480.0), (100.0, 900.0, -480.0))
    assert not passes_over_all(skyline, 1200.0, (-600.0, -900.0, -380.0), (-600.0, 900.0, -380.0))
    assert not passes_over_all(skyline, 1200.0, (100.0, -900.0, -480.0), (100.0, 900.0, -505.0))
    # Nothing is known outside of the cells, nor of larger reaches.
    assert not is_over_all(skyline, 1200.0, (1300.0, 0.0, -100.0), 1.0)
    assert not is_over_all(skyline, 1200.0, (0.0, 0.0, -100.0), REACHES_CM[-1] + 1.0)
    assert not passes_over_all(skyline, 1200.0, (1100.0, 0.0, -50.0), (1800.0, 0.0, -50.0))
