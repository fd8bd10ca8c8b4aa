"""Drag things in the view, undo, set numbers and save, by real input."""

import subprocess
import sys
from contextlib import closing
from threading import Event

import numpy as np
import pytest
from msgspec.structs import replace

from subsea.scenario.load import load_scenario
from subsea.scenario.schema import TourTable, Waypoint
from subsea.ui import dive as ui_dive
from subsea.ui.dive import Dive
from subsea.ui.panels import initialisation
from subsea.ui.panels.placement import REFUSED, PlacementState, apply_placement
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
def dive(display, user, coarse, tmp_path_factory):
    folder = tmp_path_factory.mktemp("lagoon")
    path = folder / "lagoon.toml"
    path.write_text(LAGOON)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_DATA_HOME", str(folder))
        with closing(Dive(dive_options(path, (720, 560), coarse, seed=None))) as running:
            running.overlay.hide_help()
            running.inspector.toggle()
            running.inspector.shown = {"Placement"}
            yield running


@pytest.fixture
def lagoon(dive, user, spots):
    """The dive, begun again as its file says."""
    assert initialisation.open_file(dive.inspector, str(dive.source))
    user.glide(dive, 0.3)
    return dive


def on_screen(dive, kind, number=0):
    """The position of a thing's middle on the display."""
    things = placement.handles(dive.scenario, dive.world.state.sea)
    thing = next(one for one in things if (one.kind, one.number) == (kind, number))
    middle = thing.outline.reshape(-1, 3).mean(axis=0)
    x, y = dive.picture.front_view.places(middle[None])[0]
    (left, top), (wide, high) = dive.window.position, dive.window.points
    return round(left + x * wide), round(top + y * high)


def drag(dive, user, begin, *ways, drop=True):
    """Drag with the left button from a place through some offsets; optionally release."""
    places = [(begin[0] + x, begin[1] + y) for x, y in ways]
    user.drag(dive, begin, *places, drop=drop)


def test_a_thing_is_dragged_and_the_dive_goes_on_around_the_submarine(lagoon, user):
    before, world = lagoon.scenario, lagoon.world
    begin = on_screen(lagoon, "pillar")
    empty = user.screen(lagoon)
    drag(lagoon, user, begin, (30, 0), (60, 0), drop=False)
    placing = lagoon.inspector.state(PlacementState)
    assert placing.chosen == ("pillar", 0)
    assert placing.trial.pillar[0].position_cm != before.pillar[0].position_cm
    assert lagoon.world is world and lagoon.scenario is before  # only the outline moves
    changed = np.abs(user.screen(lagoon) - empty).max(axis=2) > 40
    x = begin[0] + 60 - lagoon.window.position[0]
    assert changed[:, x - 40 : x + 40].sum() > 100
    submarine, tick = world.state.submarine.position.copy(), world.state.tick
    fishes = world.state.fishes.length.copy()
    user.do("mouseup", 1)
    user.until(lagoon, lambda: lagoon.world is not world)
    assert lagoon.world.state.tick >= tick > 5
    assert np.array_equal(lagoon.world.state.fishes.length, fishes)
    assert np.linalg.norm(lagoon.world.state.submarine.position - submarine) < 5.0
    x0, y0 = before.pillar[0].position_cm
    x1, y1 = lagoon.world.state.sea.pillars[0, :2]
    assert y1 < y0 - 20.0 and abs(x1 - x0) < 60.0  # to the right, and about as far away
    assert lagoon.scenario.rock == before.rock
    assert np.abs(np.subtract(on_screen(lagoon, "pillar"), begin) - (60, 0)).max() < 12


@pytest.mark.nightly
def test_a_school_is_dragged_from_where_it_swims_and_goes_on(lagoon, user):
    before, world = lagoon.scenario, lagoon.world
    # Before the eye, where the panel is not.
    front = lagoon.picture.front_view
    eye, way = front.ray(0.75, 0.4)
    fishes, number = world.state.fishes, before.fish[0].number
    middle = fishes.position[:number].mean(axis=0)
    fishes.position[:number] += (eye + 300.0 * way - middle).astype(np.float32)
    user.glide(lagoon, 0.1)
    begin = school_on_screen(lagoon)
    drag(lagoon, user, begin, (-30, 0), (-60, 0))
    user.until(lagoon, lambda: lagoon.world is not world)
    ours = lagoon.world.state
    assert ours.tick >= world.state.tick > 5  # life goes on
    assert np.array_equal(ours.fishes.alive, world.state.fishes.alive)
    assert lagoon.scenario.fish[1:] == before.fish[1:]
    place = np.array(lagoon.scenario.fish[0].position_cm)
    away = np.linalg.norm(ours.fishes.position[:number].mean(axis=0) - place)
    assert away < 40.0  # it has swum on for a moment
    assert school_on_screen(lagoon)[0] < begin[0] - 30


