"""Input files are regular files; pipes and devices are refused before they are opened."""

import errno
import fcntl
import os
from pathlib import Path

import pytest

from subsea.base import hdf5
from subsea.base.errors import TransientError, UserError
from subsea.base.files import check_input, read_input
from subsea.base.toml_files import load_toml
from subsea.dive.settings import read_settings, settings_path, usual_settings
from subsea.export.obj import read_mesh
from subsea.fish import color_sheet
from subsea.fish.species import load_species
from subsea.lab.benchmark_reports import read_reports
from subsea.media.eye_frames import _frames_in
from subsea.media.film import NAME, missing_frames
from subsea.media.record import read_record
from subsea.repertoire import read_repertoire
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Scenario
from subsea.scenario.storage import held
from subsea.stage.cluster.keys import read_keys
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.mesh_formats import read_warp
from subsea.stage.theatre.mpcdi import read_mpcdi
from subsea.studio.draft import changed_on_disk, read_draft
from subsea.studio.dress import load_mesh
from subsea.studio.photograph import Photograph, read_photograph

READERS = {
    "toml": lambda path: load_toml(path, Scenario),
    "scenario": lambda path: load_scenario(str(path)),
    "species": lambda path: load_species(str(path)),
    "draft": read_draft,
    "theatre": lambda path: load_theatre(str(path)),
    "settings": read_settings,
    "record": read_record,
    "repertoire": read_repertoire,
    "format": hdf5.format_of,
    "report": read_reports,
    "mesh": read_mesh,
    "meshes": lambda path: load_mesh(path, PHOTOGRAPH, load_species("clownfish")),
    "photograph": read_photograph,
    "sheet": color_sheet.read,
    "warp": lambda path: read_warp(path.with_suffix(".pfm"), (64, 48)),
    "archive": read_mpcdi,
    "keys": lambda path: read_keys(path.parent, "any", []),
}
PHOTOGRAPH = Photograph(Path("fish.png"), color_sheet.np.zeros((120, 160, 3), "u1"), None)


@pytest.fixture
def pipe(tmp_path):
    """A pipe that nobody writes to, under all names that readers look for."""
    path = tmp_path / "any.toml"
    os.mkfifo(path)
    for name in ("any.pfm", "any.key_secret", NAME, "frame_00000.png"):
        (tmp_path / name).symlink_to(path)
    return path


@pytest.mark.parametrize("reader", READERS)
def test_every_reader_refuses_a_pipe(pipe, reader):
    with pytest.raises(UserError, match=r"any\.\w+: not a regular file"):
        READERS[reader](pipe)


def test_readers_that_forgive_do_not_wait_for_a_pipe(pipe, monkeypatch):
    assert held(pipe) == b""
    assert not changed_on_disk(pipe, None)
    assert _frames_in(pipe, {}) == 0
    with pytest.raises(UserError, match="damaged, cannot tell"):
        missing_frames(pipe.parent, {}, [""], 1)
    lines = []
    monkeypatch.setenv("XDG_CONFIG_HOME", str(pipe.parent))
    settings_path().parent.mkdir(parents=True, exist_ok=True)
    settings_path().symlink_to(pipe)
    usual_settings(lines.append)
    assert lines == [f"{settings_path()}: not a regular file; the defaults are used"]


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("/dev/zero", "not a regular file"),
        ("/tmp", "cannot read (it is a folder)"),
        ("/nowhere/x", "no such file"),
        ("/proc/kmsg", "not a regular file"),
        ("/proc/self/status", "not a regular file"),
        ("a" * 300, "cannot read (File name too long)"),
        ("a\0b", "cannot read (embedded null byte)"),
    ],
)
def test_what_is_no_file_is_one_line(path, said):
    with pytest.raises(UserError) as fault:
        check_input(Path(path))
    assert fault.value.message == said


def test_content_is_read_up_to_the_limit(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"x" * 2**20)
    assert check_input(path) == len(read_input(path, 2**20)) == 2**20
    path.write_bytes(b"x" * (2**20 + 1))
    with pytest.raises(UserError, match="larger than 1 MiB, expected a smaller file"):
        read_input(path, 2**20)


def test_a_name_that_becomes_a_pipe_is_refused(tmp_path, monkeypatch):
    path, other = tmp_path / "file", tmp_path / "other"
    other.write_text("x")
    os.mkfifo(path)
    before = other.stat()
    monkeypatch.setattr(Path, "stat", lambda self: before)
    with pytest.raises(UserError, match="not a regular file"):
        read_input(path)


def test_an_empty_file_is_a_file(tmp_path):
    (tmp_path / "file").touch()
    assert check_input(tmp_path / "file") == 0


def test_a_file_system_without_locks_is_read(tmp_path, monkeypatch):
    path = tmp_path / "file.h5"
    with hdf5.writing(path) as file:
        file.attrs["format"] = hdf5.text("a")
    with path.open("rb") as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        with pytest.raises(TransientError, match="another program has locked it to write to it"):
            hdf5.format_of(path)

        def none(*given):
            raise OSError(errno.ENOLCK, "No locks available")

        monkeypatch.setattr(fcntl, "flock", none)
        monkeypatch.setenv("HDF5_USE_FILE_LOCKING", "TRUE")
        assert hdf5.format_of(path) == "a"
