"""Reference points of a camera."""

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.stage.calibration.points import points_template, read_points
from subsea.stage.calibration.surface import LitSurface
from subsea.stage.theatre.screens import Flat

EYE = np.array([10.0, 20.0, 0.0])
WALL = LitSurface(
    Flat(np.array([-200.0, -80.0, 300.0]), np.array([400.0, 0, 0]), np.array([0, 160.0, 0]))
)
FOUR = "".join(
    f"[[point]]\nat_cm = [{x}, 0, 300]\npixel = [{x + 300}, 5]\n" for x in (-100, 0, 50, 100)
)


def test_points_count_from_the_eye(tmp_path):
    path = tmp_path / "points.toml"
    path.write_text(FOUR + '[[point]]\nname = "left"\ndirection_deg = [-30, 0]\npixel = [1, 2]\n')
    points = read_points(path, EYE, [WALL])
    np.testing.assert_allclose(points[0].at, [-110, -20, 300])
    np.testing.assert_allclose(points[4].at, [-300 * np.tan(np.radians(30)), 0, 300], atol=1e-9)
    assert points[0].name == "point 1" and points[4].name == "left"


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("[[point]]\npixel = [1, 2]\n", "expected one of `at_cm` and `direction_deg`"),
        ("[[point]]\ndirection_deg = [170, 0]\npixel = [1, 2]\n", "13: no screen lies in this"),
        ("[[point]]\nat_cm = [0, 0]\n", "at_cm"),
    ],
)
def test_faults_name_file_and_line(tmp_path, more, message):
    path = tmp_path / "points.toml"
    path.write_text(FOUR + more)
    with pytest.raises(UserError) as fault:
        read_points(path, EYE, [WALL])
    assert str(path) in str(fault.value) and message in str(fault.value)


def test_the_template_has_the_corners_to_fill_in(tmp_path):
    path = tmp_path / "points.toml"
    text = points_template(EYE, [WALL, WALL])
    path.write_text(text)
    with pytest.raises(UserError, match="0 points with a `pixel`, expected 4 or more"):
        read_points(path, EYE, [WALL])
    path.write_text(text.replace("# pixel = [x, y]", "pixel = [1, 2]"))
    points = read_points(path, EYE, [WALL])
    assert [point.name for point in points] == [
        "lower left", "lower right", "upper right", "upper left", "middle",
    ]  # fmt: skip
    np.testing.assert_allclose(points[0].at, [-200, -80, 300], atol=0.06)
