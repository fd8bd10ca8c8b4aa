"""Fish-ticks out of bounds."""

import numpy as np
import pytest

from subsea.lab.measures import outside
from tests.support.records import TICK_S, a_record


def test_the_snout_outside_the_wall_counts():
    """The snout reaches 8 cm ahead of a fish that crosses the wall for three of ten ticks."""
    x = np.full((10, 2), 400.0)
    x[4:7, 1] = 497.0
    place = np.stack([x, 0 * x, 0 * x - 200.0], axis=2)
    species = np.array([0, 1], np.uint8)
    names = {"species": species, "species_names": ["a", "b"]}
    first, second = outside(a_record(place, **names))
    assert (first.outside, first.deepest_cm, first.longest_s) == (0, 0.0, 0.0)
    assert (second.species, second.fish_ticks, second.outside) == ("b", 10, 3)
    assert second.deepest_cm == pytest.approx(5.0, abs=0.01)
    assert (second.barrier, second.longest_s) == ("wall", pytest.approx(3 * TICK_S))
