"""The tree of boxes around all fishes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.geometry.vector import ZERO
from subsea.perception.crowd import (
    FASTEST,
    HIGH,
    LARGEST,
    LOW,
    RADIUS,
    SLOWEST,
    WIDE,
    Path,
    U,
    X,
    crowd_of,
    find_meetings,
    place_of,
    radius_of,
    room_for,
)
from subsea.perception.vision import along_body
from subsea.state import NOBODY

SEEDS = st.integers(0, 2**32 - 1)
NUMBERS = (0, 1, 7, 8, 9, 64, 65, 520)


def school(tank, seed, n):
    """Make n fishes of several sizes and speeds; every ninth is dead."""
    rng, t = np.random.default_rng(seed), tank(max(n, 1))
    fishes = t.fishes
    fishes.alive[:] = np.arange(max(n, 1)) % 9 < (8 if n else 0)
    fishes.length[:] = rng.choice([8.0, 20.0, 120.0], max(n, 1))
    fishes.position[:] = rng.normal((0, 0, -300), (200, 60, 40), (max(n, 1), 3))
    fishes.velocity[:] = rng.normal(0, 40, (max(n, 1), 3))
    return fishes


def met(crowd, path):
    slots = room_for(crowd)
    row, count = find_meetings(crowd, path, slots)
    return slots[row, :count]


@given(SEEDS, st.sampled_from(NUMBERS))
def test_a_search_finds_all_whose_way_comes_near_and_nobody_else(tank, seed, n):
    fishes = school(tank, seed, n)
    crowd, rng = crowd_of(fishes), np.random.default_rng(seed + 1)
    living = np.flatnonzero(fishes.alive)
    middles = np.array([along_body(fishes, i, 0.5) for i in living]).reshape(-1, 3)
    radii = np.array([radius_of(fishes, i) for i in living])
    for lasts in (0.0, 0.5, 3.0):
        here = rng.normal((0, 0, -300), (200, 60, 40))
        velocity = rng.normal(0, 30, 3).astype(np.float32)
        found = met(crowd, Path(tuple(here), tuple(velocity), 25.0, lasts))
        gaps, drift = middles - here, fishes.velocity[living].astype(float) - velocity
        closest = np.clip(-(gaps * drift).sum(1) / (drift**2).sum(1), 0.0, lasts)
        apart = np.linalg.norm(gaps + closest[:, None] * drift, axis=1) - radii - 25.0
        assert abs(apart).min(initial=1.0) > 1e-6  # rounding decides nothing
        assert sorted(crowd.member[found]) == list(living[apart < 0.0])
        for slot in found:
            np.testing.assert_array_equal(
                place_of(crowd, slot), along_body(fishes, crowd.member[slot], 0.5)
            )


@pytest.mark.parametrize("n", NUMBERS)
def test_each_living_fish_has_one_slot_within_the_boxes_above_it(tank, n):
    fishes = school(tank, 3, n)
    crowd = crowd_of(fishes)
    members = crowd.member[crowd.member != NOBODY]
    assert sorted(members) == list(np.flatnonzero(fishes.alive))
    assert len(crowd.box) == crowd.first[-1]
    for slot in np.flatnonzero(crowd.member != NOBODY):
        body, node = crowd.fish[slot // WIDE, :, slot % WIDE], slot // WIDE
        for level in range(len(crowd.first) - 1):
            box = crowd.box[crowd.first[level] + node // WIDE, :, node % WIDE]
            assert (box[LOW:HIGH] <= body[X:U]).all()
            assert (body[X:U] <= box[HIGH:SLOWEST]).all()
            assert (box[SLOWEST:FASTEST] <= body[U:RADIUS]).all()
            assert (body[U:RADIUS] <= box[FASTEST:LARGEST]).all()
            assert body[RADIUS] <= box[LARGEST]
            node //= WIDE


def test_a_search_in_a_school_looks_at_few_of_its_fishes(tank):
    """The boxes are tight: those of a place meet few blocks of eight."""
    t = tank(4096)
    grid = np.stack(np.meshgrid(*3 * [np.arange(16.0)], indexing="ij"), -1).reshape(-1, 3)
    order = np.random.default_rng(0).permutation(4096)
    t.fishes.position[:] = 30.0 * grid[order] - (225.0, 225.0, 600.0)
    crowd = crowd_of(t.fishes)
    reach = 20.0 + radius_of(t.fishes, 0)
    boxes, middle = crowd.box[: crowd.first[1]], np.array([[0.0], [0.0], [-375.0]])
    low, high = boxes[:, LOW:HIGH], boxes[:, HIGH:SLOWEST]
    gap = np.maximum(np.maximum(low - middle, middle - high), 0.0)
    blocks = ((gap**2).sum(axis=1) < reach**2).sum()
    near = len(met(crowd, Path(tuple(np.float32([0.0, 0.0, -375.0])), ZERO, 20.0, 0.0)))
    assert near > 0
    assert blocks <= 16


def test_in_a_box_images_are_found_beyond_its_sides(tank):
    t = tank(2)
    t.fishes.period[:] = 1000.0
    t.fishes.position[:] = (490.0, 0.0, -300.0), (0.0, 0.0, -300.0)
    crowd = crowd_of(t.fishes)
    found = met(crowd, Path(tuple(np.float32([-480.0, 0.0, -300.0])), ZERO, 60.0, 0.0))
    assert list(crowd.member[found]) == [0]
    assert place_of(crowd, found[0])[0] < -500.0
