"""The fish builder by real events, from a copy to a fish in the sea."""

import time
from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest
from msgspec import structs
from PIL import Image

from capture.learning.improve import write_plans
from subsea.base.errors import UserError
from subsea.fish.species import load_species, own_species_file, repertoire_file, species_file
from subsea.rendering.fish import preview
from subsea.repertoire import read_repertoire, write_repertoire
from subsea.repertoire.findings import FishMotion
from subsea.scenario.load import load_scenario
from subsea.studio.builder.jobs import SEA, SHOAL
from subsea.studio.builder.window import builder_for
from subsea.studio.checks import SwimTrial
from subsea.studio.draft import copy_draft, read_draft, save_draft, with_value
from subsea.studio.handles import handles
from subsea.studio.outline import with_mass
from subsea.studio.tool_window import ToolWindow
from subsea.submarine.vessel import Helm
from subsea.world.build import create_world
from subsea.world.step import step

SIZE = 800, 600
TRIAL = SwimTrial(True, (0.9, 1.1), "", 0.2, 0.05, FishMotion({}, 20.0), {})
RING, BACK = ("body", "ring", 1), ("surface", "back", 6)
LEARN_S, RECORD_S = 240.0, 120.0  # at most, on a busy machine


@pytest.fixture(scope="module")
def window(display, tmp_path_factory):
    """A builder with an own copy of the fusilier, over a photograph, in its own home folder."""
    photo = tmp_path_factory.mktemp("photo") / "green.png"
    Image.new("RGB", (400, 200), (20, 200, 40)).save(photo)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_DATA_HOME", str(tmp_path_factory.mktemp("home")))
        # Test swims take the processor from the window; tests/studio/test_checks.py has them.
        patch.setattr("subsea.studio.builder.assessment.try_swimming", lambda muscles: TRIAL)
        patch.setattr(preview, "SAMPLES", 0)  # a preview with smooth edges takes twice as long
        copy = copy_draft(read_draft(species_file("fusilier")), "red_snapper", "Red Snapper")
        save_draft(copy, own_species_file("red_snapper"))
        make = builder_for("red_snapper", over=photo)
        with closing(ToolWindow("subsea build", make, SIZE)) as window:
            for _ in range(5):
                window.frame(0.1)
            yield window


def at(window, view, x, y):
    """The position on the display of a place in a view."""
    left, top = window.window.position
    across, down = getattr(window.tool.views, view).on_screen((x, y))
    return round(left + across), round(top + down)


def drag(window, user, begin, end):
    """Drag a point, and wait until the display has delivered its release."""
    before = window.tool.editing.history.present
    user.drag(window, begin, end)
    user.until(window, lambda: window.tool.editing.history.present is not before)


def spot(window, view, path):
    """The position of a point of the current draft."""
    present = window.tool.editing.present
    return next(one.at for one in handles(present, view) if one.path == path)


def species(window):
    return window.tool.editing.present.species


def wait(window, true, seconds):
    """Run frames, few lest those take its time, until another process makes a condition true."""
    end = time.monotonic() + seconds
    while not true() and time.monotonic() < end:
        window.frame(0.05)
        time.sleep(0.3)
    assert true(), window.message


