"""Numbers entered in the panel, restart of the dive, and files, by real input."""

from contextlib import closing

import numpy as np
import pytest
from msgspec.structs import replace

from subsea.base.errors import UserError
from subsea.base.system import resource_path
from subsea.scenario import storage
from subsea.scenario.load import load_scenario, scenario_names
from subsea.scenario.schema import IndividualTable, Shoal
from subsea.ui.dive import Dive
from subsea.ui.gui import TEXT_PT
from subsea.ui.inspector import LEAST_LETTERS
from subsea.ui.panels.initialisation import NUMBER, InitialisationState, open_file, present
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.inventory import counts, with_counts
from tests.support.windows import dive_options

POOL = """
title = "A pool"
seed = 3

[bounds]
radius_cm = 600.0
depth_cm = 400.0

[water]  # clear
fog = [0.01, 0.1, 0.2]
visibility_cm = 900.0
plankton = 40

[terrain]
dune_height_cm = 20.0
dune_length_cm = 300.0

[submarine]
position_cm = [-350.0, 0.0, -200.0]

[[fish]]
species = "fusilier"  # the school
number = 3

[[fish]]
species = "blue_tang"
number = 1
"""


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """The folder of the visitor's own files."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_DATA_HOME", str(tmp_path_factory.mktemp("home")))
        yield


@pytest.fixture(scope="module")
def dive(display, user, own, coarse, tmp_path_factory):
    path = tmp_path_factory.mktemp("sea") / "pool.toml"
    path.write_text(POOL)
    with closing(Dive(dive_options(path, (720, 560), coarse, seed=None))) as running:
        running.inspector.toggle()
        running.inspector.shown = {"Initialisation"}
        yield running, path


@pytest.fixture
def pool(dive, user, spots):
    """The dive, begun again from a file with `POOL`."""
    running, path = dive
    path.write_text(POOL)
    assert open_file(running.inspector, str(path))
    user.glide(running, 0.3)
    return running


def test_entered_numbers_are_those_of_the_restarted_dive(pool, user, spots):
    window, world = pool.window.handle, pool.world
    spots.type(pool, "fusilier", "12")
    left, _, right, _ = spots["clownfish"]
    spots.click(
        pool, "clownfish", 0.9 * NUMBER * LEAST_LETTERS * TEXT_PT / (right - left)
    )  # one more
    spots.type(pool, "##kelp", "2")
    spots.type(pool, "pillars", "3")
    spots.type(pool, "seed", "4000000077")
    assert pool.world is world  # only on request
    spots.click(pool, "Restart")
    user.until(pool, lambda: pool.world is not world)
    names = [species.name for species in pool.world.species]
    kinds = [pool.scenario.species[k] for k in pool.world.state.fishes.species]
    assert {name: kinds.count(name) for name in kinds} == {
        "fusilier": 12, "blue_tang": 1, "clownfish": 1,
    }  # fmt: skip
    assert len(names) == 3 and len(pool.world.state.sea.pillars) == 3
    assert sum(g.clusters for g in pool.scenario.seaweed if g.kind == "kelp") == 2
    assert pool.world.state.seed == 4000000077
    user.glide(pool, 0.2)
    assert (
        pool.inspector.state(InitialisationState).counts.seed == 4000000077
    )  # showing a value does not change it
    assert pool.window.handle is window


@pytest.mark.nightly
def test_an_impossible_dive_is_refused_in_one_line(pool, user, spots, capsys):
    world = pool.world
    for name in ("fusilier", "clownfish"):
        spots.type(pool, name, "100000")
    spots.click(pool, "Restart")
    told = capsys.readouterr().err
    assert "100000" in told and told.count("\n") == 1
    assert pool.world is world
    spots.click(pool, "Revert")
    spots.click(pool, "Dice")
    spots.click(pool, "Revert")
    spots.click(pool, "Restart")
    user.until(pool, lambda: pool.world is not world)
    assert len(pool.world.state.fishes.species) == 4
    assert pool.world.state.seed == 3


def test_a_saved_scenario_makes_the_same_world(pool, user, spots, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    minds = pool.world.state.minds
    minds.male[2], minds.dread[2], minds.appetite[1] = not minds.male[2], 55.0, 37.0
    pool.world.nature = pool.world.nature._replace(keen=0.31)
    spots.type(pool, "##title", "./deep/kept")
    path = tmp_path / "deep" / "kept.toml"
    assert "deep/kept.toml" in capsys.readouterr().err
    assert pool.source == path
    assert "# the school" in path.read_text() and "# clear" in path.read_text()
    scenario = load_scenario(str(path)).scenario
    assert scenario == present(pool.inspector)
    again, minds = create_world(scenario), pool.world.state.minds
    assert np.array_equal(again.state.minds.male, minds.male)
    assert np.array_equal(again.state.minds.dread, minds.dread)
    assert np.array_equal(again.state.minds.appetite, minds.appetite)
    assert again.nature == pool.world.nature and again.state.seed == 3
    assert snapshot.checksum(again) == snapshot.checksum(create_world(present(pool.inspector)))


def test_changes_by_another_program_are_not_overwritten(pool, user, spots, capsys):
    pool.world.nature = pool.world.nature._replace(keen=0.31)
    spots.click(pool, "Save")
    path, ours = pool.source, pool.source.read_text()
    theirs = ours.replace("keen = 0.31", "keen = 0.4")
    path.write_text(theirs)
    user.glide(pool, 0.1)
    spots.click(pool, "Save")
    assert "was changed by another program" in capsys.readouterr().err
    assert path.read_text() == theirs != ours
    path.write_text(ours)
    pool.world.nature = pool.world.nature._replace(keen=0.32)
    spots.click(pool, "Save")
    spots.click(pool, "Save")  # the saved file is known
    assert "was changed" not in capsys.readouterr().err
    assert path.read_text() == ours.replace("keen = 0.31", "keen = 0.32")


def test_a_failed_save_loses_nothing(pool, spots, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folder, source = tmp_path / "closed", pool.source
    folder.write_text("a file")
    spots.type(pool, "##title", "./closed/kept")
    told = capsys.readouterr().err
    assert "closed" in told and told.count("\n") == 1
    assert pool.source == source and folder.read_text() == "a file"


def test_a_broken_file_is_one_line_and_the_dive_goes_on(pool, spots, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    world, broken = pool.world, tmp_path / "broken.toml"
    broken.write_text(POOL.replace("number = 3", "number = -3"))
    spots.type(pool, "##wanted", "broken.toml")
    told = capsys.readouterr().err
    assert "fish[0].number" in told and told.count("\n") == 1
    assert pool.world is world
    pool.frame(0.1)


@pytest.mark.nightly
def test_a_shipped_scenario_is_opened_and_saved_as_ones_own(pool, user, spots, capsys):
    shipped = resource_path("assets/scenarios/schooling.toml")
    before, world = shipped.read_bytes(), pool.world
    spots.type(pool, "##wanted", "schooling")
    user.until(pool, lambda: pool.world is not world)
    assert pool.source == shipped
    spots.click(pool, "Save")
    assert pool.source.name == "my-schooling.toml" and pool.source.exists()
    assert str(pool.source) in capsys.readouterr().err
    assert shipped.read_bytes() == before
    assert "my-schooling" in scenario_names()
    scenario, path, _ = load_scenario("my-schooling")
    assert path == pool.source and scenario == present(pool.inspector)
    spots.type(pool, "##title", "schooling")
    assert "shipped" in capsys.readouterr().err
    spots.click(pool, "Save")  # overwrites its own file
    assert pool.source == path
    assert list(path.parent.iterdir()) == [path]


def test_numbers_keep_the_proportions_of_shoals_and_individuals_their_fish():
    scenario = load_scenario("peaceful").scenario
    scenario = replace(
        scenario,
        fish=[*scenario.fish, Shoal(species="fusilier", number=11)],
        individual=[IndividualTable(fish=50, male=True), IndividualTable(fish=60, male=False)],
    )
    wanted = counts(scenario)
    assert with_counts(scenario, wanted) == scenario
    wanted.fishes["fusilier"], wanted.fishes["spotted_eagle_ray"] = 88, 2
    new = with_counts(scenario, wanted)
    assert [shoal.number for shoal in new.fish] == [66, 18, 2, 2, 2, 1, 2, 22, 2]
    assert [one.fish for one in new.individual] == [83, 93]
    wanted.fishes["fusilier"] = 0
    assert [one.fish for one in with_counts(scenario, wanted).individual] == [17]
    wanted.leaves["grass"], wanted.clusters["kelp"] = 3, 32
    groups = with_counts(scenario, wanted).seaweed
    assert {group.leaves for group in groups if group.kind == "grass"} == {3}
    before = [group.clusters for group in scenario.seaweed if group.kind == "kelp"]
    kelp = [group.clusters for group in groups if group.kind == "kelp"]
    assert sum(kelp) == 32
    assert np.allclose(kelp, 32 / sum(before) * np.array(before), atol=1.0)
    assert groups[:4] == scenario.seaweed[:4]


@pytest.mark.nightly
def test_pillars_are_added_where_a_dive_can_begin_with_them():
    scenario = load_scenario("peaceful").scenario
    wanted = counts(scenario)
    wanted.pillars = 8
    new = with_counts(scenario, wanted)
    assert len(new.pillar) == 8
    create_world(new)
    wanted.pillars = 3
    assert with_counts(new, wanted).pillar == new.pillar[:3]


def test_names_that_are_taken_are_refused(own, tmp_path):
    taken = tmp_path / "taken.toml"
    taken.write_text("")
    for name in ("peaceful", str(taken), "~/"):
        with pytest.raises(UserError):
            storage.place_named(name)
    shipped = resource_path("assets/scenarios/peaceful.toml")
    with pytest.raises(UserError, match="comes with the program"):
        storage.save(load_scenario("peaceful")[0], shipped, shipped, b"")


@pytest.mark.parametrize("name", ["~nobody-of-that-name/x", "n" * 300])
def test_impossible_file_names_are_refused(own, name):
    storage.own_scenarios().mkdir(parents=True, exist_ok=True)
    with pytest.raises(UserError):
        storage.place_named(name)
    with pytest.raises(UserError):
        storage.opened(name)
