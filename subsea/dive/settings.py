"""User settings: `settings.toml` in the folder of the platform, or a file by name."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
import platformdirs
from msgspec import Meta, inspect

from subsea.base.atomic_io import replacing
from subsea.base.errors import UserError
from subsea.base.input_files import read_input
from subsea.base.toml_files import error_at, load_toml
from subsea.dive.bindings import COMMANDS, CONTROLS, Bindings, Command, bindings_of, input_name

# Commands of visitors; in a kiosk all others have no inputs.
KIOSK_COMMANDS: tuple[Command, ...] = (
    "help", "menu", "ride", "look", "follow", "reins", "alight", "lights", "language", "cue",
    "leave",
)  # fmt: skip

Pixels = Annotated[int, Meta(ge=64, le=8192)]


class MouseSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The pointer at the helm; its buttons are in `[controls]`."""

    steer: Annotated[bool, Meta(description="whether the submarine turns to the pointer")] = True
    invert_pitch: Annotated[
        bool, Meta(description="whether the pointer below the middle lifts the nose")
    ] = False
    sensitivity: Annotated[
        float,
        Meta(ge=0.2, le=5, description="0.2 to 5: above 1 the pointer need not go to the edge"),
    ] = 1.0


class GamepadSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The sticks of a gamepad; what they and its buttons do is in `[controls]`."""

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
    """Against motion sickness. The hull never rolls and never jerks."""

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
    """The picture, where the command line says nothing else."""

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
    language: Annotated[
        Literal["auto", "en", "de", "es", "fr", "ja"],
        Meta(description="of what visitors read: auto (as the desktop), en, de, es, fr or ja"),
    ] = "auto"


class AttractSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The tour that begins when there is no input."""

    after_min: Annotated[
        float, Meta(ge=0, le=1440, description="minutes without any input; 0: never")
    ] = 3.0
    tour: Annotated[
        str, Meta(description="one of the scenario's, directed, or auto: where something happens")
    ] = "auto"


class KioskSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Settings of --kiosk only."""

    leave: Annotated[str, Meta(description="the operator's key, which ends the dive")] = (
        "Ctrl+Shift+Q"
    )
    cue: Annotated[str, Meta(description="the operator's key to the next item of a show")] = (
        "Ctrl+Shift+N"
    )
    volume: Annotated[
        float, Meta(ge=0, le=1, description="0 to 1: of the sound, instead of `sound.volume`")
    ] = 0.6


class PictureSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Pictures and films that are taken during a dive."""

    folder: Annotated[
        str, Meta(description="where they go; empty: subsea in the user's pictures")
    ] = ""
    instruments: Annotated[
        bool, Meta(description="with instruments, panels and all text of the window")
    ] = False


class SoundSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The sound of a dive."""

    volume: Annotated[float, Meta(ge=0, le=1, description="0 to 1: of everything")] = 0.8
    sea: Annotated[
        float, Meta(ge=0, le=1, description="0 to 1: reef, bubbles, waves, and the hook's winch")
    ] = 1.0
    fishes: Annotated[
        float, Meta(ge=0, le=1, description="0 to 1: schools, mouths, turns and strikes")
    ] = 1.0
    vessel: Annotated[
        float, Meta(ge=0, le=1, description="0 to 1: motor, water at the hull, breath, knocks")
    ] = 1.0
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
    mouse: MouseSettings = MouseSettings()
    gamepad: GamepadSettings = GamepadSettings()
    comfort: ComfortSettings = ComfortSettings()
    display: DisplaySettings = DisplaySettings()
    attract: AttractSettings = AttractSettings()
    kiosk: KioskSettings = KioskSettings()
    pictures: PictureSettings = PictureSettings()
    sound: SoundSettings = SoundSettings()

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
        read_input(path)
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
    sound = msgspec.structs.replace(settings.sound, volume=settings.kiosk.volume)
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
    print(path if path.exists() else f"{path} (missing; `subsea settings --write` writes it)")
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
    yield f"# {table.type.cls.__doc__}"
    for field in table.type.fields:
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
