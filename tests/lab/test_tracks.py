"""Records as tracks of other programs: their layout, numbers and units; dead fishes; faults."""

import csv
import shutil

import h5py
import numpy as np
import pandas
import pytest
import xarray

import subsea
from subsea.base import system
from subsea.base.errors import UserError
from subsea.cli.main import main
from subsea.lab.convert_command import TARGETS
from subsea.lab.tracks import SUFFIXES, FlatView, write_deeplabcut
from tests.support.commands import full_disk, refusal
from tests.support.scenes import BARE


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """A record of six ticks in which fish 1 dies after three."""
    path = tmp_path_factory.mktemp("tracks") / "run.h5"
    subsea.simulate(str(BARE), path, seconds=0.2, seed=3, fish=4)
    with h5py.File(path, "r+") as file:
        file["fish/alive"][3:, 1] = False
    return path


@pytest.fixture(scope="module")
def record(path):
    return subsea.open_record(path)


def convert(path, target, out, *options):
    assert main(["convert", str(path), "--to", target, "--out", str(out), *options]) == 0
    return out


def test_targets_are_those_of_the_help():
    assert tuple(SUFFIXES) == TARGETS


def test_a_movement_dataset_has_its_dimensions_units_and_gaps(record, path, tmp_path):
    found = record.to_movement()
    assert dict(found.sizes) == {"time": 6, "space": 3, "keypoints": 3, "individuals": 4}
    assert found.position.dims == ("time", "space", "keypoints", "individuals")
    assert found.confidence.dims == ("time", "keypoints", "individuals")
    names = [f"{record.keys[kind]}_{i}" for i, kind in enumerate(record.species)]
    assert found.individuals.values.tolist() == names
    snout = found.position.sel(keypoints="snout", individuals=names[2]).values
    assert (snout == record.snout[:, 2]).all()
    dead = found.sel(individuals=names[1])
    assert dead.position.isnull().any(["space", "keypoints"]).values.tolist() == 3 * [False] + 3 * [
        True
    ]
    assert dead.confidence.sum().item() == 9.0
    assert found.attrs["ds_type"] == "poses" and found.attrs["time_unit"] == "seconds"
    assert found.attrs["fps"] == pytest.approx(1 / 0.033)
    assert found.position.attrs == {"units": "cm"}
    with xarray.open_dataset(convert(path, "movement", tmp_path / "run.nc")) as stored:
        xarray.testing.assert_identical(stored.load(), found)


@pytest.mark.parametrize("end", ["csv", "h5"])
def test_deeplabcut_tables_have_its_levels(record, path, tmp_path, end):
    out = convert(path, "deeplabcut", tmp_path / f"tracks.{end}", "--px-per-cm", "2")
    if end == "csv":
        table = pandas.read_csv(out, header=[0, 1, 2, 3], index_col=0)
    else:
        table = pandas.read_hdf(out, key="df_with_missing")
    assert [*table.columns.names] == ["scorer", "individuals", "bodyparts", "coords"]
    assert table.shape == (6, 4 * 3 * 3)
    tail = table["subsea"][record.individuals[2]]["tail"]
    assert tail["x"].values == pytest.approx(
        2 * (record.tail[:, 2, 0] + record.radius_cm), abs=1e-3
    )
    assert tail["y"].values == pytest.approx(
        2 * (record.radius_cm - record.tail[:, 2, 1]), abs=1e-3
    )
    assert (tail["likelihood"] == 1.0).all()
    dead = table["subsea"][record.individuals[1]]
    assert dead.iloc[:3].notna().all(axis=None) and dead.iloc[3:].isna().all(axis=None)


def test_a_table_of_one_fish_is_that_of_one_animal(tmp_path):
    path = subsea.simulate(str(BARE), tmp_path / "one.h5", seconds=0.1, seed=3, fish=1)
    out = convert(path, "deeplabcut", tmp_path / "tracks.csv", "--view", "side")
    rows = [*csv.reader(out.read_text().splitlines())]
    assert [row[0] for row in rows] == ["scorer", "bodyparts", "coords", "0", "1", "2"]
    record = subsea.open_record(path)
    assert float(rows[3][2]) == pytest.approx(-record.snout[0, 0, 2], abs=1e-3)


