"""Dives in a headset of the tests."""

from contextlib import closing, contextmanager

import moderngl

from subsea.dive.options import DisplayOptions, DiveOptions
from subsea.dive.part import planned
from subsea.stage.headset import display as headset_display
from subsea.stage.parts import HeadsetPart, KioskPart
from subsea.ui.dive import Dive
from tests.support.headset import FakeHeadset
from tests.support.windows import QUIET

SIZE = (320, 240)


def start(scenario, display="headset", kiosk=False):
    options = DisplayOptions(display, SIZE, quality="low")
    parts = [*[HeadsetPart()] * (display == "headset"), *[KioskPart()] * kiosk]
    made = DiveOptions(str(scenario), seed=1, display=options, parts=parts, settings=QUIET)
    return Dive(planned(made))


@contextmanager
def diving(scenario, monkeypatch, kiosk=False):
    """A dive in a headset of the tests, and that headset."""
    made = []

    def open_headset():
        made.append(FakeHeadset(moderngl.create_context()))
        return made[-1]

    monkeypatch.setattr(headset_display, "open_headset", open_headset)
    with closing(start(scenario, kiosk=kiosk)) as running:
        yield running, made[0]
    assert made[0].calls[-1] == "close"
