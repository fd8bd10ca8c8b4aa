"""Records from a program: made, opened and measured."""

from concurrent.futures import ThreadPoolExecutor

import pytest

import subsea
from subsea.media.record import read_record
from tests.support.scenes import BARE


def test_a_record_is_that_of_the_world(tmp_path, capfd):
    path = subsea.simulate(str(BARE), tmp_path / "run.h5", seconds=0.2, seed=3, fish=4)
    record = subsea.open_record(str(path))
    world = subsea.load(str(BARE), seed=3, fish=4)
    for tick in range(6):
        world.step()
        assert (record.position[tick] == world.fishes.position).all()
    assert len(record.time) == 6
    assert subsea.measure(record) == subsea.measure(path)
    assert capfd.readouterr() == ("", "")  # a library is silent


def test_runs_may_be_recorded_in_threads(tmp_path):
    def run(seed):
        return subsea.simulate(str(BARE), tmp_path / f"{seed}.h5", seconds=0.1, seed=seed, fish=3)

    with ThreadPoolExecutor(2) as pool:
        paths = list(pool.map(run, (1, 2)))
    assert [read_record(path).seed for path in paths] == [1, 2]


def test_names_are_those_that_load_accepts():
    assert "peaceful" in subsea.scenarios()
    assert "fusilier" in subsea.species()


def test_bad_input_is_named_and_nothing_is_written(tmp_path):
    with pytest.raises(ValueError, match=r"seconds: 0.01, expected at least 0.033"):
        subsea.simulate(str(BARE), tmp_path / "run.h5", seconds=0.01)
    with pytest.raises(ValueError, match="seconds: nan"):
        subsea.simulate(str(BARE), tmp_path / "run.h5", seconds=float("nan"))
    with pytest.raises(subsea.UserError, match=r"expected a name that ends in .h5"):
        subsea.simulate(str(BARE), tmp_path / "run.nc", seconds=1)
    with pytest.raises(subsea.UserError, match="no such file"):
        subsea.measure(tmp_path / "none.h5")
    assert not list(tmp_path.iterdir())
