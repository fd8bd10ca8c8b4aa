"""Drag things in the view, undo, set numbers and save, by real input."""

import subprocess
import sys
from contextlib import closing

import numpy as np
import pytest
from msgspec.structs import replace

from subsea.scenario.load import load_scenario
from subsea.ui.dive import Dive
from subsea.ui.panels import initialisation
from subsea.ui.panels.placement import PlacementState
from subsea.world import placement, snapshot
from subsea.world.build import create_world
from tests.support.windows import dive_options

LAGOON = """
title = "A lagoon"
seed = 3

[bounds]
radius_cm = 700.0
depth_cm = 400.0

[water]
fog = [0.01, 0.1, 0.2]
visibility_cm = 1500.0
plankton = 30

[terrain]
dune_height_cm = 10.0
dune_length_cm = 300.0

[submarine]
position_cm = [-420.0, 0.0, -280.0]

[[fish]]
species = "fusilier"
number = 3
position_cm = [120.0, -330.0, -250.0]

# The one that is moved.
[[pillar]]
position_cm = [0.0, -75.0]
radius_cm = 30.0
height_cm = 220.0

[[rock]]
position_cm = [60.0, -220.0]
size_cm = [45.0, 40.0, 60.0]
"""


@pytest.fixture(scope="module")
def lagoon(display, hands, coarse, tmp_path_factory):
    folder = tmp_path_factory.mktemp("lagoon")
    path = folder / "lagoon.toml"
    path.write_text(LAGOON)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_DATA_HOME", str(folder))
        with closing(Dive(dive_options(path, (720, 560), coarse, seed=None))) as running:
            running.overlay.toggle_help()
            hands.glide(running, 0.2)
            running.inspector.toggle()
            running.inspector.shown = {"Placement"}
            hands.glide(running, 0.3)
            yield running


def on_screen(dive, kind, number=0):
    """The position of a thing's middle on the display."""
    things = placement.handles(dive.scenario, dive.world.state.sea)
    thing = next(one for one in things if (one.kind, one.number) == (kind, number))
    middle = thing.outline.reshape(-1, 3).mean(axis=0)
    x, y = dive.picture.front_view.places(middle[None])[0]
    (left, top), (wide, high) = dive.window.position, dive.window.points
    return round(left + x * wide), round(top + y * high)


def drag(dive, hands, begin, *ways, drop=True):
    """Drag with the left button from a place through some offsets; optionally release."""
    hands.do("mousemove", *begin)
    hands.glide(dive, 0.2)
    hands.do("mousedown", 1)
    hands.glide(dive, 0.2)
    for way in ways:
        hands.do("mousemove", begin[0] + way[0], begin[1] + way[1])
        hands.glide(dive, 0.2)
    if drop:
        hands.do("mouseup", 1)
        hands.glide(dive, 0.3)


def test_a_thing_is_dragged_and_the_dive_goes_on_around_the_submarine(lagoon, hands):
    before, world = lagoon.scenario, lagoon.world
    begin = on_screen(lagoon, "pillar")
    empty = hands.screen(lagoon)
    drag(lagoon, hands, begin, (30, 0), (60, 0), drop=False)
    placing = lagoon.inspector.state(PlacementState)
    assert placing.chosen == ("pillar", 0)
    assert placing.trial.pillar[0].position_cm != before.pillar[0].position_cm
    assert lagoon.world is world and lagoon.scenario is before  # only the outline moves
    changed = np.abs(hands.screen(lagoon) - empty).max(axis=2) > 40
    x = begin[0] + 60 - lagoon.window.position[0]
    assert changed[:, x - 40 : x + 40].sum() > 100
    submarine, tick = world.state.submarine.position.copy(), world.state.tick
    fishes = world.state.fishes.length.copy()
    hands.do("mouseup", 1)
    hands.until(lagoon, lambda: lagoon.world is not world)
    assert lagoon.world.state.tick >= tick > 5
    assert np.array_equal(lagoon.world.state.fishes.length, fishes)
    assert np.linalg.norm(lagoon.world.state.submarine.position - submarine) < 5.0
    x0, y0 = before.pillar[0].position_cm
    x1, y1 = lagoon.world.state.sea.pillars[0, :2]
    assert y1 < y0 - 20.0 and abs(x1 - x0) < 60.0  # to the right, and about as far away
    assert lagoon.scenario.rock == before.rock
    assert np.abs(np.subtract(on_screen(lagoon, "pillar"), begin) - (60, 0)).max() < 12


def test_what_is_held_when_the_desk_is_closed_stays_where_it_was(lagoon, hands):
    before, world = lagoon.scenario, lagoon.world
    drag(lagoon, hands, on_screen(lagoon, "rock"), (25, 0), drop=False)
    assert lagoon.inspector.state(PlacementState).trial is not None
    hands.do("key", "Tab")
    hands.until(lagoon, lambda: not lagoon.inspector.open)
    hands.do("mouseup", 1)
    hands.glide(lagoon, 0.2)
    hands.do("key", "Tab")
    hands.until(lagoon, lambda: lagoon.inspector.open)
    hands.glide(lagoon, 0.8)
    assert lagoon.inspector.state(PlacementState).trial is None
    assert lagoon.scenario is before and lagoon.world is world


def test_undo_and_redo_by_the_usual_keys(lagoon, hands):
    moved = lagoon.scenario
    hands.do("key", "ctrl+z")
    hands.until(lagoon, lambda: lagoon.scenario != moved)
    first, _ = load_scenario(str(lagoon.source))
    assert lagoon.scenario == first
    hands.do("key", "ctrl+y")
    hands.until(lagoon, lambda: lagoon.scenario == moved)


