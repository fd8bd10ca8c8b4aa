"""Decode linear timecode (SMPTE ST 12-1) from the samples of a sound device.

A frame has 80 bits in biphase mark: the signal changes at the start of each bit, and of a 1 also in
its middle. The last 16 bits, 0011 1111 1111 1101, say where a frame ends.
"""

import time
from collections.abc import Callable, Generator
from typing import Any

import numpy as np

from subsea.base.arrays import Array
from subsea.sound.device import open_capture
from subsea.sound.space import RATE
from subsea.stage.cues.device_thread import AGAIN_S, DeviceThread
from subsea.stage.cues.timecode import FrameLabel

SYNC = 0b1011111111111100  # the last 16 bits, the first of them lowest
BITS = 80
SLOWEST, FASTEST = 1.0 / (20.0 * BITS), 1.0 / (36.0 * BITS)  # s, of a bit
QUIET = 0.005  # amplitude below which there is no signal
HYSTERESIS = 0.25  # of the amplitude, by which the signal must cross its middle
FADE_S = 0.1  # in which an amplitude is forgotten
# The first bit of each digit, its number of bits, and whether it is one of tens.
DIGITS = ((48, 4, 56, 2), (32, 4, 40, 3), (16, 4, 24, 3), (0, 4, 8, 2))


class LtcDecoder:
    """Decodes samples as they come."""

    def __init__(self, rate: int) -> None:
        """`rate` is in samples a second."""
        self._rate = rate
        self._high = False  # the last state of the signal
        self._since = 0  # samples since it changed
        self._loud, self._middle = 0.0, 0.0
        self._bit = rate * SLOWEST / 1.4  # samples, followed as the speed changes
        self._half = False  # the first half of a 1 has come
        self._bits = 0  # the last 80, the newest highest
        self._count = 0  # of bits since the last fault

    def decode(self, samples: Array) -> list[FrameLabel]:
        """Take samples (n,); returns the labels of frames that end in them."""
        samples = np.asarray(samples, np.float64)
        if not len(samples):
            return []
        low, high = float(samples.min()), float(samples.max())
        middle, loud = 0.5 * (low + high), 0.5 * (high - low)
        kept = max(1.0 - len(samples) / (FADE_S * self._rate), 0.0)
        self._loud = max(loud, kept * self._loud)
        self._middle = middle + kept * (self._middle - middle)
        if self._loud < QUIET:
            self._since += len(samples)
            self._count = 0
            return []
        labels = []
        for interval in self._intervals(samples):
            label = self._take(interval)
            if label is not None:
                labels.append(label)
        return labels

    def _intervals(self, samples: Array) -> list[int]:
        """Numbers of samples between changes of the signal."""
        bound = HYSTERESIS * self._loud
        state = np.where(samples > self._middle + bound, 1, 0)
        state[samples < self._middle - bound] = -1
        sure = np.flatnonzero(state)
        high = state[sure] > 0
        before = np.concatenate([[self._high], high[:-1]])
        changes = sure[high != before]
        if not len(changes):
            self._since += len(samples)
            return []
        intervals = np.diff(changes, prepend=-self._since).tolist()
        self._high = bool(high[-1])
        self._since = len(samples) - int(changes[-1])
        return intervals

    def _take(self, interval: int) -> FrameLabel | None:
        """Take the time between two changes: a 0, or half of a 1."""
        long = interval > 0.75 * self._bit
        size = interval if long else 2 * interval
        if not 0.5 * FASTEST * self._rate < size < 2.0 * SLOWEST * self._rate:
            self._half, self._count = False, 0
            return None
        self._bit += 0.1 * (min(max(size, FASTEST * self._rate), SLOWEST * self._rate) - self._bit)
        if long:
            if self._half:  # half a 1, then a 0: out of step
                self._count = 0
            self._half = False
            return self._add(0)
        self._half = not self._half
        return None if self._half else self._add(1)

    def _add(self, bit: int) -> FrameLabel | None:
        self._bits = self._bits >> 1 | bit << (BITS - 1)
        self._count += 1
        if self._count < BITS or self._bits >> 64 != SYNC:
            return None
        self._count = 0  # the next 80 bits are the next frame
        return label_of(self._bits)


def label_of(bits: int) -> FrameLabel | None:
    """Read the label of a frame's 80 bits, the first of them lowest; None if no clock shows it."""
    parts = []
    for unit, size, ten, tens in DIGITS:
        low, high = bits >> unit & (1 << size) - 1, bits >> ten & (1 << tens) - 1
        if low > 9:
            return None
        parts.append(10 * high + low)
    label = FrameLabel(*parts)
    sane = label.hours < 24 and label.minutes < 60 and label.seconds < 60 and label.frames < 30
    return label if sane else None


SILENT_S = 2.0  # without samples after which a device is gone
Open = Callable[[str, Generator[None, bytes, None]], Any]


class LtcInput(DeviceThread):
    """Labels from a sound device, which a thread opens and watches."""

    def __init__(
        self, name: str, hear: Callable[[FrameLabel], object], open_one: Open = open_capture
    ):
        """`name` is a part of the device's; `hear` gets each label in a thread of the device."""
        self._name, self._hear, self._open = name, hear, open_one
        self._heard_s = 0.0
        super().__init__("timecode")

    def _run(self) -> None:
        device: Any = None
        missed = False
        while True:
            if device is not None and time.monotonic() - self._heard_s > SILENT_S:
                device.close()
                device, missed = None, True
                self._lines.put("timecode: the sound device is gone; the show goes on")
            if device is None:
                try:
                    samples = self._samples()
                    next(samples)
                    self._heard_s = time.monotonic()
                    device = self._open(self._name, samples)
                    self._lines.put("timecode: a sound device is heard")
                except OSError as fault:
                    if not missed:
                        self._lines.put(f"timecode: {fault}; it may come")
                    missed = True
            if self._ends.wait(AGAIN_S):
                break
        if device is not None:
            device.close()

    def _samples(self) -> Generator[None, bytes, None]:
        decoder = LtcDecoder(RATE)
        while True:
            data = yield
            self._heard_s = time.monotonic()
            for label in decoder.decode(np.frombuffer(data, np.float32)):
                self._hear(label)
