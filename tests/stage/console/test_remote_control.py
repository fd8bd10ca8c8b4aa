"""A dive in a real window, controlled by the presenter's console."""

import threading
from contextlib import closing

import msgspec
import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.scenario.load import own_scenarios
from subsea.stage.console.commands import (
    BlankScreens,
    FollowFish,
    LeaveFish,
    OpenScenario,
    RideFish,
    SetQuality,
    SetVolume,
    ShowCaption,
    ShowLineUp,
    ShowStructuredLight,
    StartCue,
    StartTour,
    StopTour,
)
from subsea.stage.console.remote_control import open_console
from subsea.stage.parts import ConsolePart
from subsea.ui.dive import Dive
from subsea.world import snapshot
from subsea.world.feeding import PINCH
from tests.stage.console.conftest import Client, free_port, local
from tests.support.scenes import BARE, scene
from tests.support.windows import dive_options

SIZE = (320, 240)
UNDO = {
    BlankScreens: BlankScreens(False), ShowLineUp: ShowLineUp(False), ShowCaption: ShowCaption(""),
    FollowFish: LeaveFish(), RideFish: LeaveFish(),
}  # fmt: skip
CAPTION = "A voice from the side"
DIRECTIONS = (
    'name = "fear"\nat_s = 1e5\nwho = { shoal = 0 }\nfear = 1.0\nfor_s = 2.0',
    'at_s = 1e5\ncaption = "Look there"',
)


def remote(running):
    """The remote control of a dive with a console."""
    return running.parts[0].remote


@pytest.fixture(scope="module")
def boat(display, user, coarse, tmp_path_factory):
    file = scene(tmp_path_factory.mktemp("sea"), *DIRECTIONS)
    file.write_text(file.read_text().replace("visibility_cm", "plankton = 60, visibility_cm", 1))
    with closing(Dive(dive_options(file, SIZE, coarse, parts=[ConsolePart(local())]))) as running:
        assert remote(running) is not None
        user.glide(running, 0.2)
        yield running


@pytest.fixture
def give(boat, user):
    """Give a command as the server does, and run frames until it is done."""
    kinds = set()

    def given(command):
        kinds.add(type(command))
        done = remote(boat)._board.put(command)
        user.until(boat, done.done)
        return done.result()

    yield given
    for kind in UNDO.keys() & kinds:
        given(UNDO[kind])
    if UNDO.keys() & kinds:
        user.glide(boat, 1.0)


def shown(boat, user):
    """The board's picture of the window, after frames that want it: (h, w, 3)."""
    board = remote(boat)._board
    board.want_picture()
    before = board.picture_number
    user.until(boat, lambda: board.picture_number >= before + 2)
    return board.picture[..., :3].astype(int)


def test_the_small_picture_is_that_of_the_window(boat, user, give):
    picture = shown(boat, user)
    assert picture.shape == (240, 320, 3)  # no smaller window is enlarged
    real = boat.window_set.picture().astype(int)
    assert np.abs(picture - real).mean() < 12.0  # the sea moves between them
    assert np.abs(picture - real[::-1]).mean() > 12.0


def test_no_picture_is_copied_while_nobody_looks(boat, user, monkeypatch):
    board = remote(boat)._board
    monkeypatch.setattr(type(board), "picture_wanted", False)
    user.glide(boat, 0.5)
    before = board.picture_number
    user.glide(boat, 2.0)
    assert board.picture_number == before


@pytest.mark.nightly
def test_the_screens_become_black_and_return(boat, user, give):
    bright = shown(boat, user).mean()
    give(BlankScreens(True))
    user.glide(boat, 1.0)
    assert shown(boat, user).max() <= 2
    give(BlankScreens(False))
    user.glide(boat, 1.0)
    assert shown(boat, user).mean() > 0.5 * bright


def test_a_caption_is_shown_for_a_while(boat, user, give):
    give(ShowCaption(f"{CAPTION}\n\x1b[31m", 3.0))
    user.glide(boat, 1.0)
    assert boat.caption.words == f"{CAPTION} ?[31m" and boat.caption.opacity == 1.0
    user.glide(boat, 2.5)
    assert boat.caption.words == ""


def test_the_line_up_pattern_comes_and_goes(boat, user, give):
    assert "pattern" in give(ShowLineUp(True))
    assert boat.picture.pattern
    user.glide(boat, 0.3)
    give(ShowLineUp(True))
    assert boat.picture.pattern
    boat.run_command("pattern")  # the pilot's key
    assert not boat.picture.pattern
    give(ShowLineUp(True))
    assert boat.picture.pattern


def test_structured_light_needs_a_theatre(give):
    with pytest.raises(UserError, match="no projectors to calibrate: begin the dive with"):
        give(ShowStructuredLight(1))


def test_fishes_are_followed_and_ridden(boat, give):
    species = boat.world.script.species[0]
    give(FollowFish(species))
    assert boat.picture.ride.behind
    give(RideFish("1"))
    assert boat.picture.ride.by.fish == 1 and not boat.picture.ride.behind
    give(LeaveFish())
    assert boat.picture.ride is None
    give(FollowFish("nearest"))
    assert boat.picture.ride is not None
    for name in ("999", "nobody", f"{species}:999", f"{species}:x", "/etc/passwd"):
        with pytest.raises(UserError):
            give(FollowFish(name))


def test_a_tour_begins_and_ends(boat, give):
    give(StartTour("auto"))
    assert boat.tick_source.steering.tour is not None and boat.tours.timer.touring
    assert remote(boat)._state(0.0, False)["tour"] == "auto"
    give(StopTour())
    assert boat.tick_source.steering.tour is None and not boat.tours.timer.touring
    with pytest.raises(UserError, match="unknown tour 'nowhere'"):
        give(StartTour("nowhere"))


