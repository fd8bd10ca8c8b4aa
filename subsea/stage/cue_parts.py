"""The parts of a dive for cues: lamps of the room, and the OSC, timecode and MIDI of a show."""

import time
from argparse import Namespace
from collections.abc import Callable
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

from subsea.base.errors import UserError
from subsea.base.progress import count_noun, say
from subsea.dive.part import DivePart

if TYPE_CHECKING:
    from subsea.dive.options import DiveOptions
    from subsea.dive.presented import Presented
    from subsea.stage.console.remote_control import RemoteControl
    from subsea.stage.cues.tables import MidiCue
    from subsea.stage.show_file import Show
    from subsea.stage.show_player import ShowScreens
    from subsea.ui.dive import Dive

MOST_A_FRAME = 32  # messages of MIDI


class LightsPart(DivePart):
    """Sends the sea's light to the lamps of a theatre, from the computer with the pilot."""

    def __init__(self, theatre: str) -> None:
        """`theatre` is its name or file."""
        self._name = theatre
        self._sender: Any = None  # None: there are no lamps
        self._next_s = 0.0

    @classmethod
    def made(cls, options: Namespace, dive: "DiveOptions") -> "LightsPart | None":
        """Make the part for `--theatre`."""
        return None if options.theatre is None else cls(options.theatre)

    def begin(self, dive: "Dive") -> None:
        """Begin to send, if the theatre has lamps."""
        from subsea.stage.theatre.load import load_theatre

        theatre, _ = load_theatre(self._name)
        if not theatre.lamp or theatre.lights is None or not dive.tick_source.has_pilot:
            return
        from subsea.stage.cues.dmx import LightSender, place_of
        from subsea.stage.cues.room_light import SeaLight

        self._lamps, self._lights = theatre.lamp, theatre.lights
        self._sea, self._sender = SeaLight(self._lamps), LightSender(self._lights)
        universes = sorted({lamp.universe for lamp in self._lamps})
        places = ", ".join(
            f"universe {one} to {place_of(self._lights, one)[0]}" for one in universes
        )
        lamps = count_noun(len(self._lamps), "lamp", "lamps")
        say(f"{lamps} by {self._lights.protocol}: {places}")

    def shown(self, dive: "Dive") -> None:
        """Set the lamps, as often as they are sent."""
        now = time.monotonic()
        if self._sender is None or now < self._next_s:
            return
        self._next_s = now + 1.0 / self._lights.rate
        if line := self._sender.check():
            dive.faults.say(line)
        self._sender.set(self._universes(dive))

    def close(self) -> None:
        """Leave the lamps as they are while the screens are black."""
        if self._sender is None:
            return
        from subsea.stage.cues.room_light import dark_levels

        self._sender.set(dark_levels(self._lamps, self._lights.dark))
        self._sender.close()
        self._sender = None

    def _universes(self, dive: "Dive") -> dict[int, bytes]:
        from subsea.stage.cues.room_light import universes_of
        from subsea.world.world import TICK_S

        world, picture = dive.world, dive.picture
        time_s = (world.state.tick - 1 + picture.alpha) * TICK_S
        light = self._sea.at(world.scenario.water, picture.observer, time_s)
        blank = 1.0 if dive.black else dive.tick_source.presented.blank
        return universes_of(self._lamps, self._lights, light, blank)


