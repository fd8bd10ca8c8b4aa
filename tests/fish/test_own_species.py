"""The user's own species, beside the shipped ones."""

import shutil

import h5py
import numpy as np
import pytest

from capture.cli import main as capture_cli
from capture.recording import batch as workers
from subsea.base.errors import UserError
from subsea.base.system import ROOT, own_path, resource_path
from subsea.cli.main import main
from subsea.fish import species
from subsea.fish.species import (
    load_species,
    own_species,
    own_species_file,
    repertoire_file,
    shipped_species,
    species_file,
    species_names,
)
from subsea.scenario.load import load_scenario, own_scenarios
from subsea.world.inventory import counts
from tests.support.recording import each_once

WRASSE = resource_path("assets/species/moon_wrasse.toml")


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    """A user's folder with a valid species and a damaged one."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    own_species().mkdir(parents=True)
    text = WRASSE.read_text().replace('name = "Moon wrasse"', 'name = "Moorish jewel"', 1)
    own_species_file("jewel").write_text(text)
    own_species_file("torn").write_text("[")
    return tmp_path


@pytest.fixture
def checkout(home, monkeypatch):
    """The repertoires that are shipped, as a copy that tests may record into."""
    folder = home / "checkout"
    shutil.copytree(ROOT / "repertoires", folder)
    monkeypatch.setattr(
        species, "resource_path", lambda name: folder if name == "repertoires" else ROOT / name
    )
    return folder


def captured(capsys, *arguments):
    """Exit code, output and fault of `subsea-capture`."""
    code = capture_cli.main(arguments)
    return code, *capsys.readouterr()


def test_it_has_a_name_beside_those_shipped(home):
    assert species_names() == [*shipped_species(), "jewel", "torn"]
    assert species_file("jewel") == home / "subsea/species/jewel.toml"
    assert repertoire_file("jewel") == home / "subsea/repertoires/jewel.h5"
    assert species_file("fusilier") == ROOT / "assets/species/fusilier.toml"
    assert repertoire_file("fusilier") == ROOT / "repertoires/fusilier.h5"
    assert str(species_file("some/fish.toml")) == "some/fish.toml"
    assert str(repertoire_file("fish.h5")) == "fish.h5"
    assert load_species("jewel").name == "Moorish jewel"
    for known in (species_file, repertoire_file, load_species):
        with pytest.raises(UserError, match="did you mean 'jewel'"):
            known("jewell")


def test_a_shipped_name_is_taken(home, capsys):
    with pytest.raises(UserError, match="'fusilier' is that of a shipped species"):
        own_species_file("fusilier")
    (own_species() / "fusilier.toml").write_text("[")
    assert load_species("fusilier").name != "Moorish jewel"
    assert species_names().count("fusilier") == 1
    main(["doctor"])
    [line] = [line for line in capsys.readouterr().out.splitlines() if "/fusilier.toml" in line]
    assert line.startswith("--") and "a shipped species has this name" in line


@pytest.mark.parametrize("name", ["", "../up", "a b", ".hidden", "x/y", "jewel.toml"])
def test_a_name_is_a_word(name):
    with pytest.raises(UserError, match="letters, digits"):
        own_species_file(name)


@pytest.mark.nightly
def test_a_damaged_species_does_not_affect_others(home, checkout, capsys):
    text = resource_path("assets/scenarios/peaceful.toml").read_text()
    own_scenarios().mkdir(parents=True)
    (own_scenarios() / "mine.toml").write_text(text + '\n[[fish]]\nspecies = "torn"\nnumber = 1\n')
    assert counts(load_scenario("peaceful")[0]).fishes["torn"] == 0
    code, out, err = captured(capsys, "record", "--all")
    assert code == 0 and not err and "torn" not in out and "fusilier.h5: up to date" in out
    # Loading it reports the fault in one line.
    file = own_species_file("torn")
    code, out, err = captured(capsys, "record", "torn")
    assert code == 2 and not out and str(file) in err and err.count("\n") == 1
    run = ["simulate", "--ticks", "1", "--out", str(home / "run.h5")]
    assert main([*run, "--scenario", "mine"]) == 2
    progress, fault = capsys.readouterr().err.splitlines()[-2:]  # the first start compiles
    assert progress.endswith("reading repertoires") and str(file) in fault
    main(["doctor"])
    lines = capsys.readouterr().out.splitlines()
    [line] = [line for line in lines if "fish torn" in line]
    assert line.startswith("--") and str(file) in line
    assert any(line.startswith("ok") and "fish fusilier" in line for line in lines)


def test_from_a_copied_file_to_a_fish_in_a_sea(home, known_turns, capsys):
    shipped = {path: path.stat().st_mtime_ns for path in (ROOT / "repertoires").iterdir()}
    sea = ["simulate", "--ticks", "3", "--set", "fish.0.species=jewel", "--set", "fish.0.number=2"]
    out = home / "run.h5"
    # Before it is recorded one line says how that is done.
    assert main([*sea, "--out", str(out)]) == 2
    assert "`subsea-capture record jewel`" in capsys.readouterr().err
    code, printed, _ = captured(capsys, "record", "jewel")
    path = own_path("repertoires") / "jewel.h5"
    assert code == 0 and printed == f"{path}\n"
    assert captured(capsys, "record", "jewel") == (0, f"{path}: up to date\n", "")
    # The file is that of the wrasse, so the motion is, too. Another processor may round otherwise.
    with h5py.File(path) as mine, h5py.File(ROOT / "repertoires/moon_wrasse.h5") as theirs:
        assert mine.attrs["species"] == b"jewel"
        for name, segment in theirs["segments"].items():
            nodes = mine[f"segments/{name}/nodes"][()]
            np.testing.assert_allclose(nodes, segment["nodes"][()], rtol=0, atol=1e-8)  # cm
    # Another body or gait makes it stale, another colour does not.
    file = own_species_file("jewel")
    file.write_text(file.read_text().replace("gloss = ", "gloss = 0.1 # ", 1))
    assert captured(capsys, "record", "jewel")[1].endswith("up to date\n")
    assert {path: path.stat().st_mtime_ns for path in (ROOT / "repertoires").iterdir()} == shipped
    assert main([*sea, "--out", str(out)]) == 0
    with h5py.File(out) as record:
        assert "jewel" in record.attrs["species_keys"].astype(str)
        assert "Moorish jewel" in record.attrs["species_names"].astype(str)
        mine = record["fish/species"][:] == list(record.attrs["species_keys"]).index(b"jewel")
        assert mine.sum() == 2
    main(["doctor"])
    lines = capsys.readouterr().out.splitlines()
    [line] = [line for line in lines if "fish jewel" in line]
    assert line.startswith("ok") and "own species in" in line


@pytest.mark.nightly
def test_one_recording_of_a_shipped_and_an_own_one_and_names_for_every_command(
    home, checkout, capsys, known_turns, monkeypatch
):
    monkeypatch.setattr(workers, "record_segment", each_once({}))
    (checkout / "clownfish.h5").unlink()
    (own_species() / "devil.toml").write_text(species_file("clownfish").read_text())
    both, out = ("devil", "clownfish"), home / "elsewhere"
    code, printed, _ = captured(capsys, "record", *both, "--out", str(out))
    assert code == 0 and printed.splitlines() == [f"{out}/{name}.h5" for name in both]
    assert not repertoire_file("devil").exists()
    code, printed, _ = captured(capsys, "record", *both)
    assert printed.splitlines() == [
        f"{repertoire_file('devil')}",
        f"{checkout}/clownfish.h5",
    ]
    assert captured(capsys, "inspect", "devil")[1].startswith(f"{repertoire_file('devil')}: devil")
    assert captured(capsys, "plot", "devi", "--out", str(out))[0] == 2
    mesh = home / "box.obj"
    mesh.write_text("v 1 0 0\nv -1 0 0\nv 0 1 0\nf 1 2 3\n")
    arguments = ["mesh", "devil", str(mesh), "--fit", "--out", str(out / "frames")]
    assert captured(capsys, *arguments)[0] == 0
    assert (out / "frames/box_swim_fast_0000.obj").exists()


@pytest.mark.nightly
def test_learning_writes_into_its_own_file(home, capsys):
    """Whatever is found, only the user's file may change."""
    before = WRASSE.read_bytes()
    code, printed, err = captured(capsys, "learn", "jewel", "--only", "swim", "--budget", "2")
    assert code in (0, 1), err
    assert str(own_species_file("jewel")) in printed
    assert WRASSE.read_bytes() == before
