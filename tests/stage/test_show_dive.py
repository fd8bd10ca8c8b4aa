"""A show in a window: its items, cues, fades and captions, and a cut of the power."""

import json
from contextlib import closing
from datetime import date

import pytest

from subsea.base.system import state_folder
from subsea.cli.main import main
from subsea.dive.settings import AttractSettings, Settings
from subsea.geometry.rotation import x_axis
from subsea.stage import show_player
from subsea.stage.console.commands import BlankScreens, NextItem, ShowCaption
from subsea.stage.parts import ConsolePart, KioskPart, ShowPart, show_of
from subsea.stage.show_file import shipped_shows
from subsea.stage.show_player import DiveCount
from subsea.ui.dive import Dive
from tests.stage.console.conftest import local
from tests.support.scenes import BARE
from tests.support.windows import display_pixels, dive_options

pytestmark = pytest.mark.timeout(900)  # a first start compiles
SHOW = """
title = "a short one"
fade_s = 0.4
[[item]]
scenario = "first.toml"
tour = "auto"
caption = "first words"
for_s = 3
[[item]]
scenario = "second.toml"
caption = "second words"
[[item]]
start = "cue"
tour = "glide"
[[item]]
start = "cue"
scenario = "gone.toml"
[[item]]
start = "cue"
scenario = "first.toml"
"""


