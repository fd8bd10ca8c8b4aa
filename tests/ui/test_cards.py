"""The three cards for visitors: where they are docked, and what they say and change."""

from contextlib import closing
from itertools import combinations

import glfw
import numpy as np
import pytest

from subsea.state import NOBODY, SUBMARINE
from subsea.ui.cards import CARDS, EYES, MIND, SEA, EyePictures, common, companions, dock
from subsea.ui.dive import Dive
from tests.support.windows import dive_options

ROOM = 12.0, 34.0, 1256.0, 674.0
SIZES = {MIND: (380.0, 230.0), EYES: (380.0, 240.0), SEA: (380.0, 290.0)}
GAP = 10.0


def apart(areas):
    return all(common(one, other) == 0.0 for one, other in combinations(areas.values(), 2))


def test_cards_lie_at_the_sides_and_apart():
    areas = dock(SIZES, {}, ROOM, (), GAP)
    assert apart(areas) and set(areas) == set(SIZES)
    for x, y, wide, high in areas.values():
        assert x in (ROOM[0], ROOM[0] + ROOM[2] - wide)
        assert ROOM[1] <= y and y + high <= ROOM[1] + ROOM[3]


def test_no_card_ever_covers_a_fish_that_swims_across_the_screen():
    areas = {}
    for step in range(120):
        fish = 10.0 * step, 60.0 + 4.5 * step, 120.0, 70.0
        areas = dock(SIZES, areas, ROOM, [fish], GAP)
        assert apart(areas)
        assert all(common(area, fish) == 0.0 for area in areas.values()), step


def test_a_card_stays_where_it_is_while_it_covers_nothing():
    first = dock(SIZES, {}, ROOM, [(20.0, 40.0, 60.0, 60.0)], GAP)
    assert dock(SIZES, first, ROOM, [(600.0, 300.0, 60.0, 60.0)], GAP) == first


def test_without_room_for_all_the_fish_comes_first():
    small = 6.0, 30.0, 628.0, 440.0
    fish = 40.0, 100.0, 100.0, 60.0
    areas = dock({MIND: SIZES[MIND]}, {}, small, [fish], GAP)
    assert common(areas[MIND], fish) == 0.0


@pytest.fixture(scope="module")
def boat(display, user, quiet, coarse):
    with closing(Dive(dive_options(quiet, (640, 480), coarse))) as running:
        running.overlay.hide_help()
        user.glide(running, 0.2)
        yield running


@pytest.fixture
def opened(boat, user):
    user.do("key", "Tab")
    user.until(boat, lambda: boat.inspector.open)
    user.glide(boat, 0.5)
    yield boat
    user.do("key", "Tab")
    user.until(boat, lambda: not boat.inspector.open)


def test_a_visitor_sees_three_cards_about_a_fish_ahead_and_more_behind_the_bar(opened, user, spots):
    inspector = opened.inspector
    user.glide(opened, 0.2)
    assert inspector.shown == set(CARDS) and inspector.chosen is not None
    assert "Physics" not in spots and "more" in spots
    spots.click(opened, "more")
    assert "Physics" in spots
    spots.click(opened, "less")
    spots.clear()
    user.glide(opened, 0.2)
    assert "Physics" not in spots and inspector.shown == set(CARDS)


def test_the_card_of_eyes_shows_what_both_eyes_see(opened, user):
    seen = opened.inspector.state(EyePictures)
    user.until(opened, lambda: seen.texture is not None)
    before = user.screen(opened)
    pictures = {}
    for look in ("colours", "identity", "range"):
        opened.picture.colours = look
        pixels = opened.picture.through_eyes(opened.inspector.chosen, (64, 48))
        assert pixels.shape[1] * 48 == pixels.shape[0] * 128 and pixels.std() > 2.0
        pictures[look] = pixels.astype(int)
    opened.picture.colours = "colours"
    assert np.abs(pictures["identity"] - pictures["range"]).mean() > 5.0
    user.glide(opened, 0.2)
    # The sea itself is drawn as before.
    assert np.abs(user.screen(opened)[-40:] - before[-40:]).mean() < 20.0


@pytest.mark.nightly
def test_large_letters_shrink_until_cards_are_apart(opened, user, monkeypatch):
    opened.inspector.chosen = None  # no fish in the way
    glfw.set_window_size(opened.window.handle, 800, 500)
    try:
        user.until(opened, lambda: opened.window.size == (800, 500))
        for text in ("normal", "largest"):
            opened.preferences.set_display(text=text)
            user.glide(opened, 2.0)
            assert len(opened.inspector.cards) == 3 and apart(opened.inspector.cards)
        assert opened.inspector._fit < 1.0
        hud = opened.overlay.hud
        opened.preferences.set_display(text="normal")
        monkeypatch.setattr(hud, "mode", "always")
        user.until(opened, lambda: hud.opacity == 0.0)  # a card lies over the instruments
        monkeypatch.setattr(opened.inspector, "shown", set())
        user.until(opened, lambda: hud.opacity == 1.0)
    finally:
        opened.preferences.set_display(text="normal")
        glfw.set_window_size(opened.window.handle, 640, 480)
        user.until(opened, lambda: opened.window.size == (640, 480))


def test_companions_are_named_in_plain_words(boat):
    world = boat.world
    minds = world.state.minds
    before = minds.liked[0].copy(), minds.liking[0].copy()
    minds.liked[0], minds.liking[0] = NOBODY, 0.0
    assert companions(world, 0) == "Likes nobody in particular yet."
    minds.liked[0, 0], minds.liking[0, 0] = SUBMARINE, 0.5
    assert companions(world, 0) == "Likes: you"
    minds.liking[0, 0] = -0.5
    assert companions(world, 0) == "Shuns: you"
    minds.liked[0], minds.liking[0] = before
