"""A sea as a library: stepped, read and restored from a program."""

import ast
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import subsea
from subsea.base.syntax import parse_source
from subsea.scenario.load import load_scenario
from subsea.submarine.vessel import NEUTRAL
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.step import step
from tests.support.scenes import BARE


@pytest.fixture
def world():
    return subsea.load(str(BARE), seed=5, fish=8)


def test_importing_the_library_loads_nothing_heavy():
    heavy = ["numpy", "numba", "h5py", "moderngl", "glfw", "gymnasium", "tqdm"]
    program = (
        f"import json, sys, subsea; print(json.dumps([m for m in {heavy} if m in sys.modules]))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True)
    assert json.loads(done.stdout) == []


def test_every_public_name_exists_and_has_a_description():
    for name in subsea.__all__:
        one = getattr(subsea, name)
        assert name == "__version__" or one.__doc__
    assert dir(subsea) == sorted(subsea.__all__)
    with pytest.raises(AttributeError, match="no attribute 'loda'"):
        _ = subsea.loda


def test_type_checkers_find_every_public_name_where_it_is_loaded_from():
    stub = parse_source(Path(subsea.__file__).with_suffix(".pyi").read_text("utf-8"))
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    found = {one.asname: node.module for node in imports for one in node.names}
    places = subsea._PLACES.items()  # a module is in its package
    assert found == {name: place.removesuffix(f".{name}") for name, place in places}


def test_it_steps_as_every_other_part_of_the_program_does(world):
    chosen = load_scenario(str(BARE)).scenario
    expected = create_world(chosen, 5, 8)
    world.step(4)
    world.step(2, subsea.Helm(surge=1.0))
    for k in range(6):
        step(expected, NEUTRAL if k < 4 else subsea.Helm(surge=1.0))
    assert world.checksum() == snapshot.checksum(expected)
    assert (world.tick, world.seed, world.time_s) == (6, 5, pytest.approx(6 * 0.033))
    assert np.linalg.norm(world.submarine.velocity) > 0.0
    assert repr(world) == f"World({str(BARE)!r}, seed=5, 8 fishes, tick 6)"


def test_arrays_show_the_present_and_cannot_be_written(world):
    position = world.fishes.position
    before = position.copy()
    world.step()
    assert (position != before).any()
    np.testing.assert_array_equal(position, world.internal.state.fishes.position)
    groups = [world.fishes, world.minds, world.sea, vars(world.submarine).values()]
    arrays = [one for group in groups for one in group if isinstance(one, np.ndarray)]
    assert len(arrays) > 80
    for array in arrays:
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    with pytest.raises(AttributeError):
        world.fishes.position = before
    with pytest.raises(AttributeError):
        world.tick = 0


def test_codes_have_names(world):
    assert set(world.names["fishes.species"]) == set(world.species)
    world.step()
    for key, names in world.names.items():
        group, name = key.split(".")
        values = getattr(getattr(world, group), name)
        assert values.shape[-1] == len(names) if name == "mental" else values.max() < len(names)


def test_a_snapshot_brings_a_world_back(world):
    world.step(3)
    kept, told = world.snapshot(), world.checksum()
    world.step(3)
    later = world.checksum()
    world.restore(kept)
    assert (world.tick, world.checksum()) == (3, told)
    world.step(3)
    assert world.checksum() == later
    other = subsea.load(str(BARE), seed=6, fish=8)
    with pytest.raises(subsea.UserError, match="seed 5, expected 6"):
        other.restore(kept)


def commands(**given):
    usual = {"fish": [0, 1], "turn": [0, 0], "rise": [0, 0], "speed": [0, 0], "feeds": [0, 0]}
    return subsea.TeleopCommands(**usual | given)


def test_several_fishes_are_steered_while_others_follow_their_minds(world):
    other = subsea.load(str(BARE), seed=5, fish=8)
    world.step(20, commands(fish=[1, 4], turn=[1, -1], speed=[1, 1]))
    other.step(20)
    moved = np.linalg.norm(world.fishes.position - other.fishes.position, axis=1)
    assert moved[[1, 4]].min() > 2.0 * moved[[0, 2, 3, 5, 6, 7]].max()


@pytest.mark.parametrize(
    ("order", "fault", "words"),
    [
        (subsea.TeleopCommand(8), ValueError, "fish 8: expected one from 0 to 7"),
        (subsea.TeleopCommand(0.5), ValueError, "fish 0.5: expected one from 0 to 7"),
        (commands(fish=[0, 8]), ValueError, "fish 8: expected one from 0 to 7"),
        (commands(fish=[2, 2]), ValueError, "order: a fish is there twice"),
        (commands(turn=[0.0]), ValueError, r"turn has shape \(1,\), expected one number for each"),
        (commands(speed=[0.0, np.nan]), ValueError, "speed .*, expected numbers from -1 to 1"),
        (commands(rise=["a", "b"]), ValueError, "rise .*, expected numbers from -1 to 1"),
        (subsea.TeleopCommand(-1), ValueError, "fish -1: expected"),
        (subsea.TeleopCommand(0, speed=float("nan")), ValueError, "speed nan, expected numbers"),
        (subsea.Helm(yaw=1.5), ValueError, "yaw 1.5, expected numbers from -1 to 1"),
        (subsea.Helm(yaw=[0.0]), ValueError, r"yaw has shape \(1,\), expected one number"),
        ("ahead", TypeError, "order: expected a Helm, a TeleopCommand or .*, got 'ahead'"),
    ],
)
def test_a_wrong_order_is_refused_before_the_world_changes(world, order, fault, words):
    before = world.checksum()
    with pytest.raises(fault, match=words):
        world.step(1, order)
    for number in (-1, 1.5, True):
        with pytest.raises(ValueError, match=f"n: {number}, expected a whole number of ticks"):
            world.step(number)
    assert world.checksum() == before


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"seed": -1}, "seed: -1, expected a whole number from 0 to 4294967295"),
        ({"seed": 0.5}, "seed: 0.5, expected a whole number"),
        ({"fish": 100_001}, "fish: 100001, expected a whole number from 1 to 100000"),
        ({"fish": 0}, "fish: 0, expected a whole number from 1"),
    ],
)
def test_a_number_that_no_command_accepts_is_refused(given, words, tmp_path):
    with pytest.raises(ValueError, match=words):
        subsea.load(str(BARE), **given)
    with pytest.raises(ValueError, match=words):
        subsea.simulate(str(BARE), tmp_path / "run.h5", seconds=1, **given)


def test_changes_are_a_mapping_or_texts():
    keys = {"nature.keen": np.float32(0.5), "title": 'a "sea"', "water.current_cm_s": (1, 2)}
    world = subsea.load(str(BARE), fish=2, changes=keys)
    assert world.internal.scenario.title == 'a "sea"'
    assert world.internal.nature.keen == 0.5
    assert world.internal.current_cm_s == (1, 2)
    same = subsea.load(str(BARE), fish=2, changes=["nature.keen=0.5"])
    assert same.internal.nature.keen == 0.5
    with pytest.raises(subsea.UserError, match="unknown key `kee`"):
        subsea.load(str(BARE), changes={"nature.kee": 1})
    with pytest.raises(TypeError, match="expected a mapping or a list of texts"):
        subsea.load(str(BARE), changes="nature.keen=0.5")
