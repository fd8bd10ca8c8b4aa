"""Monitors are found by name and number; missing ones are reported and skipped."""

import pytest

from subsea.base.errors import UserError
from subsea.ui import monitors as module
from subsea.ui.monitors import Monitor, Screen, monitors, on_display, placed

LEFT = Monitor(1, "DP-1", (0, 0), (1280, 1024), 60)
RIGHT = Monitor(2, "HDMI-1", (1280, 0), (1920, 1080), 50)
TWINS = [
    Monitor(1, "beamer", (0, 0), (800, 600), 60),
    Monitor(2, "beamer", (800, 0), (800, 600), 0),
]


LEFT_OUT = "this window is left out"


@pytest.mark.parametrize(
    ("screens", "expected", "message"),
    [
        (
            [
                Screen("a", RIGHT.size, monitor="HDMI-1"),
                Screen("b", LEFT.size, monitor=1),
                Screen("c", (10, 10), position=(5, 5)),
            ],
            [(0, RIGHT), (1, LEFT), (2, None)],
            "",
        ),
        (
            [Screen("left", LEFT.size, monitor="DP-3"), Screen("right", RIGHT.size, monitor=2)],
            [(1, RIGHT)],
            "window 'left': no monitor 'DP-3'; there are: 1 'DP-1' 1280x1024, "
            f"2 'HDMI-1' 1920x1080; {LEFT_OUT}",
        ),
        (
            [Screen("a", LEFT.size, monitor=1), Screen("b", LEFT.size, monitor="DP-1")],
            [(0, LEFT)],
            f"window 'b': monitor 1 'DP-1' 1280x1024 has window 'a'; {LEFT_OUT}",
        ),
        (
            [Screen("a", (800, 600), monitor=1)],
            [(0, LEFT)],
            "window 'a': its 800x600 pixels are stretched over monitor 1 'DP-1' 1280x1024",
        ),
    ],
    ids=["by name and number", "missing", "shown twice", "stretched"],
)
def test_windows_are_placed_on_their_monitors(screens, expected, message):
    messages = []
    assert placed(screens, [LEFT, RIGHT], "t.toml", messages.append) == expected
    assert messages == ([f"t.toml: {message}"] if message else [])


def test_without_a_window_it_is_an_error_and_equal_names_need_a_number():
    with pytest.raises(UserError, match=r"^t\.toml: window 'a': no monitor 3; there are: 1 'DP-1'"):
        placed([Screen("a", (64, 64), monitor=3)], [LEFT], "t.toml")
    with pytest.raises(UserError, match="there are: none"):
        placed([Screen("a", (64, 64), monitor=1)], [])
    with pytest.raises(UserError, match="2 monitors are called 'beamer', take a number; there are"):
        placed([Screen("a", (800, 600), monitor="beamer")], TWINS)
    assert placed([Screen("a", (800, 600), monitor=2)], TWINS) == [(0, TWINS[1])]


def test_the_monitor_of_a_display_is_listed_as_the_library_knows_it(display):
    with on_display() as there:
        [monitor] = there.monitors
    assert (monitor.number, monitor.position, monitor.size) == (1, (0, 0), (800, 600))
    assert str(monitor) == f"1 {monitor.name!r} 800x600"


def test_several_monitors_are_numbered_in_their_order(display, monkeypatch):
    with on_display():
        [only] = module.glfw.get_monitors()
        monkeypatch.setattr(module.glfw, "get_monitors", lambda: [only, only])
        found = monitors()
    assert [monitor.number for monitor in found] == [1, 2]
    assert found[0]._replace(number=2) == found[1]
