"""Placement: picking with rays, moving and editing things, undo."""

import re

import msgspec
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from subsea.base import disk_cache
from subsea.base.errors import UserError
from subsea.geometry.solids import height_at
from subsea.habitat import stone as stone_samples
from subsea.scenario.load import load_scenario
from subsea.scenario.save import save_scenario
from subsea.scenario.schema import (
    Bounds,
    IndividualTable,
    Scenario,
    Shoal,
    Start,
    Terrain,
    TourTable,
    Water,
    Waypoint,
)
from subsea.submarine.vessel import NEUTRAL, paths_of
from subsea.ui.undo import History
from subsea.world import placement, snapshot
from subsea.world.build import check_placed, create_world
from subsea.world.checks import check_in_sea, tour_fault, with_solids
from subsea.world.placement import added, aim, grip, handles, moved, pick
from subsea.world.step import step
from tests.support.daily import examples

replace = msgspec.structs.replace


def plain():
    """A sea with one thing of every kind, far from each other."""
    scenario = Scenario(
        title="Plain",
        seed=3,
        bounds=Bounds(radius_cm=2000.0, depth_cm=600.0),
        water=Water(fog=(0.0, 0.1, 0.2), visibility_cm=1500.0, plankton=20),
        terrain=Terrain(dune_height_cm=40.0, dune_length_cm=700.0),
        submarine=Start(position_cm=(-900.0, 0.0, -300.0)),
        fish=[Shoal(species="fusilier", number=3, position_cm=(0.0, -900.0, -250.0))],
    )
    sea = create_world(scenario).state.sea
    kinds = [kind for kind in placement.KINDS if kind not in ("fish", "submarine")]
    for k, kind in enumerate(kinds):
        turn = 2.0 * np.pi * k / len(kinds)
        scenario = added(
            scenario, kind, (1200.0 * np.cos(turn), 1200.0 * np.sin(turn), -200.0), sea
        )
    return scenario


@pytest.fixture(scope="module")
def full():
    scenario = plain()
    return scenario, create_world(scenario).state.sea


def toward(eye, place):
    way = np.array(place) - eye
    return way / np.linalg.norm(way)


def before(handle, away=250.0, high=60.0):
    """An eye between a thing and the middle of the sea, and a ray to the thing."""
    row = handle.body[0]
    z = row[2] if len(row) == 7 else row[3] - 20.0
    middle = np.array([row[0], row[1], z])
    out = np.array([*middle[:2], 0.0]) / np.hypot(*middle[:2])
    eye = middle - away * out + (0.0, 0.0, high)
    return eye, toward(eye, middle)


def test_a_ray_picks_the_first_thing(full):
    scenario, sea = full
    those = handles(scenario, sea)
    assert sorted(one.kind for one in those) == sorted(placement.KINDS)
    for handle in those:
        eye, way = before(handle, {"arch": 420.0, "wreck": 420.0}.get(handle.kind, 250.0))
        assert pick(those, sea, eye, way) is handle, handle.kind
        assert pick(those, sea, eye, -way + (0.0, 0.0, 1.0)) is None
        # From below the seabed is before it.
        low = eye.copy()
        low[2] = height_at(sea.heights, sea.half_width, *eye[:2]) - 50.0
        assert pick(those, sea, low, toward(low, handle.body[0, :3])) is None
        assert np.isfinite(handle.outline).all()
        near = np.abs(handle.outline[:, :, :2] - np.array(handle.place[:2])).max()
        assert 10.0 < near < 600.0


def test_the_nearer_of_two_things_in_a_line_is_picked(full):
    scenario, sea = full
    rock = next(one for one in handles(scenario, sea) if one.kind == "rock")
    eye, way = before(rock)
    between = 0.3 * eye + 0.7 * rock.body[0, :3]
    other = added(scenario, "rock", tuple(between), sea)
    those = handles(other, sea)
    assert pick(those, sea, eye, way).number == 1
    assert pick(those[::-1], sea, eye, way).number == 1


def test_a_dragged_thing_follows_the_pointer(full):
    scenario, sea = full
    for handle in handles(scenario, sea):
        eye, way = before(handle)
        way = way + (0.03, -0.02, 0.015)  # not in its middle
        way /= np.linalg.norm(way)
        held = grip(handle, eye, way)
        same = aim(held, sea, eye, way)
        assert same == pytest.approx(handle.place, abs=2.0), handle.kind
        aside = np.array([-way[1], way[0], 0.0])
        there = aim(held, sea, eye, toward(np.zeros(3), way + 0.2 * aside))
        assert np.dot(np.array(there) - handle.place, aside) > 20.0
        if handle.kind in placement.FREE:
            higher = aim(held, sea, eye, toward(np.zeros(3), way + (0.0, 0.0, 0.1)))
            assert higher[2] > handle.place[2] + 10.0
            level = aim(held, sea, eye, toward(np.zeros(3), way + (0.0, 0.0, 0.05)), level=True)
            assert level[2] == pytest.approx(handle.place[2])
        else:
            ground = height_at(sea.heights, sea.half_width, *there[:2])
            assert there[2] == pytest.approx(ground, abs=0.5)
        assert aim(held, sea, eye, np.array([0.0, 0.0, 1.0])) is None or handle.kind == "hook"


