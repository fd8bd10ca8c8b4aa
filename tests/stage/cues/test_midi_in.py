"""MIDI timecode from its bytes, and ports that come and go."""

import time

import mido
import pytest

from subsea.stage.cues import midi_in
from subsea.stage.cues.midi_in import MidiInput, MtcReader


def quarter_frames(hours, minutes, seconds, frames, rate=1):
    """The bytes of eight quarter frames, by the table of the MIDI Time Code specification."""
    nibbles = [frames & 15, frames >> 4, seconds & 15, seconds >> 4,
               minutes & 15, minutes >> 4, hours & 15, hours >> 4 | rate << 1]  # fmt: skip
    return bytes(b for kind, value in enumerate(nibbles) for b in (0xF1, kind << 4 | value))


def parsed(data):
    parser = mido.Parser()
    parser.feed(data)
    return list(parser)


def labels(data):
    reader = MtcReader()
    return [found for message in parsed(data) if (found := reader.take(message)) is not None]


def test_labels_are_put_together_of_eight_pieces():
    data = quarter_frames(1, 2, 3, 4) + quarter_frames(23, 59, 58, 22, rate=0)
    assert labels(data) == [((1, 2, 3, 4), "25", 1.75), ((23, 59, 58, 22), "24", 1.75)]


def test_a_piece_that_is_lost_costs_a_label_and_no_wrong_one_is_made():
    data = quarter_frames(1, 2, 3, 4)
    assert labels(data[:6] + data[8:] + quarter_frames(1, 2, 3, 6)) == [((1, 2, 3, 6), "25", 1.75)]
    backward = b"".join(data[k : k + 2] for k in range(14, -2, -2))
    assert labels(backward * 3) == []


def test_a_full_label_and_other_messages():
    full = bytes([0xF0, 0x7F, 0x7F, 0x01, 0x01, 0x61, 2, 3, 4, 0xF7])
    assert labels(full) == [((1, 2, 3, 4), "30", 0.0)]
    other = bytes([0xF0, 0x7F, 0x7F, 0x02, 0x01, 1, 2, 3, 4, 0xF7, 0x90, 60, 100, 0xF8])
    assert labels(other) == []
    assert labels(quarter_frames(31, 2, 3, 4)) == []  # no clock shows it


class Port:
    """A port of a driver."""

    def __init__(self, name, callback):
        self.name, self.callback, self.closed = name, callback, False

    def close(self):
        self.closed = True


@pytest.fixture
def driver(monkeypatch):
    """The names of ports that are there, and those that were opened."""
    names, opened = [], []

    def open_input(name, callback):
        opened.append(Port(name, callback))
        return opened[-1]

    monkeypatch.setattr(mido, "get_input_names", lambda: list(names))
    monkeypatch.setattr(mido, "open_input", open_input)
    monkeypatch.setattr(midi_in, "AGAIN_S", 0.02)
    return names, opened


def line_of(source):
    end = time.monotonic() + 20.0
    while not (line := source.check()):
        assert time.monotonic() < end
        time.sleep(0.01)
    return line


def test_a_port_that_comes_is_heard_and_one_that_goes_is_a_line(driver):
    names, opened = driver
    heard = []
    source = MidiInput("kontrol", heard.append)
    assert line_of(source) == "MIDI: no port 'kontrol' (there: none); it may come"
    names += ["Other", "nanoKONTROL2 1"]
    assert line_of(source) == "MIDI: hears nanoKONTROL2 1"
    opened[0].callback("message")
    assert heard == ["message"]
    names.clear()
    assert line_of(source) == "MIDI: port 'kontrol' is gone; the show goes on"
    names.append("nanoKONTROL2 1")
    assert line_of(source) == "MIDI: hears nanoKONTROL2 1"
    source.close()
    assert [port.closed for port in opened] == [True, True]


def test_a_driver_that_fails_is_one_line(driver, monkeypatch):
    def fail():
        raise RuntimeError("no sequencer")

    monkeypatch.setattr(mido, "get_input_names", fail)
    source = MidiInput("", print)
    assert line_of(source) == "MIDI: no sequencer; the show goes on"
    time.sleep(0.2)
    assert source.check() == ""
    source.close()
