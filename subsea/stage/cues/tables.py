"""Tables of a show file for cues in and out: `[osc]`, `[timecode]` and `[midi]`."""

import shlex
from typing import Annotated, Any, Literal

import msgspec

from subsea.stage.cues.timecode import RATES, Rate
from subsea.stage.theatre.theatre_file import parse_address

Seven = Annotated[int, msgspec.Meta(ge=0, le=127)]
Device = Annotated[str, msgspec.Meta(max_length=200)]


class CueTable(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A table about cues."""


class OscOut(CueTable, frozen=True, kw_only=True):
    """The receiver of OSC messages."""

    address: str

    def __post_init__(self) -> None:
        """Refuse an address without a port."""
        parse_address(self.address)


class TimecodeIn(CueTable, frozen=True, kw_only=True):
    """The timecode that starts items."""

    source: Literal["midi", "ltc"]
    device: Device = ""  # a part of the name of the MIDI port or sound device; empty: the first
    rate: float = 25.0  # frames a second

    def __post_init__(self) -> None:
        """Refuse other rates than film and television have."""
        if f"{self.rate:g}" not in RATES:
            raise ValueError(f"`rate` is {self.rate:g}, expected {', '.join(RATES)}")

    @property
    def frames(self) -> Rate:
        """The rate by its name."""
        return next(name for name in RATES if name == f"{self.rate:g}")


class MidiCue(CueTable, frozen=True, kw_only=True):
    """A message of a MIDI device, and the command of a presenter that it gives."""

    note: Seven | None = None
    control: Seven | None = None
    program: Seven | None = None
    channel: Annotated[int, msgspec.Meta(ge=1, le=16)] | None = None  # None: any
    command: Annotated[str, msgspec.Meta(min_length=1, max_length=400)]

    def __post_init__(self) -> None:
        """Require one kind of message, and a command of words."""
        if sum(one is not None for one in (self.note, self.control, self.program)) != 1:
            raise ValueError("expected one of `note`, `control` and `program`")
        try:
            words_of(self.command)
        except ValueError as fault:
            raise ValueError(f"`command`: {fault}") from None


class MidiIn(CueTable, frozen=True, kw_only=True):
    """The MIDI device whose messages give commands."""

    port: Device = ""  # a part of its name; empty: the first
    cue: Annotated[list[MidiCue], msgspec.Meta(min_length=1, max_length=200)]


def words_of(text: str) -> tuple[str, list[Any]]:
    """Split a text such as ``/eos/go 1 2.5 "a text"`` into its first word and its values.

    Values are whole numbers, numbers, ``true``, ``false`` or texts. A ValueError for no words.
    """
    try:
        first, *words = shlex.split(text)
    except ValueError as fault:
        raise ValueError(f"{text!r}: expected a word, then values ({fault})") from None
    return first, [_value(word) for word in words]


def check_message(text: str) -> None:
    """Raise a ValueError for a text without the address of an OSC message."""
    address, _ = words_of(text)
    if not address.startswith("/") or not address.isascii() or set(address) & set(" #*,?[]{}"):
        raise ValueError(f"{text!r}: expected an address such as /cue/4/start, then values")


def _value(word: str) -> Any:
    for read in (int, float):
        try:
            return read(word)
        except ValueError:
            pass
    return {"true": True, "false": False}.get(word, word)
