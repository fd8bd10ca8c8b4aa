"""Cues of a show in a window, and lamps of a theatre."""

import socket
import threading
import time
from contextlib import closing, contextmanager

import mido
import pytest
from pythonosc.osc_message import OscMessage

from subsea.base.errors import UserError
from subsea.stage.cue_parts import CuesPart, LightsPart, check_cues, command_of, values_of
from subsea.stage.cues.tables import MidiCue
from subsea.stage.parts import ShowPart, TheatrePart, show_of
from subsea.stage.show_file import load_show
from subsea.ui.dive import Dive
from tests.support.scenes import BARE
from tests.support.windows import dive_options

SHOW = """
fade_s = 0
[osc]
address = "127.0.0.1:{port}"
[midi]
port = "kontrol"
[[midi.cue]]
note = 60
command = "next-item"
[[midi.cue]]
control = 7
command = "item 1"
[timecode]
source = "midi"
[[item]]
scenario = "bare.toml"
osc = ["/lights/go 4"]
[[item]]
start = "cue"
[[item]]
start = "01:00:00:00"
"""
THEATRE = """
[[window]]
name = "front"
size = [320, 240]
[[channel]]
name = "front"
window = "front"
angles = {{ left_deg = -40, right_deg = 40, down_deg = -30, up_deg = 30 }}
[lights]
protocol = "artnet"
address = "127.0.0.1"
port = {port}
dark = 0.5
[[lamp]]
name = "above"
channel = 1
elevation_deg = 90
[[lamp]]
name = "behind"
channel = 4
azimuth_deg = 180
"""


@pytest.fixture
def desk():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as made:
        made.bind(("127.0.0.1", 0))
        made.settimeout(20.0)
        yield made


@pytest.fixture
def keyboard(monkeypatch):
    """A MIDI port; the result takes messages once it is open."""
    opened = []

    def open_input(name, callback):
        opened.append(callback)
        return type("Port", (), {"name": name, "close": lambda self: None})()

    monkeypatch.setattr(mido, "get_input_names", lambda: ["nanoKONTROL"])
    monkeypatch.setattr(mido, "open_input", open_input)
    return opened


@contextmanager
def timecode(hear):
    """Send MIDI timecode from an hour on, by the clock."""
    ends, begun = threading.Event(), time.monotonic()

    def run():
        while not ends.wait(0.05):
            seconds, frames = divmod(int(25 * (time.monotonic() - begun)), 25)
            parts = frames, seconds % 60, seconds // 60, 1
            nibbles = [half for part in parts for half in (part & 15, part >> 4)]
            nibbles[-1] |= 1 << 1  # 25 frames a second
            for kind, value in enumerate(nibbles):
                hear(mido.Message("quarter_frame", frame_type=kind, frame_value=value))

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield
    finally:
        ends.set()
        thread.join()


def told(desk, address):
    """The values of the next message to an address."""
    while True:
        message = OscMessage(desk.recv(2000))
        if message.address == address:
            return message.params


@pytest.mark.nightly
def test_a_show_is_led_by_midi_and_timecode_and_told_by_osc(
    display, user, coarse, tmp_path, monkeypatch, desk, keyboard
):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    (tmp_path / "bare.toml").write_text(BARE.read_text())
    path = tmp_path / "show.toml"
    path.write_text(SHOW.format(port=desk.getsockname()[1]))
    options = dive_options("any", (320, 240), coarse, parts=[ShowPart(path, print)])
    player = show_of(options.parts).player
    assert isinstance(options.parts[0], CuesPart)
    with closing(Dive(options)) as running:
        user.until(running, lambda: player.shown == 0 and keyboard and player.shade == 0.0)
        assert told(desk, "/subsea/open") == [True]
        assert told(desk, "/subsea/blank") == [True]  # it begins behind black screens
        assert told(desk, "/subsea/item") == [1, "bare", ""]
        assert told(desk, "/lights/go") == [4]
        assert len(keyboard) == 1  # commands and timecode come from one port
        hear = keyboard[0]
        hear(mido.Message("note_on", note=60, velocity=90))
        hear(mido.Message("note_off", note=60))
        user.until(running, lambda: player.shown == 1)
        assert told(desk, "/subsea/item") == [2, "bare", ""]
        hear(mido.Message("control_change", control=7, value=127))
        user.until(running, lambda: player.shown == 0)
        with timecode(hear):
            user.until(running, lambda: player.shown == 2)


@pytest.mark.nightly
def test_lamps_follow_the_sea_and_the_screens(display, user, coarse, tmp_path, desk):
    path = tmp_path / "hall.toml"
    path.write_text(THEATRE.format(port=desk.getsockname()[1]))
    parts = [LightsPart(str(path)), TheatrePart(str(path))]
    with closing(Dive(dive_options(BARE, (320, 240), coarse, parts=parts))) as running:
        user.glide(running, 0.5)
        levels = desk.recv(2000)[18:]
        assert 0 < levels[5] < levels[2]  # blue, from behind and from above
        assert not any(levels[6:])
    last = levels
    desk.settimeout(0.5)
    try:
        while True:
            last = desk.recv(2000)[18:]
    except TimeoutError:
        pass
    assert last[:6] == bytes([128]) * 6  # the dive has ended


@pytest.mark.parametrize(
    ("cue", "message", "values"),
    [
        ({"note": 60}, mido.Message("note_on", note=60, velocity=1), [1.0]),
        ({"note": 60}, mido.Message("note_on", note=60, velocity=0), [0.0]),
        ({"note": 60}, mido.Message("note_off", note=60), [0.0]),
        ({"note": 60}, mido.Message("note_on", note=61), None),
        ({"note": 60, "channel": 2}, mido.Message("note_on", note=60, channel=0), None),
        ({"control": 7, "channel": 1}, mido.Message("control_change", control=7, value=0), [0.0]),
        ({"program": 3}, mido.Message("program_change", program=3), [1.0]),
        ({"program": 3}, mido.Message("clock"), None),
    ],
)
def test_messages_and_their_values(cue, message, values):
    assert values_of(MidiCue(command="blank", **cue), message) == values


def test_commands_of_messages():
    def made(text, value):
        return command_of(MidiCue(note=1, command=text), [value])

    assert made("volume", 0.25).volume == 0.25
    assert made("item 3", 1.0).number == 3 and made("item 3", 0.0) is None
    assert made("blank", 1.0).on and not made("blank", 0.0).on
    assert made("tour reef", 1.0).name == "reef"


def test_a_command_that_no_presenter_knows_is_refused(tmp_path):
    path = tmp_path / "show.toml"
    path.write_text(
        '[midi]\n[[midi.cue]]\nnote = 1\ncommand = "nexxt-item"\n[[item]]\nscenario = "peaceful"\n'
    )
    with pytest.raises(UserError, match=r"show.toml:4: `command`: unknown command 'nexxt-item'"):
        check_cues(load_show(path), path)
