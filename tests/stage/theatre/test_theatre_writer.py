"""Theatres of other programs, written as files of our own, show the same."""

import json

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.stage.theatre.channels import usable_channels
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.screens import points_on
from subsea.stage.theatre.theatre_file import FOLDER
from subsea.stage.theatre.theatre_writer import write_theatre
from subsea.view.rig import sources_at
from tests.support import theatre_samples as samples

POINTS = np.random.default_rng(2).uniform(0.1, 0.9, (20, 2))


def files(folder):
    """A file of each kind."""
    folder.mkdir()
    content = samples.sgct()
    window = content["nodes"][0]["windows"][0]
    plane = {"type": "ProjectionPlane", "lowerleft": samples.xyz(-1, -1, -2),
             "upperleft": samples.xyz(-1, 1, -2), "upperright": samples.xyz(1, 1, -2)}  # fmt: skip
    third = {"size": {"x": 0.25, "y": 1.0}}
    window["viewports"] = [
        third | {"projection": {"type": "FisheyeProjection", "fov": 200.0, "tilt": 20.0}},
        third | {"projection": plane, "pos": {"x": 0.25, "y": 0.0}, "mesh": "meshes/a.csv"},
        third | {"projection": {"type": "CylindricalProjection"}, "pos": {"x": 0.5, "y": 0.0}},
        third | {"projection": {"type": "EquirectangularProjection"}, "pos": {"x": 0.75, "y": 0}},
    ]
    window["msaa"] = 4
    (folder / "meshes").mkdir()
    (folder / "meshes" / "a.csv").write_bytes(samples.csv())
    (folder / "a.json").write_text(json.dumps(content))
    (folder / "b.ndisplay").write_text(json.dumps(samples.ndisplay()))
    (folder / "c.sgc").write_bytes(samples.sgc())
    (folder / "d.vwf").write_bytes(samples.vwf(2, size=(64, 48)))
    (folder / "e.simcad").write_bytes(samples.simcad())
    return [folder / name for name in ("a.json", "b.ndisplay", "c.sgc", "d.vwf", "e.simcad")]


def test_a_written_theatre_shows_the_same(tmp_path):
    for source in files(tmp_path / "there"):
        theatre, path = load_theatre(str(source))
        out = tmp_path / "here" / f"{source.stem}.toml"
        written = write_theatre(theatre, path, out)
        assert written[-1] == out and all(file.exists() for file in written)
        ours, own_path = load_theatre(str(out))
        assert ours.window == theatre.window and ours.cluster == theatre.cluster
        before, faults = usable_channels(theatre, path)
        after, more = usable_channels(ours, own_path)
        assert (faults, more) == ((), ())
        for one, other in zip(before, after, strict=True):
            assert (one.name, one.place, one.shape) == (other.name, other.place, other.shape)
            assert one.surround == other.surround and one.eye == other.eye
            if one.screen is not None:
                seen = (points_on(screen, POINTS) for screen in (one.screen, other.screen))
                np.testing.assert_allclose(*seen, atol=1e-3)
            if one.warp is not None:
                shown = (sources_at(warp, POINTS) for warp in (one.warp, other.warp))
                np.testing.assert_allclose(*shown, atol=1e-4)
            if one.mask is not None:
                np.testing.assert_allclose(one.mask, other.mask, atol=0.003)
        text = out.read_text()
        for line in theatre.left_out:
            assert f"# Left out: {line}" in text


def test_maps_of_vioso_are_written_with_their_blends(tmp_path):
    source = files(tmp_path / "there")[3]
    theatre, path = load_theatre(str(source))
    written = write_theatre(theatre, path, tmp_path / "beamers.toml")
    assert [file.name for file in written] == [
        "beamers-beamer-0.obj", "beamers-beamer-1.obj", "beamers-beamer-0.png",
        "beamers-beamer-1.png", "beamers.toml",
    ]  # fmt: skip
    assert 'mask = "beamers-beamer-1.png"' in written[-1].read_text()


def test_existing_files_are_kept_unless_forced(tmp_path):
    source = files(tmp_path / "there")[0]
    theatre, path = load_theatre(str(source))
    out = tmp_path / "a.toml"
    out.write_text("mine")
    with pytest.raises(UserError, match="--force"):
        write_theatre(theatre, path, out)
    assert out.read_text() == "mine"
    write_theatre(theatre, path, out, force=True)
    assert load_theatre(str(out))[0].channel == load_theatre(str(out))[0].channel
    with pytest.raises(UserError, match=r"ends in \.toml"):
        write_theatre(theatre, path, tmp_path / "a.txt")


def test_our_own_theatres_survive_being_written(tmp_path):
    from subsea.base.system import resource_names

    for name in resource_names(FOLDER, ".toml"):
        theatre, path = load_theatre(name)
        out = tmp_path / f"{name}.toml"
        write_theatre(theatre, path, out)
        assert load_theatre(str(out))[0] == theatre


def test_names_of_other_programs_cannot_write_a_line_of_toml(tmp_path):
    content = samples.sgct(meta={"name": 'a"\n[[window]]\nname = "b\u2028'})
    content["nodes"][0]["windows"][0]["viewports"].append({"projection": None, "overlay": "\n[x]"})
    content["nodes"][0]["windows"][0]["name"] = '\n"""'
    (tmp_path / "a.json").write_text(json.dumps(content))
    theatre, path = load_theatre(str(tmp_path / "a.json"))
    write_theatre(theatre, path, tmp_path / "b.toml")
    again, _ = load_theatre(str(tmp_path / "b.toml"))
    assert len(again.window) == 1 and again.title == theatre.title
