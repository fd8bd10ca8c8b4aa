"""Gamepads, polled once a picture.

A part of a gamepad is a named input like a key, with an amount in [0, 1]. Mappings name the parts
of each model: those of the window library, of `assets/gamecontrollerdb.txt`, and of the user.
"""

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import glfw

from subsea.base.errors import UserError
from subsea.base.files import read_text
from subsea.base.system import resource_path
from subsea.dive.pilot import Pilot
from subsea.dive.settings import (
    PAD_AXES,
    PAD_BUTTONS,
    Command,
    GamepadSettings,
    is_action,
    is_command,
    settings_path,
)
from subsea.ui.gui import Gui

MAPPINGS = "gamecontrollerdb.txt"  # the usual name of such files
IN_ENVIRONMENT = "SDL_GAMECONTROLLERCONFIG"  # more mappings, as in games
CURVE = 1.5  # exponent of the response of a stick: fine near the middle
STEP = 0.01  # smaller changes are ignored
HANDS = -1  # the number of the controllers of a headset, beside those of gamepads
PRESSED, RELEASED = 0.5, 0.3  # thresholds at which an axis acts as a button


class GamepadState(NamedTuple):
    """The state of a gamepad, in the window library's order of buttons and axes."""

    name: str
    buttons: Sequence[int]  # 1 where pressed
    axes: Sequence[float]  # in [-1, 1]; down and right positive, a trigger at rest -1


Read = Callable[[], Mapping[int, GamepadState | None]]  # by number; None: not a known gamepad


class Gamepads:
    """All connected gamepads, which steer the same submarine and can be hot-plugged."""

    def __init__(self, pilot: Pilot, commands: list[Command], read: Read | None = None) -> None:
        """Actions go to the `pilot`, others are added to the `commands`."""
        self._pilot, self._commands = pilot, commands
        self.read = _connected if read is None else read
        self.read_hands: Callable[[], GamepadState | None] = lambda: None  # of a headset
        self._amounts: dict[str, float] = {}  # by name of the input
        self._down: set[str] = set()  # inputs beyond PRESSED
        self._names: dict[int, str | None] = {}

    def poll(self, listener: Gui | None = None) -> list[str]:
        """Process changes since the last call; the `listener` may consume them.

        Returns lines on gamepads that were connected or disconnected.
        """
        states = dict(self.read())
        if (hands := self.read_hands()) is not None:
            states[HANDS] = hands
        lines = self._changes({number: state and state.name for number, state in states.items()})
        now: dict[str, float] = {}
        for state in states.values():
            if state is not None:
                for name, amount in amounts(state, self._pilot.settings.gamepad).items():
                    now[name] = max(amount, now.get(name, 0.0))
        for name in sorted({*now, *self._amounts}):
            self._move(name, now.get(name, 0.0), listener)
        return lines

    def _changes(self, names: dict[int, str | None]) -> list[str]:
        before, self._names = self._names, names
        lines = [
            "the controllers of the headset are gone"
            if number == HANDS
            else f"the gamepad {name!r} is gone"
            for number, name in before.items()
            if name is not None and names.get(number) is None
        ]
        for number, name in names.items():
            if number in before and before[number] == name:
                continue
            if number == HANDS:
                lines.append("the controllers of the headset steer")
            elif name is not None:
                lines.append(f"the gamepad {name!r} steers")
            else:
                user_file = settings_path().parent / MAPPINGS
                model = _text(glfw.get_joystick_name(number))
                guid = _text(glfw.get_joystick_guid(number))
                lines.append(
                    f"unknown gamepad {model!r}: add a mapping for the ID {guid} to {user_file}"
                )
        return lines

    def _move(self, name: str, amount: float, listener: Gui | None) -> None:
        """The input `name` is at `amount` in [0, 1]."""
        before = self._amounts.get(name, 0.0)
        if abs(amount - before) < STEP and (amount > 0.0) == (before > 0.0):
            return
        self._pilot.note_activity()
        self._amounts[name] = amount
        if amount <= 0.0:
            del self._amounts[name]
        crossed = amount > PRESSED and name not in self._down
        if crossed:
            self._down.add(name)
        elif amount < RELEASED:
            self._down.discard(name)
        pilot = self._pilot
        consumed = listener is not None and listener.moved(name, amount)
        control = pilot.bindings.control(name, pilot.riding)
        if pilot.settings.gamepad.invert_pitch and "stick" in name and control in ("up", "down"):
            control = "down" if control == "up" else "up"
        if consumed or control is None or amount <= 0.0:
            pilot.release(name)
        elif is_action(control):
            if control != "full stop" or crossed:
                pilot.hold(control, name, amount)
        elif crossed and is_command(control):
            self._commands.append(control)


def amounts(state: GamepadState, settings: GamepadSettings) -> dict[str, float]:
    """Amounts in (0, 1] of the moved parts of a gamepad, by input name."""
    moved = {}
    for name, down in zip(PAD_BUTTONS, state.buttons, strict=True):
        if down:
            moved[f"pad {name}"] = 1.0
    for (positive, negative), value in zip(PAD_AXES, state.axes, strict=True):
        if not negative:  # a trigger
            offset = (value + 1.0) / 2.0
            share = _beyond(offset, settings)
        else:
            offset = value
            share = _beyond(abs(value), settings) ** CURVE
        if share > 0.0:
            moved[f"pad {positive if offset > 0.0 else negative}"] = share
    return moved


def add_mappings(report: Callable[[str], None]) -> None:
    """Add all mappings to the window library, which must be running; later ones win."""
    texts = [resource_path(f"assets/{MAPPINGS}").read_text(encoding="utf-8")]
    user_file = settings_path().parent / MAPPINGS
    if user_file.exists():
        texts.append(_text_of(user_file, report))
    texts.append(os.environ.get(IN_ENVIRONMENT, ""))
    for text in texts:
        # Line by line, so that one faulty line does not affect the others.
        for line in text.splitlines():
            if line and not line.startswith("#") and not _add(line):
                report(f"not a gamepad mapping: {line[:60]}")


def _connected() -> dict[int, GamepadState | None]:
    """All connected gamepads."""
    states: dict[int, GamepadState | None] = {}
    for number in range(glfw.JOYSTICK_1, glfw.JOYSTICK_LAST + 1):
        if not glfw.joystick_present(number):
            continue
        state = glfw.get_gamepad_state(number) if glfw.joystick_is_gamepad(number) else None
        states[number] = None
        if state:
            name = _text(glfw.get_gamepad_name(number))
            states[number] = GamepadState(name, list(state.buttons), list(state.axes))
    return states


def _text(words: Any) -> str:
    return words.decode("utf-8", "replace") if isinstance(words, bytes) else str(words)


def _beyond(offset: float, settings: GamepadSettings) -> float:
    """The amount beyond the dead zone, in [0, 1]."""
    zone = settings.dead_zone
    return min(max(offset - zone, 0.0) / (1.0 - zone) * settings.sensitivity, 1.0)


def _text_of(path: Path, report: Callable[[str], None]) -> str:
    try:
        return read_text(path)
    except UserError as fault:
        report(str(fault))
        return ""


def _add(line: str) -> bool:
    """Add a mapping to the window library; False if it is faulty."""
    guid = line.partition(",")[0]
    if len(guid) != 32 or not set(guid) <= set("0123456789abcdef"):
        return guid == "xinput"
    try:
        return bool(glfw.update_gamepad_mappings(line))
    except glfw.GLFWError:
        return False
