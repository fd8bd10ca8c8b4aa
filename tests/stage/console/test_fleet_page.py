"""The page of computers and projectors in a real browser."""

import copy

import numpy as np
import pytest

from subsea.stage.console.commands import RestartNode, SwitchProjector, WakeNode
from subsea.stage.fleet.pictures import bounded_jpeg
from tests.support.console_pages import (
    check_fits,
    check_names,
    check_strangers,
    check_without_theatre,
    click,
    taken,
)

LEFT = {
    "name": "left", "own": False, "connected": True, "since": 1_790_000_000,
    "seen": 1_790_000_100, "fault": "no sound device", "fault_at": 1_790_000_050,
    "pictured": None, "wakes": True, "version": "2.0", "protocol": 8,
    "system": "Debian GNU/Linux 13 (trixie), Linux 6.12", "renderer": 'GPU "X"',
    "temperature_c": 63.5, "free_disk_gb": 120.25, "frame_ms": 16.7, "longest_ms": 31.0,
    "up_s": 100.0,
}  # fmt: skip
GONE = dict.fromkeys(LEFT) | {
    "name": "right", "own": False, "connected": False, "seen": 1_790_000_000, "fault": "",
    "wakes": False,
}  # fmt: skip
FLEET = {
    "nodes": [{**LEFT, "name": "middle", "own": True, "fault": "", "fault_at": None}, LEFT, GONE],
    "projectors": [
        {"name": "left", "power": "on", "lamps": [{"hours": 1234, "on": True}], "fault": "",
         "errors": [{"part": "fan", "severity": "warning"}], "seen": 1_790_000_000},
        {"name": "right", "power": "unknown", "lamps": [], "errors": [], "seen": None,
         "fault": "does not answer (too slow)"},
    ],
}  # fmt: skip


@pytest.fixture
def hall(console, page):
    """The page of a theatre of three computers and two projectors."""
    console.dive.state["fleet"] = copy.deepcopy(FLEET)
    page.logged.clear()
    page.open(f"http://{console.host}/fleet")
    page.until("document.querySelectorAll('#projectors .card').length === 2")
    yield page
    assert not page.logged, page.logged
    page.open("about:blank")


def card(number, kind="computers"):
    return f"document.querySelectorAll('#{kind} .card')[{number}]"


def text(page, number, part, kind="computers"):
    return page.run(f"{card(number, kind)}.querySelector('[data-part={part}]').textContent")


def press(page, number, act, kind="computers"):
    page.run(f"{card(number, kind)}.querySelector('[data-act={act}]').click()")


def answer(page, button):
    page.until("document.getElementById('ask').open")
    click(page, button)
    page.until("!document.getElementById('ask').open")


def test_each_computer_and_projector_is_described(hall):
    assert [text(hall, k, "state") for k in range(3)] == ["this computer", "connected", "gone"]
    assert text(hall, 1, "temperature") == "64 °C"
    assert text(hall, 2, "temperature") == "unknown"
    assert text(hall, 1, "frame") == "16.7 ms, at most 31 ms"
    assert text(hall, 1, "version") == "2.0, protocol 8"
    assert text(hall, 1, "disk") == "120.3 GB"
    assert text(hall, 1, "fault").endswith(": no sound device")
    assert text(hall, 2, "connected").startswith("last seen ")
    assert text(hall, 0, "lamps", "projectors") == "1,234 h"
    assert text(hall, 0, "fault", "projectors") == "fan: warning"
    assert text(hall, 1, "state", "projectors") == "no answer"
    assert text(hall, 1, "fault", "projectors") == "does not answer (too slow)"


def test_pictures_are_asked_for_and_shown(console, hall):
    hall.until(f"{card(0)}.querySelector('img').naturalWidth > 0")  # of this computer
    end = "document.querySelectorAll('#computers .card')[1].querySelector('img')"
    assert hall.run(f"{end}.hidden")
    console.board.node_pictures = {"left": bounded_jpeg(np.full((90, 160, 4), 99, np.uint8))}
    console.dive.state["fleet"]["nodes"][1]["pictured"] = 1_790_000_200
    hall.until(f"{end}.naturalWidth === 160")
    assert "left" in console.dive.nodes_wanted
    assert "right" not in console.dive.nodes_wanted


def test_a_restart_is_asked_twice(console, hall):
    press(hall, 1, "restart")
    hall.until("document.getElementById('question').textContent.startsWith('Restart left?')")
    answer(hall, "no")
    press(hall, 1, "restart")
    answer(hall, "yes")
    taken(console, RestartNode("left"))
    assert console.dive.taken.count(RestartNode("left")) == 1
    click(hall, "restart-all")
    answer(hall, "yes")
    taken(console, RestartNode("all"))
    assert hall.run(f"{card(2)}.querySelector('[data-act=restart]').disabled")  # it is gone


def test_computers_are_woken_and_projectors_switched(console, hall):
    press(hall, 1, "wake")
    taken(console, WakeNode("left"))
    assert hall.run(f"{card(2)}.querySelector('[data-act=wake]').hidden")
    press(hall, 0, "on", "projectors")
    taken(console, SwitchProjector("left", True))
    press(hall, 0, "off", "projectors")
    answer(hall, "yes")
    taken(console, SwitchProjector("left", False))
    click(hall, "off-all")
    answer(hall, "no")
    click(hall, "on-all")
    taken(console, SwitchProjector("all", True))
    assert SwitchProjector("all", False) not in console.dive.taken
    hall.until("document.getElementById('done').textContent === 'done'")


def test_the_question_is_answered_by_keyboard(console, hall):
    hall.run(f"{card(1)}.querySelector('[data-act=restart]').focus()")
    hall.press("Enter", "\r")
    hall.until("document.activeElement.id === 'yes'")
    hall.press("Tab")
    assert hall.run("document.activeElement.id") == "no"
    hall.press("Enter", "\r")
    hall.until("!document.getElementById('ask').open")
    assert RestartNode("left") not in console.dive.taken


def test_a_screen_reader_finds_names(hall):
    hall.until(f"{card(0)}.querySelector('img').alt")
    check_names(
        hall,
        ("button", "Restart program left"),
        ("button", "Switch off right"),
        ("button", "Restart all"),
        ("heading", "Computers"),
        ("image", "Picture of middle"),
    )


@pytest.mark.parametrize("width", [320, 768, 1280])
def test_it_fits_a_telephone_and_a_tablet(hall, width):
    check_fits(hall, width)


def test_without_a_theatre_it_says_so(console, page):
    check_without_theatre(console, page, "/fleet", "fleet")


def test_strangers_are_sent_to_the_login(guarded, page):
    check_strangers(guarded, page, "/fleet")