def school_on_screen(dive):
    """The place of the middle of the first school on the display."""
    now, state = dive.scenario, dive.world.state
    one = placement.schools(now, now, state.fishes, state.sea)[0]
    x, y = dive.picture.front_view.places(np.array([one.place]))[0]
    (left, top), (wide, high) = dive.window.position, dive.window.points
    return round(left + x * wide), round(top + y * high)


def test_a_drag_is_dropped_when_the_inspector_is_closed(lagoon, user):
    before, world = lagoon.scenario, lagoon.world
    drag(lagoon, user, on_screen(lagoon, "rock"), (25, 0), drop=False)
    assert lagoon.inspector.state(PlacementState).trial is not None
    user.do("key", "Tab")
    user.until(lagoon, lambda: not lagoon.inspector.open)
    user.do("mouseup", 1)
    user.glide(lagoon, 0.2)
    user.do("key", "Tab")
    user.until(lagoon, lambda: lagoon.inspector.open)
    user.glide(lagoon, 0.8)
    assert lagoon.inspector.state(PlacementState).trial is None
    assert lagoon.scenario is before and lagoon.world is world


@pytest.mark.nightly
def test_undo_and_redo_by_the_usual_keys(lagoon, user):
    first = lagoon.scenario
    drag(lagoon, user, on_screen(lagoon, "pillar"), (30, 0), (60, 0))
    user.until(lagoon, lambda: lagoon.scenario != first)
    moved = lagoon.scenario
    user.do("key", "ctrl+z")
    user.until(lagoon, lambda: lagoon.scenario == first)
    user.do("key", "ctrl+y")
    user.until(lagoon, lambda: lagoon.scenario == moved)


@pytest.mark.nightly
def test_the_wheel_resizes_and_with_ctrl_turns(lagoon, user):
    begin, before = on_screen(lagoon, "rock"), lagoon.scenario.rock[0]
    drag(lagoon, user, begin)
    user.do("click", 4, "click", 4)
    user.until(lagoon, lambda: lagoon.scenario.rock[0].size_cm[0] > 1.1 * before.size_cm[0])
    user.do("keydown", "ctrl", "click", 4, "click", 4, "click", 4, "keyup", "ctrl")
    user.until(lagoon, lambda: lagoon.scenario.rock[0].yaw_deg == 15.0)
    assert lagoon.scenario.rock[0].position_cm == before.position_cm
    user.do("keydown", "shift")
    user.glide(lagoon, 0.2)
    high = lagoon.scenario.rock[0].size_cm[2]
    drag(lagoon, user, on_screen(lagoon, "rock"), (0, -20), (0, -40))
    user.do("keyup", "shift")
    user.until(lagoon, lambda: lagoon.scenario.rock[0].size_cm[2] > 1.1 * high)


@pytest.mark.nightly
def test_the_sea_goes_on_until_the_changed_one_is_there(lagoon, monkeypatch):
    """Only then it is replaced, and what did not change is not made again."""
    before, ticks, tries = lagoon.world, [], []
    fishes = lagoon.picture.renderer._fishes
    pillar = lagoon.scenario.pillar[0]
    x, y = pillar.position_cm
    moved = replace(lagoon.scenario, pillar=[replace(pillar, position_cm=(x + 23.0, y + 9.0))])
    making, go_on = ui_dive.create_world, Event()

    def slow(*given, **named):
        assert go_on.wait(60.0)
        return making(*given, **named)

    def advance(elapsed_s):
        alpha = ahead(elapsed_s)
        ticks.append(before.state.tick)
        if len(ticks) == 5:
            tries.append(lagoon.change_world(lagoon.scenario))
        if len(ticks) == 30:
            go_on.set()
        return alpha

    ahead = lagoon.tick_source.advance
    monkeypatch.setattr(ui_dive, "create_world", slow)
    monkeypatch.setattr(lagoon.tick_source, "advance", advance)
    start = before.state.tick
    assert apply_placement(lagoon.inspector, moved)
    assert tries == [False]  # one change at a time
    assert len(ticks) >= 30 and ticks[-1] > start
    assert lagoon.world is not before and lagoon.world.state.tick == ticks[-1]
    assert np.array_equal(lagoon.world.state.fishes.position, before.state.fishes.position)
    assert lagoon.picture.renderer._fishes is fishes
    assert lagoon.scenario == moved
    lagoon.frame(0.1)


