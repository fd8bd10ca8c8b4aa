"""The inspector in a real window: the pointer, and new worlds in the same windows."""

import math
from contextlib import closing

import msgspec
import numpy as np
import pytest
from imgui_bundle import imgui

from subsea.base.errors import UserError
from subsea.ui.dive import Dive
from subsea.ui.inspector import Inspector, common, places_path
from subsea.ui.panels import PANELS
from tests.support.windows import dive_options

SIZE = (640, 480)


@pytest.fixture(scope="module")
def boat(display, user, quiet, coarse):
    with closing(Dive(dive_options(quiet, SIZE, coarse))) as running:
        running.inspector.more = True
        running.inspector.shown.clear()
        user.glide(running, 0.2)
        yield running


@pytest.fixture
def at_the_desk(boat, user):
    """A dive with a resting submarine and the inspector open."""
    submarine = boat.world.state.submarine
    boat.pilot.full_stop()
    user.until(boat, lambda: np.linalg.norm(submarine.velocity) < 1.0)
    user.until(boat, lambda: np.abs(submarine.rates).max() < 1e-3)
    user.do("key", "Tab")
    user.until(boat, lambda: boat.inspector.open)
    boat.pilot.hold("ahead", "W")
    boat.pilot.release("W")  # ends the full stop, so that steering would show
    user.glide(boat, 0.3)
    yield boat
    if boat.inspector.open:
        user.do("key", "Tab")
        user.until(boat, lambda: not boat.inspector.open)


def heading(boat):
    return boat.world.state.submarine.angles[0]


def test_in_the_inspector_the_pointer_and_its_buttons_do_not_steer(at_the_desk, user):
    boat, submarine = at_the_desk, at_the_desk.world.state.submarine
    before, place = heading(boat), submarine.position.copy()
    user.point(boat, 0.9, 0.6)
    user.do("mousedown", 1)
    user.glide(boat, 1.0)
    user.do("mouseup", 1, "click", 4, "click", 4)
    user.glide(boat, 1.0)
    assert abs(heading(boat) - before) < math.radians(1.0)
    assert boat.pilot.throttle == 0.0
    assert np.linalg.norm(submarine.position - place) < 5.0


def test_a_drag_that_begins_on_the_bar_never_steers_not_even_after_it_is_closed(at_the_desk, user):
    boat = at_the_desk
    left, top = boat.window.position
    user.do("mousemove", left + 200, top + 8)
    user.until(boat, lambda: boat.gui.on_panel)
    user.do("mousedown", 1)
    user.do("mousemove", left + 460, top + 300)
    user.glide(boat, 0.5)
    user.do("key", "Tab")
    user.until(boat, lambda: not boat.inspector.open)
    user.glide(boat, 0.5)
    assert not boat.pilot.held
    assert abs(boat.pilot.helm(0.0).surge) < 0.01
    user.do("mouseup", 1)
    user.glide(boat, 0.2)


def test_keys_steer_in_the_inspector(at_the_desk, user):
    boat = at_the_desk
    user.do("keydown", "a")
    before = heading(boat)
    user.until(boat, lambda: heading(boat) - before > math.radians(5.0))
    user.do("keyup", "a")
    user.glide(boat, 0.3)


def test_a_panel_is_opened_from_the_bar_drawn_and_closed(at_the_desk, spots, monkeypatch):
    boat, drawn = at_the_desk, []
    monkeypatch.setitem(PANELS, "Spare", drawn.append)
    boat.frame(0.0)
    spots.click(boat, "Spare")
    assert boat.inspector.shown == {"Spare"}
    assert drawn and drawn[-1] is boat.inspector
    spots.click(boat, "Spare")
    assert not boat.inspector.shown
    drawn.clear()
    boat.frame(0.0)
    assert not drawn


