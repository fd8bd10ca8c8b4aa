"""User settings: `settings.toml` in the folder of the platform, or a file by name.

They bind inputs to controls. An input's name is what a settings file calls it: ``W``, ``PageUp``,
``Ctrl+Shift+Q``, ``mouse left``, ``pad right trigger``. Nothing here knows the window library.
"""

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, TypeGuard, get_args

import msgspec
import platformdirs
from msgspec import Meta, inspect

from subsea.base.errors import UserError, nearest, unknown
from subsea.base.files import read_text, replacing
from subsea.base.language import translated
from subsea.base.progress import print_line
from subsea.base.toml_files import error_at, load_toml

# Controls that act as long as an input is held.
Action = Literal["ahead", "astern", "left", "right", "up", "down", "rise", "dive", "full stop"]
# Controls that act once, when an input goes down.
Command = Literal[
    "help", "menu", "desk", "quality", "pattern", "ride", "look", "follow", "reins", "alight",
    "lights", "feed", "instruments", "fullscreen", "pause", "slower", "faster", "tick", "rewind",
    "picture", "photo", "film", "mute", "louder", "quieter", "score", "language", "recentre", "cue",
    "leave",
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
    "feed": Control("scatter food for the fishes", ("V", "pad down")),
    "instruments": Control("show or hide the instruments", ("U",)),
    "fullscreen": Control("full screen, and back", ("F", "F11")),
    "pause": Control("let time stand still, and go on", ("K",)),
    "slower": Control("let time go slower", ("J",)),
    "faster": Control("let time go faster", ("L",)),
    "tick": Control("one tick further", (".",)),
    "rewind": Control("a second back", (",",)),
    "picture": Control("take a picture", ("F12",)),
    "photo": Control("stop time to take pictures, and go on", ("O", "pad right thumb")),
    "film": Control("start a film, and end it", ("F10",)),
    "mute": Control("sound off, and on", ("M",)),
    "louder": Control("sound up", ("=",)),
    "quieter": Control("sound down", ("-",)),
    "score": Control("the quiet score on, and off", ("Y",)),
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
KEY_WORDS = (
    "Space", "Esc", "Tab", "Backspace", "Insert", "Delete", "Right", "Left", "Down", "Up",
    "PageUp", "PageDown", "Home", "End", "CapsLock", "ScrollLock", "NumLock", "NumEnter", "Ctrl",
    "Alt", "Shift", "Super", "LeftShift", "LeftCtrl", "LeftAlt", "LeftSuper", "RightShift",
    "RightCtrl", "RightAlt", "RightSuper", "Menu",
)  # fmt: skip
"""Names of keys that have other names on other keyboards."""
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


def key_words(name: str) -> str:
    """Name a key, alone or with modifiers, in the language of visitors."""
    return re.sub("[A-Za-z]+", lambda word: _key_word(word[0]), name)


def _key_word(word: str) -> str:
    return translated(word) if word in KEY_WORDS else word


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


# Commands of visitors; in a kiosk all others have no inputs.
KIOSK_COMMANDS: tuple[Command, ...] = (
    "help", "menu", "ride", "look", "follow", "reins", "alight", "lights", "feed", "language",
    "cue", "leave",
)  # fmt: skip

Pixels = Annotated[int, Meta(ge=64, le=8192)]


class MouseSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The table `[mouse]`."""

    steer: Annotated[bool, Meta(description="whether the submarine turns to the pointer")] = True
    invert_pitch: Annotated[
        bool, Meta(description="whether the pointer below the middle lifts the nose")
    ] = False
    sensitivity: Annotated[
        float,
        Meta(ge=0.2, le=5, description="0.2 to 5: above 1 the pointer need not go to the edge"),
    ] = 1.0
    touch: Annotated[
        bool,
        Meta(description="a touch screen: drag to look, hold to go, tap a fish for its card"),
    ] = False


class GamepadSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The table `[gamepad]`."""

    dead_zone: Annotated[
        float, Meta(ge=0, le=0.9, description="0 to 0.9: how far a stick moves before it counts")
    ] = 0.15
    invert_pitch: Annotated[
        bool, Meta(description="whether pulling the stick back lifts the nose")
    ] = False
    sensitivity: Annotated[
        float, Meta(ge=0.2, le=5, description="0.2 to 5: above 1 less than a full push is all")
    ] = 1.0


class ComfortSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The table `[comfort]`."""

    vignette: Annotated[
        float, Meta(ge=0, le=1, description="0 to 1: how much the rim darkens in fast turns")
    ] = 0.0
    horizon: Annotated[bool, Meta(description="a line where the horizon is, when it tilts")] = True
    headset_vignette: Annotated[float, Meta(ge=0, le=1, description="the same in a headset")] = 0.6
    snap_turn_deg: Annotated[
        float,
        Meta(
            ge=0,
            le=90,
            description="in a headset: the sea turns in steps of this angle; 0: smoothly",
        ),
    ] = 0.0
    acceleration: Annotated[
        float,
        Meta(ge=0.1, le=1, description="0.1 to 1: share of full thrust and rudder"),
    ] = 1.0


COMFORTS = {
    "calm": ComfortSettings(
        vignette=0.6, headset_vignette=0.9, snap_turn_deg=30.0, acceleration=0.5
    ),
    "usual": ComfortSettings(),
    "free": ComfortSettings(headset_vignette=0.0, horizon=False),
}
"""Presets of the menu."""


class DisplaySettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The table `[display]`."""

    mode: Annotated[str, Meta(description="as --display: mono, a mode for two eyes, or dome …")] = (
        "mono"
    )
    quality: Annotated[
        Literal["auto", "low", "medium", "high", "ultra"],
        Meta(description="auto, low, medium, high or ultra"),
    ] = "auto"
    fullscreen: Annotated[bool, Meta(description="whether the dive begins on the full screen")] = (
        False
    )
    size: Annotated[
        tuple[Pixels, Pixels], Meta(description="of the window: width and height in pixels")
    ] = (1280, 720)
    introduction: Annotated[
        Literal["full", "short", "off"],
        Meta(description="how a dive begins: full (short for those who return), short or off"),
    ] = "full"
    text: Annotated[
        Literal["normal", "large", "largest"],
        Meta(description="the size of all text: normal, large or largest"),
    ] = "normal"
    contrast: Annotated[
        bool, Meta(description="opaque grounds behind text, and no thin or quiet lines")
    ] = False
    language: Annotated[
        Literal["auto", "en", "de", "es", "fr", "ja"],
        Meta(description="of what visitors read: auto (as the desktop), en, de, es, fr or ja"),
    ] = "auto"


class AttractSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The table `[attract]`."""

    after_min: Annotated[
        float, Meta(ge=0, le=1440, description="minutes without any input; 0: never")
    ] = 3.0
    tour: Annotated[
        str, Meta(description="one of the scenario's, directed, or auto: where something happens")
    ] = "auto"


class KioskSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The table `[kiosk]`."""

    leave: Annotated[str, Meta(description="the operator's key, which ends the dive")] = (
        "Ctrl+Shift+Q"
    )
    cue: Annotated[str, Meta(description="the operator's key to the next item of a show")] = (
        "Ctrl+Shift+N"
    )
    prompts: Annotated[
        bool, Meta(description="whether prompts tell each visitor what to do first")
    ] = False
    volume: Annotated[
        float, Meta(ge=0, le=1, description="0 to 1: of the sound, instead of `sound.volume`")
    ] = 0.6
    score: Annotated[
        bool, Meta(description="whether a quiet score is played, instead of `sound.score`")
    ] = False


class PictureSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The table `[pictures]`."""

    folder: Annotated[
        str, Meta(description="where they go; empty: subsea in the user's pictures")
    ] = ""
    instruments: Annotated[
        bool, Meta(description="with instruments, panels and all text of the window")
    ] = False
    logbook: Annotated[bool, Meta(description="whether to keep a logbook of what you see")] = True


class SoundSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The table `[sound]`."""

    volume: Annotated[float, Meta(ge=0, le=1, description="0 to 1: of everything")] = 0.8
    sea: Annotated[
        float, Meta(ge=0, le=1, description="0 to 1: reef, bubbles, sand, waves, and the winch")
    ] = 1.0
    fishes: Annotated[
        float, Meta(ge=0, le=1, description="0 to 1: schools, mouths, turns, strikes, large ones")
    ] = 1.0
    vessel: Annotated[
        float, Meta(ge=0, le=1, description="0 to 1: motor, water at the hull, breath, knocks")
    ] = 1.0
    score: Annotated[bool, Meta(description="whether a quiet score is played")] = False
    score_level: Annotated[float, Meta(ge=0, le=1, description="0 to 1: of the score")] = 0.7
    mute: Annotated[bool, Meta(description="whether the dive begins without sound")] = False
    night: Annotated[bool, Meta(description="whether loud sounds are softer")] = False
    captions: Annotated[bool, Meta(description="whether sounds are shown in words")] = False
    layout: Annotated[
        Literal["mono", "stereo", "binaural", "quad", "5.1", "7.1"],
        Meta(description="stereo, binaural for headphones, mono, quad, 5.1 or 7.1"),
    ] = "stereo"


class Settings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """All settings, with their defaults."""

    # Only those in the file: see `bindings`.
    controls: dict[str, list[str]] = msgspec.field(default_factory=dict)
    mouse: Annotated[
        MouseSettings,
        Meta(description="The pointer at the helm; its buttons are in `[controls]`."),
    ] = MouseSettings()
    gamepad: Annotated[
        GamepadSettings,
        Meta(
            description="The sticks of a gamepad; what they and its buttons do is in `[controls]`."
        ),
    ] = GamepadSettings()
    comfort: Annotated[
        ComfortSettings,
        Meta(description="Against motion sickness. The hull never rolls and never jerks."),
    ] = ComfortSettings()
    display: Annotated[
        DisplaySettings,
        Meta(description="The picture, where the command line says nothing else."),
    ] = DisplaySettings()
    attract: Annotated[
        AttractSettings,
        Meta(description="The tour that begins when there is no input."),
    ] = AttractSettings()
    kiosk: Annotated[KioskSettings, Meta(description="Settings of --kiosk only.")] = KioskSettings()
    pictures: Annotated[
        PictureSettings,
        Meta(description="Pictures and films that are taken during a dive."),
    ] = PictureSettings()
    sound: Annotated[SoundSettings, Meta(description="The sound of a dive.")] = SoundSettings()

    @property
    def bindings(self) -> Bindings:
        """The bindings of all inputs."""
        return bindings_of(self.controls)


DEFAULTS = Settings()


def settings_path() -> Path:
    """The path of the settings if no file is named; it may not exist."""
    return platformdirs.user_config_path("subsea", appauthor=False) / "settings.toml"


def read_settings(path: Path) -> Settings:
    """Read a settings file. A UserError names the key and what was expected."""
    settings = load_toml(path, Settings)
    for place, check in (
        ("controls", lambda: settings.bindings),
        ("display.mode", lambda: _check_mode(settings.display.mode)),
        ("kiosk.leave", lambda: input_name(settings.kiosk.leave)),
        ("kiosk.cue", lambda: input_name(settings.kiosk.cue)),
    ):
        try:
            check()
        except UserError as fault:
            key = place if fault.key is None else f"{place}.{fault.key}"
            raise error_at(path, key, f"{fault}, at `{place}`") from None
    return settings


def usual_settings(tell: Callable[[str], None]) -> Settings:
    """The settings in the usual place, or the defaults.

    A faulty file is renamed and reported in one line; an unreadable one is reported and left.
    """
    path = settings_path()
    try:
        read_text(path)
    except UserError as fault:
        if isinstance(fault.__cause__, FileNotFoundError | NotADirectoryError):
            return DEFAULTS
        tell(f"{fault}; the defaults are used")
        return DEFAULTS
    try:
        return read_settings(path)
    except UserError as fault:
        tell(f"{fault}; {_rename_aside(path)}")
        return DEFAULTS


def kiosk_settings(settings: Settings) -> Settings:
    """The same settings with inputs for visitors only, and the operator's keys.

    A UserError if one of these is an input of visitors.
    """
    nothing: dict[str, list[str]] = {wish: [] for wish in COMMANDS if wish not in KIOSK_COMMANDS}
    controls = settings.controls | nothing
    keys = {name: input_name(getattr(settings.kiosk, name)) for name in ("cue", "leave")}
    for name, key in keys.items():
        free = controls | {"cue": [], "leave": []}
        others: list[str] = [*bindings_of(free).controls.get(key, ())]
        others += [other for other in keys if other > name and keys[other] == key]
        if others:
            raise UserError(
                f"--kiosk: {key!r} cannot be both {name!r} and {others[0]!r}, "
                f"at `kiosk.{name}` of the settings"
            )
    kiosk = settings.kiosk
    sound = msgspec.structs.replace(settings.sound, volume=kiosk.volume, score=kiosk.score)
    controls |= {name: [key] for name, key in keys.items()}
    return msgspec.structs.replace(settings, controls=controls, sound=sound)


def write_settings(path: Path, force: bool = False) -> None:
    """Write a file with every setting at its default; replaces a file only with `force`."""
    if path.exists() and not force:
        raise UserError("exists; rename it, or give --force to replace it", file=path)
    with replacing(path) as part:
        part.write_text(default_text(), encoding="utf-8")


def default_text() -> str:
    """The text of a settings file that explains every key and changes none."""
    lines = [
        "# The settings of subsea. Every line below is as it is without this file:",
        "# take its first # away and change it.",
    ]
    for table in inspect.type_info(Settings).fields:  # type: ignore[attr-defined]
        lines += ["", f"[{table.encode_name}]", *_rows(table)]
    return "\n".join(lines) + "\n"


def show_settings(write: bool, force: bool = False) -> int:
    """`subsea settings`: print the path, or write the defaults there; exit code 0."""
    path = settings_path()
    if write:
        write_settings(path, force)
    elif path.exists():
        read_settings(path)
    print_line(path if path.exists() else f"{path} (missing; `subsea settings --write` writes it)")
    return 0


def _rows(table: Any) -> Iterator[str]:
    """The lines of a table: its purpose and its keys."""
    if table.encode_name == "controls":
        yield "# Actions of inputs. Keys are named by their place on a US keyboard, alone or as"
        yield "# Ctrl+Shift+Q; mouse left, right, middle, 4 to 8; the parts of a gamepad as below."
        for name, control in CONTROLS.items():
            key = name if name.isidentifier() else json.dumps(name)
            inputs = json.dumps(list(control.inputs))
            yield f"# {key} = {inputs}  # {control.what}"
        return
    yield f"# {table.type.extra_json_schema['description']}"
    for field in table.type.type.fields:
        default = field.default
        value = json.dumps(list(default) if isinstance(default, tuple) else default)
        about = field.type.extra_json_schema or {}
        yield f"# {field.encode_name} = {value}  # {about['description']}"


def _check_mode(mode: str) -> None:
    from subsea.view.display_rigs import check_display

    check_display(mode)


def _rename_aside(path: Path) -> str:
    """Rename a file to the first free `kept-N`; returns what was done, as a text."""
    number = 1
    while (other := path.with_name(f"{path.name}.kept-{number}")).exists():
        number += 1
    try:
        path.rename(other)
    except OSError as fault:
        return f"the defaults are used (it cannot be renamed: {fault.strerror})"
    return f"it is kept as {other.name}, and the defaults are used"
