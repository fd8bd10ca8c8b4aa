"""Meshes of other calibration programs show what their files say, and their views are the same."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.stage.theatre.measured_mesh import (
    ViewAngles,
    angles_of,
    flipped,
    quaternion_rotation,
    turned,
    turns,
)
from subsea.stage.theatre.mesh_formats import read_mesh, read_warp
from subsea.stage.theatre.vioso import vioso_maps
from subsea.stage.theatre.warp import is_mirrored
from subsea.view.camera import axes_of
from subsea.view.rig import sources_at
from tests.support import theatre_samples as samples

POINTS = np.random.default_rng(7).uniform(0.06, 0.94, (60, 2))
FILES = {
    "single.sgc": samples.sgc(),
    "strip.sgc": samples.sgc(2, False),
    "old.sgc": samples.sgc(1),
    "digit.sgc": samples.sgc().replace(b"SGC\x02", b"SGC2"),
    "a.csv": samples.csv(),
    "a.simcad": samples.simcad(),
    "a.ol": samples.ol(),
    "a.skyskan": samples.skyskan(),
    "a.vwf": samples.vwf(),
}


def written(folder, name, data):
    path = folder / name
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("name", FILES)
def test_each_format_shows_the_same_sources(name, tmp_path):
    warp, _ = read_warp(written(tmp_path, name, FILES[name]), (160, 120))
    expected = np.column_stack(samples.bend(*POINTS.T))
    np.testing.assert_allclose(sources_at(warp, POINTS), expected, atol=2e-4)
    assert not is_mirrored(warp)


@pytest.mark.parametrize(
    ("name", "view"),
    [
        ("single.sgc", (20, 10, 0, -30, 40, -20, 25)),
        ("a.csv", (20, 10, 0, -30, 40, -20, 25)),
        ("a.ol", (20, 0, 0, -30, 40, -20, 25)),
        ("a.skyskan", (20, 10, 0, -40, 40, -25, 25)),
        ("a.simcad", None),
    ],
)
def test_the_view_of_a_mesh(name, view, tmp_path):
    written(tmp_path, "a_frustum.csv", samples.frustum())
    found = read_mesh(written(tmp_path, name, FILES[name]), (160, 120)).view
    assert (view is None) == (found is None)
    if view is not None:
        np.testing.assert_allclose(found, view, atol=1e-4)


def test_a_view_of_skyskan_without_a_height_is_as_high_as_its_projectors(tmp_path):
    data = samples.skyskan().replace(b"Vertical FOV=50\n", b"")
    view = read_mesh(written(tmp_path, "a.skyskan", data), (160, 120)).view
    ratio = np.tan(np.radians(view.up_deg)) / np.tan(np.radians(view.right_deg))
    assert ratio == pytest.approx(1200 / 2048)


@pytest.mark.parametrize("bits", [24, 32, 64, 128])
def test_a_blend_of_vioso_is_a_mask(bits, tmp_path):
    _, mask = read_warp(written(tmp_path, "a.vwf", samples.vwf(bits=bits)), (160, 120))
    assert mask.shape == (12, 16, 4)
    np.testing.assert_allclose(mask[..., 0], 0.5, atol=0.003)
    np.testing.assert_allclose(mask[..., 1:3], 1.0)
    assert not mask[..., 3].any()


def test_the_maps_of_a_set_have_names_and_the_rest_of_a_file_is_told(tmp_path):
    data = samples.vwf(maps=3)
    maps, notes = vioso_maps(data, "x")
    assert [one.name for one in maps] == ["beamer 0", "beamer 1", "beamer 2"]
    assert notes == ()
    black = data + samples.bitmap((16, 12), 24)
    black = b"vwf1" + struct.pack("<I", 7) + black[8:]
    assert vioso_maps(black, "x")[1] == ("x: 1 bitmaps for black and white levels",)
    found = read_mesh(written(tmp_path, "a.vwf", data), (16, 12))
    assert "2 more maps" in found.notes[0]


def test_a_border_of_vioso_is_cut_off():
    plain = vioso_maps(samples.vwf(), "x")[0][0].sources
    data = bytearray(samples.vwf())
    data[16 + 8] = 8
    bordered = vioso_maps(bytes(data), "x")[0][0].sources
    np.testing.assert_allclose(bordered, (plain - 0.5) * 1.02 + 0.5, atol=1e-6)


def test_brightness_of_scalable_is_a_mask(tmp_path):
    mask = read_mesh(written(tmp_path, "a.ol", samples.ol(51)), (160, 120)).mask
    np.testing.assert_allclose(mask[10:-10, 10:-10, :3], 0.2, atol=1e-6)
    assert read_mesh(written(tmp_path, "b.ol", samples.ol()), (160, 120)).mask is None


def test_nodes_without_a_source_stay_dark(tmp_path):
    """As SCISS's files for stereo have them: (0, 0) more than once."""
    data = bytearray(samples.sgc(1))
    for node in (0, 1):
        data[60 + 24 * node + 12 : 60 + 24 * node + 20] = bytes(8)
    warp, _ = read_warp(written(tmp_path, "a.sgc", bytes(data)), (160, 120))
    assert np.isnan(sources_at(warp, np.array([[0.02, 0.98]]))).all()
    assert not np.isnan(sources_at(warp, np.array([[0.5, 0.5]]))).any()


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("a.sgc", b"SGB" + samples.sgc()[3:], "not an SGC file"),
        ("a.sgc", samples.sgc()[:-4], "indices"),
        ("a.sgc", samples.sgc()[:52] + struct.pack("<2I", 4, 2**31) + samples.sgc()[60:], "nodes"),
        ("a.sgc", samples.sgc()[:-4] + struct.pack("<I", 99), "beyond the 35"),
        ("a.sgc", samples.sgc()[:8] + struct.pack("<f", np.nan) + samples.sgc()[12:], "finite"),
        ("a.csv", b"x;y;u;v;column;row\n", "no nodes"),
        ("a.csv", b"0;0;0;0;0;1e300\n", "nodes, expected 2×2"),
        ("a.csv", b"0;0;0;0;0.5;0\n", "whole numbers"),
        ("a.csv", b"0;0;zero\n", "line 1: expected the numbers x y u v column row"),
        ("a.simcad", b"<GeometryFile/>", "GeometryDefinition"),
        ("a.simcad", samples.simcad().replace(b'"1920"', b'"0"'), "range 0"),
        ("a.simcad", samples.simcad(6).replace(b"Y-Flat", b"Z-Flat"), "Y-FlatParameters"),
        ("a.ol", samples.ol().replace(b"VERTICES 35", b"VERTICES 36"), "VERTICES 36, but 35"),
        ("a.ol", samples.ol().replace(b"NATIVEXRES 1920", b""), "no area"),
        ("a.skyskan", samples.skyskan().replace(b"7 5\n", b"9999999 9999999\n"), "nodes"),
        ("a.skyskan", samples.skyskan().replace(b"Dome A", b"Dome B"), "Dome Azimuth="),
        ("a.vwf", samples.vwf()[:200], "do not fit"),
        ("a.vwf", b"vwf0" + struct.pack("<4I2i", 28, 64, 1, 0, 2, 2) + bytes(64), "in space"),
        ("a.vwf", b"vwf0" + struct.pack("<4I2i", 28, 0, 1, 0, 2**30, 2**30), "do not fit"),
        ("a.vwf", b"vwf1" + struct.pack("<3I", 2**31, 16, 0), "block 1 at byte 16"),
        ("a.xyz", b"", "ends in .obj, .pfm, .data, .sgc, .csv"),
    ],
)
def test_faulty_files_are_refused_in_a_line(name, data, words, tmp_path):
    path = written(tmp_path, name, data)
    with pytest.raises(UserError) as error:
        read_warp(path, (160, 120))
    assert words in str(error.value)
    assert str(path) in str(error.value)


