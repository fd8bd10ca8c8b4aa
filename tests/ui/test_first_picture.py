"""The first picture of a dive: kept once, and shown when the same dive begins again."""

import numpy as np
import pytest

from subsea.base import disk_cache
from subsea.base.system import resource_path
from subsea.dive import start
from subsea.ui.dive import Dive
from subsea.ui.first_picture import COMPILED, MOST_PX, FirstPicture, LoadingBar, picture_name
from subsea.ui.open_windows import open_windows
from tests.support.windows import dive_options

SIZE = (320, 240)


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setattr(disk_cache, "cache_folder", lambda: tmp_path / "cache")


def picture(height=90, width=160):
    """Brighter to the right and to the top."""
    y, x = np.mgrid[0:height, 0:width]
    return np.stack([255 * x // width, 255 * (height - y) // height, 0 * x], axis=2).astype("u1")


def test_it_is_kept_by_its_name():
    first = FirstPicture("first_picture-a")
    assert not first.known
    first.keep(picture())
    assert FirstPicture("first_picture-a").known
    assert not FirstPicture("first_picture-b").known


def test_a_picture_of_an_earlier_version_is_replaced():
    FirstPicture("first_picture-a").keep(picture())
    FirstPicture("first_picture-a").keep(255 - picture())
    np.testing.assert_array_equal(FirstPicture("first_picture-a")._pixels, 255 - picture())


def test_before_there_is_one_the_picture_beside_the_scenario_shows_the_place(tmp_path):
    place = resource_path("assets/scenarios/peaceful.toml")
    first = FirstPicture("first_picture-a", place, 4 / 3)
    assert first.known and first._pixels.shape == (480, MOST_PX, 3) and first._pixels.std() > 5.0
    assert not FirstPicture("first_picture-a").known  # it is not kept as the first one
    assert not FirstPicture("", tmp_path / "none.toml").known
    first.keep(picture())
    again = FirstPicture("first_picture-a", place)
    np.testing.assert_array_equal(again._pixels, picture())


def test_the_bar_fills_and_never_goes_back():
    bar, shares = LoadingBar(), []
    for line in (
        "loading", "compiling: 0/2", "compiling: 1/2", "compiling: 2/2", "reading repertoires",
        "letting the fishes in", "unknown", "starting OpenGL", "reading repertoires",
    ):  # fmt: skip
        bar.follow(line)
        shares.append(bar.share)
    assert shares == sorted(shares) and shares[0] >= 0.0 and shares[-1] <= 1.0
    assert shares[2] > 0.3 and shares[3] >= COMPILED and shares[-1] > COMPILED + 0.1


def test_a_large_one_is_kept_smaller():
    first = FirstPicture("first_picture-a")
    first.keep(picture(1080, 1920))
    assert FirstPicture("first_picture-a")._pixels.shape == (360, MOST_PX, 3)


def test_a_damaged_one_counts_as_missing(tmp_path):
    FirstPicture("first_picture-a").keep(picture())
    (path,) = (tmp_path / "cache").iterdir()
    path.write_bytes(path.read_bytes()[:-100])
    assert not FirstPicture("first_picture-a").known


def test_a_fault_while_loading_is_raised(display, quiet, monkeypatch):
    def fail(tell):
        raise OSError("disk full")

    monkeypatch.setattr(start, "warm_up", fail)
    with pytest.raises(OSError, match="disk full"):
        Dive(dive_options(quiet, SIZE))


def test_its_name_depends_on_all_that_changes_the_picture(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text("a = 1")
    names = [picture_name(path, (), (1,)), picture_name(path, (), (2,))]
    names.append(picture_name(path, ("fish.0.number=3",), (1,)))
    path.write_text("a = 2")
    names.append(picture_name(path, (), (1,)))
    assert len({*names}) == 4 and picture_name(path, (), (1,)) == names[3]


def test_the_window_shows_it_at_once_with_the_text_at_its_foot(display, user):
    FirstPicture("first_picture-a").keep(picture())
    first = FirstPicture("first_picture-a")
    opening = open_windows("mono", SIZE, first=first)
    seen = []
    opening.window_set.present, present = (
        lambda: seen.append(opening.window_set.picture().astype(int)),
        opening.window_set.present,
    )
    opening.show("reading repertoires")
    opening.window_set.present = present
    opening.close()
    (shown,) = seen
    assert shown[20, -10, 0] > 200 > 60 > shown[20, 10, 0]  # brighter to the right
    assert shown[10, 100, 1] > shown[180, 100, 1] + 60  # and to the top
    letters = shown.min(axis=2) > 140
    rows = np.flatnonzero(letters.any(axis=1))
    assert len(rows) and rows.min() > 0.8 * SIZE[1]
