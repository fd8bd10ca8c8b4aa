"""Records: what other programs and older versions of this one make of them."""

import lzma

import netCDF4
import numpy as np
import pytest

from subsea.base.hdf5 import NO_VARIABLE
from subsea.cli.main import main
from subsea.media.record import COORDINATES, DIMENSIONS, FIELDS, read_record
from tests.support.records import OLDEST_RECORD
from tests.support.scenes import scene

CODES = {
    "intention": "intention_names",
    "segment": "segment_names",
    "courtship": "courtship_names",
    "species": "species_names",
    "kind": "kind_names",
}


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    folder = tmp_path_factory.mktemp("netcdf")
    file = scene(folder, "name = 'Lichter über Sand'\nat_s = 0.05\nlights = true")
    out = folder / "run.h5"
    command = ["simulate", "--ticks", "3", "--scenario", str(file), "--out", str(out)]
    assert main([*command, "--set", "fish.1.number=1", "--seed", "4"]) == 0
    return out


def test_netcdf_knows_dimensions_units_and_meanings(record):
    with netCDF4.Dataset(record) as file:
        groups = [file, *file.groups.values()]
        found = {
            f"{group.path}/{name}".strip("/"): variable
            for group in groups
            for name, variable in group.variables.items()
        }
        assert found.keys() == FIELDS.keys() | COORDINATES.keys()
        for name, spec in (FIELDS | COORDINATES).items():
            variable = found[name]
            assert variable.dimensions == spec.dimensions
            assert getattr(variable, "units", "") == spec.unit
            assert variable.long_name == spec.meaning
        for name, (path, size) in DIMENSIONS.items():
            folder = file[path.rpartition("/")[0]] if "/" in path else file
            assert size in (None, len(folder.dimensions[name]))
        for name, names in CODES.items():
            variable, meanings = file["fish"][name], file.getncattr(names)
            assert list(variable.flag_values) == list(range(len(meanings)))
            assert variable.flag_values.dtype == variable.dtype
            assert variable.flag_meanings.split(" ") == [one.replace(" ", "_") for one in meanings]
        assert file.title == "A bare sea"
        assert file.direction_names == "Lichter über Sand"
        assert file.changes == "fish.1.number=1"
        assert file.seed == 4


def test_xarray_reads_every_group(record):
    import xarray

    with xarray.open_datatree(record, engine="netcdf4") as tree:
        named = {f"{node.path}/{name}".strip("/") for node in tree.subtree for name in node.ds}
        assert named == FIELDS.keys() - {"time"}
        fish = tree["fish"]
        assert fish["position"].sel(axis="z", fish=3).sizes == {"time": 3}
        assert list(fish["time"].values) == pytest.approx([0.033, 0.066, 0.099])
        assert list(fish["drive"].values) == ["hunger", "libido", "fear"]
        assert fish["alive"].dtype == bool and fish["alive"].all()
        assert list(tree["species"]["species"].values) == tree.attrs["species_names"]
        assert tree["direction"]["began"].values == pytest.approx([0.099])
        half_width = tree.attrs["sea_half_width_cm"]
        assert tree["sea"]["x"].values[[0, -1]] == pytest.approx([-half_width, half_width])
        assert tree["sea"]["heights"].interp(x=0.0, y=0.0) < -300.0
        read = read_record(record)
        assert np.array_equal(fish["position"], read.position)
        assert np.array_equal(tree["sea"]["rocks"], read.rocks)


def test_xarray_shows_time_and_origin_without_a_group(record):
    import xarray

    with xarray.open_dataset(record, engine="netcdf4") as root:
        assert list(root.coords) == ["axis", "time"]
        assert root.attrs["format"] == "subsea-record"
        assert root.attrs["program"].startswith("subsea ")
    with xarray.open_dataset(record, engine="netcdf4", group="fish") as fish:
        assert fish["velocity"].dims == ("time", "fish", "axis")
        assert fish["velocity"].attrs["units"] == "cm s-1"


def test_dimensions_without_values_are_no_variables(record):
    import h5py

    with h5py.File(record) as file:
        for name in {path for path, _ in DIMENSIONS.values()} - FIELDS.keys() - COORDINATES.keys():
            label = file[name].attrs["NAME"].decode()
            assert label == f"{NO_VARIABLE}{len(file[name]):10d}"


def test_a_record_of_the_first_release_is_read(tmp_path, capsys):
    """Its dimensions had no names, and nothing told its origin."""
    old = tmp_path / "old.h5"
    old.write_bytes(lzma.decompress(OLDEST_RECORD.read_bytes()))
    read = read_record(old)
    assert read.position.shape == (6, 4, 3)
    assert read.species_names == ["Ocellaris clownfish", "Yellowback fusilier"]
    expected = read.position + 0.2 * (read.snout - read.position)
    assert read.centre == pytest.approx(expected, abs=1e-3)  # the file has none
    assert main(["study", str(old)]) == 0
    assert capsys.readouterr().out.startswith("6 ticks (0.198 s) of 4 fishes, seed 1")