class CuesPart(DivePart):
    """Follows a timecode, takes commands by MIDI and sends OSC, as the tables of a show say."""

    leads = True

    def __init__(self, screens: "ShowScreens") -> None:
        """`screens` play the show."""
        self._screens, self._show = screens, screens.show
        self._remote: RemoteControl | None = None  # of its own, without a console
        self._board: Any = None
        self._osc: Any = None
        self._inputs: list[Any] = []
        self._follower: Any = None
        self._messages: SimpleQueue[Any] = SimpleQueue()
        self._labels: SimpleQueue[tuple[float, float]] = SimpleQueue()
        self._told: dict[str, Any] = {}  # the values sent last, by address
        self._jumps, self._following, self._rates = 0, False, set[str]()

    def begin(self, dive: "Dive") -> None:
        """Open the devices; one that is missing may come."""
        show = self._show
        if show.osc is not None:
            from subsea.stage.cues.osc_out import OscSender

            self._osc = OscSender(show.osc.address)
            say(f"OSC to {show.osc.address}")
        if show.midi is not None:
            self._board = self._find_board(dive)
        if show.timecode is not None:
            from subsea.stage.cues.timecode import TimecodeFollower

            self._follower = TimecodeFollower()
        self._open_inputs()

    def before(self, dive: "Dive", elapsed_s: float) -> bool:
        """Apply what was heard."""
        for one in self._inputs:
            if line := one.check():
                dive.note(line)
        if self._board is not None:
            self._take_messages()
        if self._follower is not None:
            self._follow(dive)
        if self._remote is not None:
            self._remote.update(elapsed_s)
        return False

    def over(self, presented: "Presented") -> "Presented":
        """Show what MIDI commands lay over the sea."""
        return presented if self._remote is None else self._remote.presented

    def shown(self, dive: "Dive") -> None:
        """Send what has changed."""
        if self._osc is None:
            return
        player = self._screens.player
        self._tell("/subsea/open", player.open)
        self._tell("/subsea/blank", dive.tick_source.presented.blank >= 1.0)
        if player.shown is not None and self._tell(
            "/subsea/item",
            player.shown + 1,
            dive.source.stem,
            player.show.item[player.shown].tour or "",
        ):
            from subsea.stage.cues.tables import words_of

            for text in player.show.item[player.shown].osc:
                address, values = words_of(text)
                self._osc.send(address, *values)
        began = dive.world.state.directions.began[: len(dive.world.scenario.direction)]
        if begun := [k for k, tick in enumerate(began.tolist()) if tick >= 0]:
            last = max(begun, key=lambda k: int(began[k]))
            self._tell("/subsea/cue", last, dive.world.scenario.direction[last].name)
        if line := self._osc.check():
            dive.faults.say(line)

    def close(self) -> None:
        """Close the devices."""
        for one in (*self._inputs, self._osc, self._remote):
            if one is not None:
                one.close()
        self._inputs, self._osc, self._remote = [], None, None

    def _tell(self, address: str, *values: Any) -> bool:
        """Send values that differ from the last ones; True if they were sent."""
        if self._told.get(address) == values:
            return False
        self._told[address] = values
        self._osc.send(address, *values)
        return True

    def _find_board(self, dive: "Dive") -> Any:
        """The board of the console, or of a presenter of its own."""
        from subsea.stage.console.board import Board
        from subsea.stage.console.remote_control import RemoteControl

        for part in dive.parts:
            if (remote := getattr(part, "remote", None)) is not None:
                return remote.board
        self._remote = RemoteControl(dive, Board(), None, self._screens)
        return self._remote.board

    def _open_inputs(self) -> None:
        timecode, midi = self._show.timecode, self._show.midi
        if timecode is not None and timecode.source == "ltc":
            from subsea.stage.cues.ltc import LtcInput

            self._inputs.append(LtcInput(timecode.device, self._hear_label))
        by_midi = timecode if timecode is not None and timecode.source == "midi" else None
        ports: dict[str, Callable[[Any], object]] = {}
        if midi is not None:
            ports[midi.port] = self._messages.put
        if by_midi is not None or midi is not None:
            from subsea.stage.cues.midi_in import MidiInput, MtcReader

            self._reader = MtcReader()
        if by_midi is not None:
            port = by_midi.device or ("" if midi is None else midi.port)
            ports[port] = self._hear_both if port in ports else self._hear_mtc
        for port, hear in ports.items():
            self._inputs.append(MidiInput(port, hear))

    def _hear_label(self, label: Any, late: float = 0.0) -> None:
        """Take a label, `late` by a number of frames; called in a thread of a device."""
        from subsea.stage.cues.timecode import RATES, seconds_of

        assert self._show.timecode is not None
        rate = self._show.timecode.frames
        self._labels.put((seconds_of(label, rate) + late / RATES[rate], time.monotonic()))

    def _hear_mtc(self, message: Any) -> None:
        if (heard := self._reader.take(message)) is not None:
            self._rates.add(heard[1])
            self._hear_label(heard[0], heard[2])

    def _hear_both(self, message: Any) -> None:
        self._hear_mtc(message)
        self._messages.put(message)

    def _take_messages(self) -> None:
        """Give the commands of messages that have come."""
        assert self._show.midi is not None
        for _ in range(MOST_A_FRAME):
            try:
                message = self._messages.get_nowait()
            except Empty:
                return
            for cue in self._show.midi.cue:
                if (values := values_of(cue, message)) is not None:
                    self._give(cue, values)

    def _give(self, cue: "MidiCue", values: list[float]) -> None:
        try:
            command = command_of(cue, values)
            if command is not None:
                self._board.put(command)
        except UserError as fault:
            self._board.refusals.add(f"MIDI {cue.command[:100]}: {fault}")

    def _follow(self, dive: "Dive") -> None:
        """Let the show follow the timecode; each jump and stop is a line."""
        follower = self._follower
        while not self._labels.empty():
            follower.hear(*self._labels.get_nowait())
        time_s = follower.time_at(time.monotonic())
        if time_s is not None and (follower.jumps != self._jumps or not self._following):
            clock = time.strftime("%H:%M:%S", time.gmtime(time_s))
            dive.note(f"timecode: the show follows it, from {clock} on")
        elif time_s is None and self._following:
            dive.note("timecode: it has stopped; the show goes on alone")
        self._following, self._jumps = time_s is not None, follower.jumps
        assert self._show.timecode is not None
        for rate in self._rates - {self._show.timecode.frames}:
            dive.note(f"timecode: it has {rate} frames a second, and `rate` of the show is "
                      f"{self._show.timecode.frames}")  # fmt: skip
        self._rates.clear()
        self._screens.player.follow(time_s, follower.jumps)


