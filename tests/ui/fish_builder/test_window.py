"""The fish builder in the hands of a visitor: real events, from a copy to a fish in the sea."""

import time
from contextlib import closing

import numpy as np
import pytest
from msgspec import structs
from PIL import Image

from capture.learning.species_edit import write_controllers
from subsea.core.errors import UserError
from subsea.fish.editing import draft as drafts
from subsea.fish.species import load_species, own_species_file, repertoire_file
from subsea.repertoire import read_repertoire
from subsea.scenario.load import load_scenario
from subsea.submarine.helm import Helm
from subsea.ui.fish_builder.jobs import MOST, SEA, SHOAL
from subsea.ui.fish_builder.window import begun
from subsea.ui.tool_window import Bench
from subsea.world.build import create_world
from subsea.world.step import step

SIZE = 800, 600
RING, BACK = ("body", "ring", 1), ("surface", "back", 6)
LEARN_S, RECORD_S = 240.0, 120.0  # at most, on a busy machine


@pytest.fixture(scope="module")
def table(display, tmp_path_factory):
    """A builder that was started without a species, in a home of its own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_DATA_HOME", str(tmp_path_factory.mktemp("home")))
        photo = tmp_path_factory.mktemp("photo") / "green.png"
        Image.new("RGB", (400, 200), (20, 200, 40)).save(photo)
        with closing(Bench("subsea build", begun(None, over=photo), SIZE)) as bench:
            for _ in range(5):
                bench.frame(0.1)
            yield bench


def at(bench, view, x, y):
    """Where on the display a place of a view is."""
    left, top = bench.window.position
    across, down = getattr(bench.craft.views, view).on_screen((x, y))
    return round(left + across), round(top + down)


def drag(bench, hands, begin, end):
    """Drag a point, until it is let go of: the display may take its time."""
    before = bench.craft.editing.history.present
    for words in (
        ("mousemove", *begin), ("mousedown", 1), ("mousemove", *end), ("mouseup", 1),
    ):  # fmt: skip
        hands.do(*words)
        hands.glide(bench, 0.4)
    hands.until(bench, lambda: bench.craft.editing.history.present is not before)


def spot(bench, view, path):
    """Where a point of the present draft is."""
    present = bench.craft.editing.present
    return next(one.at for one in drafts.spots(present, view) if one.path == path)


def species(bench):
    return bench.craft.editing.present.species


def wait(bench, true, seconds):
    """Frames until something is true, that other processes work at."""
    end = time.monotonic() + seconds
    while not true() and time.monotonic() < end:
        bench.frame(0.05)
        time.sleep(0.05)
    assert true(), bench.told


def test_from_a_copy_to_a_fish_in_the_sea(table, hands, spots):
    craft = table.craft
    # It asks what to begin from: a copy of the fusilier, which gets a name and a file.
    hands.until(table, lambda: "its name" in spots)
    craft.naming.source = "blue_tang"  # is shown at once
    hands.until(table, lambda: species(table).name == "Blue tang")
    assert not craft.unsaved
    craft.naming.source = "fusilier"
    spots.type(table, "its name", "Red Snapper")
    assert craft.naming.key == "red_snapper"
    spots.click(table, "Make it")
    hands.until(table, lambda: craft.naming is None)
    assert craft.unsaved and species(table).name == "Red Snapper"
    fusilier = load_species("fusilier")
    assert species(table).body == fusilier.body

    # A point of the back is dragged upward in the side view ...
    x, y = spot(table, "side", BACK)
    drag(table, hands, at(table, "side", x, y), at(table, "side", x, y + 0.04))
    hands.until(table, lambda: spot(table, "side", BACK)[1] == pytest.approx(y + 0.04, abs=0.01))
    assert craft.editing.chosen == BACK
    lifted = spot(table, "side", BACK)[1]
    hands.do("key", "Up")
    hands.until(table, lambda: spot(table, "side", BACK)[1] == pytest.approx(lifted + 0.002))
    # ... and a ring outward in the top view, where its twin on the other side is taken hold of.
    x, wide = spot(table, "top", RING)
    drag(table, hands, at(table, "top", x, -wide), at(table, "top", x, -wide - 0.015))
    hands.until(
        table, lambda: spot(table, "top", RING)[1] == pytest.approx(wide + 0.015, abs=0.006)
    )
    widened = species(table).body.half_widths[1]
    assert widened > fusilier.body.half_widths[1]
    hands.do("key", "ctrl+z")
    hands.until(table, lambda: species(table).body == fusilier.body)
    hands.do("key", "ctrl+y")
    hands.until(table, lambda: species(table).body.half_widths[1] == widened)

    # What stands in the file is what was shown.
    spots.click(table, "Save")
    hands.until(table, lambda: not craft.unsaved)
    path = own_species_file("red_snapper")
    assert load_species("red_snapper") == species(table) and str(path) in table.told

    # It is judged by swimming, ...
    wait(table, lambda: craft.remarks is not None, 60.0)
    assert any("swims" in remark.text for remark in craft.remarks)
    # ... recorded, ...
    spots.click(table, "Record")
    wait(table, lambda: craft.making.runs or craft.swims, 20.0)
    wait(table, lambda: not craft.making.runs, RECORD_S)
    assert craft.swims, craft.making.told
    recorded = read_repertoire(repertoire_file("red_snapper"))
    assert recorded.provenance["body"]["half_widths"][1] == widened


def test_it_is_let_into_a_sea_and_swims_there(table):
    scenario, _ = load_scenario(SEA, [f"{SHOAL}.species=red_snapper"])
    world = create_world(scenario)
    kind = [one.name for one in world.species].index("Red Snapper")
    mine = world.state.fishes.species == kind
    before = world.state.fishes.position[mine].copy()
    for _ in range(10):
        step(world, Helm())
    way = np.linalg.norm(world.state.fishes.position[mine] - before, axis=1)
    assert mine.sum() == scenario.fish[1].number and np.median(way) > 0.5


def test_a_photograph_lies_behind_the_side_view(table):
    table.frame(0.1)

    def green(x, y):
        left, top = table.window.position
        across, down = at(table, "side", x, y)
        red, green, blue = table.picture()[down - top, across - left][:3].astype(int)
        return green > red + 60 and green > blue + 60

    assert green(0.95, 0.21) and not green(1.02, 0.21)  # half as high as wide
    table.craft.tracing.left += 0.05
    table.craft.tracing.flipped = True
    table.frame(0.1)
    assert green(1.02, 0.21) and not green(0.03, 0.21)


def test_points_are_added_and_taken_away(table, hands, spots):
    craft = table.craft
    before = len(species(table).surface.belly)
    (a, y0), (b, y1) = (spot(table, "side", ("surface", "belly", k)) for k in (3, 4))
    place = at(table, "side", (a + b) / 2, (y0 + y1) / 2)
    hands.do("mousemove", *place)
    hands.glide(table, 0.2)
    hands.do("click", "--repeat", 2, "--delay", 60, 1)
    hands.until(table, lambda: len(species(table).surface.belly) == before + 1)
    assert craft.editing.chosen == ("surface", "belly", 4)
    hands.do("key", "Delete")
    hands.until(table, lambda: len(species(table).surface.belly) == before)
    table.frame(0.1)
    spots.click(table, "Add point")
    hands.do("mousemove", *place)
    hands.glide(table, 0.2)
    hands.do("click", 1)
    hands.until(table, lambda: len(species(table).surface.belly) == before + 1)
    spots.click(table, "Take away")
    hands.until(table, lambda: len(species(table).surface.belly) == before)


def test_what_corresponds_is_lit_in_both_views(table, hands):
    x, y = spot(table, "side", RING)
    top = np.array(at(table, "top", *spot(table, "top", RING))) - table.window.position

    def lit():
        picture = table.picture().astype(int)
        part = picture[top[1] - 9 : top[1] + 10, top[0] - 9 : top[0] + 10]
        return int((part[..., 2] > 230).sum())

    hands.do("mousemove", *at(table, "side", 0.02, 0.28))
    hands.until(table, lambda: table.craft.editing.over is None)
    hands.glide(table, 0.3)
    table.craft.editing.chosen = None
    dark = lit()
    hands.do("mousemove", *at(table, "side", x, y))
    hands.until(table, lambda: table.craft.editing.over == RING)
    hands.glide(table, 0.3)
    assert lit() > dark + 15


def test_both_views_keep_one_scale_and_place_along_the_body(table, hands, spots):
    views = table.craft.views
    hands.do("mousemove", *at(table, "top", 0.5, 0.1))
    hands.glide(table, 0.2)
    hands.do("click", 4, "click", 4)
    hands.until(table, lambda: views.top.scale == views.side.scale > 1.1 * 300)
    assert at(table, "side", 0.3, 0)[0] == pytest.approx(at(table, "top", 0.3, 0)[0], abs=1)
    spots.click(table, "Fit")
    hands.glide(table, 0.3)
    assert at(table, "side", 0.3, 0)[0] == pytest.approx(at(table, "top", 0.3, 0)[0], abs=1)


def test_the_fish_is_turned_by_the_mouse_and_its_muscles_contract(table, hands, spots):
    craft = table.craft
    before = craft.orbit
    table.frame(0.1)
    spots.drag(table, "##fish", 0.4, 0.6)
    assert craft.orbit.turn != before.turn
    craft.swimmer.way = "fast"
    hands.glide(table, 2.0)
    assert np.abs(craft.swimmer.contraction).max() > 0.1


def test_a_number_is_typed_and_one_that_no_file_may_say_is_told(table, hands, spots):
    craft = table.craft
    craft.panels.show = "Body"
    hands.until(table, lambda: "Neutral" in spots)
    hands.do("mousemove", *spots.place(table, "##body.masses.2"))
    hands.glide(table, 0.3)
    for _ in range(8):
        hands.do("click", 5)  # the wheel
        hands.glide(table, 0.2)
    weight = species(table).body.mass
    spots.click(table, "Neutral")
    hands.until(table, lambda: species(table).body.mass != weight)
    hands.do("key", "ctrl+z")
    hands.until(table, lambda: species(table).body.mass == weight)
    for _ in range(10):
        hands.do("click", 4)
        hands.glide(table, 0.2)
    label = "##body.half_heights.1"
    hands.do("mousemove", *spots.place(table, label))
    hands.glide(table, 0.2)
    hands.do("click", "--repeat", 2, "--delay", 60, 1)
    hands.glide(table, 0.5)
    hands.do("key", "ctrl+a")
    hands.glide(table, 0.2)
    hands.do("type", "--delay", 15, "1.3")
    hands.do("key", "Return")
    hands.glide(table, 1.0)
    hands.until(table, lambda: species(table).body.half_heights[1] == 1.3)
    draft = craft.editing.present
    craft.editing.do(lambda one: drafts.as_heavy(one, 1e5))
    table.frame(0.1)
    assert "masses" in table.told and craft.editing.present is draft


def test_what_is_learned_comes_into_the_draft(table, hands, spots):
    craft = table.craft
    table.frame(0.1)
    spots.click(table, "Save")
    hands.until(table, lambda: not craft.unsaved)
    craft.making.tries = MOST  # it does not end by itself
    spots.click(table, "Learn")
    wait(table, lambda: craft.making.share > 0, LEARN_S)
    spots.click(table, "New from…")  # would take the fish away that learns
    assert craft.naming is None and not table.asks
    spots.click(table, "Stop")
    wait(table, lambda: not craft.making.runs, LEARN_S)
    assert craft.making.told
    assert load_species("red_snapper") == species(table)
    # As if it had found something, while the fish was drawn on.
    path = own_species_file("red_snapper")
    found = load_species("red_snapper")
    write_controllers(path, path, structs.replace(found.swim, lag=1.21), found.turn)
    craft.editing.do(lambda draft: drafts.changed(draft, ("schooling",), False))
    craft._ended("learn", 0)
    assert species(table).swim.lag == 1.21 and not species(table).schooling
    assert craft.unsaved and load_species("red_snapper").swim == species(table).swim
    assert table.save() and not table.asks


@pytest.mark.parametrize("answer", ["Read it", "Write over it"])
def test_what_an_editor_wrote_is_not_written_over_unasked(table, hands, spots, answer):
    craft, path = table.craft, own_species_file("red_snapper")
    path.write_text(path.read_text() + "# by hand\n")
    there = path.read_bytes()
    craft.editing.do(lambda draft: drafts.changed(draft, ("name",), answer))
    assert not table.save() and path.read_bytes() == there
    hands.until(table, lambda: f"{answer}##answer" in spots)
    hands.glide(table, 0.3)
    spots.click(table, f"{answer}##answer")
    hands.until(table, lambda: not craft.unsaved)
    assert (path.read_bytes() == there) == (answer == "Read it")
    assert load_species("red_snapper") == species(table)


def test_saving_amid_the_question_for_a_new_one_keeps_the_fish(table, hands, spots):
    craft = table.craft
    editing, path = craft.editing, craft.path
    spots.clear()
    table.frame(0.1)
    spots.click(table, "New from…")
    hands.until(table, lambda: "Cancel" in spots)
    craft.naming.source = "clownfish"
    hands.until(table, lambda: craft.editing.present.key == "clownfish")
    assert not table.save() and craft.naming.copies
    hands.glide(table, 0.3)
    spots.click(table, "Cancel")
    hands.until(table, lambda: craft.naming is None)
    assert craft.editing is editing and craft.path == path


def test_a_file_elsewhere_does_not_swim_as_its_namesake(table, tmp_path, monkeypatch):
    craft = table.craft
    assert repertoire_file("fusilier").is_file()
    craft._ended("record", 0)
    assert craft.swims
    monkeypatch.setattr(craft, "path", tmp_path / "fusilier.toml")
    monkeypatch.setattr(craft, "swims", True)
    craft._ended("record", 0)
    assert not craft.swims


def test_closing_asks_once_about_unsaved_work(table, hands, spots):
    craft = table.craft
    x, y = spot(table, "side", BACK)
    drag(table, hands, at(table, "side", x, y), at(table, "side", x, y - 0.02))
    hands.until(table, lambda: craft.unsaved)
    table.window.ask_to_close()
    hands.until(table, lambda: table.asks)
    hands.glide(table, 0.4)
    assert table.open
    spots.click(table, "Go on##answer")
    hands.until(table, lambda: not table.asks)
    table.window.ask_to_close()
    hands.until(table, lambda: table.asks)
    hands.glide(table, 0.4)
    spots.click(table, "Save##answer")
    hands.until(table, lambda: not table.open)
    assert load_species("red_snapper") == species(table)


def test_a_faulty_file_is_one_line_before_a_window_opens(tmp_path):
    (tmp_path / "torn.toml").write_text("name = 3")
    with pytest.raises(UserError, match=r"torn\.toml"):
        begun(str(tmp_path / "torn.toml"))
    with pytest.raises(UserError, match="fusilier"):
        begun("fusiler")
    with pytest.raises(UserError, match=r"torn\.toml: not a picture"):
        begun("fusilier", over=tmp_path / "torn.toml")
