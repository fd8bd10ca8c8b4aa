import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from capture.cli.main import main
from subsea.export.clips import make_clips
from subsea.export.skinning import best_shares
from subsea.fish.species import own_species_file, repertoire_file, species_file
from subsea.repertoire import read_repertoire, write_repertoire
from tests.support.commands import full_disk, refusal

FEW = ["swim_slow", "turn_left_sharp"]  # clips


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """Export FEW clips and fit joints once: how all clips and joints are made is tested elsewhere.

    Joints are in `test_gltf.py`, clips in `test_clips.py`.
    """
    monkeypatch.setattr("subsea.export.skinning.ROUNDS", 1)

    @cache
    def few(name, detail):
        model, clips = make_clips(name, detail)
        return model, [clip for clip in clips if clip.name in FEW]

    monkeypatch.setattr("subsea.export.clips.make_clips", few)


@pytest.mark.nightly
def test_each_format_prints_a_line_for_each_file(tmp_path, capsys):
    vat = ["fusilier_vat.png", "fusilier_basecolor.png", "fusilier.glb", "fusilier-remap_info.json"]
    for form, files in (
        ("vat", [f"fusilier_vat/{name}" for name in vat]),
        ("usd", ["fusilier.usdc", "fusilier_basecolor.png", "fusilier_normal.png"]),
        ("usd --skeleton", ["fusilier.usdc", "fusilier_basecolor.png", "fusilier_normal.png"]),
        ("gltf", ["fusilier.glb"]),
        ("gltf --morph", ["fusilier.glb"]),
    ):
        out = tmp_path / form
        wanted = f"export fusilier --to {form} --detail 3".split()
        assert main([*wanted, "--out", str(out)]) == 0
        told = [line.partition(": ")[0] for line in capsys.readouterr().out.splitlines()]
        assert told == [str(out / name) for name in files]
        assert {path for path in out.rglob("*") if path.is_file()} == {out / one for one in files}


@pytest.mark.nightly
def test_detail_and_root_reach_the_files(tmp_path):
    small = ["export", "fusilier", "--to", "vat", "--detail", "3"]
    assert main([*small, "--out", str(tmp_path / "a")]) == 0
    assert main([*small, "--root", "baked", "--out", str(tmp_path / "b")]) == 0
    info = [
        (tmp_path / folder / "fusilier_vat" / "fusilier-remap_info.json").read_text()
        for folder in "ab"
    ]
    assert '"root"' in info[0] and '"root"' not in info[1]
    assert main([*small, "--fps", "24", "--out", str(tmp_path / "c")]) == 0
    whole = json.loads((tmp_path / "c/fusilier_vat/fusilier-remap_info.json").read_text())
    assert whole["subsea"]["framesPerSecond"] == 24.0
    assert {track["framerate"] for track in whole["animations"].values()} == {24}
    assert list(json.loads(info[0])["animations"]) == FEW
    glb = tmp_path / "a" / "fusilier_vat" / "fusilier.glb"
    assert main([*small[:-1], "1", "--out", str(tmp_path / "c")]) == 0
    assert glb.stat().st_size < (tmp_path / "c" / "fusilier_vat" / "fusilier.glb").stat().st_size


def test_wrong_commands_are_errors_of_one_line(capsys):
    for arguments, expected in (
        (["fusiler", "--to", "usd"], "did you mean 'fusilier'?"),
        (["", "--to", "gltf"], "unknown species ''"),
        (["assets/species/fusilier.toml", "--to", "gltf"], "expected the name of a species"),
        (["my_fish.toml", "--to", "vat"], "my_fish.toml: expected the name of a species"),
        (["fusilier"], "--to"),
        (["fusilier", "--to", "fbx"], "'fbx'"),
        (["fusilier", "--to", "vat", "--detail", "4"], "whole number from 0 to 3"),
        (["fusilier", "--to", "vat", "--root", "fixed"], "'fixed'"),
        (["fusilier", "--to", "usd", "--morph"], "--morph is for --to gltf"),
        (["fusilier", "--to", "gltf", "--skeleton"], "--skeleton is for --to usd, not gltf"),
        (["fusilier", "--to", "usd", "--levels"], "--levels is for --to gltf, without --morph"),
        (["fusilier", "--to", "gltf", "--levels", "--detail", "3"], "--detail 3 is the coarsest"),
        (["fusilier", "--to", "gltf", "--out", "/proc/none"], "/proc/none"),
        (["fusilier", "--to", "vat", "--out", "/proc/none"], "/proc/none"),
        (["fusilier", "--to", "usd", "--out", "/proc/none"], "/proc/none"),
    ):
        assert expected in refusal(main, ["export", *arguments], capsys)


def test_an_own_species_is_exported_by_name(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    mine, shipped = own_species_file("my-fish"), species_file("fusilier")
    mine.parent.mkdir(parents=True)
    mine.write_text(shipped.read_text(encoding="utf-8"), encoding="utf-8")
    arguments = ["export", "my-fish", "--to", "usd", "--detail", "3", "--out", str(tmp_path)]
    assert main(arguments) == 2
    assert "run `subsea-capture record my-fish`" in capsys.readouterr().err
    repertoire = read_repertoire(repertoire_file("fusilier"))
    write_repertoire(repertoire_file("my-fish"), replace(repertoire, species="my-fish"))
    assert main(arguments) == 0
    assert (tmp_path / "my-fish.usdc").is_file()


def test_an_interrupted_export_leaves_nothing(tmp_path, monkeypatch, capsys):
    """While joints are fitted, which takes longest."""

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("subsea.export.skinning._fit_weights", interrupt)
    new = tmp_path / "new"
    assert main(["export", "fusilier", "--to", "gltf", "--detail", "3", "--out", str(new)]) == 130
    out, err = capsys.readouterr()
    assert not out and err == "subsea-capture: interrupted\n"
    assert not list(tmp_path.iterdir())


@pytest.mark.nightly
def test_a_full_disk_leaves_nothing(tmp_path, capsys):
    """The first files fit, the last ones fail."""
    best_shares(np.eye(2), 2)  # or the limit would keep its kernel from the cache
    for form in ("vat", "usd", "gltf"):
        arguments = f"export fusilier --to {form} --detail 2 --out {tmp_path / 'new'}"
        with full_disk(200 * 1024):
            assert "File too large" in refusal(main, arguments.split(), capsys)
        assert not list(tmp_path.iterdir())
