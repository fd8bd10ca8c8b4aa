"""Records of worlds that a program moves: whole files, with the ticks of the block."""

import signal

import gymnasium
import h5py
import numpy as np
import pytest

import subsea
import subsea.environments
from subsea.lab import recording
from tests.support.scenes import BARE


@pytest.fixture
def world():
    return subsea.load(str(BARE), seed=3, fish=4)


def movers(path):
    """By whom a record says that its world was moved."""
    with h5py.File(path) as file:
        return list(file.attrs["moved_by"].astype(str))


def everybody(**given):
    still = np.zeros(4)
    usual = {"fish": np.arange(4), "turn": still, "rise": still, "speed": still, "feeds": still}
    return subsea.TeleopCommands(**usual | given)


def test_a_world_that_a_program_steps_has_the_record_of_simulate(world, tmp_path):
    with subsea.record(world, tmp_path / "mine.h5") as path:
        for n in (1, 2, 0, 3):
            world.step(n)
    world.step()  # not recorded
    theirs = subsea.simulate(str(BARE), tmp_path / "theirs.h5", seconds=0.2, seed=3, fish=4)
    assert path.read_bytes() == theirs.read_bytes()
    assert movers(path) == ["minds"]
    assert subsea.measure(path)["ticks"] == 6
    assert world.internal.observers == []


def test_a_record_tells_by_whom_the_world_was_moved(world, tmp_path):
    with subsea.record(world, tmp_path / "some.h5") as some:
        world.step(2, subsea.TeleopCommand(1, speed=0.5))
        world.step(2, subsea.Helm(surge=0.5))
    with subsea.record(world, tmp_path / "all.h5") as whole:
        world.step(2, everybody())
    assert movers(some) == ["a helm of the submarine", "minds", "teleop commands"]
    assert movers(whole) == ["teleop commands"]
    record = subsea.open_record(whole)
    assert record.time == pytest.approx(0.033 * np.arange(5, 7))
    assert {record.intention_names[code] for code in record.intention.ravel()} == {"wander"}


def test_an_environment_is_recorded_while_it_learns(tmp_path):
    env = gymnasium.make("subsea/Forage-v0", scenario=str(BARE), fish_count=4)
    env.reset(seed=1)
    with subsea.record(env.unwrapped.world, tmp_path / "episode.h5") as path:
        for _ in range(3):
            env.step([0.5, 0.0, 1.0])
    record = subsea.open_record(path)
    assert (record.position[-1] == env.unwrapped.world.fishes.position).all()
    assert len(record.time) == 9 and "teleop commands" in movers(path)
    with (
        pytest.raises(subsea.UserError, match=r"two\.h5: the world went from tick \d+ to \d+, and"),
        subsea.record(env.unwrapped.world, tmp_path / "two.h5") as path,
    ):
        env.step([0.5, 0.0, 1.0])
        env.reset(seed=2)
    assert len(subsea.open_record(path).time) == 3


@pytest.mark.parametrize("fault", [KeyboardInterrupt, ZeroDivisionError])
def test_a_fault_in_the_block_leaves_a_whole_file_or_none(world, tmp_path, monkeypatch, fault):
    monkeypatch.setattr(recording, "BLOCK_FISH_TICKS", 12)  # three ticks between two writes
    with pytest.raises(fault), subsea.record(world, tmp_path / "none.h5"):
        raise fault
    assert not list(tmp_path.iterdir())
    with pytest.raises(fault) as raised, subsea.record(world, tmp_path / "run.h5") as path:
        for _ in range(5):
            world.step()
        raise fault
    assert raised.value.__notes__ == [f"{path}: 5 ticks of 4 fishes kept"]
    assert [one.name for one in tmp_path.iterdir()] == ["run.h5"]
    assert len(subsea.open_record(path).time) == 5


def test_ctrl_c_while_a_block_is_written_waits_for_its_end(world, tmp_path, monkeypatch):
    monkeypatch.setattr(recording, "BLOCK_FISH_TICKS", 8)  # two ticks between two writes
    table = recording._table

    def interrupted(happened):
        signal.raise_signal(signal.SIGINT)
        return table(happened)

    with pytest.raises(KeyboardInterrupt), subsea.record(world, tmp_path / "run.h5") as path:
        world.step()
        monkeypatch.setattr(recording, "_table", interrupted)
        try:
            world.step(10)
        finally:
            monkeypatch.setattr(recording, "_table", table)
    assert len(subsea.open_record(path).time) == world.tick == 2


def test_what_cannot_be_recorded_is_one_line(world, tmp_path):
    (tmp_path / "text.h5").write_text("no record")
    faults = {
        "run.nc": r"run\.nc: expected a name that ends in \.h5 or \.hdf5",
        "text.h5": r"text\.h5: exists and is not a record",
        "run.h5": r"run\.h5: the world made no tick, nothing to record",
    }
    for name, words in faults.items():
        with pytest.raises(subsea.UserError, match=words), subsea.record(world, tmp_path / name):
            pass
    with (
        pytest.raises(TypeError, match=r"expected a world of subsea\.load, got 3"),
        subsea.record(3, tmp_path / "run.h5"),
    ):
        pass
    assert [one.name for one in tmp_path.iterdir()] == ["text.h5"]
