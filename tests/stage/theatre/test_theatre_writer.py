"""Theatres of other programs, written as files of our own, show the same."""

import json

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.base.toml_files import load_toml
from subsea.stage.theatre.channels import usable_channels
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.screens import points_on
from subsea.stage.theatre.theatre_file import FILE, FOLDER, GAMMAS, SCREENS, Theatre
from subsea.stage.theatre.theatre_writer import write_theatre
from subsea.view.rig import sources_at
from tests.support import theatre_samples as samples
from tests.support.structs import contents

POINTS = np.random.default_rng(2).uniform(0.1, 0.9, (20, 2))
GAMMA = st.floats(*GAMMAS)
FILES = "a.obj", "maps/left side.png", "../shared/b.mpcdi", "/srv/c.data", 'd "e" ä.png'
GIVEN = {
    FILE: st.sampled_from(FILES),
    "address": st.sampled_from(["192.168.10.41", "::1"]),
    "cluster": st.just({"master": "a", "address": "10.0.0.1:5560", "timeout_s": 1.5, "keys": "k"}),
    "wake": st.sampled_from(["192.168.10.255:9", "[::1]:7"]),
    "mac": st.sampled_from(["00:1a:2b:3c:4d:5e", "00-1A-2B-3C-4D-5E"]),
    "gamma": GAMMA | st.lists(GAMMA, min_size=3, max_size=3),
    "Lamp.gamma": GAMMA,
}


CONTENT = contents(Theatre, GIVEN)


@st.composite
def theatres(draw):
    """A theatre that may have every key."""
    content = draw(CONTENT)
    for kind in ("channel", "mpcdi"):
        for table in content.get(kind, []):
            screens = {key: table.pop(key) for key in SCREENS if key in table}
            if not screens and kind == "channel":
                screens = {"dome": {}}
            table |= dict([draw(st.sampled_from(sorted(screens.items())))] if screens else [])
    return msgspec.convert(content, Theatre)


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


@given(theatres())
def test_no_key_of_a_theatre_is_lost(tmp_path_factory, theatre):
    there, here = (tmp_path_factory.mktemp(name) for name in ("there", "here"))
    write_theatre(theatre, there / "foreign.sail", there / "a.toml")
    assert load_toml(there / "a.toml", Theatre) == theatre
    text = (there / "a.toml").read_text().replace("\n[", "\n# ours\n[") + "# the end\n"
    (there / "a.toml").write_text(text)
    write_theatre(theatre, there / "a.toml", there / "b.toml")
    assert (there / "b.toml").read_text() == text
    write_theatre(theatre, there / "a.toml", here / "c.toml")
    moved = load_toml(here / "c.toml", Theatre)
    assert [line for line in (here / "c.toml").read_text().splitlines() if line[:1] == "#"] == [
        line for line in text.splitlines() if line[:1] == "#"
    ]
    write_theatre(moved, here / "c.toml", there / "d.toml")
    assert load_toml(there / "d.toml", Theatre) == theatre


def test_files_are_named_from_where_the_theatre_is_written(tmp_path):
    (tmp_path / "hall").mkdir()
    source = tmp_path / "hall" / "a.toml"
    source.write_bytes(
        b'eye_cm = [0, 10, 0] # of the best seat\r\n\r\n[[window]]\r\nname = "w"\r\n'
        b"size = [640, 480]\r\n\r\n[[channel]]\r\n"
        b'name = "w"\r\nwindow = "w"\r\nwarp = "w.obj" # measured in May\r\n'
        b'mask = "/srv/w.png"\r\n[channel.dome]\r\ntilt_deg = 20 # not 30\r\n\r\n'
        b'[[projector]]\r\nname = "w"\r\naddress = "10.0.0.2"\r\npassword = "w.password"\r\n'
        b'[cluster]\r\nmaster = "main"\r\nkeys = "../keys"\r\n'
    )
    theatre, path = load_theatre(str(source))
    write_theatre(theatre, path, tmp_path / "b.toml")
    wanted = source.read_bytes()
    for old, new in (
        (b'"w.obj"', b'"hall/w.obj"'),
        (b'"w.password"', b'"hall/w.password"'),
        (b'"../keys"', b'"keys"'),
    ):
        wanted = wanted.replace(old, new)
    assert (tmp_path / "b.toml").read_bytes() == wanted


def test_names_of_other_programs_cannot_write_a_line_of_toml(tmp_path):
    content = samples.sgct(meta={"name": 'a"\n[[window]]\nname = "b\u2028'})
    content["nodes"][0]["windows"][0]["viewports"].append({"projection": None, "overlay": "\n[x]"})
    content["nodes"][0]["windows"][0]["name"] = '\n"""'
    (tmp_path / "a.json").write_text(json.dumps(content))
    theatre, path = load_theatre(str(tmp_path / "a.json"))
    write_theatre(theatre, path, tmp_path / "b.toml")
    again, _ = load_theatre(str(tmp_path / "b.toml"))
    assert len(again.window) == 1 and again.title == theatre.title