def test_the_wheel_resizes_and_with_ctrl_turns(lagoon, hands):
    begin, before = on_screen(lagoon, "rock"), lagoon.scenario.rock[0]
    drag(lagoon, hands, begin)
    hands.do("click", 4, "click", 4)
    hands.until(lagoon, lambda: lagoon.scenario.rock[0].size_cm[0] > 1.1 * before.size_cm[0])
    hands.do("keydown", "ctrl", "click", 4, "click", 4, "click", 4, "keyup", "ctrl")
    hands.until(lagoon, lambda: lagoon.scenario.rock[0].yaw_deg == 15.0)
    assert lagoon.scenario.rock[0].position_cm == before.position_cm
    hands.do("keydown", "shift")
    hands.glide(lagoon, 0.2)
    high = lagoon.scenario.rock[0].size_cm[2]
    drag(lagoon, hands, on_screen(lagoon, "rock"), (0, -20), (0, -40))
    hands.do("keyup", "shift")
    hands.until(lagoon, lambda: lagoon.scenario.rock[0].size_cm[2] > 1.1 * high)


def test_what_would_be_misplaced_is_red_and_refused_in_one_line(lagoon, hands, capsys):
    """The pillar would stand at the start of the school."""
    before, world = lagoon.scenario, lagoon.world
    sea, front_view, begin = world.state.sea, lagoon.picture.front_view, on_screen(lagoon, "pillar")
    pillar = next(one for one in placement.handles(before, sea) if one.kind == "pillar")

    def ray(x, y):
        (left, top), (wide, high) = lagoon.window.position, lagoon.window.points
        return front_view.ray((x - left) / wide, (y - top) / high)

    held = placement.grip(pillar, *ray(*begin))
    ways = [(x, y) for x in range(0, 200, 6) for y in range(-160, 20, 4)]
    aims = [placement.aim(held, sea, *ray(begin[0] + x, begin[1] + y)) for x, y in ways]
    school = before.fish[0].position_cm
    far = [np.inf if at is None else np.hypot(*np.subtract(at, school)[:2]) for at in aims]
    way = ways[int(np.argmin(far))]
    drag(lagoon, hands, begin, (way[0] // 2, way[1] // 2), way, drop=False)
    assert "fish[0].position_cm" in lagoon.inspector.state(PlacementState).fault
    red = hands.screen(lagoon)
    assert ((red[..., 0] > 200) & (red[..., 2] < 130)).sum() > 100
    capsys.readouterr()
    hands.do("mouseup", 1)
    hands.glide(lagoon, 0.4)
    told = capsys.readouterr().err
    assert "fish[0].position_cm" in told and told.count("\n") == 1
    assert lagoon.world is world and lagoon.scenario is before


def test_a_drag_that_begins_on_a_panel_moves_nothing_in_the_sea(lagoon, hands, spots):

    before = lagoon.scenario
    lagoon.inspector.state(PlacementState).chosen = None
    hands.glide(lagoon, 0.2)
    bar = spots.place(lagoon, "Redo")  # nothing to redo
    target = on_screen(lagoon, "rock")
    drag(lagoon, hands, bar, (target[0] - bar[0], target[1] - bar[1]), (200, 20), (0, 0))
    assert lagoon.inspector.state(PlacementState).chosen is None
    assert lagoon.scenario is before


def test_numbers_add_and_remove(lagoon, hands, spots):
    lagoon.inspector.state(PlacementState).chosen = ("pillar", 0)
    hands.glide(lagoon, 0.3)
    before = lagoon.scenario
    spots.drag(lagoon, "radius, cm", 0.3, 0.45)
    hands.until(lagoon, lambda: lagoon.scenario.pillar[0].radius_cm > 35.0)
    spots.click(lagoon, "Remove")
    hands.until(lagoon, lambda: not lagoon.scenario.pillar)
    assert len(lagoon.world.state.sea.pillars) == 0
    spots.click(lagoon, "Undo")
    hands.until(lagoon, lambda: lagoon.scenario.pillar)
    spots.click(lagoon, "Undo")
    hands.until(lagoon, lambda: lagoon.scenario == before)
    spots.click(lagoon, "Add")
    spots.click(lagoon, "a vent of bubbles")
    hands.until(lagoon, lambda: lagoon.scenario.vent)
    assert lagoon.inspector.state(PlacementState).chosen == ("vent", 0)


def test_what_was_placed_is_saved_and_is_the_same_world_in_another_process(lagoon, hands, tmp_path):
    path = initialisation.save(lagoon.inspector, str(tmp_path / "placed"))
    text = path.read_text()
    assert "# The one that is moved." in text and "[[vent]]" in text
    scenario, _ = load_scenario(str(path))
    assert scenario == replace(lagoon.scenario, physics=scenario.physics)
    words = "from subsea.scenario.load import load_scenario; "
    words += "from subsea.world.build import create_world; "
    words += "from subsea.world import snapshot; import sys; "
    words += "print(snapshot.checksum(create_world(load_scenario(sys.argv[1])[0])))"
    told = subprocess.run(
        [sys.executable, "-c", words, str(path)], capture_output=True, text=True, check=True
    )
    assert told.stdout.strip() == snapshot.checksum(create_world(lagoon.scenario))
    assert lagoon.source == path
    hands.do("key", "ctrl+z")  # undo still works after saving
    hands.until(lagoon, lambda: not lagoon.scenario.vent)