def test_moving_a_thing_changes_nothing_else(full):
    scenario, sea = full
    for handle in handles(scenario, sea):
        there = moved(scenario, handle, (123.4, -77.7, -222.2))
        again = next(one for one in handles(there, sea) if one[:2] == handle[:2])
        assert again.place[:2] == (123.0, -78.0)
        if handle.kind in placement.FREE:
            assert again.place[2] == -222.0
        for other in handles(there, sea):
            if other[:2] != handle[:2]:
                was = next(one for one in handles(scenario, sea) if one[:2] == other[:2])
                assert was.place == other.place
    sizes = [len(np.unique(one.outline)) for one in handles(scenario, sea)]
    assert min(sizes) > 10


def test_sizes_and_turns_keep_their_limits(full):
    scenario, sea = full
    for handle in handles(scenario, sea):
        for factor in (1.5, 1e-6, 1e6):
            changed = placement.resized(scenario, handle, factor)
            msgspec.json.decode(msgspec.json.encode(changed), type=Scenario)
            assert (changed != scenario) == (handle.kind in placement.SIZES)
        quarter = placement.turned(scenario, handle, 90.0)
        assert (quarter != scenario) == (handle.kind in placement.TURNS)
        # Four quarters are a full turn; a school without a heading has one then.
        for _ in range(3):
            quarter = placement.turned(quarter, handle, 90.0)
        assert quarter == scenario or handle.kind == "fish"


def test_single_fishes_keep_their_tables_when_shoals_change():
    scenario = load_scenario("peaceful")[0]
    own = [IndividualTable(fish=k, dread_cm=float(k)) for k in (2, 30, 33, 50, 58)]
    scenario = replace(scenario, individual=own)
    fewer = placement.with_shoal_size(scenario, 0, 20)
    assert [(one.fish, one.dread_cm) for one in fewer.individual] == [
        (2, 2.0), (20, 33.0), (37, 50.0), (45, 58.0),
    ]  # fmt: skip
    more = placement.with_shoal_size(scenario, 1, 28)
    assert [one.fish for one in more.individual] == [2, 30, 33, 50, 68]
    for fish, then in ((-1, -1), (2, 2), (30, -1), (50, 37)):  # which one is simulated first
        first = replace(scenario, physics=replace(scenario.physics, fish=fish))
        assert placement.with_shoal_size(first, 0, 20).physics.fish == then
    shoal = next(
        one for one in handles(scenario, create_world(scenario).state.sea) if one[:2] == ("fish", 0)
    )
    gone = placement.removed(scenario, shoal)
    assert [one.fish for one in gone.individual] == [0, 17, 25]
    assert len(gone.fish) == len(scenario.fish) - 1


def test_a_trial_near_a_tour_is_no_fault_and_both_it_and_the_world_warn(full):
    scenario, sea = full
    way = [
        Waypoint(time_s=0.0, position_cm=(-900.0, 0.0, -300.0)),
        Waypoint(time_s=30.0, position_cm=(900.0, 0.0, -300.0), ahead=True),
    ]
    scenario = replace(scenario, tour=[TourTable(name="across", waypoint=way)])
    rock = next(one for one in handles(scenario, sea) if one.kind == "rock")
    tall = replace(scenario.rock[0], size_cm=(60.0, 60.0, 450.0))
    clear = placement.with_table(scenario, "rock", 0, tall)
    trial = moved(clear, rock, (0.0, 0.0, 0.0))
    assert tour_fault(clear, *with_solids(clear, sea), stored=False) is None
    check_in_sea(trial, sea)
    check_placed(trial)
    found = str(tour_fault(trial, *with_solids(trial, sea), stored=False))
    assert re.search(r"`tour\[0\]` 'across' is .* from `rock\[0\]`", found)
    (notice,) = create_world(trial, source="bay.toml").notices
    assert notice == f"bay.toml: {found}"
    lines = paths_of(trial)
    assert lines.shape[1:] == (2, 3)
    np.testing.assert_allclose(lines[0, 0], way[0].position_cm)
    assert np.linalg.norm(lines[1:, 0] - lines[:-1, 1]) == 0.0


