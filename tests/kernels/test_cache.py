"""Compiled code is not older than the code that it calls."""

import os
import pickle
import sys
from pathlib import Path

import pytest

from subsea.base.source_stamp import ROOT, source_stamp
from subsea.behavior.steering import ease_goals
from subsea.kernels import cache
from subsea.kernels.cache import KernelCache, VerifiedFile


def _write(folder: Path, **files: str) -> None:
    for name, text in files.items():
        file = folder / "subsea" / f"{name}.py"
        file.parent.mkdir(exist_ok=True)
        file.write_text(text, encoding="utf-8")


def _project(tmp_path: Path, name: str, **changed: str) -> str:
    """The stamp of a.py, which imports b.py, which imports c.py; nobody imports d.py."""
    folder = tmp_path / name
    folder.mkdir()
    files = {
        "a": "from subsea.b import (\n    x,\n    y,\n)\n",
        "b": "import math\nfrom subsea import c\n",
        "c": "from subsea.a import z\nK = 1\n",
        "d": "K = 1\n",
    }
    _write(folder, **(files | changed))
    return source_stamp(folder / "subsea" / "a.py", folder)


def test_a_change_of_anything_imported_changes_the_stamp(tmp_path):
    before = _project(tmp_path, "before")
    assert _project(tmp_path, "same") == before
    assert _project(tmp_path, "far", c="from subsea.a import z\nK = 2\n") != before
    assert _project(tmp_path, "unrelated", d="K = 2\n") == before


def test_kernels_are_kept_by_that_stamp():
    file = ROOT / "subsea" / "behavior" / "steering.py"
    assert ease_goals._cache._impl.locator.get_source_stamp() == source_stamp(file)
    assert isinstance(ease_goals._cache._cache_file, VerifiedFile)


def test_a_kernel_that_is_not_called_reads_nothing(monkeypatch):
    stamps = []
    monkeypatch.setattr(cache, "source_stamp", stamps.append)
    kernel_cache = KernelCache(ease_goals.py_func)
    assert not stamps
    assert kernel_cache._cache_file is not None
    assert stamps


def test_code_that_does_not_match_its_index_is_not_taken(tmp_path, monkeypatch):
    def file(stamp):
        return VerifiedFile(str(tmp_path), "kernel", stamp)

    def full(*unused):
        raise OSError("no room")

    file("old").save("key", "old code")
    assert file("old").load("key") == "old code"
    with monkeypatch.context() as patched, pytest.raises(OSError, match="no room"):
        patched.setattr(VerifiedFile, "_save_data", full)
        file("new").save("key", "new code")
    assert file("new").load("key") is None
    file("new").save("key", "new code")
    assert file("new").load("key") == "new code"
    one, other = file("new"), file("new")
    both = {"one": "kernel.2.nbc", "other": "kernel.2.nbc"}  # as two write it who begin at once
    one._save_index(both)
    other.save("other", "code of the other")
    assert one.load("one") is None
    assert one.load("other") == "code of the other"


def test_damaged_files_are_compiled_anew(tmp_path):
    file = VerifiedFile(str(tmp_path), "kernel", "stamp")
    for length in (0, 9):
        for suffix in (".nbi", ".nbc"):
            file.save("key", "code")
            for part in tmp_path.glob(f"*{suffix}"):
                part.write_bytes(part.read_bytes()[:length])
            assert file.load("key") is None
            file.save("key", "code")
            assert file.load("key") == "code"
    for at in range(3, 200, 7):
        (part,) = tmp_path.glob("*.nbc")
        code = bytearray(part.read_bytes())
        if at < len(code):
            code[at] ^= 255
            part.write_bytes(code)
            assert file.load("key") is None
            file.save("key", "code")


def test_code_of_another_numba_is_not_taken(tmp_path):
    file = VerifiedFile(str(tmp_path), "kernel", "stamp")
    file._version = "0.60"
    file.save("key", "code")
    index = file._load_index()
    file._version = "0.68"
    file._save_index(index)
    assert file.load("key") is None


class Ends:
    def __reduce__(self):
        return sys.exit, (7,)


@pytest.mark.parametrize("suffix", [".nbi", ".nbc"])
def test_a_pipe_and_a_file_that_ends_the_program_count_as_missing(tmp_path, suffix):
    file = VerifiedFile(str(tmp_path), "kernel", "stamp")
    file.save("key", "code")
    (part,) = tmp_path.glob(f"*{suffix}")
    part.write_bytes(pickle.dumps(Ends()))
    assert file.load("key") is None
    part.unlink()
    os.mkfifo(part)
    assert file.load("key") is None
    file.save("key", "code")
    assert file.load("key") == "code"


@pytest.mark.parametrize("suffix", [".nbi", ".nbc"])
def test_a_file_that_others_may_write_is_not_read(tmp_path, suffix):
    file = VerifiedFile(str(tmp_path), "kernel", "stamp")
    file.save("key", "code")
    (part,) = tmp_path.glob(f"*{suffix}")
    part.chmod(0o666)
    assert file.load("key") is None


def test_a_folder_that_others_may_write_is_not_used(tmp_path, monkeypatch):
    monkeypatch.setattr(cache.caching.config, "CACHE_DIR", str(tmp_path))
    place = Path(KernelCache(_write).cache_path)
    assert place.parent == tmp_path and place.stat().st_mode & 0o777 == 0o700
    place.chmod(0o777)
    cache._make_folder.cache_clear()
    assert Path(KernelCache(_write).cache_path).parent != tmp_path


@pytest.mark.parametrize("mask", [0, 0o002])
def test_code_is_for_the_user_alone_whatever_the_umask(tmp_path, mask):
    file = VerifiedFile(str(tmp_path), "kernel", "stamp")
    before = os.umask(mask)
    try:
        file.save("key", "code")
    finally:
        os.umask(before)
    assert {path.stat().st_mode & 0o777 for path in tmp_path.iterdir()} == {0o600}
    assert file.load("key") == "code"
