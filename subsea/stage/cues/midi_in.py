"""Hear a MIDI device: its notes, controls and programs, and MIDI timecode.

The only module that speaks MIDI. A thread looks for the device, which may be plugged in at any
time; messages come in a thread of the driver and wait in queues.
"""

from collections.abc import Callable
from typing import Any

import mido

from subsea.stage.cues.device_thread import AGAIN_S, DeviceThread
from subsea.stage.cues.timecode import RATES, FrameLabel, Rate

MTC_RATES: tuple[Rate, ...] = ("24", "25", "29.97", "30")
PIECES = 8  # of a label, over two frames
LATE_FRAMES = 1.75  # from the first piece, which the label is of, to the last
FULL = (0x7F, 0x01, 0x01)  # manufacturer, and after a device number: timecode, a full label


class MtcReader:
    """Puts the labels of MIDI timecode together."""

    def __init__(self) -> None:
        """Start without pieces."""
        self._pieces: list[int] = []

    def take(self, message: Any) -> tuple[FrameLabel, Rate, float] | None:
        """Take a message; returns a label, its rate and by how many frames it is late, or None."""
        if message.type == "sysex":
            return self._whole(tuple(message.data))
        if message.type != "quarter_frame":
            return None
        if message.frame_type != len(self._pieces):  # backward, or one is lost
            self._pieces = []
        if message.frame_type == len(self._pieces):
            self._pieces.append(message.frame_value)
        if len(self._pieces) < PIECES:
            return None
        low, high = self._pieces[::2], self._pieces[1::2]
        frames, seconds, minutes, hours = (a | b << 4 for a, b in zip(low, high, strict=True))
        self._pieces = []
        return _label(hours, minutes, seconds, frames, LATE_FRAMES)

    def _whole(self, data: tuple[int, ...]) -> tuple[FrameLabel, Rate, float] | None:
        """Read a full label, as a player sends when it is put somewhere."""
        self._pieces = []
        if len(data) != 8 or (data[0], data[2], data[3]) != FULL:
            return None
        return _label(*data[4:], late=0.0)


def _label(
    hours: int, minutes: int, seconds: int, frames: int, late: float
) -> tuple[FrameLabel, Rate, float] | None:
    rate = MTC_RATES[hours >> 5 & 3]
    label = FrameLabel(hours & 31, minutes & 63, seconds & 63, frames & 31)
    sane = label.hours < 24 and label.minutes < 60 and label.seconds < 60
    return (label, rate, late) if sane and label.frames < round(RATES[rate]) else None


class MidiInput(DeviceThread):
    """Messages of the first MIDI port whose name holds a text."""

    def __init__(self, name: str, hear: Callable[[Any], object]) -> None:
        """`hear` gets each message, in a thread of the driver."""
        self._name, self._hear = name, hear
        super().__init__("midi")

    def _run(self) -> None:
        port: Any = None
        missed = False
        while True:
            try:
                names = mido.get_input_names()
                if port is not None and port.name not in names:
                    port.close()
                    port = None
                    self._lines.put(f"MIDI: {self._wanted} is gone; the show goes on")
                    missed = True
                if port is None:
                    name = next((one for one in names if self._name.lower() in one.lower()), None)
                    if name is not None:
                        port = mido.open_input(name, callback=self._hear)
                        self._lines.put(f"MIDI: hears {name}")
                        missed = True
                    elif not missed:
                        there = ", ".join(names) or "none"
                        self._lines.put(f"MIDI: no {self._wanted} (there: {there}); it may come")
                        missed = True
            except Exception as fault:  # the drivers have errors of their own
                if not missed:
                    self._lines.put(f"MIDI: {fault}; the show goes on")
                    missed = True
            if self._ends.wait(AGAIN_S):
                break
        if port is not None:
            port.close()

    @property
    def _wanted(self) -> str:
        return f"port {self._name!r}" if self._name else "port"
