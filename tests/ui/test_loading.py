"""A sea is shown before its fishes can move."""

import time
from contextlib import closing

import pytest

from subsea.dive import warm_up
from subsea.dive.warm_up import WarmUp
from subsea.jobs.background import CancelledByUserError
from subsea.ui.dive import Dive
from tests.support.windows import display_pixels, dive_options

SIZE = (320, 240)


def test_a_sea_at_rest_is_shown_while_kernels_compile(display, quiet, monkeypatch):
    seen = []

    def compile_slowly(tell, check, first):
        first()
        end = time.monotonic() + 60.0
        while time.monotonic() < end:
            pixels = display_pixels()
            if len({tuple(pixel) for pixel in pixels.reshape(-1, 3)}) > 2000:
                seen.append(pixels)
                return
            time.sleep(0.1)

    monkeypatch.setattr(warm_up, "warm_up", compile_slowly)
    with closing(Dive(dive_options(quiet, SIZE))) as running:
        assert len(seen) == 1
        assert running.world.state.tick == 1


def test_a_fault_while_compiling_is_raised(monkeypatch):
    def fail(tell, check, first):
        raise OSError("disk full")

    monkeypatch.setattr(warm_up, "warm_up", fail)
    with pytest.raises(OSError, match="disk full"):
        WarmUp().wait_for_first(print)


def test_a_cancelled_warm_up_ends(monkeypatch):
    def wait(tell, check, first):
        while True:
            check()
            time.sleep(0.01)

    monkeypatch.setattr(warm_up, "warm_up", wait)
    compiling = WarmUp()
    compiling.cancel()
    with pytest.raises(CancelledByUserError):
        compiling.wait(print)
