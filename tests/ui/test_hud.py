"""Instruments, help and comfort: contents and visibility."""

import math

import numpy as np
import pytest

from subsea.dive.bindings import USUAL, bindings_of
from subsea.state import Submarine
from subsea.ui.comfort import Vignette
from subsea.ui.help_overlay import help_content
from subsea.ui.hud import FADE_S, STILL_S, Hud, instrument_reading

DT = 0.1


def at(depth_m=2.5, heading_deg=0.0, ahead_m_s=0.0, throttle=0.0, stopping=False):
    boat = Submarine(position=np.array([0.0, 0.0, -100.0 * depth_m]))
    boat.angles[0] = math.radians(-heading_deg)
    boat.velocity[:2] = (
        100.0 * ahead_m_s * np.array([math.cos(boat.angles[0]), math.sin(boat.angles[0])])
    )
    return instrument_reading(boat, throttle, stopping)


def pass_(hud, seconds, now, **how):
    for _ in range(round(seconds / DT)):
        hud.look(now, DT, **how)


def test_they_speak_metres_and_compass():
    boat = Submarine(position=np.array([0.0, 0.0, -250.0]))
    boat.angles[0] = math.radians(90.0)  # left of +x, which the compass calls 270°
    boat.velocity[:2] = 30.0, -80.0  # sideways, and astern
    now = instrument_reading(boat, 0.5, False)
    assert now == pytest.approx((2.5, 270.0, -0.8, 0.5, False))


def test_they_fade_while_nothing_changes():
    hud, now = Hud(), at()
    pass_(hud, STILL_S - 1.0, now)
    assert hud.opacity == 1.0
    pass_(hud, 1.0 + FADE_S + 0.5, now)
    assert hud.opacity == 0.0
    pass_(hud, 5.0, at(depth_m=2.55, heading_deg=359.0))  # invisible change
    assert hud.opacity == 0.0


@pytest.mark.parametrize(
    "change",
    [
        {"depth_m": 3.0},
        {"heading_deg": 355.0},
        {"ahead_m_s": 0.2},
        {"throttle": 0.125},
        {"stopping": True},
    ],
)
def test_they_come_back_when_something_does(change):
    hud = Hud()
    pass_(hud, 20.0, at())
    pass_(hud, 0.5, at(**change))
    assert hud.opacity == 1.0


def test_they_stay_or_stay_away_if_told():
    hud = Hud()
    assert hud.turn() == "always"
    pass_(hud, 20.0, at())
    assert hud.opacity == 1.0
    pass_(hud, 20.0, at(), wanted=False)
    assert hud.opacity == 0.0
    assert hud.turn() == "never"
    pass_(hud, 1.0, at(depth_m=4.0))
    assert hud.opacity == 0.0
    assert hud.turn() == "as needed"
    pass_(hud, 1.0, at(depth_m=4.0))
    assert hud.opacity == 1.0


def test_the_sign_tells_the_inputs_as_they_are_bound():
    usual = help_content(USUAL)
    assert (usual.left, usual.right, usual.wheel) == ("ahead", "back", "wheel: speed, press: stop")
    assert usual.moving and usual.both
    keys = {row.what: row.keys for row in usual.rows}
    assert keys["turn"] == ("A", "D") and keys["menu"] == ("Esc",)
    own = bindings_of(
        {"ahead": ["I"], "rise": ["mouse left"], "menu": ["M"], "help": [], "ride": ["pad A"]}
    )
    sign = help_content(own, steers=False, without=("desk",))
    assert (sign.left, sign.right, sign.moving, sign.both) == ("rise", "back", "", "")
    keys = {row.what: row.keys for row in sign.rows}
    assert keys["ahead and back"] == ("I", "S") and keys["menu"] == ("M",)
    assert not {"this help", "panels", "ride a fish"} & set(keys)


def test_the_rim_darkens_in_fast_turns_and_starts_only():
    rest = np.zeros(3)
    for rates, faster, wanted in (
        ((0.0, 0.0), 0.0, 0.0),
        ((0.1, 0.0), 30.0, 0.0),
        ((math.radians(40.0), 0.0), 0.0, 1.0),
        ((0.0, 0.0), 150.0, 1.0),
    ):
        rim, velocity = Vignette(1.0), rest
        for _ in range(40):
            velocity = velocity + (faster * DT, 0.0, 0.0)
            rim.update(np.array(rates), velocity, DT)
        assert rim.amount == pytest.approx(wanted, abs=0.02)
