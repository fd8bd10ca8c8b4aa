"""Pictures and films taken during a dive: names, frames, and failing disks."""

import errno
import os
from datetime import datetime
from pathlib import Path

import av
import numpy as np
import pytest
from PIL import Image

from subsea.media import screenshots
from subsea.media.screenshots import FPS, MAX_GAP_S, ScreenCapture, pictures_folder

NOON = datetime(2026, 5, 4, 12, 3, 2)


@pytest.fixture
def camera(tmp_path):
    """ScreenCapture at noon into a folder that does not exist yet, and its messages."""
    told = []
    return ScreenCapture(tmp_path / "pictures" / "mine", told.append, lambda: NOON), told


def pixels(size=(64, 48), value=0):
    picture = np.zeros((size[1], size[0], 3), np.uint8)
    picture[: size[1] // 2, :, 0], picture[..., 1] = 250, value
    return picture


def decoded(path):
    with av.open(str(path)) as container:
        assert container.streams.video[0].average_rate == FPS
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]


def test_pictures_have_the_date_for_a_name_and_never_replace_another(camera, tmp_path):
    taken, told = camera
    for value in (10, 20, 30):
        taken.picture(pixels(value=value))
    folder = tmp_path / "pictures" / "mine"
    stem = "subsea-2026-05-04-120302"
    names = [f"{stem}.png", f"{stem}-2.png", f"{stem}-3.png"]
    assert sorted(path.name for path in folder.iterdir()) == sorted(names)
    assert told == [f"picture: {folder / name}" for name in names]
    for name, value in zip(names, (10, 20, 30), strict=True):
        assert np.array_equal(np.asarray(Image.open(folder / name)), pixels(value=value))


def test_a_film_lasts_as_long_as_the_dive_did_however_fast_that_was(camera, tmp_path):
    taken, told = camera
    taken.frame(pixels(), 0.1)  # before the film
    taken.film((65, 49))
    assert taken.filming
    times = [0.5, 0.1, 0.1, 0.005, 0.005, 0.005, 0.085, 10.0]  # the first is before it began
    for k, elapsed in enumerate(times):
        taken.frame(pixels((65, 49), 25 * k), elapsed)
    taken.film((65, 49))
    assert not taken.filming
    [path] = (tmp_path / "pictures" / "mine").iterdir()
    frames = decoded(path)
    assert frames[0].shape == (48, 64, 3)
    assert len(frames) == 1 + int((0.3 + MAX_GAP_S) * FPS + 1e-6)
    assert frames[0][5, 5, 0] > 200 > 50 > frames[0][-5, 5, 0]
    assert told == [f"filming: {path}", f"film of {len(frames) / FPS:.1f} s: {path}"]
    green = [int(frame[30:, :, 1].mean()) for frame in (frames[2], frames[8])]
    assert green[0] < green[1]  # pictures in order


def test_a_window_that_changes_its_size_ends_the_film(camera, tmp_path):
    taken, told = camera
    taken.film((64, 48))
    taken.frame(pixels(), 0.1)
    taken.frame(pixels(), 0.1)
    taken.frame(pixels((80, 48)), 0.1)
    assert not taken.filming
    assert "size of the window changed" in told[-1]
    [path] = (tmp_path / "pictures" / "mine").iterdir()
    assert len(decoded(path)) == 4
    taken.film((1, 1))
    assert not taken.filming
    assert "too small" in told[-1]


def test_the_end_of_a_dive_leaves_a_valid_film(camera, tmp_path):
    taken, told = camera
    taken.film((64, 48))
    taken.frame(pixels(), 0.1)
    taken.end()
    taken.end()
    [path] = (tmp_path / "pictures" / "mine").iterdir()
    assert len(decoded(path)) == 1
    path.unlink()
    taken.film((64, 48))
    taken.end()
    assert "before the first picture" in told[-1]
    assert not list(tmp_path.glob("**/*.mp4"))


def test_a_folder_that_cannot_be_made_is_one_line_and_the_dive_goes_on(tmp_path):
    told = []
    (tmp_path / "file").write_text("no folder")
    taken = ScreenCapture(tmp_path / "file" / "pictures", told.append)
    taken.picture(pixels())
    taken.film((64, 48))
    taken.frame(pixels(), 0.1)
    taken.end()
    assert not taken.filming
    assert len(told) == 2
    assert all(str(tmp_path) in line and "\n" not in line for line in told)


def test_a_full_disk_is_one_line_and_leaves_no_part_of_a_file(camera, tmp_path, monkeypatch):
    taken, told = camera

    def full(*unused, **ignored):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    taken.film((64, 48))
    taken.frame(pixels(), 0.1)
    monkeypatch.setattr(taken, "_write", full)
    taken.frame(pixels(), 0.1)
    assert not taken.filming
    taken.frame(pixels(), 0.1)
    with monkeypatch.context() as patch:
        patch.setattr(Image.Image, "save", full)
        taken.picture(pixels())
    assert [line.count("No space left on device") for line in told] == [0, 1, 1]
    assert not (tmp_path / "pictures").exists()
    taken.picture(pixels())
    assert told[-1].startswith("picture: ")


def test_where_pictures_go(monkeypatch, tmp_path):
    assert pictures_folder("/somewhere/else") == Path("/somewhere/else")
    assert pictures_folder("~/here") == Path.home() / "here"
    monkeypatch.setattr(screenshots.platformdirs, "user_pictures_path", lambda: tmp_path)
    assert pictures_folder() == tmp_path / "subsea"
