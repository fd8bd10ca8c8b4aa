"""The commands of a presenter, which the page, HTTP and OSC share."""

from collections.abc import Sequence
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta, inspect

from subsea.base.errors import UserError, unknown
from subsea.base.validation import convert

MAX_CAPTION = 300  # characters
Name = Annotated[str, Meta(min_length=1, max_length=100)]
Fish = Annotated[
    str,
    Meta(
        min_length=1,
        max_length=100,
        description="a number, a species, SPECIES:NUMBER, or nearest: to the middle of the picture",
    ),
]


class PresenterCommand(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="command"
):
    """Base of all commands."""


class OpenScenario(PresenterCommand, frozen=True, tag="scenario"):
    """The command `scenario`."""

    name: Annotated[Name, Meta(description="as `subsea dive --scenario` takes it; no path")]


class StartTour(PresenterCommand, frozen=True, tag="tour"):
    """The command `tour`."""

    name: Annotated[Name, Meta(description="one of the scenario's, directed or auto")]


class StopTour(PresenterCommand, frozen=True, tag="stop-tour"):
    """The command `stop-tour`."""


class StartCue(PresenterCommand, frozen=True, tag="cue"):
    """The command `cue`."""

    number: Annotated[
        int, Meta(ge=-1, le=1000, description="from 0; -1: the first that has not begun")
    ] = -1


class NextItem(PresenterCommand, frozen=True, tag="next-item"):
    """The command `next-item`."""


class GoToItem(PresenterCommand, frozen=True, tag="item"):
    """The command `item`."""

    number: Annotated[int, Meta(ge=1, le=200, description="from 1")]


class EditItem(PresenterCommand, frozen=True, tag="edit-item"):
    """The command `edit-item`."""

    number: Annotated[int, Meta(ge=1, le=200, description="from 1")]
    key: Annotated[
        Literal["start", "for_s", "caption", "caption_s", "fade_s", "tour", "days"],
        Meta(description="start, for_s, caption, caption_s, fade_s, tour or days"),
    ]
    value: Annotated[
        str, Meta(max_length=400, description="a TOML value or a text; empty: without the key")
    ]


class AddSpecialDay(PresenterCommand, frozen=True, tag="special-day"):
    """The command `special-day`."""

    date: Annotated[str, Meta(max_length=10, description="such as 2026-12-24, or each year 12-24")]
    title: Annotated[str, Meta(max_length=100, description="its name, which may be empty")]
    hours: Annotated[str, Meta(max_length=100, description="such as 10:00-14:00, or closed")] = (
        "closed"
    )
    days: Annotated[int, Meta(ge=1, le=366, description="on end; 1 if it is left out")] = 1


class RemoveSpecialDay(PresenterCommand, frozen=True, tag="remove-special-day"):
    """The command `remove-special-day`."""

    number: Annotated[int, Meta(ge=1, le=400, description="from 1, in the order of the file")]


class ShowCaption(PresenterCommand, frozen=True, tag="caption"):
    """The command `caption`."""

    text: Annotated[str, Meta(max_length=MAX_CAPTION, description="300 characters at most")]
    seconds: Annotated[
        float, Meta(ge=0, le=600, description="how long; 0: the time to read it")
    ] = 0.0


class FollowFish(PresenterCommand, frozen=True, tag="follow"):
    """The command `follow`."""

    fish: Fish


class RideFish(PresenterCommand, frozen=True, tag="ride"):
    """The command `ride`."""

    fish: Fish


class LeaveFish(PresenterCommand, frozen=True, tag="helm"):
    """The command `helm`."""


class FeedFishes(PresenterCommand, frozen=True, tag="feed"):
    """The command `feed`."""


class SetQuality(PresenterCommand, frozen=True, tag="quality"):
    """The command `quality`."""

    quality: Annotated[
        Literal["auto", "low", "medium", "high", "ultra"],
        Meta(description="auto, low, medium, high or ultra"),
    ]


class SetVolume(PresenterCommand, frozen=True, tag="volume"):
    """The command `volume`."""

    volume: Annotated[float, Meta(ge=0, le=1, description="0 to 1; 0: off")]


