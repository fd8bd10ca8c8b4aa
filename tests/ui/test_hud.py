"""Instruments, help and comfort: contents and visibility."""

import math

import numpy as np
import pytest
from imgui_bundle import imgui

from subsea.dive.settings import USUAL, bindings_of
from subsea.stage.setup import set_up_theatre
from subsea.state import Submarine
from subsea.ui.help_overlay import NOT_SHARED, help_content
from subsea.ui.hud import HUD_FADE_S, STILL_S, Hud, Vignette, draw_horizon, instrument_reading
from subsea.view.front_screen import front_screen
from subsea.view.rig import pose_from_angles, views

DT = 0.1


def at(depth_m=2.5, heading_deg=0.0, ahead_m_s=0.0, throttle=0.0, stopping=False):
    boat = Submarine(position=np.array([0.0, 0.0, -100.0 * depth_m]))
    boat.angles[0] = math.radians(-heading_deg)
    boat.velocity[:2] = (
        100.0 * ahead_m_s * np.array([math.cos(boat.angles[0]), math.sin(boat.angles[0])])
    )
    return instrument_reading(boat, throttle, stopping)


def wait(hud, seconds, now, **how):
    for _ in range(round(seconds / DT)):
        hud.update(now, DT, **how)


def test_readings_are_in_metres_and_compass_degrees():
    boat = Submarine(position=np.array([0.0, 0.0, -250.0]))
    boat.angles[0] = math.radians(90.0)  # left of +x, which the compass calls 270°
    boat.velocity[:2] = 30.0, -80.0  # sideways, and astern
    now = instrument_reading(boat, 0.5, False)
    assert now == pytest.approx((2.5, 270.0, -0.8, 0.5, False))


def test_they_fade_while_nothing_changes():
    hud, now = Hud(), at()
    wait(hud, STILL_S - 1.0, now)
    assert hud.opacity == 1.0
    wait(hud, 1.0 + HUD_FADE_S + 0.5, now)
    assert hud.opacity == 0.0
    wait(hud, 5.0, at(depth_m=2.55, heading_deg=359.0))  # invisible change
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
def test_they_come_back_at_a_change(change):
    hud = Hud()
    wait(hud, 20.0, at())
    wait(hud, 0.5, at(**change))
    assert hud.opacity == 1.0


def test_they_stay_or_stay_away_by_their_mode():
    hud = Hud()
    assert hud.cycle() == "always"
    wait(hud, 20.0, at())
    assert hud.opacity == 1.0
    wait(hud, 20.0, at(), wanted=False)
    assert hud.opacity == 0.0
    assert hud.cycle() == "never"
    wait(hud, 1.0, at(depth_m=4.0))
    assert hud.opacity == 0.0
    assert hud.cycle() == "as needed"
    wait(hud, 1.0, at(depth_m=4.0))
    assert hud.opacity == 1.0


def test_the_help_shows_the_inputs_as_they_are_bound():
    usual = help_content(USUAL)
    assert (usual.left, usual.right, usual.wheel) == ("ahead", "back", "wheel: speed, press: stop")
    assert usual.moving and usual.both
    keys = {row.what: row.keys for _, rows in usual.groups for row in rows}
    assert keys["hold: turn"] == ("A", "D") and keys["menu"] == ("Esc",)
    assert keys["follow a fish"] == ("C",) and keys["steer the fish"] == ("G",)
    own = bindings_of(
        {"ahead": ["I"], "rise": ["mouse left"], "menu": ["M"], "help": [], "ride": ["pad A"]}
    )
    help_ = help_content(own, steers=False, without=("desk",))
    assert (help_.left, help_.right, help_.moving, help_.both) == ("rise", "back", "", "")
    keys = {row.what: row.keys for _, rows in help_.groups for row in rows}
    assert keys["hold: ahead, back"] == ("I", "S") and keys["menu"] == ("M",)
    assert not {"this help", "panels", "ride a fish"} & set(keys)


def test_a_new_visitor_sees_three_lines_as_the_inputs_are_bound():
    mouse, fish, rest = help_content(USUAL).brief
    assert not mouse[0].keys and "hold the left button" in mouse[0].what
    assert [row.keys for row in (*fish, *rest)] == [("C",), ("G",), ("H",), ("Esc",)]
    keys, _ = help_content(bindings_of({"ahead": ["I"]}), without=NOT_SHARED).brief
    assert [(row.keys, row.what) for row in keys] == [
        (("I", "S"), "hold: ahead, back"),
        (("A", "D"), "hold: turn"),
    ]


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


@pytest.mark.parametrize(("pitch_deg", "shown"), [(0.0, False), (3.0, False), (15.0, True)])
def test_the_horizon_shows_when_the_hull_is_pitched(pitch_deg, shown):
    """The front screen of the cave has its middle below the eyes."""
    rig = set_up_theatre("cave").rig
    pose = pose_from_angles(np.zeros(3), 0.5, math.radians(pitch_deg))
    context = imgui.create_context()
    try:
        io = imgui.get_io()
        io.set_ini_filename(None)
        io.display_size = imgui.ImVec2(1024.0, 1024.0)
        io.backend_flags |= imgui.BackendFlags_.renderer_has_textures.value
        imgui.new_frame()
        draw_horizon(front_screen(rig, views(rig, pose)), pose.forward)
        drawn = imgui.get_background_draw_list().vtx_buffer.size()
        imgui.end_frame()
    finally:
        imgui.destroy_context(context)
    assert (drawn > 0) == shown
