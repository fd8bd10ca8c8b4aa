"""The menu in a real window, by keys and mouse, and its effects on the dive."""

import math
from contextlib import closing

import numpy as np
import pytest
from imgui_bundle import imgui
from PIL import Image

from subsea.base.system import resource_names, resource_path
from subsea.base.toml_files import load_toml
from subsea.dive.settings import PAD_BUTTONS
from subsea.rendering.output.quality import CHOICES, PRESETS
from subsea.scenario.load import own_scenarios
from subsea.scenario.storage import read_thumbnail
from subsea.ui import menu as menu_module
from subsea.ui.dive import Dive
from subsea.ui.gamepad import GamepadState
from subsea.ui.menu import (
    ABOUT_SIZE,
    DISPLAYS,
    LEAST_ABOUT,
    QUALITIES,
    THUMBNAIL,
    WIDE,
    scenario_summaries,
)
from subsea.view.display_rigs import DISPLAYS as ALL_DISPLAYS
from subsea.view.display_rigs import HEADSET
from tests.support.windows import dive_options

SIZE = (480, 360)


@pytest.fixture(scope="module")
def boat(display, user, quiet, coarse):
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(PRESETS, "medium", PRESETS[coarse])  # the tests need no detail of the sea
        with closing(Dive(dive_options(quiet, SIZE, "medium"))) as running:
            user.glide(running, 0.2)
            yield running


@pytest.fixture
def menu(boat, user):
    user.do("key", "Escape")
    user.until(boat, lambda: boat.menu.open)
    user.glide(boat, 0.5)
    yield boat.menu
    for _ in range(2):
        if boat.menu.open:
            boat.menu.back()


def press(boat, user, *keys):
    """Press keys, each after the menu has processed the previous one."""
    for key in keys:
        user.do("key", key)
        user.glide(boat, 0.2)


