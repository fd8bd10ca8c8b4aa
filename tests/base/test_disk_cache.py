"""Cached results equal computed ones, or are computed again."""

import importlib.util
import lzma
import os
import pickle
import sys
import zlib

import numpy as np
import pytest

from subsea.base import disk_cache
from subsea.base import files as own_files
from subsea.base.arrays import pack
from subsea.base.disk_cache import cached
from subsea.habitat.reef import grow_reefs
from subsea.habitat.sea import make_sea
from subsea.habitat.seaweed import plant_seaweed
from subsea.scenario.load import load_scenario

CODE = """
import numpy as np
made = []
def squares(n, power=2):
    made.append(n)
    row = np.arange(n, dtype=np.float32) ** power
    return [row, row, "text"]
"""


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    monkeypatch.setattr(disk_cache, "cache_folder", lambda: tmp_path / "kept")
    return tmp_path / "kept"


@pytest.fixture
def module(tmp_path):
    def load(code):
        folder = tmp_path / f"code{len(list(tmp_path.iterdir()))}"
        folder.mkdir()
        (folder / "maker.py").write_text(code)
        spec = importlib.util.spec_from_file_location("maker", folder / "maker.py")
        loaded = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(loaded)
        return loaded

    return load


def assert_squares(found):
    np.testing.assert_array_equal(found[0], np.arange(5, dtype=np.float32) ** 2)
    assert found[0].dtype == np.float32
    assert found[0] is found[1]  # parts stay shared
    assert found[2] == "text"


def set_age(file, seconds_ago):
    there = file.stat()
    os.utime(file, (there.st_atime, there.st_mtime - seconds_ago))


def test_a_result_is_computed_once(module, place):
    maker = module(CODE)
    for _ in range(3):
        assert_squares(cached(maker.squares, 5))
    assert maker.made == [5]
    assert len(list(place.iterdir())) == 1  # and nothing half-written beside it


def test_other_arguments_or_code_compute_it_again(module):
    maker = module(CODE)
    cached(maker.squares, 5)
    assert cached(maker.squares, 5, power=3)[0][2] == 8.0
    assert len(cached(maker.squares, 6)[0]) == 6
    assert maker.made == [5, 5, 6]
    other = module(CODE.replace("** power", "** power + 1"))
    assert cached(other.squares, 5)[0][2] == 5.0


@pytest.mark.parametrize("n", [5, 300_000])
def test_cached_arrays_are_independent_copies(module, place, n):
    maker = module(CODE)
    cached(maker.squares, n)
    for _ in range(2):
        row = cached(maker.squares, n)[0]
        assert row[2] == 4.0 and len(row) == n
        assert row.flags.aligned and row.ctypes.data % 16 == 0
        row[:] = 0.0
    assert maker.made == [n]
    row = cached(maker.squares, n)[0]
    (file,) = place.iterdir()
    with file.open("r+b") as harmed:  # in place, not as a new file of this name
        harmed.write(b"\xff" * file.stat().st_size)
    np.testing.assert_array_equal(row, np.arange(n, dtype=np.float32) ** 2)


def test_equal_arguments_have_equal_names(module):
    maker, row = module(CODE), np.arange(4.0)
    same = disk_cache.cache_name(maker.squares, [row, row])
    assert disk_cache.cache_name(maker.squares, [row, row.copy()]) == same
    assert disk_cache.cache_name(maker.squares, [row, row + 1.0]) != same


