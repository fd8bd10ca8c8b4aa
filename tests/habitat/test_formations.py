"""Drawn stone lies within what the fishes avoid, and corals find places on it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.habitat.contact import clearances
from subsea.habitat.formations import (
    RELIEF_CM,
    SHELL_CM,
    blocks_of,
    drawn_distance,
    formations,
    numbered_formations,
    outward,
    plain_distance,
    rough_distance,
    stone_above,
)
from subsea.habitat.stone import openness, passes, samples, shade_distance, shade_of

NO_PILLARS, NO_ROCKS = np.zeros((0, 4)), np.zeros((0, 7))
SIZE = st.floats(15.0, 150.0)
PILLAR = np.array([[30.0, -20.0, 55.0, -250.0]])


def rock(x=0.0, y=0.0, z=-500.0, a=80.0, b=60.0, c=50.0, yaw=0.4):
    return np.array([[x, y, z, a, b, c, yaw]])


@given(SIZE, SIZE, SIZE, st.floats(-3, 3), st.floats(-120, 120), st.integers(0, 2**32 - 1))
def test_drawn_stone_lies_inside_the_avoided_solids(a, b, c, yaw, apart, seed):
    rocks = np.concatenate([rock(a=a, b=b, c=c, yaw=yaw), rock(x=apart, y=30.0, z=-470.0)])
    places = np.random.default_rng(seed).uniform(-300, 300, (400, 3)) + (0, 0, -490)
    drawn = np.min(
        [[drawn_distance(f, tuple(p)) for p in places] for f in formations(NO_PILLARS, rocks)],
        axis=0,
    )
    avoided = clearances(NO_PILLARS, rocks, places)
    assert (avoided[drawn <= 0.0] < 0.0).all()
    # And it is not much thicker: a fish does not shy from open water.
    assert (drawn[avoided < -SHELL_CM - RELIEF_CM - 1.0] < 0.0).all()


def test_a_pillar_is_drawn_inside_its_cylinder():
    places = np.random.default_rng(1).uniform(-90, 90, (4000, 3)) + (30.0, -20.0, -280.0)
    (blocks,) = formations(PILLAR, NO_ROCKS)
    drawn = np.array([drawn_distance(blocks, tuple(p)) for p in places])
    assert (clearances(PILLAR, NO_ROCKS, places)[drawn <= 0.0] < 0.0).all()
    assert (drawn <= 0.0).mean() > 0.03


def test_solids_that_overlap_are_one_formation():
    rocks = np.concatenate([rock(), rock(x=110.0), rock(x=220.0), rock(x=600.0)])
    sizes = sorted(len(f) for f in formations(NO_PILLARS, rocks))
    assert sizes == [1, 3]
    beside = np.array([[340.0, 0.0, 60.0, -400.0]])
    assert sorted(len(f) for f in formations(beside, rocks)) == [1, 4]


def test_blocks_go_over_into_each_other_without_a_crease():
    rocks = np.concatenate([rock(yaw=0.0), rock(x=120.0, yaw=0.0)])
    (blocks,) = formations(NO_PILLARS, rocks)
    alone = blocks_of(NO_PILLARS, rocks[:1])
    joint = (60.0, 0.0, -470.0)  # as far from both
    assert plain_distance(blocks, joint)[0] < plain_distance(alone, joint)[0] - 1.0
    far = (-60.0, 0.0, -470.0)
    assert plain_distance(blocks, far)[0] == pytest.approx(plain_distance(alone, far)[0], abs=0.1)


def test_samples_lie_on_stone_with_their_normals_outward():
    rocks = np.concatenate([rock(), rock(x=90.0, z=-470.0), rock(x=700.0, a=40.0, b=40.0, c=40.0)])
    found = samples(PILLAR, rocks, 20.0)
    stones = formations(PILLAR, rocks)
    assert len(found.place) > 100
    assert {*found.stone} == set(range(1 + len(rocks)))
    formation = [
        next(k for k, (_, own) in enumerate(numbered_formations(PILLAR, rocks)) if stone in own)
        for stone in found.stone
    ]
    gaps = np.array(
        [
            [drawn_distance(stones[k], tuple(p + step * n)) for step in (0.0, 3.0)]
            for p, n, k in zip(found.place, found.normal, formation, strict=True)
        ]
    )
    assert np.abs(gaps[:, 0]).max() < 2.0
    assert (gaps[:, 1] > 1.0).mean() > 0.95  # but in a crack the other wall is near
    np.testing.assert_allclose(np.linalg.norm(found.normal, axis=1), 1.0)
    assert ((found.open >= 0.0) & (found.open <= 1.0)).all()


def test_samples_are_even():
    """A small sphere and a large one have places in proportion to their surface."""
    rocks = np.concatenate([rock(a=40, b=40, c=40), rock(x=500.0, a=120, b=120, c=120)])
    found = samples(NO_PILLARS, rocks, 60.0)
    stones = formations(NO_PILLARS, rocks)
    areas = np.array([4 * np.pi * (s[0, 3] - s[0, 8] - 0.4 * s[0, 9]) ** 2 / 1e4 for s in stones])
    np.testing.assert_allclose(np.bincount(found.stone) / areas / 60.0, 1.0, atol=0.5)


def test_a_roof_takes_the_light():
    roof = np.concatenate([rock(z=-300.0, a=200.0, b=200.0, c=30.0), rock(z=-500.0)])
    blocks = blocks_of(NO_PILLARS, roof)
    alone, under = shade_of(blocks[1:]), shade_of(blocks)
    up = np.array([[0.0, 0.0, 1.0]])
    top = np.array([[0.0, 0.0, -445.0]])
    assert openness(alone, top, up)[0] == pytest.approx(1.0)
    assert openness(under, top, up)[0] < 0.5
    assert passes(under, (0.0, 0.0, -445.0), (0.0, 0.0, 1.0), 0.2) < 0.15


def test_the_top_of_a_vertical_line_in_stone_is_on_the_surface():
    (blocks,) = formations(NO_PILLARS, rock())
    z = stone_above(blocks, 10.0, 5.0, -500.0)
    assert abs(drawn_distance(blocks, (10.0, 5.0, z))) < 1.5
    assert outward(blocks, (10.0, 5.0, z))[0][2] > 0.0
    assert stone_above(blocks, 300.0, 0.0, -500.0) == -500.0


def test_the_grid_for_light_has_the_distances():
    (blocks,) = formations(PILLAR, np.concatenate([rock(), rock(x=90.0, z=-470.0)]))
    shade = shade_of(blocks)
    for p in np.random.default_rng(4).uniform((-90, -90, -560), (180, 90, -230), (300, 3)):
        exact = rough_distance(blocks, tuple(p))
        if exact > -10.0:  # deep inside it has creases, and nobody asks
            assert shade_distance(shade, tuple(p)) == pytest.approx(exact, abs=6.0)
    # Beyond the grid it grows with the distance from it.
    assert shade_distance(shade, (2000.0, 0.0, -450.0)) > 1500.0


def test_samples_of_a_pillar_are_all_over_its_stem():
    found = samples(PILLAR, NO_ROCKS, 20.0)
    depth = PILLAR[0, 3] - found.place[:, 2]
    counts, _ = np.histogram(depth, np.linspace(60.0, 660.0, 7))
    assert counts.min() > 0.6 * counts.mean()
    assert (found.normal[depth < 45.0, 2] > 0.3).any()
