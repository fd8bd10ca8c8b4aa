"""Play moments as they come on the system's sound device; hear another device.

The only module that opens sound devices.
"""

import ctypes
import time
from collections import deque
from collections.abc import Callable, Generator, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from subsea.base.arrays import Array
from subsea.sound.mixer import Mixer, SoundLevels
from subsea.sound.moment import EVENT_COLUMNS, Moment
from subsea.sound.space import BLOCK, RATE, Layout

PERIOD_MS, PERIODS = 10, 2  # of the device's buffer
MOST_WAITING = 2  # moments; earlier ones lend their events to the next
STEADY = 30  # blocks after which one that always waits is skipped, for a shorter delay
SILENT_S = 2.0  # without a request of the device: it is gone
AGAIN_S = 5.0  # between attempts to open one
NO_EVENTS = np.zeros((0, len(EVENT_COLUMNS)))

Open = Callable[[int, Generator[Any, int, None]], Any]
"""Opens a device for a number of channels that asks a generator for samples."""


@ctypes.CFUNCTYPE(None, *2 * (ctypes.c_char_p, ctypes.c_int), ctypes.c_char_p)
def _say_nothing(*message: object) -> None:
    """Takes the messages of ALSA, which would hide the line that says what is wrong."""


def open_device(
    channels: int, samples: Generator[Any, int, None], backends: Sequence[str] = ()
) -> Any:
    """Open and start the system's device; an OSError without one.

    `backends` are names of miniaudio's; "NULL" is a device that nobody hears.
    """
    import miniaudio

    with suppress(OSError, AttributeError):  # systems without ALSA
        ctypes.CDLL("libasound.so.2").snd_lib_error_set_handler(_say_nothing)
    try:
        device = miniaudio.PlaybackDevice(
            output_format=miniaudio.SampleFormat.FLOAT32, nchannels=channels, sample_rate=RATE,
            buffersize_msec=PERIOD_MS, callback_periods=PERIODS, app_name="subsea",
            backends=[miniaudio.Backend[name] for name in backends] or None,
        )  # fmt: skip
        if device.backend == "Null" and "NULL" not in backends:
            device.close()
            raise OSError("the system has no device")
        device.start(samples)
    except miniaudio.MiniaudioError as fault:
        raise OSError("the system has no device that plays") from fault
    return device


def open_capture(
    name: str, samples: Generator[None, bytes, None], backends: Sequence[str] = ()
) -> Any:
    """Open and start the device to hear whose name holds a text; an OSError without one.

    An empty text is the system's device. The generator gets one channel of samples, float32 of RATE
    a second, in a thread of the device.
    """
    import miniaudio

    with suppress(OSError, AttributeError):  # systems without ALSA
        ctypes.CDLL("libasound.so.2").snd_lib_error_set_handler(_say_nothing)
    chosen = [miniaudio.Backend[one] for one in backends]
    device_id = None  # the system's
    try:
        if name:
            found = miniaudio.Devices(chosen).get_captures()
            fitting = [one["id"] for one in found if name.lower() in one["name"].lower()]
            if not fitting:
                names = ", ".join(one["name"] for one in found) or "none"
                raise OSError(f"no sound device {name!r} to hear (there: {names})")
            device_id = fitting[0]
        device = miniaudio.CaptureDevice(
            input_format=miniaudio.SampleFormat.FLOAT32, nchannels=1, sample_rate=RATE,
            buffersize_msec=2 * PERIOD_MS, callback_periods=PERIODS, device_id=device_id,
            app_name="subsea", backends=chosen or None,
        )  # fmt: skip
        if device.backend == "Null" and "NULL" not in backends:
            device.close()
            raise OSError("the system has no sound device to hear")
        device.start(samples)
    except miniaudio.MiniaudioError as fault:
        raise OSError("the system has no sound device to hear") from fault
    return device


class Player:
    """Plays moments; where none comes in time the beds of the last one sound on.

    The device's thread mixes, and only reads moments. It never waits for a tick, and no tick for
    it.
    """

    def __init__(self, layout: Layout, levels: SoundLevels, open_one: Open = open_device) -> None:
        self.levels = levels  # may be replaced at any time
        self.held = 0  # blocks for which no moment had come
        self.skipped = 0  # moments that lent their events to the next
        self.delays_s: deque[float] = deque(maxlen=1000)  # from a moment to its samples
        self._layout, self._open = layout, open_one
        self._waiting: deque[tuple[float, Moment]] = deque(maxlen=16)
        self._spare = MOST_WAITING  # fewest that waited lately
        self._device: Any = None
        self._asked_s = time.monotonic()
        self._tried_s = -AGAIN_S

    @property
    def missing(self) -> bool:
        """True if a device was looked for, and none plays."""
        return self._device is None and self._tried_s >= 0.0

    def push(self, moment: Moment) -> None:
        """Let a moment be heard next."""
        self._waiting.append((time.monotonic(), moment))

    def check(self) -> str:
        """Open a device if none plays, now and then; returns a line if that changed, else ""."""
        now = time.monotonic()
        if self._device is not None:
            if now - self._asked_s < SILENT_S:
                return ""
            self.close()
            self._tried_s = now
            return "the sound device is gone"
        if now - self._tried_s < AGAIN_S:
            return ""
        first = self._tried_s < 0.0
        self._tried_s = self._asked_s = now
        samples = self._samples()
        next(samples)
        try:
            self._device = self._open(self._layout.channels, samples)
        except OSError as fault:
            return f"no sound: {fault}" if first else ""
        return "" if first else "a sound device plays"

    def close(self) -> None:
        """Stop, and free the device."""
        if self._device is not None:
            self._device.close()
        self._device = None

    def _samples(self) -> Generator[Any, int, None]:
        """Yield as many samples (n, c) as the device asks for."""
        mixer, rest = Mixer(self._layout), np.zeros((0, self._layout.channels), np.float32)
        last: Moment | None = None
        count = 0
        number = yield b""
        while True:
            self._asked_s = time.monotonic()
            blocks = [rest]
            size = len(rest)
            while size < number:
                count += 1
                last = self._next(last, count)
                blocks.append(self._mixed(mixer, last))
                size += BLOCK
            whole = np.concatenate(blocks)
            rest = whole[number:]
            number = yield np.ascontiguousarray(whole[:number])

    def _mixed(self, mixer: Mixer, moment: Moment | None) -> Array:
        if moment is None:
            return np.zeros((BLOCK, self._layout.channels), np.float32)
        return mixer.mix(moment, self.levels)

    def _next(self, last: Moment | None, count: int) -> Moment | None:
        """The moment that is heard next, numbered by the blocks so far."""
        now = time.monotonic()
        late: list[Array] = []
        while len(self._waiting) > MOST_WAITING:
            self.skipped += 1
            late.append(self._waiting.popleft()[1].events)
        try:
            since, moment = self._waiting.popleft()
        except IndexError:
            self.held += 1
            return None if last is None else last._replace(tick=count, events=NO_EVENTS)
        self.delays_s.append(now - since)
        self._spare = min(self._spare, len(self._waiting))
        if count % STEADY == 0:
            if self._spare:  # a slow frame has left one too many
                self.skipped += 1
                late.append(moment.events)
                moment = self._waiting.popleft()[1]
            self._spare = MOST_WAITING
        events = np.concatenate([*late, moment.events])
        return moment._replace(tick=count, events=events)
