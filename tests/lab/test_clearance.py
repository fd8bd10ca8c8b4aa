"""Clearance from bounds and obstacles."""

import numpy as np
import pytest

from subsea.habitat.contact import clearances as solid_clearances
from subsea.lab.measures import BARRIERS, clearances
from tests.support.records import a_record, still

PILLARS = np.array([[0.0, 0.0, 30.0, -150.0]])
ROCKS = np.array([[100.0, -300.0, -300.0, 30.0, 60.0, 30.0, np.pi / 2]])
NONE = {"pillars": np.zeros((0, 4)), "rocks": np.zeros((0, 7))}


PLACES = [
    ((480.0, 0.0, -200.0), 500.0 - 488.0, "wall"),  # the snout reaches 8 cm ahead
    ((495.0, 0.0, -200.0), -3.0, "wall"),
    ((-490.0, 0.0, -200.0), -2.0, "wall"),  # the tail 12 cm behind
    ((0.0, 0.0, -5.0), 5.0, "surface"),
    ((0.0, 0.0, -403.0), -3.0, "seabed"),
    ((100.0, -300.0, -390.0), 10.0, "seabed"),
    ((0.0, 70.0, -200.0), 40.0, "pillar"),
    ((0.0, 20.0, -200.0), -10.0, "pillar"),
    ((0.0, 0.0, -140.0), 10.0, "pillar"),  # above its top
    ((30.0, 40.0, -140.0), 17.09, "pillar"),  # beside its top, from the tail at (18, 40)
    ((112.0, -260.0, -300.0), 10.0, "rock"),  # abreast of the shorter half axis, 30 cm
    ((150.0, -300.0, -300.0), -22.0, "rock"),  # the tail, inside the longer one, 60 cm
]


def test_clearance_is_the_least_of_snout_middle_and_tail():
    for place, clearance, barrier in PLACES:
        solids = {"pillars": PILLARS, "rocks": ROCKS} if barrier in ("pillar", "rock") else NONE
        found, which = clearances(a_record(still(2, place), **solids))
        assert found == pytest.approx(clearance, abs=0.1), place
        assert (which == BARRIERS.index(barrier)).all(), place


def test_a_study_measures_the_distances_that_fishes_perceive():
    """Also for oblique points, where a rock's distance has several approximations."""
    rng = np.random.default_rng(3)
    places = rng.uniform((40.0, -380.0, -380.0), (160.0, -220.0, -220.0), (40, 3))
    record = a_record(places[None], rocks=ROCKS)
    found, which = clearances(record)
    bodies = np.stack([record.snout[0], record.position[0], record.tail[0]], axis=1)
    no_pillars = np.zeros((0, 4))
    perceived = np.array([solid_clearances(no_pillars, ROCKS, body).min() for body in bodies])
    rock = which[0] == BARRIERS.index("rock")
    assert rock.sum() > 20
    assert found[0, rock] == pytest.approx(perceived[rock], abs=1e-3)
    assert (perceived[~rock] >= found[0, ~rock]).all()


def test_dead_fishes_have_no_clearance():
    record = a_record(still(2, (0, 0, 50)), alive=np.zeros((2, 1), bool))
    assert np.isinf(clearances(record)[0]).all()
