"""The file of a scaffold: its body, and one line for each fault."""

import re

import numpy as np
import pytest

from capture.flat.scaffold import KS_FISH, read_scaffold
from subsea.base.errors import UserError

TEXT = KS_FISH.read_text(encoding="utf-8")


def read(folder, *changes):
    """Read the scaffold of KS with texts replaced."""
    text = TEXT
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    (folder / "fish.toml").write_text(text, encoding="utf-8")
    return read_scaffold(folder / "fish.toml")


def test_the_triangles_fill_the_outline_once(body):
    """In each quadrilateral one of the two crossing edges bounds triangles."""
    corners = body.rest[body.triangles]
    (ax, ay), (bx, by) = (corners[:, k].T - corners[:, 0].T for k in (1, 2))
    area = 0.5 * (ax * by - ay * bx)
    x, y = body.rest[body.hull[:, 0]].T
    assert (area > 0).all()
    assert area.sum() == pytest.approx(0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
    assert (body.hull[1:, 0] == body.hull[:-1, 1]).all() and body.hull[-1, 1] == body.hull[0, 0]
    # An edge's height is that of the fish at both ends; twelve points weigh 107 g.
    assert body.height[0] == 0.55 and body.height[5] == 1.2 + 2.0
    assert body.mass.sum() == pytest.approx(107.03)
    assert body.mirror.tolist() == [1, 0, 3, 2, 5, 4]


def test_points_edges_and_muscles_are_added_and_removed(tmp_path):
    longer = read(
        tmp_path,
        ("\n]\n",
         '\n    { name = "tip", x = -23.0, y = 0.0, mass = 0.1, half_height = 1.0 },\n]\n'),
        ('["right_5", "tail"],', '["right_5", "tail"], ["tip", "left_5"], ["tip", "right_5"],'
         ' ["tip", "tail"],'),
        ('["left_3", "left_4"], ["right_3", "right_4"],', ""),
        ('["left_4", "left_5"], ', '["left_3", "left_4"], ["right_3", "right_4"], '
         '["left_4", "left_5"], '),
    )  # fmt: skip
    assert longer.rest.shape == (13, 2) and longer.long == 23.0
    assert len(longer.units) == 28 and len(longer.mirror) == 4
    assert longer.triangles.max() == 12 and 12 in longer.hull
    removed = read(
        tmp_path, ('["left_1", "right_2"], ', ""), ('["nose", "left_1"],', ""),
        ('["nose", "right_1"], ', ""), (re.search('.*"nose", x.*\n', TEXT)[0], ""),
    )  # fmt: skip
    assert removed.rest.shape == (11, 2) and len(removed.triangles) == 9


@pytest.mark.parametrize(
    ("old", "new", "place", "message"),
    [
        ('"left_1", "left_2"', '"left_1", "lefty_2"', "muscles.edges[0]",
         "no point 'lefty_2'; did you mean 'left_2'?"),
        ('"left_1", "left_2"', '"left_1", "left_1"', "muscles.edges[0]",
         "expected two points at different places"),
        ('"left_1", "right_2"', '"left_2", "left_1"', "springs[0].edges[0]",
         "left_2 and left_1 are joined already; remove one edge"),
        ("y = -0.88", "y = -0.87", "muscles.edges[0]",
         "expected a muscle on the other side of y = 0"),
        ('["nose", "left_1"],', "", "points[0]",
         "no triangle of edges joins 'nose' to others; add edges or remove it"),
        ('["left_1", "right_2"], ["right_1", "left_2"],', "", "points[4]",
         "expected triangles of edges that fill one outline, without holes"),
        ('"right_1", x', '"left_1", x', "points[2]", "another point is named 'left_1'; rename one"),
        ("x = -2.1,", 'x = "far",', "points[1].x", "expected a number"),
        ("mass = 1.1", "mass = 0.0", "points[0].mass", "number of at least 1e-06"),
        ("drag = 2.0", "drags = 2.0", "drags", "unknown key `drags`"),
    ],
)  # fmt: skip
def test_a_fault_is_one_line_with_file_line_and_key(tmp_path, old, new, place, message):
    with pytest.raises(UserError) as fault:
        read(tmp_path, (old, new))
    said = str(fault.value)
    assert re.match(rf"{re.escape(str(tmp_path))}/fish\.toml:\d+: ", said)
    assert message in said and f"`{place}" in said


def test_all_points_on_a_line_across_are_no_fish(tmp_path):
    with pytest.raises(UserError, match=r"fish\.toml:\d+: `points`: expected a body at least 1 cm"):
        (tmp_path / "fish.toml").write_text(re.sub("x = [-.0-9]+", "x = 0.0", TEXT))
        read_scaffold(tmp_path / "fish.toml")
