"""Bindings of inputs to controls: keys, mouse buttons and the parts of a gamepad, by name.

An input's name is what a settings file calls it: ``W``, ``PageUp``, ``Ctrl+Shift+Q``,
``mouse left``, ``pad right trigger``. Nothing here knows the window library.
"""

import re
from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple, TypeGuard, get_args

from subsea.base.errors import UserError, nearest, unknown

# Controls that act as long as an input is held.
Action = Literal["ahead", "astern", "left", "right", "up", "down", "rise", "dive", "full stop"]
# Controls that act once, when an input goes down.
Command = Literal[
    "help", "menu", "desk", "quality", "pattern", "ride", "look", "follow", "reins", "alight",
    "lights", "instruments", "fullscreen", "pause", "slower", "faster", "tick", "rewind",
    "picture", "film", "mute", "louder", "quieter", "language", "recentre", "cue", "leave",
]  # fmt: skip
ControlName = Action | Command
ACTIONS: tuple[Action, ...] = get_args(Action)
COMMANDS: tuple[Command, ...] = get_args(Command)
REPEATING: tuple[Command, ...] = ("rewind", "tick")  # repeated while a key is held


def is_action(control: ControlName) -> TypeGuard[Action]:
    """True if a control acts as long as its input is held."""
    return control in ACTIONS


def is_command(control: ControlName) -> TypeGuard[Command]:
    """True if a control acts once, when its input goes down."""
    return control in COMMANDS


class Control(NamedTuple):
    """The function of a control, in words, and its default inputs."""

    what: str
    inputs: tuple[str, ...]


CONTROLS: dict[ControlName, Control] = {
    "ahead": Control("go ahead while held", ("W", "mouse left", "pad left stick up")),
    "astern": Control("go astern while held", ("S", "mouse right", "pad left stick down")),
    "left": Control("turn left", ("A", "Left", "pad left stick left")),
    "right": Control("turn right", ("D", "Right", "pad left stick right")),
    "up": Control("nose up", ("Up", "pad right stick up")),
    "down": Control("nose down", ("Down", "pad right stick down")),
    "rise": Control("rise", ("E", "PageUp", "pad right trigger")),
    "dive": Control("dive", ("Q", "PageDown", "pad left trigger")),
    "full stop": Control("stop, and stay", ("Space", "mouse middle", "pad A")),
    "help": Control("show or hide the help", ("H", "F1", "pad back")),
    "menu": Control("the menu", ("Esc", "pad start")),
    "desk": Control("open or close the panels", ("Tab",)),
    "quality": Control("quality of the picture", ("P",)),
    "pattern": Control("test pattern", ("T",)),
    "ride": Control("ride the fish ahead, or the next", ("R", "pad Y")),
    "look": Control("on a fish: colours, identities or ranges", ("I", "pad X")),
    "follow": Control("on a fish: from behind it, or through its eyes", ("C",)),
    "reins": Control("on a fish: take its reins, or give them back", ("G", "pad right bumper")),
    "alight": Control("leave the fish; its inputs may mean something else elsewhere",
                      ("Esc", "pad B")),
    "lights": Control("the submarine's lights", ("B", "pad up", "pad left bumper")),
    "instruments": Control("show or hide the instruments", ("U",)),
    "fullscreen": Control("full screen, and back", ("F", "F11")),
    "pause": Control("let time stand still, and go on", ("K",)),
    "slower": Control("let time go slower", ("J",)),
    "faster": Control("let time go faster", ("L",)),
    "tick": Control("one tick further", (".",)),
    "rewind": Control("a second back", (",",)),
    "picture": Control("take a picture", ("F12",)),
    "film": Control("start a film, and end it", ("F10",)),
    "mute": Control("sound off, and on", ("M",)),
    "louder": Control("sound up", ("=",)),
    "quieter": Control("sound down", ("-",)),
    "language": Control("the next language", ("X",)),
    "recentre": Control("in a headset: take the place of the head as the pilot's", ("Home",)),
    "cue": Control("in a show: go on to the next item", ("N",)),
    "leave": Control("end the dive at once", ()),
}  # fmt: skip

# The window library's numbers of keys (glfw3.h). A letter is its place on a US keyboard.
KEYS: dict[int, str] = {
    32: "Space", 39: "'", 44: ",", 45: "-", 46: ".", 47: "/", 59: ";", 61: "=", 91: "[", 92: "\\",
    93: "]", 96: "`", 256: "Esc", 257: "Enter", 258: "Tab", 259: "Backspace", 260: "Insert",
    261: "Delete", 262: "Right", 263: "Left", 264: "Down", 265: "Up", 266: "PageUp",
    267: "PageDown", 268: "Home", 269: "End", 280: "CapsLock", 281: "ScrollLock", 282: "NumLock",
    283: "Print", 284: "Pause", 330: "Num.", 331: "Num/", 332: "Num*", 333: "Num-", 334: "Num+",
    335: "NumEnter", 336: "Num=", 340: "LeftShift", 341: "LeftCtrl", 342: "LeftAlt",
    343: "LeftSuper", 344: "RightShift", 345: "RightCtrl", 346: "RightAlt", 347: "RightSuper",
    348: "Menu",
    **{ord(sign): sign for sign in "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ"},
    **{289 + k: f"F{k}" for k in range(1, 26)},
    **{320 + k: f"Num{k}" for k in range(10)},
}  # fmt: skip
MODIFIERS = {2: "Ctrl", 4: "Alt", 1: "Shift", 8: "Super"}  # in the order in which they are named
MODIFIER_KEYS = tuple(f"{side}{word}" for side in ("Left", "Right") for word in MODIFIERS.values())
BUTTONS = ("left", "right", "middle", "4", "5", "6", "7", "8")  # of a mouse
# Of a gamepad, in the order of the window library.
PAD_BUTTONS = (
    "A", "B", "X", "Y", "left bumper", "right bumper", "back", "start", "guide", "left thumb",
    "right thumb", "up", "right", "down", "left",
)  # fmt: skip
# Directions of its axes at 1 and at -1: down and right are positive. A trigger rests at -1.
PAD_AXES = (
    ("left stick right", "left stick left"), ("left stick down", "left stick up"),
    ("right stick right", "right stick left"), ("right stick down", "right stick up"),
    ("left trigger", ""), ("right trigger", ""),
)  # fmt: skip

