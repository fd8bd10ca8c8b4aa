"""Compare the grid with all pairs."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.geometry.periodic import shortest
from subsea.perception.grid import REACH_CM, find_neighbours, grid_of
from subsea.scenario.school_rules import USUAL
from subsea.state import NEIGHBOURS, Fishes, Minds, empty


def _find(who, fishes, minds):
    for kind in np.unique(fishes.species):
        find_neighbours(who[fishes.species[who] == kind], fishes, minds, grid_of(fishes, kind))


def _all_pairs(fishes, reach):
    """Reference: sort all fishes by distance of the nearest image, then by index."""
    out = np.full((len(fishes.species), NEIGHBOURS), -1)
    p = fishes.position.astype(np.float64)
    for i in range(len(p)):
        d = (shortest(p - p[i], fishes.period) ** 2).sum(axis=1)
        near = [
            j
            for j in np.lexsort((np.arange(len(p)), d))
            if j != i and d[j] < reach**2 and fishes.species[j] == fishes.species[i]
        ]
        out[i, : len(near[:NEIGHBOURS])] = near[:NEIGHBOURS]
    return out


@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(0, 120),
    spread=st.sampled_from([1.0, 100.0, 800.0]),
)
def test_the_grid_finds_what_all_pairs_find(seed, n, spread):
    rng = np.random.default_rng(seed)
    fishes, minds = empty(Fishes, n=n), empty(Minds, n=n, b=1, d=1)
    # rounded places make equal distances, to test the order
    fishes.position[:] = np.round(rng.normal(0, spread, (n, 3)))
    fishes.species[:] = rng.integers(0, 2, n)
    _find(np.arange(n), fishes, minds)
    np.testing.assert_array_equal(minds.neighbour, _all_pairs(fishes, REACH_CM))


@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(0, 120),
    period=st.tuples(*[st.sampled_from([256.0, 300.0, 1000.0])] * 2),
)
def test_the_grid_of_a_box_finds_the_nearest_images(seed, n, period):
    """Fishes are anywhere in the box, and half of them near a seam; none finds itself."""
    rng = np.random.default_rng(seed)
    fishes, minds = empty(Fishes, n=n), empty(Minds, n=n, b=1, d=1)
    fishes.period[:] = period
    fishes.position[:, :2] = np.round(rng.uniform(-0.5, 0.5, (n, 2)) * period)
    near = rng.uniform(0, 1, n) < 0.5
    fishes.position[near, 0] = np.sign(fishes.position[near, 0]) * (period[0] / 2 - 1.0)
    fishes.position[:, 2] = np.round(rng.uniform(-100, 0, n))
    fishes.species[:] = rng.integers(0, 2, n)
    _find(np.arange(n), fishes, minds)
    np.testing.assert_array_equal(minds.neighbour, _all_pairs(fishes, REACH_CM))


@pytest.mark.parametrize("n", [0, 1])
def test_a_single_fish_has_no_neighbours(n):
    fishes, minds = empty(Fishes, n=n), empty(Minds, n=n, b=1, d=1)
    _find(np.arange(n), fishes, minds)
    assert (minds.neighbour == -1).all()


@given(seed=st.integers(0, 2**32 - 1), stride=st.integers(1, 5))
def test_fishes_that_do_not_think_keep_their_neighbours(seed, stride):
    rng = np.random.default_rng(seed)
    fishes, minds = empty(Fishes, n=40), empty(Minds, n=40, b=1, d=1)
    fishes.position[:] = rng.normal(0, 60, (40, 3))
    minds.neighbour[:] = 7
    seen = _all_pairs(fishes, REACH_CM)
    for first in range(stride):
        _find(np.arange(first, 40, stride), fishes, minds)
        turn = np.arange(40) % stride <= first
        np.testing.assert_array_equal(minds.neighbour[turn], seen[turn])
        assert (minds.neighbour[~turn] == 7).all()


def test_fishes_that_school_look_farther():
    fishes, minds = empty(Fishes, n=3), empty(Minds, n=3, b=1, d=1)
    fishes.length[:] = 20.0
    reach = USUAL.sight_bl * 20.0
    fishes.position[1, 0], fishes.position[2, 0] = reach - 1.0, 2.0 * reach
    minds.schools[0] = True
    _find(np.arange(3), fishes, minds)
    assert minds.neighbour[:, 0].tolist() == [1, -1, -1]
