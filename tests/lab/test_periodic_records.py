"""Records of a box with periodic sides: whole paths, and measures of nearest images."""

import h5py
import numpy as np
import pytest

import subsea
from subsea.geometry.periodic import shortest
from subsea.lab.measures import overlaps
from subsea.lab.schooling import schooling
from subsea.lab.simulate import record_world
from subsea.lab.tracks import FlatView, convert
from subsea.scenario.load import load_scenario
from subsea.submarine.vessel import NEUTRAL
from subsea.world.build import create_world
from subsea.world.step import step
from tests.support.records import a_record, still
from tests.support.scenes import BOX, SCHOOL, SIDE


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """A record of a school that leaves the box at the corner."""
    out = tmp_path_factory.mktemp("box") / "run.h5"
    loaded = load_scenario(BOX, [*SCHOOL, "fish.0.position_cm=[500, 500, -250]"])
    world = create_world(loaded.scenario, seed=2)
    with record_world(world, loaded, out, force=False):
        for _ in range(60):
            step(world, NEUTRAL)
    return out


def test_a_record_has_whole_paths_and_the_period(path):
    record = subsea.open_record(path)
    assert record.period.tolist() == [SIDE, SIDE]
    with h5py.File(path) as file:
        assert file.attrs["period_x_cm"] == file.attrs["period_y_cm"] == SIDE
        velocity = file["fish/velocity"][:]
    for places in (record.position, record.snout, record.tail, record.centre):
        assert np.abs(np.diff(places, axis=0)).max() < 15.0
    assert (np.linalg.norm(record.snout - record.tail, axis=2) < 1.1 * record.length).all()
    assert (record.position[-1] > SIDE / 2).any()  # beyond the side
    ways = np.diff(record.position, axis=0) / record.tick_s
    assert ways == pytest.approx(velocity[1:], abs=0.5)


def test_measures_of_a_school_across_the_seams_are_those_of_one_in_the_middle(path):
    """Some of its fishes are a period away from the others."""
    record = subsea.open_record(path)
    apart = SIDE * (np.arange(24) % 3 - 1)[:, None] * [1.0, 0.0, 0.0]
    (found,) = schooling(_shifted(record, apart))
    way = record.position - record.position[:, :1]
    alone = _shifted(record, shortest(way, record.period) - way)
    (expected,) = schooling(alone._replace(period=np.zeros(2)))
    assert (found.together == expected.together).all()
    for name in ("nearest_bl", "rotation", "height_bl", "ahead_bl", "room_bl3"):
        assert getattr(found, name) == pytest.approx(getattr(expected, name), rel=1e-2), name
    assert found.sector == pytest.approx(expected.sector, abs=0.01)
    whole = subsea.measure(path)
    assert whole["sea"]["out_of_bounds_or_inside"] == 0


def _shifted(record, way):
    """Shift the places of a record by a way (n, 3) or (T, n, 3); they keep the type of a file."""
    names = ("position", "snout", "tail", "centre")
    return record._replace(**{name: np.float32(getattr(record, name) + way) for name in names})


def test_bodies_overlap_across_a_seam():
    apart = [[505.0, 0.0, -200.0], [-505.0, 1.0, -200.0], [0.0, 300.0, -200.0]]
    record = a_record(still(2, *apart))
    assert not overlaps(record).any()
    assert overlaps(record._replace(period=np.full(2, SIDE))).tolist() == [[2, 2, 0]] * 2


def test_tracks_go_on_beyond_the_sides_and_pixels_do_not(path, tmp_path):
    record = subsea.open_record(path)
    tracks = record.to_movement()
    assert tracks.attrs["period_x_cm"] == SIDE
    assert tracks.position.max() > SIDE / 2
    convert(record, "idtrackerai", tmp_path / "tracks.h5", FlatView())
    with h5py.File(tmp_path / "tracks.h5") as file:
        places = file["trajectories"][:] - record.radius_cm
    assert np.abs(places).max() < SIDE / 2 + 20.0