class BlankScreens(PresenterCommand, frozen=True, tag="blank"):
    """The command `blank`."""

    on: bool


class ShowLineUp(PresenterCommand, frozen=True, tag="line-up"):
    """The command `line-up`."""

    on: bool


class LineUpCommand(PresenterCommand, frozen=True):
    """Base of the commands for line-up on the wall."""


class EditLineUp(LineUpCommand, frozen=True, tag="line-up-edit"):
    """The command `line-up-edit`."""

    on: bool


class ChooseLineUp(LineUpCommand, frozen=True, tag="line-up-choose"):
    """The command `line-up-choose`."""

    channel: Annotated[
        str, Meta(max_length=256, description="name, `next` or `previous`; empty: the same")
    ] = ""
    point: Annotated[
        str,
        Meta(
            max_length=20,
            description="`upper_left` and so on, ROW,COLUMN, edge:NUMBER, `next` or `previous`",
        ),
    ] = ""


class MoveLineUp(LineUpCommand, frozen=True, tag="line-up-move"):
    """The command `line-up-move`."""

    right: Annotated[float, Meta(ge=-10_000, le=10_000, description="pixels")] = 0.0
    down: Annotated[float, Meta(ge=-10_000, le=10_000, description="pixels")] = 0.0


class SetLineUp(LineUpCommand, frozen=True, tag="line-up-set"):
    """The command `line-up-set`."""

    key: Annotated[Name, Meta(description="of the chosen channel's adjustment, or grid")]
    value: Annotated[Any, Meta(description="as in a theatre file; none: the default")] = None


class ShowLineUpPattern(LineUpCommand, frozen=True, tag="line-up-show"):
    """The command `line-up-show`."""

    pattern: Annotated[
        Literal["", "grid", "white", "grey", "black", "sea"],
        Meta(description="grid, white, grey, black or sea; empty: the same"),
    ] = ""
    others: Annotated[
        Literal["", "full", "dim", "black"],
        Meta(description="other channels: full, dim or black; empty: the same"),
    ] = ""


class UndoLineUp(LineUpCommand, frozen=True, tag="line-up-undo"):
    """The command `line-up-undo`."""


class RedoLineUp(LineUpCommand, frozen=True, tag="line-up-redo"):
    """The command `line-up-redo`."""


class CompareLineUp(LineUpCommand, frozen=True, tag="line-up-compare"):
    """The command `line-up-compare`."""

    on: bool


class SaveLineUp(LineUpCommand, frozen=True, tag="line-up-save"):
    """The command `line-up-save`."""


class ShowStructuredLight(PresenterCommand, frozen=True, tag="structured-light"):
    """The command `structured-light`."""

    number: Annotated[
        int,
        Meta(ge=-1, le=10_000, description="from 1; 0: the sea again; -1: the next"),
    ] = -1


class RestartNode(PresenterCommand, frozen=True, tag="restart"):
    """The command `restart`."""

    node: Annotated[Name, Meta(description="a node of the theatre, or all")]


class WakeNode(PresenterCommand, frozen=True, tag="wake"):
    """The command `wake`."""

    node: Annotated[Name, Meta(description="a node with a `mac` in the theatre file, or all")]


class SwitchProjector(PresenterCommand, frozen=True, tag="projector"):
    """The command `projector`."""

    name: Annotated[Name, Meta(description="a [[projector]] of the theatre file, or all")]
    on: bool


