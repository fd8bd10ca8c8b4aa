"""Pictures and films during a dive by real keys, and diagrams in its window."""

import re
from contextlib import closing

import av
import msgspec
import numpy as np
import pytest
from PIL import Image

from subsea.core.resources import resource_path
from subsea.dive.settings import PictureSettings, Settings
from subsea.frame.diagrams import DIAGRAMS
from subsea.ui.dive import Dive
from tests.support.windows import dive_options

SIZE = (322, 241)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("pictures") / "of mine"


@pytest.fixture(scope="module")
def boat(display, folder, tmp_path_factory):
    text = (resource_path("assets/scenarios") / "peaceful.toml").read_text()
    quiet = tmp_path_factory.mktemp("sea") / "quiet.toml"
    quiet.write_text(re.sub(r"^number = \d+", "number = 3", text, flags=re.MULTILINE))
    settings = msgspec.structs.replace(Settings(), pictures=PictureSettings(folder=str(folder)))
    with closing(Dive(dive_options(quiet, SIZE, settings=settings))) as running:
        running.frame(0.1)
        yield running


def test_a_key_takes_what_the_screen_shows(boat, hands, folder, capsys):
    hands.do("key", "F12")
    hands.until(boat, lambda: list(folder.glob("*.png")))
    [path] = folder.glob("*.png")
    picture = np.asarray(Image.open(path)).astype(int)
    assert picture.shape == (SIZE[1], SIZE[0], 3)
    now = hands.screen(boat)
    assert np.abs(picture - now).mean() < 12.0  # as on the display, a few ticks later
    assert np.abs(picture[::-1] - now).mean() > 20.0
    assert f"picture: {path}" in capsys.readouterr().err


def test_a_key_films_until_it_is_pressed_again(boat, hands, folder, capsys):
    hands.do("key", "F10")
    hands.until(boat, lambda: boat.filming)
    assert not list(folder.glob("*.mp4"))  # appears only when complete
    hands.glide(boat, 1.0)
    hands.do("key", "F10")
    hands.until(boat, lambda: not boat.filming)
    [path] = folder.glob("*.mp4")
    with av.open(str(path)) as container:
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
    assert frames[0].shape == (240, 322, 3)
    assert len(frames) >= 30
    assert np.abs(frames[0].astype(int) - frames[-1]).max() > 20
    assert np.abs(frames[-1].astype(int) - hands.screen(boat)[:240]).mean() < 14.0
    told = capsys.readouterr().err
    assert f"filming: {path}" in told
    assert re.search(rf"film of \d+\.\d s: {re.escape(str(path))}", told)


def test_a_folder_that_cannot_be_written_is_told_and_the_dive_goes_on(boat, hands, folder, capsys):
    for path in folder.iterdir():
        path.unlink()
    folder.rmdir()
    folder.write_text("in the way")
    try:
        hands.do("key", "F12")
        hands.do("key", "F10")
        told = ""

        def both():
            nonlocal told
            told += capsys.readouterr().err
            return len(told.splitlines()) >= 2

        hands.until(boat, both)
    finally:
        folder.unlink()
    assert told.count("of mine") == 2
    assert boat.window_set.open
    tick = boat.world.state.tick
    hands.glide(boat, 0.2)
    assert boat.world.state.tick > tick


def test_diagrams_and_their_labels_are_over_the_picture(boat, hands):
    def settled():
        boat.frame(0.0)
        boat.frame(0.0)
        return hands.screen(boat)

    bare = settled()
    boat.picture.diagrams |= {*DIAGRAMS} - {"indices"}
    lines = settled()
    boat.picture.diagrams.add("indices")
    labels = settled()
    boat.picture.diagrams.clear()
    boat.picture.wireframe = True
    edges = settled()
    boat.picture.wireframe = False
    assert (np.abs(lines - bare).max(axis=2) > 60).mean() > 0.02
    lettered = np.abs(labels - lines).max(axis=2) > 60
    assert 10 < lettered.sum() < 0.05 * lettered.size
    assert (np.abs(edges - bare).max(axis=2) > 30).mean() > 0.05
    assert np.abs(settled() - bare).mean() < 2.0


def test_a_key_switches_the_lights_and_time_that_goes_back_switches_them_too(boat, hands):
    lights = boat.world.state.submarine.lights
    hands.glide(boat, 1.5)
    off = hands.screen(boat)
    hands.do("key", "b")
    hands.until(boat, lambda: lights[0])
    boat.frame(0.0)
    boat.frame(0.0)
    assert (hands.screen(boat) - off).mean() > 1.0
    hands.glide(boat, 0.2)
    boat.run_command("rewind")
    hands.glide(boat, 0.1)
    assert not lights[0]
    boat.run_command("lights")
    assert lights[0]
    boat.run_command("lights")
    assert not lights[0]


def test_closing_the_dive_leaves_a_valid_film(boat, hands, folder):
    boat.run_command("film")
    hands.glide(boat, 0.3)
    boat.close()
    [path] = folder.glob("*.mp4")
    with av.open(str(path)) as container:
        assert len([*container.decode(video=0)]) >= 3