@pytest.mark.nightly
def test_misplaced_things_are_one_line(full):
    scenario, sea = full
    those = {one.kind: one for one in handles(scenario, sea)}
    x, y, z = those["pillar"].place
    low = (x, y, z + 100.0)
    check_placed(scenario)
    for wrong, words in (
        (moved(scenario, those["submarine"], low), ["`submarine.position_cm`", "`pillar[0]`"]),
        (moved(scenario, those["fish"], (0.0, 0.0, -599.0)), ["`fish[0].position_cm`", "seabed"]),
        (
            moved(scenario, those["rock"], (1990.0, 900.0, 0.0)),
            ["`rock[0].position_cm`", "outside"],
        ),
        (replace(scenario, fish=[replace(scenario.fish[0], number=-2)]), ["number", "at least 0"]),
        (replace(scenario, rock=scenario.rock * 190), ["rock"]),
    ):
        with pytest.raises(UserError) as caught:
            check_placed(wrong, "bay.toml")
        assert "\n" not in str(caught.value)
        assert all(word in str(caught.value) for word in ["bay.toml", *words]), caught.value
    for kind in ("submarine", "fish"):
        with pytest.raises(UserError, match="cannot be taken away"):
            placement.removed(scenario, those[kind])


ACTS = st.lists(
    st.tuples(
        st.sampled_from(["move", "size", "turn", "add", "remove"]),
        st.integers(0, 9),
        st.floats(-900.0, 900.0),
        st.floats(-900.0, 900.0),
    ),
    min_size=1,
    max_size=5,
)


def edited(scenario, sea, act):
    """The scenario after one edit of one of its things."""
    what, which, x, y = act
    those = handles(scenario, sea)
    handle = those[which % len(those)]
    match what:
        case "move":
            return moved(scenario, handle, (x, y, -200.0 + 0.1 * x))
        case "size":
            return placement.resized(scenario, handle, 1.0 + x / 1000.0)
        case "turn":
            return placement.turned(scenario, handle, x)
        case "add":
            return added(scenario, list(placement.KINDS)[which], (x, y, -300.0), sea)
    if handle.kind == "submarine" or (handle.kind == "fish" and len(scenario.fish) == 1):
        return scenario
    return placement.removed(scenario, handle)


@settings(suppress_health_check=list(HealthCheck))
@given(ACTS)
def test_undo_and_redo_restore_every_scenario(full, acts):
    scenario, sea = full
    history, all_of = History(scenario), [scenario]
    for act in acts:
        history.do(edited(history.present, sea, act))
        if history.present != all_of[-1]:
            all_of.append(history.present)
    for was in reversed(all_of[:-1]):
        assert history.may_undo
        assert history.undo() == was
    assert not history.may_undo
    assert history.undo() == scenario
    for again in all_of[1:]:
        assert history.may_redo
        assert history.redo() == again
    assert not history.may_redo
    if len(all_of) > 1:
        history.undo()
        other = replace(scenario, title="Another")
        history.do(other)
        assert (history.present, history.may_redo) == (other, False)


@pytest.mark.nightly
@settings(max_examples=examples(4), suppress_health_check=list(HealthCheck))
@given(ACTS)
def test_a_saved_and_loaded_placement_is_the_same_world(full, tmp_path, monkeypatch, acts):
    scenario, sea = full
    for act in acts:
        after = edited(scenario, sea, act)
        try:
            check_placed(after)
        except UserError:
            continue
        scenario = after
    path = tmp_path / "placed.toml"
    save_scenario(scenario, path)
    world = create_world(scenario)
    with monkeypatch.context() as patch:
        patch.setattr(
            disk_cache, "cache_folder", lambda: tmp_path / "kept"
        )  # nothing that was kept
        stone_samples._on_stone.cache_clear()
        other = create_world(load_scenario(str(path))[0])
    assert snapshot.checksum(other) == snapshot.checksum(world)
    constant = snapshot.constant(world)
    for name, array in snapshot.constant(other).items():
        np.testing.assert_array_equal(array, constant[name], err_msg=name)
    for _ in range(30):
        step(world, NEUTRAL)
        step(other, NEUTRAL)
    assert snapshot.checksum(other) == snapshot.checksum(world)


def test_schools_are_where_their_living_fishes_are():
    scenario = plain()
    world = create_world(scenario)
    fishes, number = world.state.fishes, scenario.fish[0].number
    assert number > 1 and scenario.fish[0].position_cm is not None
    fishes.position[:number] += (30.0, -40.0, 5.0)
    fishes.alive[0] = False
    (one,) = placement.schools(scenario, scenario, fishes, world.state.sea)
    expected = fishes.position[1:number].mean(axis=0)
    assert one[:2] == ("fish", 0) and one.place == pytest.approx(expected, abs=0.01)
    # One that is being moved is where it is moved to.
    trial = moved(scenario, one, (10.0, 20.0, -150.0))
    (held,) = placement.schools(scenario, trial, fishes, world.state.sea)
    assert held.place == (10.0, 20.0, -150.0)
    fishes.alive[:number] = False
    assert not placement.schools(scenario, scenario, fishes, world.state.sea)
