"""The player, on devices that nobody hears."""

import time
from functools import partial

import numpy as np
import pytest

from subsea.sound import device
from subsea.sound.device import MOST_WAITING, Player, open_capture, open_device
from subsea.sound.mixer import SoundLevels
from subsea.sound.space import BLOCK, LAYOUTS, RATE
from tests.sound.conftest import mixed

STEREO = LAYOUTS["stereo"]
FULL = SoundLevels(volume=1.0)


class FakeDevice:
    """Asks for samples when a test says so."""

    def __init__(self, channels, samples):
        self.samples, self.closed = samples, False

    def ask(self, number):
        return self.samples.send(number)

    def close(self):
        self.closed = True


@pytest.fixture
def playing():
    player = Player(STEREO, FULL, FakeDevice)
    assert player.check() == ""
    return player, player._device


def test_moments_in_time_are_heard_as_in_a_film(heard, playing):
    player, fake = playing
    moments = heard[1][:30]
    blocks = []
    for moment in moments:
        player.push(moment)
        blocks += [fake.ask(480) for _ in range(3)] + [fake.ask(BLOCK - 3 * 480)]
    assert player.held == player.skipped == 0
    assert (np.concatenate(blocks) == mixed(*moments)).all()


def test_a_slow_frame_leaves_no_hole(heard, playing):
    player, fake = playing
    moments = iter(heard[1])
    for _ in range(5):
        player.push(next(moments))
        fake.ask(BLOCK)
    late = np.concatenate([fake.ask(480) for _ in range(20)])  # 200 ms without a moment
    assert np.isfinite(late).all()
    assert (np.abs(late).reshape(20, -1).max(axis=1) > 0.0).all()
    assert player.held == 6 + 1
    for _ in range(6):
        player.push(next(moments))
    fake.ask(BLOCK)
    assert len(player._waiting) == MOST_WAITING - 1  # it has caught up
    assert player.skipped == 6 - MOST_WAITING


def test_events_of_skipped_moments_are_heard(heard, playing):
    player, _ = playing
    moments = heard[1][:4]
    for moment in moments:
        player.push(moment)
    found = player._next(None, 1)
    assert len(found.events) == sum(len(one.events) for one in moments[:3])


def test_an_extra_moment_is_dropped_after_a_while(heard, playing):
    player, fake = playing
    player.push(heard[1][0])
    for moment in heard[1][1 : 2 + 2 * device.STEADY]:
        player.push(moment)
        fake.ask(BLOCK)
    assert len(player._waiting) == 0
    assert player.skipped == 1


def test_without_a_device_there_is_one_line(monkeypatch):
    def none(channels, samples):
        raise OSError("the system has no device")

    player = Player(STEREO, FULL, none)
    assert player.check() == "no sound: the system has no device"
    later = time.monotonic() + 60.0
    monkeypatch.setattr(time, "monotonic", lambda: later)
    assert player.check() == ""


def test_a_device_that_is_unplugged_is_reported_and_opened_again(heard, playing, monkeypatch):
    player, fake = playing
    now = time.monotonic()
    monkeypatch.setattr(time, "monotonic", lambda: now + 2.5)
    assert player.check() == "the sound device is gone"
    assert fake.closed
    assert player.check() == ""
    monkeypatch.setattr(time, "monotonic", lambda: now + 9.0)
    assert player.check() == "a sound device plays"


def test_the_real_library_plays_to_a_device_that_nobody_hears(heard):
    player = Player(STEREO, FULL, partial(open_device, backends=["NULL"]))
    assert player.check() == ""
    for moment in heard[1][:15]:
        player.push(moment)
        time.sleep(0.033)
    for _ in range(100):
        if len(player.delays_s) >= 10:
            break
        time.sleep(0.02)
    player.close()
    assert len(player.delays_s) >= 10
    assert player.check() == ""
    player.close()


def test_this_machine_has_no_sound_device_or_opens_it():
    try:
        opened = open_device(2, _silence())
    except OSError as fault:
        assert "the system has no device" in str(fault)
    else:
        opened.close()


def _silence():
    samples = _zeros()
    next(samples)
    return samples


def _zeros():
    number = yield b""
    while True:
        number = yield np.zeros((number, 2), np.float32)


def _heard(parts):
    while True:
        parts.append((yield))


def test_a_device_is_heard_and_one_that_is_missing_is_named():
    parts = []
    samples = _heard(parts)
    next(samples)
    opened = open_capture("", samples, ["NULL"])
    end = time.monotonic() + 20.0
    while len(parts) < 3:
        assert time.monotonic() < end
        time.sleep(0.01)
    opened.close()
    assert {len(part) for part in parts} == {4 * round(0.02 * RATE)}
    with pytest.raises(OSError, match=r"no sound device 'line 7' to hear \(there: "):
        open_capture("line 7", samples, ["NULL"])