EXPECTED = ", expected one such as 'W', 'PageUp', 'Ctrl+Q', 'mouse left' or 'pad right trigger'"

_NAMES = {
    name.casefold(): name
    for name in (
        *KEYS.values(),
        *(f"mouse {name}" for name in BUTTONS),
        *(f"pad {name}" for name in PAD_BUTTONS),
        *(f"pad {way}" for axis in PAD_AXES for way in axis if way),
    )
} | {"escape": "Esc", "return": "Enter", "del": "Delete"}


class Bindings(NamedTuple):
    """The controls of each input, by the name of the input."""

    controls: Mapping[str, tuple[ControlName, ...]]  # more than one only with "alight"

    def control(self, name: str, riding: bool = False) -> ControlName | None:
        """The control of an input; "alight" only while riding a fish."""
        found = self.controls.get(name, ())
        if riding and "alight" in found:
            return "alight"
        return next((one for one in found if one != "alight"), None)

    def key(self, key: int, modifiers: int, riding: bool = False) -> ControlName | None:
        """The control of a key of the window library, pressed with Ctrl and the like.

        Shift and Ctrl are ignored, unless the combination is bound; with Alt or Super the key
        belongs to the desktop.
        """
        name = key_name(key, modifiers)
        if modifiers & 12 or name in self.controls:
            return self.control(name, riding)
        return self.control(KEYS.get(key, ""), riding)

    def inputs(self, control: ControlName) -> tuple[str, ...]:
        """The names of the inputs of a control."""
        return tuple(name for name, found in self.controls.items() if control in found)


def key_name(key: int, modifiers: int = 0) -> str:
    """The name of a key with its modifiers: ``Ctrl+Shift+Q``; "" for an unknown key."""
    if key not in KEYS:
        return ""
    return "+".join([*(word for bit, word in MODIFIERS.items() if modifiers & bit), KEYS[key]])


def is_key(name: str) -> bool:
    """True if an input is a key of the keyboard, alone or with modifiers."""
    return not name.startswith(("mouse ", "pad "))


def input_name(text: str) -> str:
    """The name of an input, in any case, its words separated by blanks, hyphens or underscores.

    A UserError, with the nearest name, if there is no such input.
    """
    parts = re.fullmatch(
        r"\s*((?:(?:ctrl|alt|shift|super)\s*\+\s*)*)(.*?)\s*", text.casefold(), re.DOTALL
    )
    held, rest = parts.groups() if parts else ("", "")
    words = " ".join(re.split(r"[\s_-]+", rest))
    tries = (rest, words, words.replace(" ", ""))
    name = next((_NAMES[one] for one in tries if one in _NAMES), None)
    if name is None:
        hint = nearest(text, sorted(set(_NAMES.values())))
        raise UserError(f"unknown input {text!r}{hint or EXPECTED}")
    beside = [word for word in MODIFIERS.values() if word.casefold() in held]
    if beside and name not in KEYS.values():
        raise UserError(f"{text!r}: only keys go with {beside[0]}")
    return "+".join([*beside, name])


def bindings_of(table: Mapping[str, Sequence[str]]) -> Bindings:
    """The bindings of the table `[controls]` of a settings file: the inputs of each control.

    A control that is not named keeps its default inputs, except those that the table gives to
    another. A UserError on an unknown name, or on an input with two controls. Only "alight" may
    share its inputs: it acts on a fish, the other control elsewhere.
    """
    found: dict[str, list[ControlName]] = {}
    for word, texts in table.items():
        if word not in CONTROLS:
            raise unknown("control", word, list(CONTROLS), key=word)
        control = next(name for name in CONTROLS if name == word)
        for text in texts:
            try:
                name = input_name(text)
            except UserError as fault:
                raise UserError(f"{word!r}: {fault}", key=word) from None
            others = found.setdefault(name, [])
            if control in others:
                continue
            if control != "alight" and (rivals := [one for one in others if one != "alight"]):
                raise UserError(f"{name!r} cannot be both {rivals[0]!r} and {word!r}", key=word)
            others.append(control)
    taken = {name for name, controls in found.items() if controls != ["alight"]}
    for control, (_, inputs) in CONTROLS.items():
        if control in table:
            continue
        for name in inputs:
            if control == "alight" or name not in taken:
                found.setdefault(name, []).append(control)
    return Bindings({name: tuple(controls) for name, controls in found.items()})


USUAL = bindings_of({})