HALF_TURN = st.floats(-180, 180)


@given(HALF_TURN, st.floats(-90, 90), HALF_TURN)
def test_heading_pitch_and_roll_of_a_right_handed_rotation(heading, pitch, roll):
    rotation = turns(1, -heading) @ turns(0, pitch) @ turns(2, -roll)
    expected = axes_of(*np.radians([heading, pitch, roll]))
    np.testing.assert_allclose(axes_of(*np.radians(turned(rotation))), expected, atol=2e-4)
    # Its columns are right, up and astern.
    np.testing.assert_allclose(flipped(rotation.T * [[1], [1], [-1]]), expected, atol=1e-9)


@given(st.lists(st.floats(-1, 1), min_size=4, max_size=4))
def test_quaternions_are_rotations(numbers):
    rotation = quaternion_rotation(np.array(numbers))
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(rotation) == pytest.approx(1.0)


def test_a_quaternion_about_y_turns_to_the_left():
    half = np.radians(30) / 2
    found = turned(quaternion_rotation(np.array([0, np.sin(half), 0, np.cos(half)])))
    assert found == pytest.approx((-30, 0, 0), abs=1e-6)


def test_a_view_beyond_the_range_of_a_theatre_file_names_its_key():
    view = ViewAngles(0, 0, 0, -30, 95, -20, 20)
    with pytest.raises(UserError, match="right_deg"):
        angles_of(view)