def cues_of(screens: "ShowScreens") -> CuesPart | None:
    """The part for the tables of a show; None if it has none."""
    show = screens.show
    if show.osc is None and show.timecode is None and show.midi is None:
        return None
    check_cues(show, screens.path)
    return CuesPart(screens)


def check_cues(show: "Show", path: Path) -> None:
    """Raise a UserError for a command of MIDI that no presenter knows, or a missing package."""
    from subsea.base.system import require
    from subsea.base.toml_files import error_at

    by_midi = show.timecode is not None and show.timecode.source == "midi"
    if show.osc is not None or show.midi is not None or by_midi:
        require("cues", "`[osc]`, `[midi]` and `[timecode]`")
    for k, cue in enumerate(show.midi.cue if show.midi is not None else ()):
        try:
            command_of(cue, [1.0])
        except UserError as fault:
            raise error_at(path, f"midi.cue[{k}].command", f"`command`: {fault}") from None


def values_of(cue: "MidiCue", message: Any) -> list[float] | None:
    """The value that a message adds to a cue's command, 0 to 1; None if it is another message."""
    if cue.channel is not None and getattr(message, "channel", -1) + 1 != cue.channel:
        return None
    kind = message.type
    if kind in ("note_on", "note_off") and message.note == cue.note:
        return [1.0 if kind == "note_on" and message.velocity > 0 else 0.0]
    if kind == "control_change" and message.control == cue.control:
        return [message.value / 127.0]
    if kind == "program_change" and message.program == cue.program:
        return [1.0]
    return None


def command_of(cue: "MidiCue", values: list[float]) -> Any:
    """Make the presenter's command of a cue: its words, then the value of the message.

    None if a button was released that only triggers.
    """
    from subsea.stage.console.commands import from_words
    from subsea.stage.cues.tables import words_of

    name, given = words_of(cue.command)
    return from_words(name, [*given, *values])
