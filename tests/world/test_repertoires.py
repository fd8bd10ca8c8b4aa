"""Species and repertoires are read once, and again when their files change."""

import gc
import os
import shutil
import weakref
from pathlib import Path

import h5py
import numpy as np
import pytest

from subsea.base import disk_cache
from subsea.base.errors import UserError
from subsea.fish.species import repertoire_file
from subsea.repertoire import files
from subsea.repertoire.library import pack
from subsea.scenario.load import load_scenario
from subsea.world import repertoires
from subsea.world.build import create_world
from tests.support.scenes import BARE


@pytest.fixture
def path(tmp_path, monkeypatch):
    """A copy of a repertoire, beside an empty cache."""
    monkeypatch.setattr(disk_cache, "cache_folder", lambda: tmp_path / "kept")
    return Path(shutil.copy(repertoire_file("clownfish"), tmp_path / "clownfish.h5"))


def test_a_repertoire_is_cached_by_its_content(path, tmp_path):

    def read(stamp):  # a new stamp: not from memory
        return repertoires._repertoire(path, "clownfish", (stamp, 0))

    first = read(1)
    assert read(2).body_length_cm == first.body_length_cm
    assert len(list((tmp_path / "kept").iterdir())) == 1
    with h5py.File(path, "a") as file:
        file.attrs["body_length_cm"] = 1.25 * first.body_length_cm
    assert read(3).body_length_cm == pytest.approx(1.25 * first.body_length_cm)
    path.write_bytes(path.read_bytes()[:9000])
    with pytest.raises(UserError, match=str(path)):
        read(4)
    path.unlink()
    with pytest.raises(UserError, match="no such file"):
        read(5)


def test_a_repertoire_that_changes_while_being_read_is_not_cached(path, monkeypatch):
    whole, read = path.read_bytes(), files.read_repertoire

    def late(path):
        with h5py.File(path, "a") as file:
            file.attrs["body_length_cm"] = 1.25 * file.attrs["body_length_cm"]
        return read(path)

    monkeypatch.setattr(files, "read_repertoire", late)
    with pytest.raises(UserError, match="while it was read"):
        repertoires._repertoire(path, "clownfish", (1, 0))
    monkeypatch.setattr(files, "read_repertoire", read)
    path.write_bytes(whole)
    found = repertoires._repertoire(path, "clownfish", (2, 0))
    assert found.body_length_cm == read(path).body_length_cm


def test_pipes_are_not_read(path, tmp_path):
    path.unlink()
    os.mkfifo(path)  # opening it waits for a writer
    with pytest.raises(UserError, match=str(path)):
        repertoires._repertoire(path, "clownfish", (1, 0))
    assert not (tmp_path / "kept").exists()


def pack_of(scenario):
    """The library of a scenario, packed for itself."""
    known = [repertoires.repertoire_of(name) for name in scenario.species]
    skins = [repertoires.coupling_of(repertoires.species_of(one.species), one) for one in known]
    return pack(known, skins)


def test_worlds_of_the_same_species_share_their_motion(monkeypatch):
    scenario = load_scenario(str(BARE)).scenario
    one, two, lively = (create_world(scenario, 3, live=live) for live in (0, 0, 2))
    assert one.library.control_points is two.library.control_points
    rows = len(one.library.entry)
    packed = pack_of(scenario)
    mine, theirs = ([*one[:-3], *one.coupling, *one[-2:]] for one in (one.library, packed))
    for own, other in zip(mine, theirs, strict=True):
        np.testing.assert_array_equal(own, other)
    for name in repertoires.LIVE_ROWS:
        shared, own = getattr(one.library, name), getattr(lively.library, name)
        assert len(own) == rows + 4 and not np.shares_memory(shared, own)
        np.testing.assert_array_equal(own[:rows], shared)
        assert not own[rows:].any()
        if name in lively.state.live._fields:
            assert np.shares_memory(getattr(lively.state.live, name), own)
    monkeypatch.setattr(repertoires, "file_version", lambda path: path.stat().st_mtime_ns + 1)
    changed = create_world(scenario, 3).library
    assert changed.control_points is not one.library.control_points
    np.testing.assert_array_equal(changed.control_points, one.library.control_points)


def test_only_the_motion_of_the_last_species_is_kept():
    packed = weakref.ref(repertoires.motion_of(["clownfish"]).library.control_points)
    assert packed() is repertoires.motion_of(["clownfish"]).library.control_points
    repertoires.motion_of(["fusilier"])
    gc.collect()
    assert packed() is None
