"""A sea is shown before its fishes can move."""

import time
from contextlib import closing

import numpy as np
import pytest

from subsea.ui import first_picture as loading
from subsea.ui.dive import Dive
from tests.support.windows import display_pixels, dive_options

SIZE = (320, 240)


def test_a_sea_at_rest_is_shown_while_its_fishes_wake(display, quiet, monkeypatch):
    seen, wake = [], loading.wake

    def wake_slowly(world):
        end = time.monotonic() + 200.0
        while time.monotonic() < end and not seen:
            time.sleep(0.1)
            colors = np.unique(display_pixels() @ (1 << 16, 1 << 8, 1))
            if len(colors) > 2000:
                seen.append(colors)
        wake(world)

    monkeypatch.setattr(loading, "wake", wake_slowly)
    with closing(Dive(dive_options(quiet, SIZE))) as running:
        assert len(seen) == 1
        assert running.world.state.tick == 1


def test_a_fault_while_compiling_is_raised(quiet, monkeypatch):
    def fail(tell):
        raise OSError("disk full")

    monkeypatch.setattr(loading, "warm_up", fail)
    with pytest.raises(OSError, match="disk full"):
        loading.Loader(lambda line: None).create(None, None, None)
