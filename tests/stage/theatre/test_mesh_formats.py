"""Warp files of all kinds: OBJ, PFM and Paul Bourke's, and what is refused."""

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.stage.theatre.mesh_formats import parse_bourke, parse_obj, read_warp
from subsea.stage.theatre.theatre_writer import compose_obj
from subsea.stage.theatre.warp import from_grid, validated
from subsea.view.rig import sources_at

SIZE = (160, 120)
QUAD = b"""# from a tool
mtllib a.mtl
o screen
v -1 -1 0
v 1 -1 0 0.5 0.5 0.5
v 1 1 0
v -1 1 0
vt 0 0
vt 1 0 0
vt 1 1
vt 0 1
vn 0 0 1
usemtl a
s off
"""
POINTS = np.random.default_rng(5).uniform(0.02, 0.98, (50, 2))


@pytest.mark.parametrize(
    "faces", [b"f 1/1/1 2/2/1 3/3/1 4/4/1", b"f 1 2 3\nf 1 3 4", b"f -4/-4 -3/-3 -2/-2 -1/-1"]
)
def test_quads_triangles_and_backward_numbers_show_the_same(faces):
    warp = parse_obj(QUAD + faces, SIZE, "x").warp
    assert warp.vertices.shape == (4, 6)
    assert warp.triangles.shape == (2, 3)
    np.testing.assert_allclose(sources_at(warp, POINTS), POINTS, atol=1e-6)


def test_a_mesh_from_0_to_1_is_known_by_having_nothing_below():
    lines = QUAD.replace(b"v -1 ", b"v 0 ").replace(b" -1 0", b" 0 0").replace(b"v -1", b"v 0")
    warp = parse_obj(lines + b"f 1 2 3 4", SIZE, "x").warp
    np.testing.assert_allclose(sources_at(warp, POINTS), POINTS, atol=1e-6)


def test_a_point_that_shows_two_sources_is_split():
    warp = parse_obj(QUAD + b"f 1/1 2/2 3/3\nf 1/2 3/3 4/4", SIZE, "x").warp
    assert len(warp.vertices) == 5


@given(st.integers(0, 2**32 - 1))
def test_a_written_obj_shows_what_the_warp_did(seed):
    x, y = np.meshgrid(np.linspace(0.1, 0.9, 12), np.linspace(0.9, 0.1, 9))
    wobble = np.random.default_rng(seed).uniform(-0.01, 0.01, (9, 12, 2))
    warp = validated(from_grid(np.stack([x, y], axis=-1) + wobble, SIZE), "x")
    again = parse_obj(compose_obj(warp).encode(), SIZE, "x").warp
    np.testing.assert_allclose(sources_at(again, POINTS), sources_at(warp, POINTS), atol=1e-5)


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (b"", "an empty mesh"),
        (QUAD, "an empty mesh"),
        (QUAD + b"f 1 2", "line 15: a face of 2 corners"),
        (QUAD + b"f 1 2 5", "line 15: corner '5', expected one of 4 'v' lines"),
        (QUAD + b"f 1 2 0", "line 15: corner '0'"),
        (QUAD + b"f 1 2 -5", "line 15: corner '-5'"),
        (QUAD + b"f 1/1 2/2 3/7", "line 15: corner '3/7', expected one of 4 'vt' lines"),
        (QUAD + b"f a b c", "line 15: corner 'a'"),
        (b"v 1\n", "line 1: expected the numbers x y"),
        (b"v 1 one\n", "line 1: expected the numbers x y"),
        (b"vt 1\n", "line 1: expected the numbers u v"),
        (b"hello\n", "line 1: 'hello' is not a keyword of OBJ files"),
        (b"v \x00\xff\x00", "not text"),
        (QUAD + b"f 1/1 2/1 3/1", "its u and v have no area"),
        (QUAD + b"f 1/1 2/2 3/2", "its u and v have no area"),
        (QUAD + b"f 1 1 1", "1 of 1 triangles have no area"),
        (QUAD.replace(b"vt 1 1", b"vt 9 9") + b"f 1/3 2/3 3/3", "3 of 3 points have u or v out"),
    ],
)
def test_an_obj_that_is_wrong_is_refused_in_one_line(lines, said):
    with pytest.raises(UserError, match=said) as caught:
        parse_obj(lines, SIZE, "left.obj")
    assert str(caught.value).startswith("left.obj: ")


def bourke(kind=2, columns=7, rows=5, aspect=4 / 3, dim=1.0):
    """A mesh that shows all of a picture in the middle half of the projector."""
    lines = [f"{kind}", f"{columns} {rows}"]
    for v in np.linspace(0, 1, rows):
        for u in np.linspace(0, 1, columns):
            x, y = (2 * u - 1) * aspect / 2, (2 * v - 1) / 2
            lines.append(f"{x} {y} {u} {v} {dim if u > 0.5 else 1.0}")
    return ("\n".join(lines) + "\n").encode()


def test_a_mesh_in_bourkes_format_with_its_brightness():
    warp, mask, *_ = parse_bourke(bourke(dim=0.25), SIZE, "x")
    inside = (np.abs(POINTS - 0.5) < 0.249).all(axis=1)
    outside = (np.abs(POINTS - 0.5) > 0.251).any(axis=1)
    found = sources_at(warp, POINTS)
    np.testing.assert_allclose(found[inside], 2 * POINTS[inside] - 0.5, atol=1e-5)
    assert np.isnan(found[outside]).all()
    assert mask.shape == (384, 512, 4)
    np.testing.assert_allclose(mask[192, [140, 370, 20]], [[1, 1, 1, 0], [0.25] * 3 + [0], [0] * 4])
    np.testing.assert_allclose(mask[192, [127, 384], 0], [1, 0.25])  # pixels at its edge mix these