def test_a_folder_for_trajr_has_a_track_of_each_fish(record, path, tmp_path):
    out = convert(path, "trajr", tmp_path / "tracks")
    with (out / "fishes.csv").open() as file:
        fishes = [*csv.DictReader(file)]
    assert [one["file"] for one in fishes] == [f"{name}.csv" for name in record.individuals]
    assert {one["male"] for one in fishes} <= {"TRUE", "FALSE"}
    track = np.genfromtxt(out / fishes[2]["file"], delimiter=",", names=True)
    assert track.dtype.names == ("x", "y", "z", "time")
    assert track["z"] == pytest.approx(record.centre[:, 2, 2], abs=1e-4)
    assert track["time"] == pytest.approx(record.time, abs=1e-4)
    assert len((out / fishes[1]["file"]).read_text().splitlines()) == 4  # with its heading


def test_trajectories_of_idtracker_have_its_keys(record, path, tmp_path):
    made = convert(path, "idtrackerai", tmp_path / "a.npy", "--px-per-cm", "4")
    found = np.load(made, allow_pickle=True).item()
    assert found["trajectories"].shape == (6, 4, 2)
    assert found["trajectories"][:, 2, 0] == pytest.approx(
        4 * (record.centre[:, 2, 0] + record.radius_cm)
    )
    assert np.isnan(found["trajectories"][3:, 1]).all()
    assert found["id_probabilities"][:, 1, 0].tolist() == [1, 1, 1, 0, 0, 0]
    assert found["body_length"] == pytest.approx(4 * np.median(record.length))
    assert found["length_unit"] == 4.0 and found["width"] == 8 * record.radius_cm
    groups = found["identities_groups"].values()
    assert sorted(i for group in groups for i in group) == [1, 2, 3, 4]
    size = 4 * record.length
    assert (found["areas"]["mean"] < 0.5 * size**2).all() and (found["areas"]["mean"] > size).all()
    made = convert(path, "idtrackerai", tmp_path / "a.h5", "--px-per-cm", "4")
    with h5py.File(made) as file:
        assert np.array_equal(file["trajectories"][:], found["trajectories"], equal_nan=True)
        assert [*file.attrs["identities_labels"]] == record.individuals
        assert file.attrs["frames_per_second"] == found["frames_per_second"]
        assert file["setup_points/border"].shape == (36, 2)


@pytest.mark.parametrize(
    ("target", "out", "options", "words"),
    [
        ("movement", "a.csv", (), "expected a name that ends in .nc"),
        ("deeplabcut", "a.txt", (), "ends in .h5 or .csv"),
        ("trajr", "a", ("--view", "side"), "--view and --px-per-cm: trajr gets places"),
        ("deeplabcut", "notes.csv", (), "exists and is not a table of DeepLabCut"),
        ("idtrackerai", "notes.npy", (), "exists and is not a NumPy file"),
        ("movement", "run.nc", (), "is the record too"),
    ],
)
def test_bad_input_is_one_line(path, tmp_path, capsys, target, out, options, words):
    (tmp_path / "notes.csv").write_text("mine")
    (tmp_path / "notes.npy").write_text("mine")
    (tmp_path / "run.nc").write_bytes(path.read_bytes())
    words_ = ["convert", str(tmp_path / "run.nc"), "--to", target, "--out", str(tmp_path / out)]
    assert words in refusal(main, [*words_, *options], capsys)


@pytest.mark.parametrize(
    ("target", "out", "code", "reason"),
    [
        ("movement", "a.nc", 75, "No space left on device"),  # which its library does not say
        ("deeplabcut", "a.h5", 2, "File too large"),  # the limit of this test
        ("deeplabcut", "a.csv", 2, "File too large"),
    ],
)
def test_a_full_disk_is_one_line(path, tmp_path, capsys, monkeypatch, target, out, code, reason):
    full = shutil.disk_usage(tmp_path)._replace(free=100)
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: full)
    words = ["convert", str(path), "--to", target, "--out", str(tmp_path / out)]
    with full_disk(1000):
        said = refusal(main, words, capsys, code)
    assert said == f"subsea: {tmp_path / out}: cannot write ({reason})\n"
    assert not list(tmp_path.iterdir())


def test_without_the_extra_the_remedy_is_named(record, tmp_path, monkeypatch):
    monkeypatch.setitem(system.EXTRAS, "tracks", {"no_such_module": "xarray"})
    with pytest.raises(UserError, match=r"Record.to_movement needs xarray: run"):
        record.to_movement()
    with pytest.raises(UserError, match=r"without it: a name that ends in .csv\) needs xarray"):
        write_deeplabcut(record, tmp_path / "a.h5", FlatView())
    assert not list(tmp_path.iterdir())
