"""Species and repertoires are read once, and again when their files change."""

import os
import shutil
from pathlib import Path

import h5py
import pytest

from subsea.core import disk_cache
from subsea.core.errors import UserError
from subsea.fish.species import repertoire_file
from subsea.repertoire import files
from subsea.world import repertoires


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


def test_huge_files_and_pipes_are_not_read_completely(path, tmp_path):
    with path.open("r+b") as file:
        file.truncate(1 << 40)  # sparse: a digest would take an hour
    assert repertoires._repertoire(path, "clownfish", (1, 0)).species == "clownfish"
    path.unlink()
    os.mkfifo(path)  # opening it waits for a writer
    with pytest.raises(UserError, match=str(path)):
        repertoires._repertoire(path, "clownfish", (2, 0))
    assert not (tmp_path / "kept").exists()
