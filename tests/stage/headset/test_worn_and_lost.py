"""A headset that is put on, lost, found again, or not there."""

from contextlib import closing

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.stage.headset import display as headset_display
from tests.stage.headset.conftest import diving, start
from tests.support.scenes import BARE


@pytest.mark.nightly
def test_the_ticks_are_those_of_a_window(display, monkeypatch):
    def played(running):
        for _ in range(6):
            running.frame(0.1)
        return running.world.state.tick, running.world.state.fishes.position.copy()

    with diving(BARE, monkeypatch) as (running, _):
        tick, places = played(running)
    with closing(start(BARE, "mono")) as running:
        other_tick, other_places = played(running)
    assert tick == other_tick > 10
    np.testing.assert_array_equal(places, other_places)


@pytest.mark.nightly
def test_a_runtime_that_dies_is_told_in_one_line_and_the_dive_goes_on(display, monkeypatch, capsys):
    with diving(BARE, monkeypatch) as (running, _):
        for call in ("poll", "begin", "end"):
            headset = running.picture.head.headset
            running.frame(0.1)
            headset.lost_in = call
            running.frame(0.1)
            out = capsys.readouterr().err.strip().splitlines()
            assert out[-1] == "subsea: the headset's runtime ended; the dive goes on in the window"
            assert headset.calls[-1] == "close"
            tick = running.world.state.tick
            for _ in range(3):
                running.frame(0.1)
            assert running.world.state.tick > tick and running.picture.display == "mono"
            assert running.window_set.picture().std() > 3.0
            assert len(running.picture.displays) > 3  # another mode can be chosen
            running.put_on(headset_display.put_on(running.window_set, running.gui, running.note))


@pytest.mark.nightly
def test_a_kiosk_finds_its_headset_again(display, monkeypatch):
    with diving(BARE, monkeypatch, kiosk=True) as (running, headset):
        running.frame(0.1)
        headset.lost_in = "end"
        running.frame(0.1)
        assert running.picture.head is None
        running.frame(10.0)
        assert running.picture.head is None
        running.frame(6.0)
        again = running.picture.head
        assert again is not None and again.headset is not headset
        running.frame(0.1)
        assert again.headset.calls[-3:] == ["poll", "begin", "end"]
        assert again.headset.pictures().std() > 3.0 or again._dark > 0.5


@pytest.mark.nightly
def test_without_a_runtime_one_line_says_so_and_the_dive_is_in_the_window(
    display, monkeypatch, capsys
):
    def none():
        raise UserError("no OpenXR runtime is installed")

    monkeypatch.setattr(headset_display, "open_headset", none)
    with closing(start(BARE)) as running:
        running.frame(0.1)
        assert running.picture.head is None and running.window_set.picture().std() > 3.0
    lines = capsys.readouterr().err.splitlines()
    assert "subsea: no OpenXR runtime is installed; the dive goes on in the window" in lines


@pytest.mark.nightly
def test_in_a_kiosk_the_dive_begins_when_it_is_put_on_and_waits_when_it_is_put_off(
    display, monkeypatch
):
    with diving(BARE, monkeypatch, kiosk=True) as (running, headset):
        running.frame(0.1)
        for _ in range(5):
            running.frame(0.1)
        assert running.world.state.tick > 10
        headset.worn = False
        running.frame(0.1)
        tick, before = running.world.state.tick, running.world
        for _ in range(5):
            running.frame(0.1)
        assert running.world.state.tick <= tick + 3
        headset.worn, headset.position = True, np.array([1.0, 1.2, 0.0])
        for _ in range(5):
            running.frame(0.1)
        assert running.world is not before and 3 < running.world.state.tick < 20
        assert running.picture.head.home.position[0] == pytest.approx(1.0)  # the next visitor
        assert not running.tours.timer.touring