def test_cues_begin_in_turn_and_can_be_undone_by_time(boat, user, give):
    log = boat.world.state.directions
    assert remote(boat)._state(0.0, False)["next_cue"] == 0
    give(StartCue())
    user.glide(boat, 0.2)
    assert log.began[0] >= 0 and log.times[0] == 1 and remote(boat)._next_cue == 1
    give(StartCue(1))
    user.glide(boat, 1.0)
    assert boat.caption.words == "Look there"
    with pytest.raises(UserError, match="no cue is left"):
        give(StartCue())
    with pytest.raises(UserError, match="cue 7: expected 0 to 1"):
        give(StartCue(7))
    assert [cue["begun"] for cue in remote(boat)._state(0.0, False)["cues"]] == [True, True]
    tick = boat.world.state.tick
    boat.timeline.go(0)
    assert log.began[0] < 0
    boat.timeline.go(tick)
    assert log.began[0] >= 0  # the same again


def test_food_is_scattered_over_http_and_repeated_by_time(boat, user):
    sea, time = boat.world.state.sea, boat.timeline
    client, answers = Client(remote(boat)._server._options.http.port), []
    before = time.tick
    user.glide(boat, 0.1)  # else a quick boat is fed in that tick, too

    def work():
        answers.extend(client.ask("/api/commands", {"command": "feed"}) for _ in range(2))

    thread = threading.Thread(target=work)
    thread.start()
    user.until(boat, lambda: not thread.is_alive())
    assert answers[0][:2] == (200, {"done": "food for the fishes"})
    assert answers[1][0] == 409 and "4 s from pinch to pinch" in answers[1][1]["error"]
    assert (sea.absent < 0.0).sum() == PINCH
    tick, now = time.tick, snapshot.checksum(boat.world)
    time.go(before)
    assert not (sea.absent < 0.0).any()
    time.go(tick)
    assert snapshot.checksum(boat.world) == now


def test_the_last_refusal_is_in_state_health_and_terminal(boat, user, give, capfd):
    board = remote(boat)._board
    with pytest.raises(UserError):
        give(StartTour("nowhere"))
    board.refusals.add("OSC /subsea/x: unknown command 'x'")

    def told():  # the state is published by the clock of the wall, not by that of the dive
        return all(
            "unknown command 'x'" in msgspec.json.decode(content)["refusal"]["text"]
            for content in (board.state, board.health)
        )

    user.until(boat, told)
    assert capfd.readouterr().err.count("the console refused OSC /subsea/x: unknown command") == 1
    user.glide(boat, 1.0)
    assert "refused" not in capfd.readouterr().err


def test_quality_and_volume_are_set(boat, give):
    give(SetQuality("medium"))
    assert boat.picture.quality == "medium"
    give(SetQuality("low"))
    give(SetVolume(0.35))
    assert boat.sound.settings.volume == 0.35 and not boat.sound.settings.mute
    assert give(SetVolume(0.0)) == "sound off"


@pytest.mark.parametrize("name", ["nowhere", "/etc/passwd", "../x", "./bare.toml", str(BARE)])
def test_only_named_scenarios_are_opened(boat, give, name):
    before = boat.world
    with pytest.raises(UserError, match="unknown scenario"):
        give(OpenScenario(name))
    assert boat.world is before


def test_a_scenario_that_is_broken_leaves_the_dive_as_it_is(boat, give):
    before = boat.world
    own_scenarios().mkdir(parents=True, exist_ok=True)
    file = own_scenarios() / "broken.toml"
    file.write_text('title = "Broken"\n[[fish]]\nspecies = "unicorn"\nnumber = 2\n')
    try:
        with pytest.raises(UserError, match=r"broken\.toml"):
            give(OpenScenario("broken"))
    finally:
        file.unlink()
    assert boat.world is before


@pytest.mark.nightly
def test_a_scenario_is_opened_behind_black_screens(boat, user, give):
    own_scenarios().mkdir(parents=True, exist_ok=True)
    file = own_scenarios() / "another.toml"
    file.write_text(BARE.read_text())
    try:
        give(BlankScreens(True))
        user.glide(boat, 1.0)
        give(OpenScenario("another"))
        assert boat.source.stem == "another" and remote(boat)._state(0.0, False)["cues"] == []
        user.glide(boat, 0.1)
        assert boat.tick_source.presented.blank == 1.0
        with pytest.raises(UserError, match="there are no directions"):
            give(StartCue())
    finally:
        file.unlink()


def test_a_picture_that_stood_still_is_a_fault(boat, user):
    remote(boat)._opened = False
    remote(boat).update(3.0)
    assert boat.faults.state.text == "the picture stood still for 3.0 s"
    assert boat.faults.state.ago_s < 1.0


def test_a_client_controls_the_dive_over_http(boat, user):
    """The server's thread answers while frames are drawn."""
    client = Client(remote(boat)._server._options.http.port)
    answers = []

    def work():
        answers.append(client.ask("/api/commands", {"command": "volume", "volume": 0.5}))
        answers.append(client.ask("/api/state"))
        answers.append(client.ask("/api/picture.jpg"))
        answers.append(client.ask("/health"))

    thread = threading.Thread(target=work)
    thread.start()
    user.until(boat, lambda: not thread.is_alive())
    assert [one[0] for one in answers] == [200] * 4
    assert boat.sound.settings.volume == 0.5
    assert answers[1][1]["scenario"] == boat.source.stem
    assert answers[2][1][:2] == b"\xff\xd8"


def test_a_port_that_is_taken_does_not_end_the_dive(boat, capsys):
    options = remote(boat)._server._options
    assert open_console(boat, options) is None
    assert f"{options.http}: cannot listen there" in boat.overlay.note_text
    assert free_port() != options.http.port