def test_panels_open_beside_one_another_where_there_is_room(at_the_desk, monkeypatch):
    boat = at_the_desk
    for name in ("One", "Other"):
        monkeypatch.setitem(PANELS, name, lambda desk: imgui.dummy((60.0, 40.0)))
        boat.inspector.shown.add(name)
        boat.frame(0.0)
        boat.frame(0.0)
    (x, y, width, height), (other_x, other_y, *_) = (
        boat.inspector.areas[name] for name in ("One", "Other")
    )
    assert other_x >= x + width or other_y >= y + height
    boat.inspector.shown.clear()
    boat.frame(0.0)


def test_panels_part_on_another_screen_and_keep_off_what_they_are_about(at_the_desk, monkeypatch):
    boat, inspector, box = at_the_desk, at_the_desk.inspector, []

    def drawn(desk):
        imgui.dummy((60.0, 40.0))
        if box:
            desk.subject = "a stone", box[0]

    for name in ("One", "Other"):
        monkeypatch.setitem(PANELS, name, drawn)
        inspector.shown.add(name)
        boat.frame(0.0)
    place = inspector.areas["One"][:2]
    inspector._screen = 100.0, 100.0  # it was small, and pushed them together
    monkeypatch.setattr("subsea.ui.inspector._keep_inside", lambda name: None)
    imgui.internal.find_window_by_name("Other").pos = place
    boat.frame(0.0)
    boat.frame(0.0)
    assert common(inspector.areas["One"], inspector.areas["Other"]) == 0.0
    box.append(inspector.areas["One"])
    for _ in range(3):
        boat.frame(0.0)
    assert not any(common(area, box[0]) for area in inspector.areas.values())
    inspector.shown.clear()
    boat.frame(0.0)


@pytest.mark.nightly
def test_a_covered_panel_is_raised_from_the_bar_and_a_dragged_one_stays_there(
    at_the_desk, user, spots, monkeypatch
):
    boat, inspector = at_the_desk, at_the_desk.inspector
    inspector.places.clear()  # of panels that an earlier dive has moved
    for name in ("Under", "Over"):
        monkeypatch.setitem(PANELS, name, lambda desk: imgui.dummy((160.0, 140.0)))
        boat.frame(0.0)
        spots.click(boat, name)
    user.glide(boat, 0.2)
    (x, y, *_), (to_x, to_y, *_) = inspector.areas["Over"], inspector.areas["Under"]
    left, top = boat.window.position
    begin = round(left + x + 60), round(top + y + 8)
    shift = round(to_x + 30 - x), round(to_y + 40 - y)
    user.drag(boat, begin, (begin[0] + shift[0], begin[1] + shift[1]))
    user.glide(boat, 0.2)
    assert inspector.areas["Over"][:2] == pytest.approx((to_x + 30, to_y + 40), abs=4)
    spots.click(boat, "Under")
    assert inspector.shown == {"Under", "Over"}  # it was raised
    spots.click(boat, "Under")
    assert inspector.shown == {"Over"}
    spots.click(boat, "Over")
    user.do("key", "Tab")
    user.until(boat, lambda: not inspector.open)
    again = Inspector(boat)  # of the next dive
    assert set(again.places) == {"Over"}
    moved = np.multiply(again.places["Over"], SIZE)
    assert moved == pytest.approx((to_x + 30, to_y + 40), abs=4)
    places_path().unlink()
    inspector.places.clear()


@pytest.mark.nightly
def test_back_at_the_helm_the_pointer_steers_again(boat, user):
    assert not boat.inspector.open
    before = heading(boat)
    user.point(boat, -0.9, 0.0)
    user.until(boat, lambda: heading(boat) - before > math.radians(10.0))
    user.do("key", "space")
    user.glide(boat, 2.0)


@pytest.mark.nightly
def test_another_world_is_entered_while_the_window_stays(boat, user):
    handle, before = boat.window.handle, boat.world
    fewer = msgspec.structs.replace(boat.scenario, fish=boat.scenario.fish[:1])
    assert boat.open_world(fewer, boat.source, seed=5)
    user.glide(boat, 0.5)
    assert boat.window.handle is handle and boat.world is not before
    assert boat.world.state.seed == 5
    assert len(boat.world.state.fishes.species) == 2
    assert boat.scenario is fewer
    assert boat.world.state.tick > 1