def test_the_mask_of_a_narrow_picture_is_no_larger():
    tall = parse_bourke(bourke(aspect=16 / 16384), (16, 16384), "x").mask
    assert tall.shape == (512, 1, 4)


def test_nodes_of_negative_brightness_are_not_used():
    warp = parse_bourke(bourke(dim=-1.0), SIZE, "x").warp
    assert np.nanmax(sources_at(warp, POINTS)[:, 0]) <= 0.5


def test_a_polar_mesh_closes_to_a_ring():
    turns, rings = 24, 4
    lines = ["1", f"{turns} {rings}"]
    for r in np.linspace(0, 1, rings):
        for turn in 2 * np.pi * np.arange(turns) / turns:
            x, y = r * np.cos(turn) * 0.9, r * np.sin(turn) * 0.9
            lines.append(f"{x} {y} {0.5 + x / 2} {0.5 + y / 2} 1")
    warp = parse_bourke("\n".join(lines).encode(), (100, 100), "x").warp
    near = POINTS[np.linalg.norm(POINTS - 0.5, axis=1) < 0.4]
    np.testing.assert_allclose(sources_at(warp, near), near, atol=1e-6)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "expected a line '1' or '2'"),
        (b"3\n2 2\n", "expected a line '1' or '2'"),
        (b"2\n2\n", "expected a line '1' or '2'"),
        (b"2\n1 1\n0 0 0 0 1\n", "expected a line '1' or '2'"),
        (b"2\n2 2\n0 0 0 0 1\n", "expected 2 times 2 nodes, got 1"),
        (b"2\n2 2\n" + b"0 0 0 0\n" * 4, "line 3: expected the numbers x y u v"),
        (b"2\n2 2\n" + b"0.5\n" * 4, "line 3: expected the numbers x y u v"),
        (b"2\n2 2\n" + b"0 0 0 0 1 1\n" * 4, "line 3: expected the numbers x y u v"),
        (b"2\n2 2\n" + b"0 0 0 0 -1\n" * 4, "an empty mesh"),
        (b"2\n2 2\n0 0 .5 .5 1\n1 0 .5 .5 1\n0 1 .5 .5 1\n1 1 .5 .5 1\n", "u and v have no area"),
        (b"2\n2 2\n" + b"nan 0 0 0 1\n" * 4, "4 of 4 points"),
    ],
)
def test_a_mesh_in_bourkes_format_that_is_wrong_is_refused(data, said):
    with pytest.raises(UserError, match=said) as caught:
        parse_bourke(data, SIZE, "dome.data")
    assert str(caught.value).startswith("dome.data: ")


JUNK = st.text(" \n0123456789.-e/naif", max_size=12).map(str.encode)


@given(
    st.sampled_from(["obj", "data"]),
    st.integers(0, 9999),
    st.integers(0, 20),
    st.one_of(st.binary(max_size=12), JUNK),
)
def test_mangled_text_is_a_warp_or_refused(kind, at, gone, junk):
    whole = QUAD + b"f 1/1 2/2 3/3 4/4\n" if kind == "obj" else bourke(columns=3, rows=3)
    at %= len(whole)
    data = whole[:at] + junk + whole[at + gone :]
    with suppress(UserError):
        (parse_obj if kind == "obj" else parse_bourke)(data, SIZE, "x")


def test_a_warp_file_is_known_by_its_suffix(tmp_path, making):
    x, y = np.meshgrid((np.arange(8) + 0.5) / 8, 1 - (np.arange(6) + 0.5) / 6)
    (tmp_path / "a.PFM").write_bytes(making.pfm(np.stack([x, y], axis=-1)))
    (tmp_path / "a.obj").write_bytes(QUAD + b"f 1 2 3 4")
    (tmp_path / "a.data").write_bytes(bourke())
    for name in ("a.PFM", "a.obj"):
        warp, mask = read_warp(tmp_path / name, SIZE)
        assert mask is None
        np.testing.assert_allclose(sources_at(warp, POINTS), POINTS, atol=1e-5)
    assert read_warp(tmp_path / "a.data", SIZE)[1] is not None


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("a.txt", b"", "expected a warp file that ends in .obj, .pfm, .data"),
        ("a.pfm", b"Pf\n2 2\n-1.0\n" + bytes(16), "one number a point"),
        ("a.pfm", b"PF\n1 2\n-1.0\n" + bytes(24), "1×2 points, expected 2×2 or more"),
        ("a.pfm", b"PF\n2 2\n-1.0\n" + bytes(48), "an empty mesh"),
        ("a.pfm", b"PF\n9 7\n-1.0\n" + np.full(189, "0.5", "<f4").tobytes(), "have no area"),
    ],
)
def test_a_warp_file_that_is_wrong_is_refused_by_name(tmp_path, name, data, said):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(UserError, match=said) as caught:
        read_warp(tmp_path / name, SIZE)
    assert str(caught.value).startswith(f"{tmp_path / name}: ")