@pytest.fixture
def new(display, monkeypatch, tmp_path):
    """A builder that was started without a species."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    with closing(ToolWindow("subsea build", builder_for(None), SIZE)) as window:
        yield window


@pytest.mark.nightly
def test_from_a_copy_to_a_fish_in_the_sea(new, user, spots):
    # Must be the first test of this module: the window library has one display at a time.
    window, builder = new, new.tool
    # It asks for a template: a copy of the fusilier, which gets a name and a file.
    user.until(window, lambda: "its name" in spots)
    builder.naming.source = "blue_tang"  # shows at once
    user.until(window, lambda: species(window).name == "Blue tang")
    assert not builder.history.unsaved
    builder.naming.source = "fusilier"
    spots.type(window, "its name", "Red Snapper")
    assert builder.naming.key == "red_snapper"
    spots.click(window, "Make it")
    user.until(window, lambda: builder.naming is None)
    assert builder.history.unsaved and species(window).name == "Red Snapper"
    fusilier = load_species("fusilier")
    assert species(window).body == fusilier.body

    # A point of the back is dragged upward in the side view ...
    x, y = spot(window, "side", BACK)
    drag(window, user, at(window, "side", x, y), at(window, "side", x, y + 0.04))
    user.until(window, lambda: spot(window, "side", BACK)[1] == pytest.approx(y + 0.04, abs=0.01))
    assert builder.editing.selected == BACK
    lifted = spot(window, "side", BACK)[1]
    user.do("key", "Up")
    user.until(window, lambda: spot(window, "side", BACK)[1] == pytest.approx(lifted + 0.002))
    # ... and a ring outward in the top view, dragged by its mirrored point.
    x, wide = spot(window, "top", RING)
    drag(window, user, at(window, "top", x, -wide), at(window, "top", x, -wide - 0.015))
    user.until(
        window, lambda: spot(window, "top", RING)[1] == pytest.approx(wide + 0.015, abs=0.006)
    )
    widened = species(window).body.half_widths[1]
    assert widened > fusilier.body.half_widths[1]
    user.do("key", "ctrl+z")
    user.until(window, lambda: species(window).body == fusilier.body)
    user.do("key", "ctrl+y")
    user.until(window, lambda: species(window).body.half_widths[1] == widened)

    # The file equals the shown fish.
    spots.click(window, "Save")
    user.until(window, lambda: not builder.history.unsaved)
    path = own_species_file("red_snapper")
    assert load_species("red_snapper") == species(window) and str(path) in window.message

    # Its swimming is checked, ...
    wait(window, lambda: builder.findings is not None, 60.0)
    assert any("swims" in finding.text for finding in builder.findings)
    # ... recorded, ...
    spots.click(window, "Record")
    wait(window, lambda: builder.jobs.running or builder.recorded, 20.0)
    wait(window, lambda: not builder.jobs.running, RECORD_S)
    assert builder.recorded, builder.jobs.message
    recorded = read_repertoire(repertoire_file("red_snapper"))
    assert recorded.provenance["body"]["half_widths"][1] == widened

    # ... and tried in a sea.
    scenario = load_scenario(SEA, [f"{SHOAL}.species=red_snapper"]).scenario
    world = create_world(scenario)
    kind = [one.name for one in world.species].index("Red Snapper")
    mine = world.state.fishes.species == kind
    before = world.state.fishes.position[mine].copy()
    for _ in range(10):
        step(world, Helm())
    way = np.linalg.norm(world.state.fishes.position[mine] - before, axis=1)
    assert mine.sum() == scenario.fish[1].number and np.median(way) > 0.5


def test_a_photograph_lies_behind_the_side_view(window):
    window.frame(0.1)

    def green(x, y):
        left, top = window.window.position
        across, down = at(window, "side", x, y)
        red, green, blue = window.window_set.picture()[down - top, across - left][:3].astype(int)
        return green > red + 60 and green > blue + 60

    assert green(0.95, 0.21) and not green(1.02, 0.21)  # half as high as wide
    window.tool.overlay.left += 0.05
    window.tool.overlay.flipped = True
    window.frame(0.1)
    assert green(1.02, 0.21) and not green(0.03, 0.21)


@pytest.mark.nightly
def test_points_are_added_and_removed(window, user, spots):
    builder = window.tool
    before = len(species(window).surface.belly)
    (a, y0), (b, y1) = (spot(window, "side", ("surface", "belly", k)) for k in (3, 4))
    place = at(window, "side", (a + b) / 2, (y0 + y1) / 2)
    user.do("mousemove", *place)
    user.glide(window, 0.2)
    user.double_click(window)
    user.until(window, lambda: len(species(window).surface.belly) == before + 1)
    assert builder.editing.selected == ("surface", "belly", 4)
    user.do("key", "Delete")
    user.until(window, lambda: len(species(window).surface.belly) == before)
    window.frame(0.1)
    spots.click(window, "Add point")
    user.do("mousemove", *place)
    user.glide(window, 0.2)
    user.do("click", 1)
    user.until(window, lambda: len(species(window).surface.belly) == before + 1)
    spots.click(window, "Take away")
    user.until(window, lambda: len(species(window).surface.belly) == before)


def test_a_point_is_highlighted_in_both_views(window, user):
    x, y = spot(window, "side", RING)
    top = np.array(at(window, "top", *spot(window, "top", RING))) - window.window.position

    def lit():
        picture = window.window_set.picture().astype(int)
        part = picture[top[1] - 9 : top[1] + 10, top[0] - 9 : top[0] + 10]
        return int((part[..., 2] > 230).sum())

    user.do("mousemove", *at(window, "side", 0.02, 0.28))
    user.until(window, lambda: window.tool.editing.hovered is None)
    user.glide(window, 0.3)
    window.tool.editing.selected = None
    dark = lit()
    user.do("mousemove", *at(window, "side", x, y))
    user.until(window, lambda: window.tool.editing.hovered == RING)
    user.glide(window, 0.3)
    assert lit() > dark + 15


def test_both_views_keep_one_scale_and_place_along_the_body(window, user, spots):
    views = window.tool.views
    user.do("mousemove", *at(window, "top", 0.5, 0.1))
    user.glide(window, 0.2)
    user.do("click", 4, "click", 4)
    user.until(window, lambda: views.top.scale == views.side.scale > 1.1 * 300)
    assert at(window, "side", 0.3, 0)[0] == pytest.approx(at(window, "top", 0.3, 0)[0], abs=1)
    spots.click(window, "Fit")
    user.glide(window, 0.3)
    assert at(window, "side", 0.3, 0)[0] == pytest.approx(at(window, "top", 0.3, 0)[0], abs=1)


def test_the_fish_is_turned_by_the_mouse_and_its_muscles_contract(window, user, spots):
    builder = window.tool
    before = builder.preview.orbit
    window.frame(0.1)
    spots.drag(window, "preview", 0.4, 0.6)
    assert builder.preview.orbit.turn != before.turn
    builder.preview.swimmer.mode = "fast"
    user.glide(window, 2.0)
    assert np.abs(builder.preview.swimmer.contraction).max() > 0.1


@pytest.mark.nightly
def test_a_number_is_typed_and_an_invalid_one_is_refused(window, user, spots):
    builder = window.tool
    builder.panels.show = "Body"
    user.until(window, lambda: "Neutral" in spots)
    user.do("mousemove", *spots.place(window, "##body.masses.2"))
    user.glide(window, 0.3)
    for _ in range(8):
        user.do("click", 5)  # the wheel
        user.glide(window, 0.2)
    weight = species(window).body.mass
    spots.click(window, "Neutral")
    user.until(window, lambda: species(window).body.mass != weight)
    user.do("key", "ctrl+z")
    user.until(window, lambda: species(window).body.mass == weight)
    for _ in range(10):
        user.do("click", 4)
        user.glide(window, 0.2)
    label = "##body.half_heights.1"
    user.do("mousemove", *spots.place(window, label))
    user.glide(window, 0.2)
    user.double_click(window)
    user.glide(window, 0.5)
    user.do("key", "ctrl+a")
    user.glide(window, 0.2)
    user.do("type", "--delay", 15, "1.3")
    user.do("key", "Return")
    user.glide(window, 1.0)
    user.until(window, lambda: species(window).body.half_heights[1] == 1.3)
    draft = builder.editing.present
    builder.editing.do(lambda one: with_mass(one, 1e5))
    window.frame(0.1)
    assert "masses" in window.message and builder.editing.present is draft


@pytest.mark.nightly
def test_learned_controllers_are_put_into_the_draft(window, user, spots):
    builder = window.tool
    window.frame(0.1)
    spots.click(window, "Save")
    user.until(window, lambda: not builder.history.unsaved)
    builder.jobs.tries = 300  # soon one percent is done, and it does not end by itself
    spots.click(window, "Learn")
    wait(window, lambda: builder.jobs.progress > 0, LEARN_S)
    spots.click(window, "New from…")  # would replace the learning fish
    assert builder.naming is None and not window.asking
    spots.click(window, "Stop")
    wait(window, lambda: not builder.jobs.running, LEARN_S)
    assert builder.jobs.message
    assert load_species("red_snapper") == species(window)
    # Simulate a result that arrives while the fish is edited.
    path = own_species_file("red_snapper")
    found = load_species("red_snapper")
    write_plans(path, path, swim=structs.replace(found.swim, lag=1.21), turn=found.turn)
    builder.editing.do(lambda draft: with_value(draft, ("schooling",), False))
    builder.take_job("learn", 0)
    assert species(window).swim.lag == 1.21 and not species(window).schooling
    assert builder.history.unsaved and load_species("red_snapper").swim == species(window).swim
    # A fit writes the body too.
    write_plans(path, path, body=structs.replace(found.body, viscosity=0.3))
    builder.take_job("fit", 0)
    assert species(window).body.viscosity == 0.3 and not species(window).schooling
    assert window.save() and not window.asking


@pytest.mark.parametrize("answer", ["Read it", "Write over it"])
def test_changes_by_another_program_are_not_overwritten_without_a_question(
    window, user, spots, answer
):
    builder, path = window.tool, own_species_file("red_snapper")
    path.write_text(path.read_text() + "# by hand\n")
    there = path.read_bytes()
    builder.editing.do(lambda draft: with_value(draft, ("name",), answer))
    assert not window.save() and path.read_bytes() == there
    user.until(window, lambda: f"{answer}##answer" in spots)
    user.glide(window, 0.3)
    spots.click(window, f"{answer}##answer")
    user.until(window, lambda: not builder.history.unsaved)
    assert (path.read_bytes() == there) == (answer == "Read it")
    assert load_species("red_snapper") == species(window)


def test_saving_during_the_dialog_for_a_new_species_keeps_the_fish(window, user, spots):
    builder = window.tool
    window.save()
    editing, path = builder.editing, builder.path
    spots.clear()
    window.frame(0.1)
    spots.click(window, "New from…")
    user.until(window, lambda: "Cancel" in spots)
    builder.naming.source = "clownfish"
    user.until(window, lambda: builder.editing.present.key == "clownfish")
    assert not window.save() and builder.naming.copies
    user.glide(window, 0.3)
    spots.click(window, "Cancel")
    user.until(window, lambda: builder.naming is None)
    assert builder.editing is editing and builder.path == path


def test_a_file_elsewhere_does_not_use_the_motion_of_its_namesake(window, tmp_path, monkeypatch):
    builder = window.tool
    fusilier = read_repertoire(repertoire_file("fusilier"))
    write_repertoire(repertoire_file("red_snapper"), replace(fusilier, species="red_snapper"))
    builder.take_job("record", 0)
    assert builder.recorded
    monkeypatch.setattr(builder, "path", tmp_path / "fusilier.toml")
    monkeypatch.setattr(builder, "recorded", True)
    builder.take_job("record", 0)
    assert not builder.recorded


@pytest.mark.nightly
def test_closing_asks_once_about_unsaved_work(window, user, spots):
    builder = window.tool
    x, y = spot(window, "side", BACK)
    drag(window, user, at(window, "side", x, y), at(window, "side", x, y - 0.02))
    user.until(window, lambda: builder.history.unsaved)
    window.window.ask_to_close()
    user.until(window, lambda: window.asking)
    user.glide(window, 0.4)
    assert window.open
    spots.click(window, "Go on##answer")
    user.until(window, lambda: not window.asking)
    window.window.ask_to_close()
    user.until(window, lambda: window.asking)
    user.glide(window, 0.4)
    spots.click(window, "Save##answer")
    user.until(window, lambda: not window.open)
    assert load_species("red_snapper") == species(window)
    window.open = True


def test_a_faulty_file_is_one_line_before_a_window_opens(tmp_path):
    (tmp_path / "torn.toml").write_text("name = 3")
    with pytest.raises(UserError, match=r"torn\.toml"):
        builder_for(str(tmp_path / "torn.toml"))
    with pytest.raises(UserError, match="fusilier"):
        builder_for("fusiler")
    with pytest.raises(UserError, match=r"torn\.toml: not a picture"):
        builder_for("fusilier", over=tmp_path / "torn.toml")