def test_an_impossible_world_leaves_the_dive_as_it_is(boat, capsys):
    rock = boat.scenario.rock[0]
    start = msgspec.structs.replace(
        boat.scenario.submarine, position_cm=(*rock.position_cm, -600.0)
    )
    world = boat.world
    assert not boat.open_world(msgspec.structs.replace(boat.scenario, submarine=start), boat.source)
    assert boat.world is world
    assert "submarine.position_cm" in capsys.readouterr().err
    boat.frame(0.1)


def test_the_display_mode_changes_while_it_runs(boat, user):
    for display in ("side-by-side", "dome", "mono"):
        boat.picture.show_as(display)
        user.glide(boat, 0.2)
        assert len(boat.picture.rig.eyes) == {"side-by-side": 2, "dome": 5}.get(display, 1)
        assert user.screen(boat).std() > 5.0


def test_panels_lie_within_the_screen_and_so_does_the_bar(at_the_desk, monkeypatch, spots):
    boat = at_the_desk
    monkeypatch.setitem(PANELS, "Huge", lambda desk: imgui.dummy((1500.0, 1200.0)))
    monkeypatch.setitem(PANELS, "Small", lambda desk: imgui.dummy((60.0, 40.0)))

    def inside(name):
        boat.frame(0.0)
        boat.frame(0.0)
        x, y, width, height = boat.inspector.areas[name]
        return x >= 0 and y > 0 and x + width <= SIZE[0] and y + height <= SIZE[1]

    for name in ("Huge", "Small"):
        boat.inspector.shown.add(name)
        boat.frame(0.0)
        assert inside(name)
    for place in ((-200.0, -90.0), (600.0, 100.0), (200.0, 460.0)):
        imgui.internal.find_window_by_name("Small").pos = place
        assert inside("Small")
    assert spots["To the helm"][2] <= SIZE[0]
    boat.inspector.shown.clear()
    boat.frame(0.0)


def test_a_refusal_after_a_frame_is_noted_and_the_dive_goes_on(at_the_desk, capsys):
    def refuse():
        raise UserError("nothing to read")

    at_the_desk.inspector.later(refuse)
    at_the_desk.frame(0.0)
    assert "nothing to read" in capsys.readouterr().err
    at_the_desk.frame(0.0)


def test_a_side_button_of_the_mouse_does_no_harm(at_the_desk, user):
    boat = at_the_desk
    user.do("click", 10)
    user.glide(boat, 0.2)
    user.do("key", "Tab")
    user.until(boat, lambda: not boat.inspector.open)
    user.do("click", 10)
    user.glide(boat, 0.2)
    assert boat.window.open


def test_letters_typed_at_once_after_a_click_into_a_field_stay_there(
    at_the_desk, user, monkeypatch
):
    boat, text = at_the_desk, [""]

    def typing(desk):
        imgui.set_window_pos((100.0, 100.0))
        text[0] = imgui.input_text("##words", text[0])[1]

    monkeypatch.setitem(PANELS, "Typing", typing)
    boat.inspector.shown.add("Typing")
    user.glide(boat, 0.3)
    left, top = boat.window.position
    x, y, width, height = boat.inspector.areas["Typing"]
    place = round(left + x + 0.5 * width), round(top + y + 0.75 * height)
    user.do("mousemove", *place)
    user.glide(boat, 0.2)
    user.do("click", 1, "type", "--delay", 12, "kr")
    user.until(boat, lambda: "kr" in text[0])
    assert not boat.timeline.paused and boat.picture.ride is None
    user.do("key", "Escape")
    user.glide(boat, 0.3)
    boat.inspector.shown.clear()
    user.glide(boat, 0.2)


@pytest.mark.nightly
def test_the_help_is_hidden_by_the_inspector(boat, user):
    boat.overlay.show_help()
    user.until(boat, lambda: boat.overlay.help_opacity == 1.0)
    user.do("key", "Tab")
    user.until(boat, lambda: boat.inspector.open)
    user.until(boat, lambda: boat.overlay.help_opacity == 0.0)
    user.do("key", "Tab")
    user.until(boat, lambda: not boat.inspector.open)
