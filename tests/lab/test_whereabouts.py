"""Heights over the ground and time near the surface."""

import numpy as np
import pytest

from subsea.lab.whereabouts import joined, whereabouts
from tests.support.records import LENGTH, a_record


def slope():
    """A seabed that rises from 500 cm deep in the west to 300 cm in the east."""
    return np.tile(np.linspace(-500.0, -300.0, 3, dtype=np.float32), (3, 1))


def test_heights_are_over_the_ground_below_in_body_lengths():
    place = np.array([[[-800.0, 0, -400]], [[-800.0, 0, -400]], [[0.0, 0, -300]], [[0.0, 0, -300]]])
    (found,) = whereabouts(a_record(place, heights=slope())).values()
    assert found.height_bl == pytest.approx([100 / LENGTH, 100 / LENGTH])
    assert found.shallow == (0.0, 2.0)


def test_time_near_the_surface_is_that_less_deep_than_half_a_length():
    deep = np.array([-9.0, -9.0, -11.0, -11.0, -200.0, -200.0])
    place = np.zeros((6, 2, 3))
    place[:, 0, 2], place[:, 1, 2] = deep, -5.0
    alive = np.ones((6, 2), bool)
    alive[:, 1] = False
    names = {"species": np.array([0, 1], np.uint8), "species_names": ["ray", "gone"]}
    found = whereabouts(a_record(place, alive=alive, **names))
    assert list(found) == ["ray"]
    assert found["ray"].shallow == (1.0, 3.0)
    both = joined([found["ray"], found["ray"]])
    assert both.shallow == (2.0, 6.0)
    assert len(both.height_bl) == 6
