"""Linear timecode out of samples: any rate and loudness, noise, joins, faults."""

import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.stage.cues import ltc
from subsea.stage.cues.ltc import LtcDecoder, LtcInput
from subsea.stage.cues.timecode import FrameLabel

RATE = 48000


def bits_of(label):
    """The 80 bits of a frame, by the table of SMPTE ST 12-1."""
    bits = np.zeros(80, int)
    places = {"frames": (0, 8), "seconds": (16, 24), "minutes": (32, 40), "hours": (48, 56)}
    for name, (unit, ten) in places.items():
        value = getattr(label, name)
        for k in range(4):
            bits[unit + k] = value % 10 >> k & 1
        for k in range(2 if name in ("frames", "hours") else 3):
            bits[ten + k] = value // 10 >> k & 1
    bits[64:] = [int(bit) for bit in "0011111111111101"]
    return bits


def signal(labels, fps=25.0, rate=RATE, loud=0.5):
    """A signal that changes at the start of each bit, and in the middle of each 1."""
    levels, times, level, at = [], [], loud, 0.0
    for bit in np.concatenate([*map(bits_of, labels), [0, 0]]):  # the last change ends a frame
        half = 0.5 / (80.0 * fps)
        level = -level
        levels.append(level)
        times.append(at)
        if bit:
            level = -level
            levels.append(level)
            times.append(at + half)
        at += 2.0 * half
    places = np.arange(int(at * rate)) / rate
    return np.array(levels)[np.searchsorted(times, places, side="right") - 1]


def run_of(count, first=0):
    return [FrameLabel(10, 20, 30 + k // 25, k % 25) for k in range(first, first + count)]


@pytest.mark.parametrize(
    ("fps", "rate", "loud"),
    [(24.0, 48000, 0.5), (25.0, 44100, 1.0), (29.97, 48000, 0.02), (30.0, 48000, 0.9)],
)
def test_all_frames_are_read_in_pieces_of_any_length(fps, rate, loud):
    labels = run_of(40)
    samples = signal(labels, fps, rate, loud)
    decoder, heard, at = LtcDecoder(rate), [], 0
    rng = np.random.default_rng(1)
    while at < len(samples):
        size = int(rng.integers(1, 2000))
        heard += decoder.decode(samples[at : at + size])
        at += size
    assert heard == labels[-len(heard) :] and len(heard) >= 39


def test_noise_an_offset_and_soft_edges_are_borne():
    labels = run_of(50)
    samples = np.convolve(signal(labels), np.ones(5) / 5.0, "same")
    samples = samples + 0.2 + np.random.default_rng(2).normal(0.0, 0.04, len(samples))
    decoder = LtcDecoder(RATE)
    heard = [one for part in np.array_split(samples, 100) for one in decoder.decode(part)]
    assert len(heard) >= 47 and set(heard) <= set(labels)


def test_a_gap_costs_the_frames_around_it():
    samples = signal(run_of(50))
    samples[30000:34000] = 0.0
    decoder = LtcDecoder(RATE)
    heard = [one for part in np.array_split(samples, 100) for one in decoder.decode(part)]
    assert set(heard) <= set(run_of(50)) and 44 <= len(heard) <= 49


def test_speech_has_no_timecode():
    rng = np.random.default_rng(3)
    noise = np.cumsum(rng.normal(size=RATE)) % 1.0 - 0.5
    assert LtcDecoder(RATE).decode(noise) == []
    assert LtcDecoder(RATE).decode(np.zeros(RATE)) == []


@given(st.lists(st.integers(0, 1), min_size=80, max_size=400), st.integers(0, 4))
def test_any_bits_are_survived(bits, rest):
    edges = np.cumsum(np.concatenate([[24] if bit == 0 else [12, 12] for bit in bits]))
    samples = np.ones(int(edges[-1]) + rest)
    for edge in edges:
        samples[edge:] *= -1.0
    for label in LtcDecoder(RATE).decode(samples):
        assert label.hours < 24 and label.frames < 30


def test_a_device_that_is_missing_comes_and_goes(monkeypatch):
    monkeypatch.setattr(ltc, "AGAIN_S", 0.02)
    monkeypatch.setattr(ltc, "SILENT_S", 0.3)
    opened, heard = [], []

    class Device:
        closed = False

        def close(self):
            self.closed = True

    def open_one(name, samples):
        if not opened:
            opened.append(None)
            raise OSError(f"no sound device {name!r} to hear (there: none)")
        opened.append(Device())
        for part in np.array_split(signal(run_of(5)).astype(np.float32), 7):
            samples.send(part.tobytes())
        return opened[-1]

    source, lines, end = LtcInput("line", heard.append, open_one), [], time.monotonic() + 20.0
    while len(lines) < 4:
        assert time.monotonic() < end
        lines += [line] if (line := source.check()) else []
        time.sleep(0.01)
    source.close()
    assert lines == [
        "timecode: no sound device 'line' to hear (there: none); it may come",
        "timecode: a sound device is heard",
        "timecode: the sound device is gone; the show goes on",
        "timecode: a sound device is heard",
    ]
    assert heard[:5] == run_of(5)
    assert all(device.closed for device in opened[1:])