@pytest.fixture
def playlist(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    for name in ("first", "second"):
        (tmp_path / f"{name}.toml").write_text(BARE.read_text())
    path = tmp_path / "show.toml"
    path.write_text(SHOW)
    return path


def opened(path, coarse, told, *others):
    parts = [*others, ShowPart(path, told.append)]
    settings = Settings(attract=AttractSettings(after_min=0.0))
    options = dive_options("any", (320, 240), coarse, settings=settings, parts=parts)
    return show_of(options.parts), Dive(options)


@pytest.mark.nightly
def test_a_presenter_sees_the_show_and_leads_it(display, user, coarse, playlist):
    console = ConsolePart(local())
    _, dive = opened(playlist, coarse, [], console)
    with closing(dive) as running:
        user.glide(running, 1.0)
        state = json.loads(console.remote._board.state)["show"]
        assert (state["title"], state["item"], state["items"]) == ("a short one", 1, 5)
        done = console.remote._board.put(NextItem())
        user.until(running, lambda: running.source.name == "second.toml")
        assert done.result() == "on to the next item"
        # A node of a cluster would get the black between two items with the picture.
        assert running.tick_source.presented.blank > 0.0
        console.remote._board.put(ShowCaption("Welcome"))
        user.until(running, lambda: running.caption.words == "Welcome")
        console.remote._board.put(BlankScreens(True))
        user.until(running, lambda: running.tick_source.presented.blank == 1.0)
        console.remote._board.put(BlankScreens(False))
        user.until(running, lambda: running.tick_source.presented.blank == 0.0)


def brightness():
    return display_pixels()[:240, :320].mean()


def test_a_show_of_items_and_two_cues(display, user, coarse, playlist):
    told = []
    show, dive = opened(playlist, coarse, told)
    with closing(dive) as running:
        assert [one for one in told if "show.toml:17: item 4" in one and "no such file" in one]
        running.frame(0.05)
        assert brightness() < 60.0  # still dark
        user.glide(running, 1.0)
        assert running.source.name == "first.toml" and running.tick_source.steering.tour
        assert running.caption.words == "first words" and brightness() > 40.0
        dark = []
        for _ in range(60):
            running.frame(0.1)
            dark.append(display_pixels()[:240, :320].max())
            if running.source.name == "second.toml":
                break
        assert running.source.name == "second.toml" and min(dark) == 0
        user.glide(running, 1.0)
        assert running.caption.words == "second words"
        assert running.tick_source.steering.tour is None  # the pilot steers
        user.glide(running, 4.0)
        assert show.player.state()["next"] == "cue" and show.player.state()["item"] == 2
        world = running.world
        user.do("key", "n")
        user.until(running, lambda: show.player.shown == 2)
        user.glide(running, 1.0)
        assert running.world is world  # the same sea goes on
        assert running.tick_source.steering.tour
        show.player.next_cue()  # as a console does
        user.glide(running, 2.0)
        assert running.world is world and show.player.shown == 3
        assert sum("gone.toml" in line for line in told) == 2  # at the start, and now
        show.player.next_cue()
        user.glide(running, 2.0)
        assert running.world is not world and running.source.name == "first.toml"
        show.end(running)
    assert not (state_folder() / "show.state").exists()


@pytest.mark.nightly
def test_it_goes_on_where_a_cut_of_the_power_ended_it(display, user, coarse, playlist, monkeypatch):
    monkeypatch.setattr(show_player, "SAVE_S", 3.0)
    told = []
    show, dive = opened(playlist, coarse, told)
    with closing(dive) as running:
        user.glide(running, 2.0)
        show.player.next_cue()
        user.glide(running, 3.0)  # a state is saved meanwhile
        show.close()  # a second one is saved once the first is written
        user.glide(running, 2.0)
        ticks = running.world.state.tick
    assert (state_folder() / "show.state").exists()
    again, dive = opened(playlist, coarse, told)
    with closing(dive) as running:
        assert again.player.progress.item == 1 and running.source.name == "second.toml"
        assert 2.0 < again.player.progress.elapsed_s < 5.0
        assert 100 < running.world.state.tick < ticks  # the sea, too
        second = f"{again.player.progress.elapsed_s:.0f}"
        assert f"the show goes on at item 2, second {second}" in told
        user.glide(running, 1.0)
        assert running.world.state.tick > 100 and again.player.shown == 1
        again.end(running)


@pytest.mark.nightly
def test_screens_are_black_outside_the_hours(display, user, coarse, playlist):
    playlist.write_text(SHOW.replace("[[item]]", "[hours]\n[[item]]", 1))  # no day is named
    show, dive = opened(playlist, coarse, [], KioskPart())
    with closing(dive) as running:
        user.glide(running, 1.0)
        assert show.player.closed and display_pixels().max() == 0
        assert running.sound.settings.mute
        before = running.pictures, running.world.state.tick
        user.glide(running, 0.5)
        assert running.pictures > before[0]  # the watchdog stays calm
        assert running.world.state.tick == before[1]


@pytest.mark.nightly
def test_dives_of_visitors_are_counted_by_day(display, user, coarse, playlist):

    _, dive = opened(playlist, coarse, [], KioskPart())
    with closing(dive) as running:
        user.glide(running, 1.0)
        for _ in range(3):  # one visitor
            user.do("mousemove_relative", 9, 9)
            user.glide(running, 0.5)
        assert DiveCount(print).of(date.today()) == 1
        running.tours.begin()  # after a while without input
        user.do("mousemove_relative", 9, 9)
        user.glide(running, 0.5)
    assert DiveCount(print).of(date.today()) == 2
    assert (state_folder() / "dives.csv").read_text() == f"date,dives\n{date.today()},2\n"


def test_the_command_checks_a_show(playlist, capsys):
    assert main(["show", str(playlist)]) == 1
    out, err = capsys.readouterr()
    assert "5 items, always open today" in out and "on cue" in out and "first words" in out
    assert err.splitlines() == [
        f"subsea: {playlist}:17: item 4: {playlist.parent / 'gone.toml'}: no such file"
    ]
    for faulty, line in (
        ('start = "cue"', 'start = "soon"'),
        ("for_s = 3", ""),
        ('scenario = "first.toml"', 'scenery = "first.toml"'),
        ('[[item]]\nscenario = "first.toml"', '[[item]]\ntour = "auto"'),
        ('tour = "auto"', 'show = ["springs"]'),
        ('tour = "auto"', 'tour = "auto"\neyes = "0"'),
        ('tour = "auto"', 'eyes = "0"\ngaze_deg = [150, 0]'),
    ):
        playlist.write_text(SHOW.replace(faulty, line, 1))
        assert main(["show", str(playlist)]) == 2
        err = capsys.readouterr().err
        assert err.startswith(f"subsea: {playlist}:") and len(err.splitlines()) == 1


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("eyes", "no fish 99: expected 0 to"),
        ("follow", "no fish 99: expected 0 to"),
    ],
)
def test_a_fish_that_is_not_there_is_named_with_its_line(key, words, playlist, capsys):
    playlist.write_text(SHOW.replace('tour = "auto"', f'{key} = "99"').replace("gone", "first"))
    assert main(["show", str(playlist)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"subsea: {playlist}:6: item 1: ") and words in line


@pytest.mark.nightly
def test_an_item_shows_springs_and_a_fish_from_its_side(display, user, coarse, playlist):
    own = """tour = "auto"
[[item]]
start = "cue"
eyes = "0"
gaze_deg = [20, 0]
[[item]]
start = "cue"
follow = "0"
gaze_deg = [90, 0]
show = ["scaffold"]
bodies = false
wireframe = true
"""
    end = SHOW.index("[[item]]", SHOW.index("[[item]]") + 1)
    playlist.write_text(SHOW[:end].replace("for_s = 3\n", "").replace('tour = "auto"\n', own))
    screens, dive = opened(playlist, coarse, [])
    with closing(dive) as running:
        user.glide(running, 0.8)
        assert running.picture.ride is None and running.picture.bodies
        screens.cue()
        user.glide(running, 1.2)
        ride = running.picture.ride
        assert ride is not None and not ride.behind and ride.gaze.pan_deg == 20.0
        screens.cue()
        user.glide(running, 1.2)
        ride, fishes = running.picture.ride, running.world.state.fishes
        assert ride is not None and ride.behind
        assert running.picture.diagrams == {"scaffold"} and running.picture.wireframe
        assert not running.picture.bodies and not running.picture.insets
        way = ride.observer(running.world, 1.0).forward
        assert abs(way @ x_axis(fishes.orientation[0])) < 0.5  # across
        screens.cue()  # the first item again
        user.glide(running, 1.2)
        assert running.picture.ride is None and running.picture.bodies
        assert not running.picture.diagrams and not running.picture.wireframe


def test_shipped_shows_have_all_that_they_name(capsys):
    assert shipped_shows() == ["go-fish"]
    for name in shipped_shows():
        assert main(["show", name]) == 0
    assert main(["show", "go-fihs"]) == 2
    assert "go-fish" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words",
    [
        ["--tour", "auto"],
        ["--set", "seed=1"],
        ["--display", "headset"],
        ["--fish", "3"],
        ["--scenario", "visitors"],
    ],
)
def test_options_that_a_show_chooses_are_refused(words, playlist, capsys):
    assert main(["dive", "--playlist", str(playlist), *words]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
