"""What is kept on the disk is what would be made, or it is made anew."""

import importlib.util
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from subsea.core import disk_cache
from subsea.core.disk_cache import cached
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
def place(tmp_path, monkeypatch) -> Iterator[Path]:
    monkeypatch.setattr(disk_cache, "cache_folder", lambda: tmp_path / "kept")
    yield tmp_path / "kept"


@pytest.fixture
def module(tmp_path) -> Callable[[str], ModuleType]:
    def load(code: str) -> ModuleType:
        folder = tmp_path / f"code{len(list(tmp_path.iterdir()))}"
        folder.mkdir()
        (folder / "maker.py").write_text(code)
        spec = importlib.util.spec_from_file_location("maker", folder / "maker.py")
        loaded = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(loaded)
        return loaded

    return load


def _same(found: list[object]) -> None:
    np.testing.assert_array_equal(found[0], np.arange(5, dtype=np.float32) ** 2)
    assert found[0].dtype == np.float32
    assert found[0] is found[1]  # what is shared stays shared
    assert found[2] == "text"


def _used(file: Path, seconds_ago: float) -> None:
    there = file.stat()
    os.utime(file, (there.st_atime, there.st_mtime - seconds_ago))


def test_a_thing_is_made_once(module, place):
    maker = module(CODE)
    for _ in range(3):
        _same(cached(maker.squares, 5))
    assert maker.made == [5]
    assert len(list(place.iterdir())) == 1  # and nothing half-written beside it


def test_other_arguments_and_other_code_make_it_anew(module):
    maker = module(CODE)
    cached(maker.squares, 5)
    assert cached(maker.squares, 5, power=3)[0][2] == 8.0
    assert len(cached(maker.squares, 6)[0]) == 6
    assert maker.made == [5, 5, 6]
    other = module(CODE.replace("** power", "** power + 1"))
    assert cached(other.squares, 5)[0][2] == 5.0


@pytest.mark.parametrize("n", [5, 300_000])
def test_what_is_read_is_one_s_own(module, place, n):
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


def test_equal_arguments_are_the_same_whatever_they_share(module):
    maker, row = module(CODE), np.arange(4.0)
    same = disk_cache.cache_name(maker.squares, [row, row])
    assert disk_cache.cache_name(maker.squares, [row, row.copy()]) == same
    assert disk_cache.cache_name(maker.squares, [row, row + 1.0]) != same


@pytest.mark.parametrize("harm", ["empty", "short", "flipped", "other"])
def test_what_is_damaged_is_made_anew(module, place, harm):
    maker = module(CODE)
    cached(maker.squares, 5)
    (file,) = place.iterdir()
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 0x40
    cut = {"empty": b"", "short": data[:-7], "flipped": data, "other": b"not at all a pickle"}
    file.write_bytes(cut[harm])
    _same(cached(maker.squares, 5))
    _same(cached(maker.squares, 5))
    assert maker.made == [5, 5]


def test_where_nothing_can_be_written_it_is_made_each_time(module, place):
    place.write_text("a file, where a folder should be")
    maker = module(CODE)
    for _ in range(2):
        _same(cached(maker.squares, 5))
    assert maker.made == [5, 5]


def test_what_can_only_be_read_is_read(module, monkeypatch):
    maker = module(CODE)
    cached(maker.squares, 5)

    def refuse(path: Path) -> None:
        raise PermissionError(path)

    monkeypatch.setattr(os, "utime", refuse)
    _same(cached(maker.squares, 5))
    assert maker.made == [5]


def test_what_was_not_used_for_longest_makes_room(module, place, monkeypatch):
    maker = module(CODE)
    cached(maker.squares, 1000)
    (first,) = place.iterdir()
    monkeypatch.setattr(disk_cache, "MAX_BYTES", 3 * first.stat().st_size + 99)
    for age, n in ((50, 1001), (40, 1002)):
        before = set(place.iterdir())
        cached(maker.squares, n)
        (new,) = set(place.iterdir()) - before
        _used(new, age)
    _used(first, 60)
    cached(maker.squares, 1000)  # used again: now the one of 1001 is the oldest
    cached(maker.squares, 1003)
    maker.made.clear()
    for n in (1000, 1002, 1003, 1001):
        cached(maker.squares, n)
    assert maker.made == [1001]


def test_what_was_cut_off_while_it_was_written_makes_room(module, place, monkeypatch):
    maker = module(CODE)
    cached(maker.squares, 1000)
    (whole,) = place.iterdir()
    part = place / ".squares.pickle.1.part"
    part.write_bytes(whole.read_bytes())
    _used(part, 60)
    monkeypatch.setattr(disk_cache, "MAX_BYTES", int(2.5 * whole.stat().st_size))
    cached(maker.squares, 1001)
    assert not part.exists() and whole.exists()


def test_a_reef_from_the_disk_is_the_reef_that_grew():
    scenario, _ = load_scenario("peaceful")
    sea = make_sea(scenario, np.random.default_rng(1))
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
