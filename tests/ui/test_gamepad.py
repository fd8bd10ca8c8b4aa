"""Simulated gamepads."""

import re

import pytest

from subsea.base.system import resource_path
from subsea.dive.pilot import Pilot
from subsea.dive.settings import GamepadSettings, Settings, settings_path
from subsea.ui import gamepad
from subsea.ui.gamepad import Gamepads, GamepadState, amounts

AXES = "left x", "left y", "right x", "right y", "left trigger", "right trigger"
BUTTONS = {"A": 0, "B": 1, "right bumper": 5, "back": 6, "start": 7, "up": 11}
DT = 0.033


def state(*pressed, name="Pad", **axes):
    """A gamepad at rest except these buttons and axes."""
    rest = [0.0, 0.0, 0.0, 0.0, -1.0, -1.0]
    for axis, value in axes.items():
        rest[AXES.index(axis.replace("_", " "))] = value
    return GamepadState(
        name, [int(k in [BUTTONS[one] for one in pressed]) for k in range(15)], rest
    )


class Box:
    """Simulated gamepads to plug in, with their pilot."""

    def __init__(self, **settings):
        self.there, self.commands = {}, []
        self.pilot = Pilot(Settings(**settings))
        self.pads = Gamepads(self.pilot, self.commands, lambda: self.there)

    def helm(self, seconds=2.0):
        for _ in range(round(seconds / DT)):
            helm = self.pilot.helm(DT)
        return helm

    def at(self, *pressed, **axes):
        self.there = {0: state(*pressed, **axes)}
        self.pads.poll()
        return self.helm()


@pytest.mark.parametrize(
    ("axes", "field", "sign"),
    [
        ({"left_y": -1.0}, "surge", 1), ({"left_y": 1.0}, "surge", -1),
        ({"left_x": -1.0}, "yaw", 1), ({"left_x": 1.0}, "yaw", -1),
        ({"right_y": -1.0}, "pitch", 1), ({"right_y": 1.0}, "pitch", -1),
        ({"right_trigger": 1.0}, "heave", 1), ({"left_trigger": 1.0}, "heave", -1),
    ],
)  # fmt: skip
def test_sticks_and_triggers_make_every_manoeuvre(axes, field, sign):
    box = Box()
    assert getattr(box.at(**axes), field) == pytest.approx(sign, abs=1e-3)
    (axis, value), *_ = axes.items()
    half = {axis: 0.5 * value if "trigger" not in axis else 0.0}
    assert 0.1 < sign * getattr(box.at(**half), field) < 0.7  # less deflection gives less
    assert getattr(box.at(), field) == pytest.approx(0.0, abs=1e-3)


def test_a_stick_within_its_dead_zone_does_nothing():
    box = Box()
    assert box.at(left_x=0.14, left_y=-0.1, right_y=0.12, left_trigger=-0.9)[:4] == (0, 0, 0, 0)
    assert Box(gamepad=GamepadSettings(dead_zone=0.0)).at(left_x=0.5).yaw < -0.3


def test_buttons_run_commands_once_and_stop():
    box = Box()
    box.at("right bumper", "start", left_y=-1.0)
    box.at("right bumper", left_y=-1.0)
    assert sorted(box.commands) == ["menu", "reins"]
    assert box.at("A", left_y=-1.0).full_stop
    assert box.at(left_y=-1.0).full_stop  # the stick has not moved
    assert box.at(left_y=-0.5).surge > 0.1
    box.commands.clear()
    box.at("B")
    assert box.commands == []
    box.at()
    box.pilot.set_riding(True)
    box.at("B")
    assert box.commands == ["alight"]


def test_settings_bind_the_parts_of_a_gamepad():
    box = Box(
        controls={"rise": ["pad up"], "picture": ["pad left trigger"]},
        gamepad=GamepadSettings(invert_pitch=True, sensitivity=2.0),
    )
    assert box.at("up").heave == pytest.approx(1.0, abs=1e-3)
    assert box.at(right_y=-0.7).pitch < -0.9
    for pulled in (1.0, 0.0, 0.9, -1.0, 1.0):  # twice, with a tremble between
        box.at(left_trigger=pulled)
    assert box.commands == ["picture", "picture"]


def test_an_unplugged_gamepad_releases_its_inputs_and_may_come_back():
    box = Box()
    box.there = {3: state(left_y=-1.0, name="Pad of Ada")}
    assert box.pads.poll() == ["the gamepad 'Pad of Ada' steers"]
    assert box.pads.poll() == []
    assert box.helm().surge > 0.9
    box.there = {}
    assert box.pads.poll() == ["the gamepad 'Pad of Ada' is gone"]
    assert box.pads.poll() == []
    assert box.helm().surge == pytest.approx(0.0, abs=1e-3)
    box.there = {0: state(left_y=-1.0, name="Pad of Ada"), 1: state("start", name="Other")}
    assert len(box.pads.poll()) == 2
    assert box.helm().surge > 0.9
    assert box.commands == ["menu"]


def test_an_unknown_gamepad_is_reported_with_its_id(monkeypatch):
    monkeypatch.setattr(gamepad.glfw, "get_joystick_name", lambda number: b"Strange")
    monkeypatch.setattr(gamepad.glfw, "get_joystick_guid", lambda number: b"03000000deadbeef")
    box = Box()
    box.there = {2: None}
    (line,) = box.pads.poll()
    assert "unknown gamepad 'Strange'" in line
    assert "03000000deadbeef" in line
    assert str(settings_path().parent / "gamecontrollerdb.txt") in line
    assert box.pads.poll() == []


class Ear:
    def __init__(self):
        self.heard = []

    def moved(self, name, amount):
        self.heard.append((name, amount))
        return True


def test_a_listener_consumes_input_first():
    box, ear = Box(), Ear()
    box.there = {0: state("start", left_y=-1.0)}
    box.pads.poll(ear)
    assert ear.heard == [("pad left stick up", 1.0), ("pad start", 1.0)]
    assert box.commands == []
    assert box.helm().surge == 0.0


def test_two_pads_are_as_strong_as_the_stronger():
    box = Box()
    box.there = {0: state(left_y=-0.5), 1: state(left_y=-1.0)}
    box.pads.poll()
    assert box.helm().surge == pytest.approx(1.0, abs=1e-3)


def test_amounts_are_shares_beyond_the_dead_zone():
    found = amounts(state("A", left_x=0.575), GamepadSettings(dead_zone=0.15))
    assert found == {"pad A": 1.0, "pad left stick right": pytest.approx(0.5**gamepad.CURVE)}


def test_all_mappings_are_added_and_faulty_lines_reported(monkeypatch, tmp_path):
    text = resource_path("assets/gamecontrollerdb.txt").read_text()
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    assert len(lines) == 750
    for line in lines:
        assert re.match(r"[0-9a-f]{32},[^,]+,", line)
        assert re.search(r",platform:(Linux|Mac OS X|Windows),$", line)
    taught, told = [], []
    monkeypatch.setattr(
        gamepad.glfw, "update_gamepad_mappings", lambda line: taught.append(line) or True
    )
    monkeypatch.setenv("SDL_GAMECONTROLLERCONFIG", lines[0] + "\nnonsense")
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    own = settings_path().parent / "gamecontrollerdb.txt"
    own.parent.mkdir(parents=True)
    own.write_text(lines[1])
    gamepad.add_mappings(told.append)
    assert taught == [*lines, lines[1], lines[0]]
    assert told == ["not a gamepad mapping: nonsense"]
    own.write_bytes(b"\xff")
    gamepad.add_mappings(told.append)
    assert "not UTF-8 text" in told[1]