def test_a_tour_that_no_longer_fits_is_no_error_of_a_move(lagoon, user, capsys):
    """The move is accepted: no red, and no waypoints, which are not in the view."""
    x, y = lagoon.scenario.pillar[0].position_cm
    points = [
        Waypoint(time_s=t, position_cm=(x + ahead, y, -250.0))
        for t, ahead in ((0.0, -150.0), (60.0, 150.0))
    ]
    tour = TourTable(name="round", waypoint=points)
    capsys.readouterr()
    assert apply_placement(lagoon.inspector, replace(lagoon.scenario, tour=(tour,)))
    lagoon.frame(0.1)
    placing = lagoon.inspector.state(PlacementState)
    assert placing.misfit.startswith("The tour 'round', drawn in the sea, passes too near.")
    assert not placing.fault and not placing.message and not lagoon.world.notices
    told = capsys.readouterr()
    assert "waypoint" not in told.err + told.out + placing.misfit
    picture = user.screen(lagoon)
    red = np.abs(picture[..., :3].astype(int) - np.multiply(REFUSED, 255)).max(axis=2) < 12
    assert red.sum() < 30


def test_an_invalid_place_is_red_and_refused_in_one_line(lagoon, user, capsys):
    """The pillar would stand at the start of the school."""
    before, world = lagoon.scenario, lagoon.world
    sea, front_view, begin = world.state.sea, lagoon.picture.front_view, on_screen(lagoon, "pillar")
    pillar = next(one for one in placement.handles(before, sea) if one.kind == "pillar")

    def ray(x, y):
        (left, top), (wide, high) = lagoon.window.position, lagoon.window.points
        return front_view.ray((x - left) / wide, (y - top) / high)

    held = placement.grip(pillar, *ray(*begin))
    ways = [(x, y) for x in range(0, 280, 6) for y in range(-160, 20, 4)]
    aims = [placement.aim(held, sea, *ray(begin[0] + x, begin[1] + y)) for x, y in ways]
    school = before.fish[0].position_cm
    far = [np.inf if at is None else np.hypot(*np.subtract(at, school)[:2]) for at in aims]
    way = ways[int(np.argmin(far))]
    drag(lagoon, user, begin, (way[0] // 2, way[1] // 2), way, drop=False)
    assert "fish[0].position_cm" in lagoon.inspector.state(PlacementState).fault
    red = user.screen(lagoon)
    assert ((red[..., 0] > 200) & (red[..., 2] < 130)).sum() > 100
    capsys.readouterr()
    user.do("mouseup", 1)
    user.glide(lagoon, 0.4)
    told = capsys.readouterr().err
    assert "fish[0].position_cm" in told and told.count("\n") == 1
    assert lagoon.world is world and lagoon.scenario is before


def test_a_drag_that_begins_on_a_panel_moves_nothing_in_the_sea(lagoon, user, spots):
    before = lagoon.scenario
    bar = spots.place(lagoon, "Redo")  # nothing to redo
    target = on_screen(lagoon, "rock")
    drag(lagoon, user, bar, (target[0] - bar[0], target[1] - bar[1]), (200, 20), (0, 0))
    assert lagoon.inspector.state(PlacementState).chosen is None
    assert lagoon.scenario is before


@pytest.mark.nightly
def test_numbers_add_and_remove_and_another_process_makes_the_saved_world(
    lagoon, user, spots, tmp_path, pytestconfig
):
    lagoon.inspector.state(PlacementState).chosen = ("pillar", 0)
    user.glide(lagoon, 0.3)
    before = lagoon.scenario
    spots.drag(lagoon, "radius, cm", 0.3, 0.45)
    user.until(lagoon, lambda: lagoon.scenario.pillar[0].radius_cm > 35.0)
    spots.click(lagoon, "Remove")
    user.until(lagoon, lambda: not lagoon.scenario.pillar)
    assert len(lagoon.world.state.sea.pillars) == 0
    spots.click(lagoon, "Undo")
    user.until(lagoon, lambda: lagoon.scenario.pillar)
    spots.click(lagoon, "Undo")
    user.until(lagoon, lambda: lagoon.scenario == before)
    spots.click(lagoon, "Add")
    spots.click(lagoon, "a vent of bubbles")
    user.until(lagoon, lambda: lagoon.scenario.vent)
    assert lagoon.inspector.state(PlacementState).chosen == ("vent", 0)

    path = initialisation.save(lagoon.inspector, str(tmp_path / "placed"))
    text = path.read_text()
    assert "# The one that is moved." in text and "[[vent]]" in text
    scenario = load_scenario(str(path)).scenario
    assert scenario == replace(lagoon.scenario, physics=scenario.physics)
    if not pytestconfig.getoption("--nightly"):
        return  # tests/world/test_placement.py makes a saved world every day
    words = "from subsea.scenario.load import load_scenario; "
    words += "from subsea.world.build import create_world; "
    words += "from subsea.world import snapshot; import sys; "
    words += "print(snapshot.checksum(create_world(load_scenario(sys.argv[1])[0])))"
    told = subprocess.run(
        [sys.executable, "-c", words, str(path)], capture_output=True, text=True, check=True
    )
    assert told.stdout.strip() == snapshot.checksum(create_world(lagoon.scenario))
    assert lagoon.source == path
    user.do("key", "ctrl+z")  # undo still works after saving
    user.until(lagoon, lambda: not lagoon.scenario.vent)
