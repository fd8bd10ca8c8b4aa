"""Levels of detail: monotone, with hysteresis, and cross-fades that share every pixel."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.view.levels import (
    FADE_S,
    HIDDEN,
    HYSTERESIS,
    LEVELS,
    SPECK,
    THRESHOLDS_PX,
    draw_order,
    empty_lod_state,
    thresholds_of,
    update_levels,
)

SIZES = st.floats(1.0, 1000.0)


def _level(pixels, memory, time_s=0.0, finer=False):
    pixels = np.atleast_1d(np.asarray(pixels, np.float32))
    update_levels(pixels, np.full(len(pixels), finer), THRESHOLDS_PX, time_s, memory)
    return memory.level.copy()


@given(st.lists(SIZES, min_size=2, max_size=20))
def test_nearer_is_never_coarser(sizes):
    """The level of fishes that come into sight is monotone in the projected size."""
    sizes = np.sort(sizes)[::-1]
    levels = _level(sizes, empty_lod_state(len(sizes))).astype(int)
    assert (np.diff(levels) >= 0).all()


def test_every_level_has_its_sizes():
    sizes = np.concatenate([[2 * THRESHOLDS_PX[0]], 0.99 * THRESHOLDS_PX])
    np.testing.assert_array_equal(_level(sizes, empty_lod_state(6)), range(len(LEVELS)))
    finer = _level(sizes, empty_lod_state(6), finer=True)
    np.testing.assert_array_equal(finer, [0, 0, 1, 2, 3, 4])


def test_without_dots_specks_are_the_smallest():
    with_dots, without = (thresholds_of(0.7, dots) for dots in (True, False))
    np.testing.assert_allclose(with_dots, THRESHOLDS_PX / 0.7)
    np.testing.assert_allclose(without, [*with_dots[:-1], 0.0])
    specks = np.full(20, 0.1)
    update_levels(specks, specks > 1.0, without, 0.0, memory := empty_lod_state(20))
    assert (memory.level == SPECK).all()


def test_a_level_changes_once_on_an_approach_and_a_retreat():
    """Levels change at HYSTERESIS beyond the threshold; sizes within that never change them."""
    for threshold in THRESHOLDS_PX:
        span = 1.0 + HYSTERESIS
        sizes = threshold * np.linspace(0.8, 1.25, 200)
        memory = empty_lod_state(1)
        up = [int(_level(size, memory, 10.0 * k)[0]) for k, size in enumerate(sizes)]
        down = [int(_level(size, memory, 1e4 + 10.0 * k)[0]) for k, size in enumerate(sizes[::-1])]
        assert up[0] - up[-1] == 1
        assert down[-1] - down[0] == 1
        assert sizes[np.argmax(np.diff(up) != 0)] == pytest.approx(threshold * span, rel=0.01)
        assert sizes[::-1][np.argmax(np.diff(down) != 0)] == pytest.approx(
            threshold / span, rel=0.01
        )


@given(st.lists(st.floats(0.95, 1.05), min_size=3, max_size=30))
def test_a_fish_that_hovers_about_a_threshold_keeps_its_level(shares):
    memory = empty_lod_state(1)
    seen = {int(_level(60.0 * share, memory, 5.0 * k)[0]) for k, share in enumerate(shares)}
    assert len(seen) == 1


def _drawn(memory, time_s, distance=None):
    n = len(memory.level)
    distance = np.ones(n, np.float32) if distance is None else distance
    fish, share, (starts,) = draw_order(distance[None], time_s, len(LEVELS), memory)
    return fish, share, starts


def test_a_fade_shares_the_pixels_between_both_levels():
    memory = empty_lod_state(1)
    _level(100.0, memory, 0.0)
    shares = []
    for k in range(7):
        time_s = 1.0 + 0.07 * k
        _level(100.0 if k == 0 else 40.0, memory, time_s)
        fish, share, starts = _drawn(memory, time_s)
        groups = np.repeat(np.arange(2 * len(LEVELS)), np.diff(starts))
        if len(fish) == 2:
            assert share.max() - share.min() == pytest.approx(1.0)  # f and f - 1
            # The new, coarse level comes first.
            np.testing.assert_array_equal(groups, 2 * len(LEVELS) - 1 - np.array([3, 2]))
            assert share[0] > 0 > share[1]
            shares.append(share[0])
        else:
            assert share[0] == 0
    assert len(shares) == 5
    assert (np.diff(shares) > 0).all()
    assert shares[-1] == pytest.approx(4 * 0.07 / FADE_S, abs=1e-5)


def test_no_change_begins_while_one_is_under_way():
    memory = empty_lod_state(1)
    _level(30.0, memory, 0.0)
    assert _level(70.0, memory, 1.0)[0] == 2
    assert _level(300.0, memory, 1.0 + 0.5 * FADE_S)[0] == 2
    assert _level(300.0, memory, 1.0 + 1.1 * FADE_S)[0] == 0
    assert memory.former[0] == 2


def test_a_fish_that_comes_into_sight_does_not_fade_in():
    memory = empty_lod_state(2)
    _level([100.0, -1.0], memory, 0.0)
    np.testing.assert_array_equal(memory.level, [2, HIDDEN])
    _level([-1.0, 30.0], memory, 1.0)
    np.testing.assert_array_equal(memory.level, [HIDDEN, 3])
    _level([300.0, 30.0], memory, 1.1)
    fish, share, _ = _drawn(memory, 1.1)
    np.testing.assert_array_equal(np.sort(fish), [0, 1])
    np.testing.assert_array_equal(share, 0)


@given(
    sizes=st.lists(st.floats(-50.0, 400.0), min_size=1, max_size=40), seed=st.integers(0, 99),
)  # fmt: skip
def test_groups_hold_their_levels_the_farthest_first(sizes, seed):
    rng = np.random.default_rng(seed)
    n = len(sizes)
    memory = empty_lod_state(n)
    _level(rng.uniform(5, 400, n), memory, 0.0)
    _level(sizes, memory, 1.0)
    distance = rng.uniform(10, 1000, n).astype(np.float32)
    fish, share, starts = _drawn(memory, 1.1, distance)
    assert starts[-1] == len(fish)
    for k in range(len(starts) - 1):
        group = fish[starts[k] : starts[k + 1]]
        assert (np.diff(distance[group]) <= 0).all()
        level = len(LEVELS) - 1 - k % len(LEVELS)
        fading = k >= len(LEVELS)
        assert level >= SPECK or ((share[starts[k] : starts[k + 1]] != 0) == fading).all()
        mine = np.where(
            share[starts[k] : starts[k + 1]] < 0, memory.former[group], memory.level[group]
        )
        assert (mine == level).all()
    visible = np.flatnonzero(memory.level != HIDDEN)
    np.testing.assert_array_equal(np.unique(fish), visible)


@given(
    sizes=st.lists(st.floats(5.0, 400.0), min_size=1, max_size=30), seed=st.integers(0, 99),
    views=st.integers(1, 4),
)  # fmt: skip
def test_each_view_has_its_own_fishes_at_the_level_that_is_common_to_all(sizes, seed, views):
    """Each view looks as if drawn alone, from a memory that has seen all views."""
    rng = np.random.default_rng(seed)
    n = len(sizes)
    distance = rng.uniform(10, 1000, (views, n)).astype(np.float32)
    distance[rng.uniform(size=distance.shape) < 0.5] = np.inf
    memory = empty_lod_state(n)
    for size in (rng.uniform(5, 400, n), np.asarray(sizes)):
        seen = np.isfinite(distance).any(axis=0)
        _level(np.where(seen, size, -1.0), memory, 1.0 if size is not sizes else 1.1)
    fish, share, starts = draw_order(distance, 1.1, len(LEVELS), memory)
    assert starts.shape == (views, 2 * len(LEVELS) + 1)
    assert starts[-1, -1] == len(fish) == len(share)
    for own, row in zip(starts, distance, strict=True):
        one_fish, one_share, (alone,) = draw_order(row[None], 1.1, len(LEVELS), memory)
        np.testing.assert_array_equal(own - own[0], alone)
        np.testing.assert_array_equal(fish[own[0] : own[-1]], one_fish)
        np.testing.assert_array_equal(share[own[0] : own[-1]], one_share)
        np.testing.assert_array_equal(np.unique(one_fish), np.flatnonzero(np.isfinite(row)))


def test_time_that_runs_back_ends_a_fade():
    memory = empty_lod_state(1)
    _level(100.0, memory, 5.0)
    _level(40.0, memory, 5.1)
    assert len(_drawn(memory, 5.2)[0]) == 2
    assert len(_drawn(memory, 0.0)[0]) == 1
