"""The record of a simulation."""

import hashlib
import signal
import subprocess
import sys

import h5py
import numpy as np
import pytest

from subsea import __version__
from subsea.base import hdf5
from subsea.cli.main import main
from subsea.dive.start import start_world
from subsea.fish.species import load_species, repertoire_file, species_file
from subsea.lab import recording, sweep
from subsea.lab import simulate as simulation
from subsea.lab.recording import provenance_of
from subsea.lab.simulate import live_records
from subsea.media.record import COORDINATES, DIMENSIONS, FIELDS, read_record
from subsea.scenario.load import load_scenario
from subsea.world import step as ocean
from tests.support.scenes import BARE, scene

SIZES = {"time": 20, "fish": 12, "species": 7, "y": 193, "x": 193, "event": 0}


def arguments_for(out):
    return ["simulate", "--ticks", "20", "--fish", "12", "--out", str(out)]


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    out = tmp_path_factory.mktemp("record") / "one.h5"
    assert main(arguments_for(out)) == 0
    return out


def test_a_record_matches_its_format(record):
    with h5py.File(record) as file:
        found = {}
        file.visititems(
            lambda name, item: (
                found.update({name: item.shape}) if isinstance(item, h5py.Dataset) else None
            )
        )
        sizes = SIZES | {k: len(file[f"sea/{k}s"]) for k in ("pillar", "rock")}
        sizes |= {name: size for name, (_, size) in DIMENSIONS.items() if size}
        assert found == {
            name: tuple(sizes[k] for k in field.dimensions)
            for name, field in (FIELDS | COORDINATES).items()
        } | {path: (sizes[name],) for name, (path, _) in DIMENSIONS.items()}
        for name, field in FIELDS.items():
            assert file[name].dtype == field.type
            assert file[name].attrs["units"].decode() == field.unit
            assert file[name].attrs["long_name"].decode() == field.meaning
        assert file["time"][:] == pytest.approx(0.033 * np.arange(1, 21))
        assert np.linalg.norm(file["fish/orientation"], axis=2) == pytest.approx(1.0, abs=1e-3)
        for code in ("species", "kind", "intention", "segment", "courtship"):
            names = file.attrs[f"{code}_names"]
            assert file[f"fish/{code}"][()].max() < len(names)
        assert len(file.attrs["target_names"]) == len(file.attrs["intention_names"])
        keys = list(file.attrs["species_keys"].astype(str))
        names = list(file.attrs["species_names"].astype(str))
        assert len(keys) == 7
        assert names == [load_species(key).name for key in keys]
        assert file.attrs["format"] == b"subsea-record"
        assert "[bounds]" in file.attrs["scenario"]
        assert np.hypot(*file["fish/position"][-1, :, :2].T).max() < file.attrs["radius_cm"]


def test_live_records_are_the_blocks_of_a_file(record):
    whole = read_record(record)
    world = start_world("peaceful", fish=12, tell=lambda message: None)
    parts = [*live_records(world, 20, 12 * 8)]
    assert [len(part.time) for part in parts] == [8, 8, 4]
    for name, values in whole._asdict().items():
        if isinstance(values, np.ndarray) and values.shape[:1] == (20,):
            assert (np.concatenate([getattr(part, name) for part in parts]) == values).all(), name
        else:
            assert np.array_equal(getattr(parts[0], name), values), name


def test_snout_and_tail_are_a_body_apart_and_the_middle_between_them(record):
    with h5py.File(record) as file:
        snout, tail = file["fish/snout"][:], file["fish/tail"][:]
        body = np.linalg.norm(snout - tail, axis=2) / file["fish/length"][:]
        assert (body > 0.7).all() and (body < 1.01).all()
        reach = np.linalg.norm(snout - file["fish/position"][:], axis=2)
        assert reach == pytest.approx(np.tile(file["fish/snout_reach"][:], (20, 1)), rel=0.1)


def test_the_centre_of_mass_recoils_less_than_any_single_point_of_the_body(record):
    """The recoil of a beat moves origin, snout and tail; the body as a whole keeps its way."""
    with h5py.File(record) as file:
        length, tick_s = file["fish/length"][:][:, None], file.attrs["tick_s"]
        pulls = {
            name: np.linalg.norm(np.diff(file[f"fish/{name}"][:], 2, axis=0) / length, axis=2)
            for name in ("centre", "position", "snout", "tail")
        }
        least = {name: np.median(pull) / tick_s**2 for name, pull in pulls.items()}
        assert least["centre"] < 0.8 * min(least["position"], least["snout"], least["tail"])


def test_velocity_is_the_change_of_position(record):
    with h5py.File(record) as file:
        step = np.diff(file["fish/position"][:], axis=0) / file.attrs["tick_s"]
        assert file["fish/velocity"][1:] == pytest.approx(step, abs=0.5)


@pytest.mark.nightly
def test_the_same_seed_gives_the_same_bytes_in_another_process(record, tmp_path):
    again, other = tmp_path / "two.h5", tmp_path / "three.h5"
    command = [sys.executable, "-m", "subsea", *arguments_for(again)]
    subprocess.run(command, check=True, capture_output=True, timeout=280)
    assert again.read_bytes() == record.read_bytes()
    assert main([*arguments_for(other), "--seed", "99"]) == 0
    assert other.read_bytes() != again.read_bytes()