COMMANDS: dict[type[PresenterCommand], str] = {
    OpenScenario: "Open a scenario",
    StartTour: "Start a tour",
    StopTour: "End the tour",
    StartCue: "Start a direction of the scenario now, whatever its conditions",
    NextItem: "Go on to the next item of the show",
    GoToItem: "Go to an item of the show",
    EditItem: "Change a key of an item in the file of the show, from its next start on",
    AddSpecialDay: "Add a special day to the file of the show",
    RemoveSpecialDay: "Remove a special day from the file of the show",
    ShowCaption: "Show a caption; an empty one ends the one before",
    FollowFish: "Look at a fish from behind",
    RideFish: "Look through the eyes of a fish",
    LeaveFish: "Return from a fish to the submarine",
    FeedFishes: "Scatter food before the submarine, at most every 4 s",
    SetQuality: "Set the quality of the picture",
    SetVolume: "Set the volume",
    BlankScreens: "Make all screens black, or show the sea again",
    ShowLineUp: "Show the test pattern on all screens, or the sea again",
    EditLineUp: "Begin to line up the projectors of a theatre, or return to its file and the sea",
    ChooseLineUp: "Choose a channel of the theatre, and a corner or point of its picture",
    MoveLineUp: "Move the chosen point",
    SetLineUp: "Set a key of the chosen channel",
    ShowLineUpPattern: "Show a pattern or the sea, and the other channels like it, dim or black",
    UndoLineUp: "Take the last change of the line-up back",
    RedoLineUp: "Make it again",
    CompareLineUp: "Show what the theatre file has for comparison, or the changes again",
    SaveLineUp: "Save the line-up into the theatre file, on all computers",
    RestartNode: "End the dive of a computer, and start it again with the same options",
    WakeNode: "Switch a computer on through the network",
    SwitchProjector: "Switch a projector on, or to standby",
    ShowStructuredLight: "Show a picture of a theatre's structured light to calibrate it",
}
"""The commands with their purposes, for clients and the reference."""
NAMES = {str(kind.__struct_config__.tag): kind for kind in COMMANDS}


def from_json(data: bytes) -> PresenterCommand:
    """Decode ``{"command": NAME, KEY: VALUE…}``; a UserError for anything else."""
    try:
        content = msgspec.json.decode(data)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as fault:
        raise UserError(f"not JSON ({fault})") from fault
    name = content.get("command") if isinstance(content, dict) else None
    if not isinstance(name, str):
        raise UserError('expected {"command": NAME, KEY: VALUE…}')
    return _built(name, content)


def to_json(command: PresenterCommand) -> bytes:
    """Encode a command as `from_json` decodes it."""
    return msgspec.json.encode(command)


def from_words(name: str, values: Sequence[Any]) -> PresenterCommand | None:
    """Build a command of its name and values in the order of its keys; or a UserError.

    One value more is the state of a button: 1 triggers the command, 0 gives None.
    """
    keys = _kind(name).__struct_fields__
    pressed = True
    if len(values) == len(keys) + 1 and values[-1] in (0, 1):
        *values, pressed = values
    if len(values) > len(keys):
        raise UserError(f"{len(values)} values, expected {len(keys)} at most")
    command = _built(name, dict(zip(keys, values, strict=False)))
    return command if pressed else None


def described() -> list[dict[str, Any]]:
    """Name, purpose and parameters of each command, for clients and the reference."""
    return [
        {
            "command": name,
            "what": COMMANDS[kind],
            "parameters": [_parameter(field) for field in _fields(kind)],
        }
        for name, kind in NAMES.items()
    ]


def _built(name: str, content: dict[str, Any]) -> PresenterCommand:
    """Build a command of values by key. Control surfaces know only floats, so these stand for all.

    1.0 and 0.0 are yes and no, a whole number may be a float, and a fish a number.
    """
    kind = _kind(name)
    for field in _fields(kind):
        value, wanted = content.get(field.encode_name), field.type
        while isinstance(wanted, inspect.Metadata):
            wanted = wanted.type
        if isinstance(value, bool) or not isinstance(value, int | float):
            continue
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if isinstance(wanted, inspect.BoolType) and value in (0, 1):
            value = bool(value)
        elif field.encode_name == "fish" and isinstance(value, int):
            value = str(value)
        content[field.encode_name] = value
    return convert({**content, "command": name}, kind)


def _kind(name: str) -> type[PresenterCommand]:
    if name not in NAMES:
        raise unknown("command", name[:100], list(NAMES))
    return NAMES[name]


def _fields(kind: type[PresenterCommand]) -> Sequence[Any]:
    return inspect.type_info(kind).fields  # type: ignore[attr-defined]


def _parameter(field: Any) -> dict[str, Any]:
    about, type_ = "true or false", field.type
    while isinstance(type_, inspect.Metadata):
        about = (type_.extra_json_schema or {}).get("description", about)
        type_ = type_.type
    return {"name": field.encode_name, "about": about, "required": field.required}
