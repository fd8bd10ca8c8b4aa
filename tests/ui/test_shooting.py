"""Pictures and films during a dive by real keys, and diagrams in its window."""

import re
from contextlib import closing

import av
import msgspec
import numpy as np
import pytest
from PIL import Image

from subsea.dive.settings import PictureSettings, Settings
from subsea.frame.diagrams import DIAGRAMS
from subsea.ui.dive import Dive
from subsea.world import snapshot
from subsea.world.feeding import PINCH
from tests.support.windows import dive_options

SIZE = (322, 241)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("pictures") / "of mine"


@pytest.fixture(scope="module")
def boat(display, folder, quiet):
    settings = msgspec.structs.replace(Settings(), pictures=PictureSettings(folder=str(folder)))
    with closing(Dive(dive_options(quiet, SIZE, settings=settings))) as running:
        running.overlay.hide_help()  # pictures do not show it
        running.overlay.help_opacity, running.overlay.hud.mode = 0.0, "never"
        running.frame(0.1)
        yield running


@pytest.fixture(scope="module")
def begun(boat):
    return snapshot.take(boat.world)


@pytest.fixture(autouse=True)
def _begun_first(begun):
    """The snapshot is taken before any test."""


def test_a_key_saves_a_picture_of_the_screen(boat, user, folder, capsys):
    user.do("key", "F12")
    user.until(boat, lambda: list(folder.glob("*.png")))
    [path] = folder.glob("*.png")
    picture = np.asarray(Image.open(path)).astype(int)
    assert picture.shape == (SIZE[1], SIZE[0], 3)
    now = user.screen(boat)
    assert np.abs(picture - now).mean() < 12.0  # as on the display, a few ticks later
    assert np.abs(picture[::-1] - now).mean() > 20.0
    assert f"picture: {path}" in capsys.readouterr().err


def test_a_key_films_until_it_is_pressed_again(boat, user, folder, capsys):
    user.do("key", "F10")
    user.until(boat, lambda: boat.shots.filming)
    assert not list(folder.glob("*.mp4"))  # appears only when complete
    user.glide(boat, 1.0)
    user.do("key", "F10")
    user.until(boat, lambda: not boat.shots.filming)
    [path] = folder.glob("*.mp4")
    with av.open(str(path)) as container:
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
    assert frames[0].shape == (240, 322, 3)
    assert len(frames) >= 30
    assert np.abs(frames[0].astype(int) - frames[-1]).max() > 20
    assert np.abs(frames[-1].astype(int) - user.screen(boat)[:240]).mean() < 14.0
    told = capsys.readouterr().err
    assert f"filming: {path}" in told
    assert re.search(rf"film of \d+\.\d s: {re.escape(str(path))}", told)


@pytest.mark.parametrize("with_text", [False, True])
def test_pictures_and_films_show_the_sea_and_no_text_unless_asked(
    boat, user, folder, monkeypatch, with_text
):
    monkeypatch.setattr(boat.tick_source, "advance", lambda elapsed_s: 1.0)  # paused time
    monkeypatch.setattr(boat, "records_text", with_text)
    boat.overlay.note("a line of text over the picture")
    boat.overlay.hud.mode = "always"
    before = {*folder.iterdir()}
    boat.run_command("film")
    boat.run_command("picture")
    for _ in range(3):
        boat.frame(0.1)
    screen = user.screen(boat)
    boat.run_command("film")
    with monkeypatch.context() as patch:
        patch.setattr("subsea.ui.hud.Hud.draw", lambda *rest: None)
        patch.setattr("subsea.ui.overlay.draw_line", lambda *rest: rest[-1])
        boat.frame(0.0)
        boat.frame(0.0)
        bare = user.screen(boat)
    boat.overlay.hud.mode = "never"
    png, mp4 = sorted({*folder.iterdir()} - before, key=lambda path: path.suffix == ".mp4")
    picture = np.asarray(Image.open(png)).astype(int)
    with av.open(str(mp4)) as container:
        *_, last = container.decode(video=0)
    frame = last.to_ndarray(format="rgb24").astype(int)
    mark = slice(0, 24), slice(-60, None)
    red = (screen[mark] @ (1, -1, -1) > 60).sum()
    assert red > 20  # while it films
    assert (bare[mark] @ (1, -1, -1) > 60).sum() == 0
    foot = slice(SIZE[1] // 2, 240)
    assert np.abs(screen - bare)[foot].mean() > 4.0
    for taken in (picture, frame):
        assert bool(np.abs(taken[foot] - bare[foot]).mean() > 4.0) is with_text
        assert bool((taken[mark] @ (1, -1, -1) > 60).any()) is with_text
    for path in (png, mp4):
        path.unlink()


def test_a_folder_that_cannot_be_written_is_reported(boat, user, folder, capsys):
    for path in folder.iterdir():
        path.unlink()
    folder.rmdir()
    folder.write_text("in the way")
    try:
        user.do("key", "F12")
        user.do("key", "F10")
        told = ""

        def both():
            nonlocal told
            told += capsys.readouterr().err
            return len(told.splitlines()) >= 2

        user.until(boat, both)
    finally:
        folder.unlink()
    assert told.count("of mine") == 2
    assert boat.window_set.open
    tick = boat.world.state.tick
    user.glide(boat, 0.2)
    assert boat.world.state.tick > tick


def test_diagrams_and_their_labels_are_over_the_picture(boat, user, begun):
    snapshot.restore(boat.world, begun)  # fishes are in sight, however long others took

    def settled():
        boat.frame(0.0)
        boat.frame(0.0)
        return user.screen(boat)

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


def test_a_key_switches_the_lights_and_a_rewind_restores_them(boat, user):
    lights = boat.world.state.submarine.lights
    user.glide(boat, 1.5)
    off = user.screen(boat)
    user.do("key", "b")
    user.until(boat, lambda: lights[0])
    boat.frame(0.0)
    boat.frame(0.0)
    assert (user.screen(boat) - off).mean() > 1.0
    user.glide(boat, 0.2)
    boat.run_command("rewind")
    user.glide(boat, 0.1)
    assert not lights[0]
    boat.run_command("lights")
    assert lights[0]
    boat.run_command("lights")
    assert not lights[0]


def test_a_key_scatters_food_and_a_rewind_takes_it_back(boat, user):
    sea = boat.world.state.sea
    user.glide(boat, 1.2)
    assert not (sea.absent < 0.0).any()
    user.do("key", "v")
    user.until(boat, lambda: (sea.absent < 0.0).any())
    assert (sea.absent < 0.0).sum() == min(PINCH, len(sea.plankton))
    boat.run_command("rewind")
    user.glide(boat, 0.1)
    assert not (sea.absent < 0.0).any()


def test_closing_the_dive_leaves_a_valid_film(boat, user, folder):
    boat.run_command("film")
    user.glide(boat, 0.3)
    boat.close()
    [path] = folder.glob("*.mp4")
    with av.open(str(path)) as container:
        assert len([*container.decode(video=0)]) >= 3