def test_ctrl_c_leaves_a_valid_file_with_the_ticks_so_far(tmp_path, monkeypatch, capsys):
    out = tmp_path / "long.h5"
    made = []

    def stepped(*given):
        made.append(ocean.step(*given))
        if len(made) == 7:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(simulation, "step", stepped)
    monkeypatch.setattr(recording, "BLOCK_FISH_TICKS", 60)  # five ticks between two writes
    command = ["simulate", "--scenario", str(BARE), "--ticks", "1000000", "--fish", "12"]
    assert main([*command, "--out", str(out)]) == 130
    told = capsys.readouterr().err.splitlines()[-1]
    assert [path.name for path in tmp_path.iterdir()] == ["long.h5"]
    with h5py.File(out) as file:
        assert told.endswith(f"subsea: interrupted: {out}: 7 ticks of 12 fishes kept")
        assert all(
            len(file[name]) == 7 for name, field in FIELDS.items() if field.dimensions[0] == "time"
        )
        assert file["time"][-1] == pytest.approx(0.033 * 7)


def test_an_interruption_between_two_datasets_trims_to_whole_ticks(tmp_path):
    class Cut(dict):
        def items(self):
            yield "a", self["a"]
            raise KeyboardInterrupt

    with (
        pytest.raises(KeyboardInterrupt),
        hdf5.recording(tmp_path / "r.h5", {"seed": 1}, {}) as append,
    ):
        append({"a": np.arange(3), "b": np.arange(3)})
        append(Cut(a=np.arange(3), b=np.arange(3)))
    with h5py.File(tmp_path / "r.h5") as file:
        assert len(file["a"]) == len(file["b"]) == 3


@pytest.mark.parametrize("fault", [KeyboardInterrupt, RuntimeError])
def test_a_record_without_a_tick_is_no_file(tmp_path, fault):
    with pytest.raises(fault), hdf5.recording(tmp_path / "r.h5", {}, {}):
        raise fault
    assert not list(tmp_path.iterdir())


def test_settings_are_part_of_the_record(tmp_path):
    out = tmp_path / "set.h5"
    own = ["--set", "fish.0.number=4", "--set", "individual.0.fish=2"]
    own += ["--set", "individual.0.male=true", "--set", "simulated = 2"]
    assert main(["simulate", "--ticks", "2", "--scenario", "preying", "--out", str(out), *own]) == 0
    with h5py.File(out) as file:
        text = file.attrs["scenario"]
        assert file["fish/male"][2]
    (tmp_path / "again.toml").write_text(text)
    changes = ["fish.0.number=4", "individual.0.fish=2", "individual.0.male=true", "simulated = 2"]
    again = load_scenario(str(tmp_path / "again.toml"))[0]
    assert again == load_scenario("preying", changes)[0] != load_scenario("preying")[0]
    assert text.startswith(load_scenario("preying")[1].read_text()[:60])


def test_an_invalid_setting_is_one_line(tmp_path, capsys):
    out = tmp_path / "set.h5"
    assert main(["simulate", "--ticks", "2", "--out", str(out), "--set", "fish.0.numbr=4"]) == 2
    fault = capsys.readouterr().err
    assert fault.count("\n") == 1
    assert "`numbr`" in fault
    assert "did you mean 'number'" in fault
    assert not out.exists()


def test_a_record_lists_the_directions_that_began(tmp_path, monkeypatch):
    monkeypatch.setattr(recording, "BLOCK_FISH_TICKS", 60)  # ten ticks between two writes
    file = scene(
        tmp_path,
        "name = 'at first'\ncaption = 'There.'",
        "at_s = 0.3\nlights = true",
        "name = 'they pass'\nevent = 'passes'\nof = { shoal = 0 }\n"
        "gate_cm = [-300.0, 0.0, -250.0]\nradius_cm = 400.0\nevery_s = 0.5\ncaption = 'They pass.'",
    )
    out = tmp_path / "out.h5"
    assert main(["simulate", "--ticks", "40", "--scenario", str(file), "--out", str(out)]) == 0
    with h5py.File(out) as record:
        assert list(record.attrs["direction_names"].astype(str)) == ["at first", "", "they pass"]
        times, numbers = record["direction/began"][:], record["direction/number"][:]
        assert list(numbers) == [0, 2, 1, 2, 2]
        assert times == pytest.approx([0.033, 0.033, 0.33, 0.528, 1.023])
        assert set(times) <= set(record["time"][:])
        cast = record["direction/cast"][:]
        assert (cast[numbers != 2] == -1).all()
        assert (cast[numbers == 2, 0] < 4).all() and (cast[numbers == 2, 0] >= 0).all()


def test_hashes_are_those_of_the_files():
    changes = ["fish.0.number=3"]
    scenario, source, _ = load_scenario(str(BARE), changes)
    found = provenance_of(scenario, source, changes, simulation.__file__)
    assert found.program == f"subsea {__version__}"
    assert found.changes == ("fish.0.number=3",)
    assert "number = 3" in found.scenario and "number = 4" not in found.scenario
    assert found.scenario_sha256 == hashlib.sha256(BARE.read_bytes()).hexdigest()
    assert found.species_keys == ("clownfish", "fusilier")
    for place, hashes in (
        (species_file, found.species_sha256),
        (repertoire_file, found.repertoire_sha256),
    ):
        contents = [place(name).read_bytes() for name in found.species_keys]
        assert hashes == tuple(hashlib.sha256(one).hexdigest() for one in contents)


def test_the_code_is_that_of_the_module():
    scenario, source, _ = load_scenario(str(BARE))
    hashes = {
        provenance_of(scenario, source, (), file).code_sha256
        for file in (simulation.__file__, sweep.__file__)
    }
    assert len(hashes) == 2
