"""The page in a real browser: by mouse, keyboard and screen reader."""

import time

import pytest

from subsea.stage.console import board
from subsea.stage.console.commands import (
    AddSpecialDay,
    BlankScreens,
    EditItem,
    FeedFishes,
    FollowFish,
    GoToItem,
    OpenScenario,
    RemoveSpecialDay,
    SetQuality,
    SetVolume,
    ShowCaption,
    ShowLineUp,
    StartCue,
    StartTour,
)
from tests.stage.console.conftest import TOKEN
from tests.support.console_pages import check_fits, check_names, click, taken


@pytest.fixture
def opened(console, page):
    page.logged.clear()
    page.open(f"http://{console.host}/")
    page.until("document.getElementById('scene').textContent === 'A bay'")
    yield page
    assert not page.logged, page.logged
    page.open("about:blank")


def test_every_control_sends_its_command(console, opened):
    click(opened, "line-up")
    taken(console, ShowLineUp(True))
    opened.run("document.getElementById('tour').value = 'reef'")
    opened.run("document.getElementById('tour-form').requestSubmit()")
    taken(console, StartTour("reef"))
    click(opened, "next-cue")
    taken(console, StartCue(-1))
    opened.run("document.querySelectorAll('#cues button')[1].click()")
    taken(console, StartCue(1))
    opened.run("document.getElementById('caption').value = 'Good evening'")
    opened.run("document.getElementById('caption-form').requestSubmit()")
    taken(console, ShowCaption("Good evening"))
    click(opened, "clear-caption")
    taken(console, ShowCaption(""))
    opened.run("document.getElementById('fish').value = 'moon_wrasse'")
    opened.run("document.getElementById('fish-form').requestSubmit()")
    taken(console, FollowFish("moon_wrasse"))
    click(opened, "feed")
    taken(console, FeedFishes())
    opened.run("document.getElementById('scenario').value = 'deep'")
    opened.run("document.getElementById('scenario-form').requestSubmit()")
    taken(console, OpenScenario("deep"))
    for name, value, command in (
        ("quality", "low", SetQuality("low")), ("volume", "35", SetVolume(0.35)),
    ):  # fmt: skip
        opened.run(
            f"const one = document.getElementById('{name}'); one.value = '{value}';"
            "one.dispatchEvent(new Event('change'))".replace("const one", "var one")
        )
        taken(console, command)


def test_a_presenter_leads_and_edits_the_programme(console, opened):
    def fill(name, value):
        opened.run(f"document.getElementById('{name}').value = '{value}'")

    rows = "[...document.querySelectorAll('#items .words')].map(one => one.textContent)"
    assert opened.run(rows) == [
        "1. bay, reef, 60 s, Good morning", "2. cue, the same sea, Here they come, not today",
    ]  # fmt: skip
    assert (
        opened.run("document.querySelector('#items [aria-current] .words').textContent[0]") == "2"
    )
    opened.run("document.querySelectorAll('#items button')[0].click()")
    taken(console, GoToItem(1))
    opened.run("document.querySelectorAll('#items button')[1].click()")
    assert opened.run("document.activeElement.id") == "item-start"
    fill("item-length", "90")
    fill("item-caption", "Good evening")
    opened.run("document.getElementById('item-form').requestSubmit()")
    taken(console, EditItem(1, "for_s", "90"))
    taken(console, EditItem(1, "caption", "Good evening"))
    opened.until("document.getElementById('item-form').hidden")
    assert not any(isinstance(one, EditItem) and one.key == "start" for one in console.dive.taken)
    assert opened.run("document.querySelector('#days .words').textContent") == (
        "Gala, each 12-24, closed, today"
    )
    opened.run("document.querySelector('#days button').click()")
    taken(console, RemoveSpecialDay(1))
    opened.run("document.querySelector('#show-card details').open = true")
    fill("day-date", "2026-12-31")
    fill("day-title", "New Year")
    opened.run("document.getElementById('day-form').requestSubmit()")
    taken(console, AddSpecialDay("2026-12-31", "New Year", "closed"))


def test_the_screens_become_blank_by_keyboard_alone(console, opened):
    assert opened.run("document.getElementById('blank').ariaPressed") == "false"
    for _ in range(30):
        opened.press("Tab")
        if opened.run("document.activeElement.id") == "blank":
            break
    assert opened.run("document.activeElement.matches(':focus-visible')")
    opened.press("Enter", "\r")
    taken(console, BlankScreens(True))
    opened.until("document.getElementById('blank').ariaPressed === 'true'")
    assert opened.run("document.activeElement.id") == "blank"  # an update takes no focus away
    opened.until("document.getElementById('now').textContent.startsWith('The screens are blank.')")
    opened.press(" ", " ")
    taken(console, BlankScreens(False))