def test_damaged_files_are_computed_again(module, place):
    maker = module(CODE)
    cached(maker.squares, 5)
    (file,) = place.iterdir()
    flipped = bytearray(file.read_bytes())
    flipped[len(flipped) // 2] ^= 0x40
    for number, damaged in enumerate((b"", file.read_bytes()[:-7], flipped, b"no pickle"), start=2):
        file.write_bytes(damaged)
        assert_squares(cached(maker.squares, 5))
        assert_squares(cached(maker.squares, 5))
        assert maker.made == [5] * number


def test_without_a_folder_it_is_computed_each_time(module, place):
    place.write_text("a file, where a folder should be")
    maker = module(CODE)
    for _ in range(2):
        assert_squares(cached(maker.squares, 5))
    assert maker.made == [5, 5]


def test_a_read_only_cache_is_used(module, monkeypatch):
    maker = module(CODE)
    cached(maker.squares, 5)

    def refuse(path):
        raise PermissionError(path)

    monkeypatch.setattr(os, "utime", refuse)
    assert_squares(cached(maker.squares, 5))
    assert maker.made == [5]


def test_the_least_recently_used_file_is_deleted(module, place, monkeypatch):
    maker = module(CODE)
    cached(maker.squares, 1000)
    (first,) = place.iterdir()
    monkeypatch.setattr(disk_cache, "MAX_BYTES", 3 * first.stat().st_size + 99)
    for age, n in ((50, 1001), (40, 1002)):
        before = set(place.iterdir())
        cached(maker.squares, n)
        (new,) = set(place.iterdir()) - before
        set_age(new, age)
    set_age(first, 60)
    cached(maker.squares, 1000)  # used again: now the one of 1001 is the oldest
    cached(maker.squares, 1003)
    maker.made.clear()
    for n in (1000, 1002, 1003, 1001):
        cached(maker.squares, n)
    assert maker.made == [1001]


def test_partial_files_are_deleted_first(module, place, monkeypatch):
    maker = module(CODE)
    cached(maker.squares, 1000)
    (whole,) = place.iterdir()
    part = place / ".squares.pickle.1.part"
    part.write_bytes(whole.read_bytes())
    set_age(part, 60)
    monkeypatch.setattr(disk_cache, "MAX_BYTES", int(2.5 * whole.stat().st_size))
    cached(maker.squares, 1001)
    assert not part.exists() and whole.exists()


def test_a_cached_reef_equals_a_grown_one():
    scenario = load_scenario("peaceful").scenario
    sea = make_sea(scenario, np.random.default_rng(1))[0]
    seen = []
    for _ in range(2):
        reefed, reef = grow_reefs(scenario, sea)
        planted, seaweed = plant_seaweed(scenario, reefed, reef, 1)
        seen.append([*planted, *reef, *seaweed])
    assert len(reef.place) > 100 and len(seaweed.node) > 100
    np.testing.assert_array_equal(planted.plankton, sea.plankton)
    for made, found in zip(*seen, strict=True):
        np.testing.assert_array_equal(made, found)
        assert np.asarray(made).dtype == np.asarray(found).dtype


ASKING = """
from typing import NamedTuple
import numpy as np
from numpy.typing import NDArray
made = []
class Part(NamedTuple):
    row: NDArray[np.float32]
    number: int
def part(n: int) -> Part | None:
    made.append(n)
    return Part(np.asfortranarray(np.ones((2, n), np.float32)), n) if n else None
"""


def test_a_result_has_the_annotated_type(module):
    maker = module(ASKING)
    for _ in range(2):
        found = cached(maker.part, 3)
        assert type(found) is maker.Part and found.number == 3
        assert found.row.shape == (2, 3) and found.row.flags.f_contiguous
        assert cached(maker.part, 0) is None
    assert maker.made == [3, 0]


@pytest.mark.parametrize(
    "other", [[], {"row": [1.0], "number": 3}, (np.ones(3), 3), (np.ones(3, np.float32), "3"), None]
)
def test_a_file_with_another_content_counts_as_missing(module, place, other):
    maker = module(ASKING)
    cached(maker.part, 3)
    (file,) = place.iterdir()
    name = file.stem if other is not None else "of another result"
    file.write_bytes(pack(name, other))
    for _ in range(2):
        assert cached(maker.part, 3).number == 3
    assert maker.made == [3, 3]


def test_reading_executes_nothing(module, place):
    class Ends:
        def __reduce__(self):
            return sys.exit, (7,)

    maker = module(CODE)
    cached(maker.squares, 5)
    (file,) = place.iterdir()
    # As earlier versions wrote them: checksum, sizes, a pickle.
    sizes, head = pickle.dumps([len(pickle.dumps(Ends()))]), pickle.dumps(Ends())
    start = bytes(4) + len(sizes).to_bytes(4) + sizes
    data = bytearray(start + bytes(-len(start) % 64) + head)
    data += bytes(-len(data) % 64)
    data[:4] = zlib.crc32(data[4:]).to_bytes(4)
    file.write_bytes(data)
    assert_squares(cached(maker.squares, 5))


def test_a_pipe_counts_as_missing(module, place):
    maker = module(CODE)
    cached(maker.squares, 5)
    (file,) = place.iterdir()
    file.unlink()
    os.mkfifo(file)
    for _ in range(2):
        assert_squares(cached(maker.squares, 5))
    assert maker.made == [5, 5, 5] and not file.is_file()  # only files are replaced


def test_a_new_folder_is_for_the_user_alone(module, place):
    cached(module(CODE).squares, 5)
    assert place.stat().st_mode & 0o777 == 0o700


def change_owner(monkeypatch):
    monkeypatch.setattr(os, "geteuid", lambda: 12345)


@pytest.mark.parametrize("mode", [0o777, 0o770, None])
def test_a_folder_that_others_may_write_is_not_used(module, place, monkeypatch, capsys, mode):
    maker = module(CODE)
    cached(maker.squares, 5)
    (file,) = place.iterdir()
    monkeypatch.setattr(own_files, "_is_private", lambda group: False)
    if mode is None:
        change_owner(monkeypatch)
    else:
        place.chmod(mode)
    before = file.stat().st_mtime_ns
    for _ in range(2):
        assert_squares(cached(maker.squares, 5))
    assert maker.made == [5, 5, 5]
    assert file.stat().st_mtime_ns == before
    assert capsys.readouterr().err.count(str(place)) == 1


def test_a_file_that_others_may_write_is_replaced(module, place):
    maker = module(CODE)
    cached(maker.squares, 5)
    (file,) = place.iterdir()
    file.chmod(0o666)
    for _ in range(2):
        assert_squares(cached(maker.squares, 5))
    assert maker.made == [5, 5]


def test_the_group_of_the_user_alone_may_write(module, place, monkeypatch):
    maker = module(CODE)
    cached(maker.squares, 5)
    monkeypatch.setattr(own_files, "_is_private", lambda group: True)
    place.chmod(0o770)
    assert_squares(cached(maker.squares, 5))
    assert maker.made == [5]


@pytest.fixture
def shipped(tmp_path, monkeypatch, module, place):
    """A function whose result is shipped, and the file of that."""
    squares = module(CODE).squares
    cached(squares, 5, 2)
    [kept] = place.iterdir()
    file = tmp_path / "shipped" / kept.with_suffix(".xz").name
    file.parent.mkdir()
    file.write_bytes(lzma.compress(kept.read_bytes()))
    kept.unlink()
    monkeypatch.setattr(disk_cache, "SHIPPED", file.parent)
    return squares, file


def test_a_shipped_result_is_not_kept_and_a_damaged_one_is_made_again(shipped, place):
    squares, file = shipped
    assert_squares(cached(squares, 5, 2))
    assert not list(place.iterdir())
    for content in (b"", file.read_bytes()[:-1], lzma.compress(b"other")):
        file.write_bytes(content)
        assert_squares(cached(squares, 5, 2))
        [made] = place.iterdir()
        made.unlink()


def test_a_shipped_result_needs_no_folder_of_the_user(shipped, tmp_path, monkeypatch, capsys):
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setattr(disk_cache, "cache_folder", lambda: tmp_path / "file" / "kept")
    assert_squares(cached(shipped[0], 5, 2))
    assert not capsys.readouterr().err


@pytest.mark.parametrize("mask", [0, 0o002])
def test_files_are_for_the_user_alone_whatever_the_umask(module, place, mask):
    maker = module(CODE)
    before = os.umask(mask)
    try:
        for _ in range(2):
            assert_squares(cached(maker.squares, 5))
    finally:
        os.umask(before)
    assert maker.made == [5]
    assert [path.stat().st_mode & 0o777 for path in place.iterdir()] == [0o600]


def test_what_is_remembered_can_be_forgotten():
    made = []

    def make():
        made.append(len(made))
        return made[-1]

    assert [disk_cache.remembered("a name of this test", make) for _ in range(2)] == [0, 0]
    disk_cache.forget()
    assert disk_cache.remembered("a name of this test", make) == 1
