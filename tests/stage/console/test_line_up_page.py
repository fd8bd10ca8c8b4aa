"""The page of line-up on the wall in a real browser: by finger, mouse and keyboard."""

import time

import pytest

from subsea.stage.theatre.line_up import LineUp, LineUpChannel
from subsea.stage.theatre.theatre_file import Adjustment, Corners
from tests.support.console_pages import (
    check_fits,
    check_names,
    check_strangers,
    check_without_theatre,
    click,
)


@pytest.fixture
def tool(console, page):
    """The page with the tool open, and its line-up."""
    line_up = LineUp(
        [LineUpChannel("left", (400, 200), Adjustment(gamma=2.4), "a", True),
         LineUpChannel("right", (400, 200))]
    )  # fmt: skip
    console.dive.line_up = line_up
    console.dive.state["projectors"] = line_up.describe()
    page.logged.clear()
    page.open(f"http://{console.host}/line-up")
    page.until("!document.getElementById('closed').hidden")
    click(page, "begin")
    page.until("document.querySelectorAll('#pad .point').length === 20")
    yield page
    assert not page.logged, page.logged
    page.open("about:blank")


def until(true):
    end = time.monotonic() + 30.0
    while not true():
        assert time.monotonic() < end
        time.sleep(0.02)


def adjustment(console, name="left"):
    return console.dive.line_up._now[name]


def place(page, number):
    """The place of a point of the pad in the window."""
    return page.run(
        f"(r => [r.x + r.width / 2, r.y + r.height / 2])"
        f"(document.querySelectorAll('#pad .point')[{number}].getBoundingClientRect())"
    )


def finger(page, *places):
    """Touch the page, go to further places, and let go."""
    for k, (x, y) in enumerate(places):
        page.call("Input.dispatchMouseEvent", type="mousePressed" if k == 0 else "mouseMoved", x=x,
                  y=y, button="left", buttons=1, clickCount=1)  # fmt: skip
    page.call("Input.dispatchMouseEvent", type="mouseReleased", x=places[-1][0], y=places[-1][1],
              button="left", clickCount=1)  # fmt: skip


def test_a_tap_chooses_and_arrows_and_keys_move(console, tool):
    finger(tool, place(tool, 2))
    until(lambda: console.dive.line_up.state.point == "lower_right")
    tool.until("document.getElementById('chosen').textContent.startsWith('lower right corner: 0')")
    click(tool, "left")
    tool.run("document.getElementById('step').value = '10'")
    click(tool, "down")
    until(lambda: adjustment(console).corners_px == Corners(lower_right=(-1, 10)))
    tool.until("document.activeElement.id === 'pad'")
    tool.press("ArrowLeft")
    until(lambda: adjustment(console).corners_px == Corners(lower_right=(-2, 10)))
    tool.press("n", "n")
    until(lambda: console.dive.line_up.state.point == "lower_left")
    tool.until(
        "document.getElementById('chosen').textContent === 'lower left corner: 0 right, 0 down'"
    )


def test_a_drag_moves_by_a_step_for_each_pixel_and_is_undone_at_once(console, tool):
    x, y = place(tool, 0)
    tool.run("document.getElementById('step').value = '0.1'")
    finger(tool, (x, y), (x + 10, y), (x + 20, y + 10), (x + 50, y + 20))
    until(lambda: adjustment(console).corners_px == Corners(upper_left=(5.0, 2.0)))
    tool.until("!document.getElementById('undo').disabled")
    click(tool, "undo")
    until(lambda: adjustment(console) == Adjustment(gamma=2.4))
    tool.until("!document.getElementById('redo').disabled")


def test_every_control_changes_its_key(console, tool):
    tool.run("document.getElementById('channel').value = 'right'")
    tool.run("document.getElementById('channel').dispatchEvent(new Event('change'))")
    until(lambda: console.dive.line_up.state.channel == "right")
    for name, value, key, wanted in (
        ("gamma", "1.9", "gamma", 1.9), ("black", "0.01", "black", 0.01),
        ("gain-1", "0.5", "gain", (1.0, 0.5, 1.0)), ("flip", "horizontal", "flip", "horizontal"),
        ("rotate", "180", "rotate", 180), ("edge_soft_px", "9", "edge_soft_px", 9),
    ):  # fmt: skip
        tool.run(
            f"var one = document.getElementById('{name}'); one.value = '{value}';"
            "one.dispatchEvent(new Event('change'))"
        )
        until(lambda key=key, wanted=wanted: getattr(adjustment(console, "right"), key) == wanted)
    for name in ("edge", "edge-more"):
        tool.until(f"!document.getElementById('{name}').disabled")
        click(tool, name)
        tool.until("document.getElementById('edge').ariaPressed === 'true'")
    until(lambda: len(adjustment(console, "right").edge_mask) == 8)
    tool.run("var one = document.getElementById('grid'); one.value = '5,5';"
             "one.dispatchEvent(new Event('change'))")  # fmt: skip
    until(lambda: console.dive.line_up.state.grid == (5, 5))
    tool.run("var one = document.getElementById('others'); one.value = 'black';"
             "one.dispatchEvent(new Event('change'))")  # fmt: skip
    until(lambda: console.dive.line_up.state.others == "black")


def test_before_save_and_cancel(console, tool):
    click(tool, "right")
    tool.until("document.getElementById('kept').textContent === 'Not saved yet.'")
    click(tool, "compare")
    tool.until("document.getElementById('compare').ariaPressed === 'true'")
    click(tool, "compare")
    tool.until("document.getElementById('compare').ariaPressed === 'false'")
    click(tool, "save")
    until(lambda: console.dive.saved)
    tool.until("document.getElementById('save').disabled")
    click(tool, "right")
    tool.until("!document.getElementById('save').disabled")
    click(tool, "cancel")
    tool.until("!document.getElementById('closed').hidden")
    assert adjustment(console) == console.dive.saved[0]["left"]


def test_a_refused_change_is_read_aloud(console, tool):
    tool.run("var one = document.getElementById('gamma'); one.value = '9';"
             "one.dispatchEvent(new Event('change'))")  # fmt: skip
    tool.until("document.getElementById('message').textContent.includes('0.5 to 4')")
    assert tool.run("document.getElementById('message').getAttribute('role')") == "alert"
    tool.logged.clear()  # the browser's own line about the refusal


def test_a_screen_reader_finds_names(tool):
    check_names(
        tool,
        ("button", "Up"),
        ("combobox", "Projector"),
        ("spinbutton", "Gamma"),
        ("spinbutton", "Red"),
        ("button", "Save"),
    )


@pytest.mark.parametrize("width", [320, 768, 1280])
def test_it_fits_a_telephone_and_a_tablet(tool, width):
    check_fits(tool, width)


def test_without_a_theatre_it_says_so(console, page):
    check_without_theatre(console, page, "/line-up", "tool")


def test_strangers_are_sent_to_the_login(guarded, page):
    check_strangers(guarded, page, "/line-up")