def test_the_order_of_the_focus_is_that_of_the_page(opened):
    order = []
    opened.run("document.body.focus()")
    for _ in range(40):
        opened.press("Tab")
        order.append(opened.run("document.activeElement.id || document.activeElement.className"))
        if order.count("skip") == 2:
            break
    first = [name for name in order[: order[1:].index("skip") + 1] if name]
    known = ["skip", "show-picture", "blank", "line-up", "tour", "next-cue", "caption",
             "clear-caption", "fish", "ride", "scenario", "quality", "volume",
             "scroll"]  # fmt: skip
    assert [name for name in first if name in known] == known


def test_a_screen_reader_finds_names_and_states(opened):
    tree = check_names(
        opened,
        ("button", "Blank"), ("combobox", "Tour"), ("combobox", "Quality"), ("slider", "Volume"),
        ("textbox", "Your text, 300 characters at most"), ("button", "Start Cue 1"),
        ("image", "Live picture of the dive"), ("main", ""), ("region", "Screens"),
        ("columnheader", "Mean wait, ms"), ("rowheader", "left"),
        ("heading", "Presenter's console"),
    )  # fmt: skip
    live = {one.get("live") for one in tree}
    assert "polite" in live
    assert next(one for one in tree if one["name"] == "Blank")["pressed"] == "false"


def test_a_refusal_is_read_aloud(console, opened):
    opened.run("document.getElementById('caption').value = 'refuse'")
    opened.run("document.getElementById('caption-form').requestSubmit()")
    opened.until("document.getElementById('message').textContent === 'the dive refuses'")
    assert opened.run("document.getElementById('message').getAttribute('role')") == "alert"
    opened.logged.clear()  # the browser's own line about the refusal


@pytest.mark.parametrize("width", [320, 768, 1280])
def test_it_fits_a_telephone_and_a_tablet(opened, width):
    check_fits(opened, width)


def test_the_picture_is_renewed_only_while_it_is_shown(console, opened, monkeypatch):
    monkeypatch.setattr(board, "WANTED_S", 0.8)
    opened.until("document.getElementById('picture').naturalWidth === 64")
    click(opened, "show-picture")
    time.sleep(1.4)
    assert not console.board.picture_wanted
    click(opened, "show-picture")
    opened.until("document.getElementById('show-picture').checked")


def test_words_of_a_scenario_are_only_words(console, opened):
    evil = "<img src=x onerror=alert(1)>"
    console.dive.state |= {"title": evil, "caption": evil, "cues": [
        {"number": 0, "name": evil, "caption": evil, "begun": False}]}  # fmt: skip
    opened.until(f"document.getElementById('scene').textContent === {evil!r}")
    assert opened.run("document.querySelectorAll('img').length") == 1


@pytest.mark.nightly
def test_it_goes_on_when_the_dive_returns(console, opened, monkeypatch):
    console.server.close()
    opened.until("document.getElementById('status').textContent.startsWith('No connection')")
    console.server = type(console.server)(console.options, console.board)
    opened.until("document.getElementById('status').textContent === 'Connected'")
    opened.logged.clear()  # the browser's own lines about the lost connection


@pytest.mark.parametrize("way", ["form", "link"])
def test_it_asks_for_the_token_once(secure, page, way):
    page.logged.clear()
    page.open("about:blank")
    url = f"https://{secure.host}/"
    page.open(f"{url}#{TOKEN}" if way == "link" else url)
    if way == "form":
        page.until("document.activeElement.id === 'token'")
        assert page.run("document.getElementById('console').hidden")
        page.type("wrong")
        page.press("Enter", "\r")
        page.until("document.getElementById('message').textContent === 'This is not the token.'")
        page.type(TOKEN)
        page.press("Enter", "\r")
    page.until("!document.getElementById('console').hidden")
    assert TOKEN not in page.run("location.href + document.cookie")
    page.open(url)  # it is known now
    page.until("!document.getElementById('console').hidden")
    click(page, "logout")
    page.until("!document.getElementById('login').hidden")
    assert page.run("fetch('/api/state').then(answer => answer.status)") == 401
    page.logged.clear()  # refusals are logged