def click(boat, user, monkeypatch, text, release=True):
    """Click the entry that begins with this text, after scrolling to it."""
    found, draw = {}, boat.menu.draw_entry

    def noted(entry, line):
        draw(entry, line)
        low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        found[entry.text] = (low.x + high.x) / 2, (low.y + high.y) / 2

    def place():
        user.glide(boat, 0.2)
        return next(place for name, place in found.items() if name.startswith(text))

    with monkeypatch.context() as patch:
        patch.setattr(boat.menu, "draw_entry", noted)
        x, y = place()
        left, top = boat.window.position
        user.do("mousemove", int(left + x), top + SIZE[1] // 2)
        for _ in range(100):
            if 0.1 * SIZE[1] < y < 0.9 * SIZE[1]:
                break
            user.do("click", 4 if y < 0.5 * SIZE[1] else 5)
            x, y = place()
    user.drag(boat, (int(left + x), int(top + y)), drop=release)


def open_page(boat, name):
    """Open a page of the menu by its entry."""
    next(entry for entry in boat.menu.entries() if entry.text == name).act()
    boat.frame(0.1)


def heading(boat):
    return boat.world.state.submarine.angles[0]


def test_every_mode_and_quality_has_a_label():
    assert DISPLAYS.keys() == {*ALL_DISPLAYS, HEADSET}
    assert list(QUALITIES) == list(CHOICES)
    files = scenario_summaries()
    assert files[(resource_path("assets/scenarios") / "mating.toml").resolve()].title == "Courtship"


def test_scenarios_are_read_again_only_after_a_change(monkeypatch):
    read = []

    def noted(path, kind):
        read.append(path.stem)
        return load_toml(path, kind)

    path = own_scenarios() / "changed.toml"
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        path.write_text('title = "One"\n')
        scenario_summaries()
        monkeypatch.setattr(menu_module, "load_toml", noted)
        assert scenario_summaries()[path.resolve()].title == "One"
        assert not read
        path.write_text('title = "Another"\n')
        assert scenario_summaries()[path.resolve()].title == "Another"
        assert read == ["changed"]
    finally:
        path.unlink()


def test_every_scenario_has_a_sentence_that_fits_and_the_seed_is_explained(boat, menu, monkeypatch):
    shown = {}
    draw = menu.draw_entry

    def noted(entry, line):
        shown[entry.aside] = entry.about, imgui.calc_text_size(entry.about).x * ABOUT_SIZE / line
        draw(entry, line)

    monkeypatch.setattr(menu, "draw_entry", noted)
    open_page(boat, "Scenario")
    for name in resource_names("assets/scenarios", ".toml"):
        about, wide = shown[name]
        assert about.endswith(".") and wide < WIDE - 1.4
    assert "seed" in shown[f"with seed {menu.seed}"][0]


def thumbnail_area(boat, user, monkeypatch, name):
    """The pixels of the window where the entry of a scenario file has its picture."""
    found, draw = {}, boat.menu.draw_entry

    def noted(entry, line):
        draw(entry, line)
        low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        if entry.picture:
            wide, tall = (side * line for side in THUMBNAIL)
            gap = (high.y - low.y - tall) / 2
            found[entry.picture.stem] = low.x + gap, low.y + gap, wide, tall

    with monkeypatch.context() as patch:
        patch.setattr(boat.menu, "draw_entry", noted)
        user.glide(boat, 0.5)
    left, top, wide, tall = found[name]
    rows = slice(round(top) + 1, round(top + tall) - 1)
    return user.screen(boat)[rows, round(left) + 1 : round(left + wide) - 1].astype(float)


def test_each_scenario_shows_its_picture(boat, menu, user, monkeypatch):
    folder, names = resource_path("assets/scenarios"), ("go-fish", "mating", "open-ocean")
    open_page(boat, "Scenario")
    for name in names:
        shown = thumbnail_area(boat, user, monkeypatch, name)
        off = {}
        for other in names:
            picture = Image.fromarray(read_thumbnail(folder / f"{other}.toml"))
            small = np.asarray(picture.resize(shown.shape[1::-1], Image.Resampling.BOX), float)
            off[other] = np.abs(shown - small)[3:-3, 3:-3].mean()  # without the round corners
        assert min(off, key=off.get) == name and off[name] < 25.0, off


def test_an_own_scenario_may_have_a_picture_and_a_broken_one_is_ignored(
    boat, menu, user, monkeypatch
):
    assert boat.source.stem == "quiet"
    picture, magenta = boat.source.with_suffix(".jpg"), np.array((220.0, 30.0, 200.0))

    def off():
        menu.hide()
        menu.show()
        open_page(boat, "Scenario")
        shown = thumbnail_area(boat, user, monkeypatch, "quiet")
        return np.abs(np.median(shown, axis=(0, 1)) - magenta).max()

    try:
        Image.new("RGB", (160, 90), tuple(magenta.astype(int))).save(picture)
        assert off() < 10.0
        picture.write_bytes(picture.read_bytes()[:300])
        assert off() > 100.0
    finally:
        picture.unlink()
    assert off() > 100.0


def test_while_it_is_open_the_sea_goes_on_and_the_submarine_holds_station(boat, menu, user):
    tick, before = boat.world.state.tick, heading(boat)
    lit = user.screen(boat).mean()
    user.do("keydown", "a", "keydown", "w")
    user.point(boat, 0.9, 0.5)
    user.glide(boat, 1.0)
    user.do("keyup", "a", "keyup", "w", "key", "r", "key", "Tab", "key", "t")
    user.glide(boat, 0.5)
    assert boat.world.state.tick > tick + 20
    assert abs(heading(boat) - before) < math.radians(1.0)
    assert np.linalg.norm(boat.world.state.submarine.velocity) < 1.0
    assert not boat.pilot.riding and not boat.picture.pattern
    press(boat, user, "Escape")
    assert not boat.menu.open and not boat.inspector.open
    assert user.screen(boat).mean() > 1.2 * lit
    user.glide(boat, 1.0)
    assert abs(heading(boat) - before) < math.radians(1.0)  # until further input


def test_enter_continues_at_once(boat, menu, user):
    press(boat, user, "Return")
    assert not boat.menu.open


def test_arrows_and_enter_change_the_quality(boat, menu, user):
    press(boat, user, "Down", "Down", "Return")
    assert boat.menu.page == "Quality"
    press(boat, user, "Up", "Return")
    assert boat.picture.quality == "low"
    assert boat.picture.quality_text == "picture low"
    press(boat, user, "Escape")
    assert boat.menu.open and boat.menu.page == ""


def test_a_gamepad_chooses_and_goes_back(boat, user, monkeypatch):
    def push(*pressed):
        for down in (pressed, (), ()):  # one picture each: a held input repeats
            buttons = [int(name in down) for name in PAD_BUTTONS]
            state = GamepadState("Pad", buttons, [0.0, 0.0, 0.0, 0.0, -1.0, -1.0])
            monkeypatch.setattr(boat.window_set.gamepads, "read", lambda now=state: {0: now})
            boat.frame(0.1)

    push("start")
    assert boat.menu.open
    for button in ("down", "down", "A"):
        push(button)
    assert boat.menu.page == "Quality"
    for button in ("down", "A"):
        push(button)
    assert boat.picture.quality == "medium"
    push("B")
    assert boat.menu.open and boat.menu.page == ""
    push("B")
    assert not boat.menu.open
    assert np.linalg.norm(boat.world.state.submarine.velocity) < 1.0


def test_the_mouse_changes_the_display(boat, menu, user, monkeypatch):
    click(boat, user, monkeypatch, "Display")
    click(boat, user, monkeypatch, "3D, side")
    assert boat.picture.display == "side-by-side"
    assert len(boat.picture.rig.eyes) == 2
    left, right = np.split(user.screen(boat)[60:300], 2, axis=1)
    assert np.abs(left - right).mean() < 5.0 < left.std()
    boat.picture.show_as("mono")


def test_a_drag_that_begins_on_it_never_steers(boat, menu, user, monkeypatch):
    click(boat, user, monkeypatch, "Continue", release=False)
    left, top = boat.window.position
    user.do("mousemove", left + 20, top + 20)
    user.glide(boat, 0.3)
    press(boat, user, "Escape")
    assert not boat.menu.open
    user.glide(boat, 0.5)
    assert np.linalg.norm(boat.world.state.submarine.velocity) < 1.0
    user.do("mouseup", 1)
    user.glide(boat, 0.3)
    assert not boat.menu.open


def test_escape_leaves_a_fish_first(boat, user):
    user.do("key", "r")
    user.until(boat, lambda: boat.pilot.riding)
    press(boat, user, "Escape")
    assert not boat.pilot.riding and not boat.menu.open


def test_it_closes_to_the_inspector_where_that_was_open(boat, user):
    press(boat, user, "Tab")
    press(boat, user, "Escape")
    assert boat.menu.open
    press(boat, user, "Escape")
    assert boat.inspector.open and not boat.menu.open
    press(boat, user, "Tab")
    assert not boat.inspector.open


@pytest.mark.nightly
def test_it_restarts_the_dive(boat, menu, user, monkeypatch):
    boat.menu.seed = 2**32 - 7
    click(boat, user, monkeypatch, "Scenario")
    click(boat, user, monkeypatch, "Restart")
    assert boat.world.state.seed == 2**32 - 7 and not boat.menu.open


@pytest.mark.nightly
def test_it_opens_another_shipped_scenario(boat, menu, user, monkeypatch):
    handle = boat.window.handle
    click(boat, user, monkeypatch, "Scenario")
    click(boat, user, monkeypatch, "Courtship")
    assert boat.scenario.title == "Courtship" and boat.source.stem == "mating"
    assert boat.window.handle is handle and not boat.menu.open


def test_it_lists_own_scenarios_and_a_broken_one_changes_nothing(boat, user, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    own_scenarios().mkdir(parents=True)
    mine = boat.source.read_text().replace('title = "', 'title = "My ', 1)
    assert mine != boat.source.read_text()
    (own_scenarios() / "mine.toml").write_text(mine)
    for number in range(20):  # more than fit: the page scrolls
        (own_scenarios() / f"torn-{number:02}.toml").write_text("[")
    before = boat.world
    press(boat, user, "Escape")
    click(boat, user, monkeypatch, "Scenario")
    click(boat, user, monkeypatch, "torn-00")
    assert boat.world is before and not boat.menu.open
    assert "torn-00.toml:1: not valid TOML" in boat.overlay.note_text
    press(boat, user, "Escape")
    click(boat, user, monkeypatch, "Scenario")
    click(boat, user, monkeypatch, "My ")
    assert boat.source == own_scenarios() / "mine.toml"
    scrolls = imgui.internal.find_window_by_name("menu Scenario").scroll_max.y
    assert scrolls > 0.0
    for path in own_scenarios().glob("torn-*"):
        path.unlink()
    press(boat, user, "Escape")
    click(boat, user, monkeypatch, "Scenario")
    assert imgui.internal.find_window_by_name("menu Scenario").scroll_max.y < 0.5 * scrolls
    press(boat, user, "Escape", "Escape")


def test_the_horizon_is_at_its_height_and_the_vignette_darkens_the_rim(boat, user, monkeypatch):
    def screen():
        boat.frame(0.0)
        boat.frame(0.0)
        return user.screen(boat)

    monkeypatch.setattr(boat.tick_source, "advance", lambda elapsed_s: 1.0)  # paused time
    boat.overlay.hud.opacity, boat.overlay.help_opacity = 0.0, 0.0
    boat.world.state.submarine.angles[1] = math.radians(-15.0)
    boat.world.state.submarine.previous_angles[1] = math.radians(-15.0)
    rim = boat.text.vignette
    with_line = screen()
    monkeypatch.setattr(boat.text, "horizon", False)
    without = screen()
    rows = np.abs(with_line - without).max(axis=2).max(axis=1)
    submarine = boat.world.state.submarine
    far = submarine.position + 1e6 * np.array(
        [math.cos(heading(boat)), math.sin(heading(boat)), 0.0]
    )
    ((_, y),) = boat.picture.front_view.places(far[None])
    found = np.flatnonzero(rows > 20)
    assert abs(found[0] - y * SIZE[1]) < 4 and found[-1] - found[0] < 20
    rim.most, rim.amount = 1.0, 1.0
    dark = screen()
    rim.most = 0.0
    assert dark[:20, :20].mean() < 0.3 * without[:20, :20].mean()
    middle = slice(140, 220), slice(180, 300)
    np.testing.assert_array_equal(dark[middle], without[middle])


def test_help_is_shown_from_it(boat, menu, user, monkeypatch):
    click(boat, user, monkeypatch, "Help")
    user.until(boat, lambda: boat.overlay.help_opacity == 1.0)
    assert not boat.menu.open
    press(boat, user, "h")


def test_the_page_of_sound(boat, menu):
    menu.page = "Sound"
    before = boat.sound.settings

    def entry(text):
        return next(one for one in menu.entries() if one.text == text)

    assert entry("80%").chosen
    entry("40%").act()
    assert boat.sound.settings.volume == 0.4
    assert entry("40%").chosen
    entry("Off").act()
    assert entry("Off").chosen
    assert not entry("40%").chosen
    for level in ("50%", "0%", "100%"):
        entry("Fishes").act()
        assert entry("Fishes").aside == level
    for level in ("100%", "70%", "40%", "off"):
        entry("Quiet score").act()
        assert entry("Quiet score").aside == level
    entry("Night").act()
    entry("Captions").act()
    assert (entry("Night").aside, entry("Captions").aside) == ("on", "on")
    menu.page = ""
    boat.sound.change(
        **{
            name: getattr(before, name)
            for name in ("volume", "mute", "night", "captions", "score_level")
        }
    )


@pytest.fixture
def english(boat):
    yield
    boat.preferences.restore()
    boat.preferences.set_language("en")


def entry_of(menu, text):
    return next(one for one in menu.entries() if one.text == text)


def test_a_key_is_bound_by_pressing_it(boat, menu, user, english):
    open_page(boat, "Settings")
    open_page(boat, "Keys")
    lights = boat.world.state.submarine.lights
    entry_of(menu, "the submarine's lights").act()
    assert entry_of(menu, "the submarine's lights").aside == "press a key, or Esc"
    press(boat, user, "z")
    assert entry_of(menu, "the submarine's lights").aside == "Z"
    before = lights.copy()
    menu.hide()
    user.glide(boat, 0.3)
    press(boat, user, "b")
    assert (lights == before).all()
    press(boat, user, "z")
    assert (lights != before).all()
    press(boat, user, "z")
    rows = [row for _, rows in boat.overlay.help.groups for row in rows]
    assert any("z" in row.keys or "Z" in row.keys for row in rows)
    boat.preferences.usual_keys()


def test_escape_leaves_a_key_as_it_is(boat, menu, user):
    menu.page = "Keys"
    entry_of(menu, "the menu").act()
    press(boat, user, "Escape")
    assert menu.open and menu.page == "Keys" and entry_of(menu, "the menu").aside == "Esc"
    press(boat, user, "Escape")
    assert menu.page == "Settings"
    press(boat, user, "Escape")
    assert menu.page == ""


def test_a_visitor_changes_the_language(boat, menu, user, english):
    menu.page = "Language"
    user.glide(boat, 0.2)
    shown = {"en": user.screen(boat)}
    for code, name, back, title in (
        ("de", "Deutsch", "Zurück", "Ein Bild"),
        ("ja", "日本語", "戻る", "1 画面"),
    ):
        entry_of(menu, name).act()
        assert entry_of(menu, name).chosen and entry_of(menu, back)
        menu.page = ""
        assert title in [one.aside for one in menu.entries()]
        menu.page = "Language"
        user.glide(boat, 0.2)
        shown[code] = user.screen(boat)
    assert np.abs(shown["ja"] - shown["de"]).max() > 50
    menu.hide()
    press(boat, user, "x")
    assert boat.overlay.note_text == "English" and boat.overlay.help.moving == "move: look and turn"
    press(boat, user, "x")
    assert boat.overlay.note_text == "Deutsch"
    assert boat.overlay.help.moving == "bewegen: schauen, drehen"


@pytest.mark.parametrize("code", ["de", "es", "fr", "ja"])
def test_sentences_below_entries_fit_in_every_language(boat, menu, monkeypatch, english, code):
    boat.preferences.set_language(code)
    wide, draw = {}, menu.draw_entry

    def noted(entry, line):
        room = menu._width - 1.4
        about = imgui.calc_text_size(entry.about).x * ABOUT_SIZE * LEAST_ABOUT
        about += THUMBNAIL[0] * line if entry.picture else 0.0
        both = imgui.calc_text_size(entry.text).x + 0.7 * imgui.calc_text_size(entry.aside).x
        wide[entry.text] = max(about, both) / line < room
        draw(entry, line)

    monkeypatch.setattr(menu, "draw_entry", noted)
    for menu.page in (
        "",
        "Settings",
        "Keys",
        "Comfort",
        "Sound",
        "Language",
        "Scenario",
        "Display",
    ):
        boat.frame(0.1)
    menu.page = ""
    assert [text for text, fits in wide.items() if not fits] == []


def test_leaving_is_its_last_entry(boat, menu, user):
    press(boat, user, *["Down"] * 7, "Return")
    assert not boat.window.open
