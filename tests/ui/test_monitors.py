"""Monitors are found by name and number; missing ones are reported and skipped."""

import pytest

from subsea.core.errors import UserError
from subsea.ui import monitors as screens
from subsea.ui.monitors import Monitor, Screen, monitors, on_display, placed

LEFT = Monitor(1, "DP-1", (0, 0), (1280, 1024), 60)
RIGHT = Monitor(2, "HDMI-1", (1280, 0), (1920, 1080), 50)
TWINS = [
    Monitor(1, "beamer", (0, 0), (800, 600), 60),
    Monitor(2, "beamer", (800, 0), (800, 600), 0),
]


def test_a_name_and_a_number_find_a_monitor():
    asked = [
        Screen("a", RIGHT.size, monitor="HDMI-1"),
        Screen("b", LEFT.size, monitor=1),
        Screen("c", (10, 10), position=(5, 5)),
    ]
    said = []
    assert placed(asked, [LEFT, RIGHT], "", said.append) == [(0, RIGHT), (1, LEFT), (2, None)]
    assert not said


def test_a_window_without_its_monitor_is_left_out_and_told():
    asked = [Screen("left", LEFT.size, monitor="DP-3"), Screen("right", RIGHT.size, monitor=2)]
    said = []
    assert placed(asked, [LEFT, RIGHT], "theatre.toml", said.append) == [(1, RIGHT)]
    assert said == [
        "theatre.toml: window 'left': no monitor 'DP-3'; there are: 1 'DP-1' 1280x1024, "
        "2 'HDMI-1' 1920x1080; this window is left out"
    ]


def test_if_no_window_is_left_it_is_a_fault():
    with pytest.raises(UserError, match=r"^t\.toml: window 'a': no monitor 3; there are: 1 'DP-1'"):
        placed([Screen("a", (64, 64), monitor=3)], [LEFT], "t.toml")
    with pytest.raises(UserError, match="there are: none"):
        placed([Screen("a", (64, 64), monitor=1)], [])


def test_two_monitors_of_one_name_need_a_number():
    with pytest.raises(UserError, match="2 monitors are called 'beamer', take a number; there are"):
        placed([Screen("a", (800, 600), monitor="beamer")], TWINS)
    assert placed([Screen("a", (800, 600), monitor=2)], TWINS) == [(0, TWINS[1])]


def test_a_monitor_shows_one_window_whatever_it_is_called():
    asked = [Screen("a", LEFT.size, monitor=1), Screen("b", LEFT.size, monitor="DP-1")]
    said = []
    assert placed(asked, [LEFT, RIGHT], "t.toml", said.append) == [(0, LEFT)]
    assert said == [
        "t.toml: window 'b': monitor 1 'DP-1' 1280x1024 has window 'a'; this window is left out"
    ]


def test_pixels_that_do_not_meet_those_of_the_monitor_are_told():
    said = []
    placed([Screen("a", (800, 600), monitor=1)], [LEFT], "t.toml", said.append)
    assert said == [
        "t.toml: window 'a': its 800x600 pixels are stretched over monitor 1 'DP-1' 1280x1024"
    ]


def test_the_monitor_of_a_display_is_listed_as_the_library_knows_it(display):
    with on_display() as there:
        [monitor] = there.monitors
    assert (monitor.number, monitor.position, monitor.size) == (1, (0, 0), (800, 600))
    assert str(monitor) == f"1 {monitor.name!r} 800x600"


def test_several_monitors_are_numbered_in_their_order(display, monkeypatch):
    with on_display():
        [only] = screens.glfw.get_monitors()
        monkeypatch.setattr(screens.glfw, "get_monitors", lambda: [only, only])
        found = monitors()
    assert [monitor.number for monitor in found] == [1, 2]
    assert found[0]._replace(number=2) == found[1]
