"""Points of a sweep, drawn or listed."""

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.lab.designs import latin_hypercube, read_points, read_ranges, sobol

RANGES = {"nature.timidity": (0.5, 2.0), "fish.0.number": (1, 16)}


def shares(points):
    """Drawn numbers as shares of their ranges (points,)."""
    return np.array([(point["nature.timidity"] - 0.5) / 1.5 for point in points])


def test_each_stratum_of_a_latin_hypercube_has_one_point():
    points = latin_hypercube(RANGES, 16, seed=3)
    assert sorted((shares(points) * 16).astype(int)) == [*range(16)]
    assert sorted(point["fish.0.number"] for point in points) == [*range(1, 17)]
    assert points == latin_hypercube(RANGES, 16, seed=3)
    assert points != latin_hypercube(RANGES, 16, seed=4)
    assert all(type(point["fish.0.number"]) is int for point in points)


def test_a_sobol_sequence_fills_the_plane_evenly_and_goes_on():
    points = sobol(RANGES, 64)
    cells = (shares(points) * 8).astype(int), [(p["fish.0.number"] - 1) // 2 for p in points]
    assert len(set(zip(*cells, strict=True))) == 64  # one in each of 8 × 8 cells
    assert sobol(RANGES, 20) == points[:20]
    assert sobol(RANGES, 20, seed=1) != points[:20]


@pytest.mark.parametrize(
    ("ranges", "number", "words"),
    [
        ({}, 4, "at least one key"),
        ({"a": (2, 1)}, 4, "a: .2, 1., expected two finite numbers in order"),
        ({"a": (0.0, float("nan"))}, 4, "finite"),
        ({"a": "01"}, 4, "two finite numbers"),
        ({"a": (0, 1)}, 0, "number: 0, expected 1 to 100,000"),
    ],
)
def test_faulty_ranges_are_named(ranges, number, words):
    for design in (latin_hypercube, sobol):
        with pytest.raises(ValueError, match=words):
            design(ranges, number)


def test_ranges_of_the_command_line():
    found = read_ranges(["nature.timidity=0.5:2", " fish.0.number = 1:16"])
    assert found == RANGES
    for faulty in (["a=1"], ["a=1:2:3"], ["a=2:1"], ["a=x:1"], ["=1:2"], ["a=0:1", "a=0:2"]):
        with pytest.raises(UserError, match="--draw"):
            read_ranges(faulty)


def test_points_of_a_table(tmp_path):
    path = tmp_path / "points.csv"
    path.write_text('fish.0.number,submarine.position_cm\n3,"[0, 0, -200]"\n\n4,"[1,0,-200]"\n')
    assert read_points(path) == [
        {"fish.0.number": "3", "submarine.position_cm": "[0, 0, -200]"},
        {"fish.0.number": "4", "submarine.position_cm": "[1,0,-200]"},
    ]


@pytest.mark.parametrize(
    ("text", "words"),
    [("", "a line with the keys"), ("a,a\n1,2\n", "a line with"), ("a\n", "a line with the keys"),
     ("a,b\n1\n", "points.csv:2: expected 2 values"), ("a,b\n1,\n", "expected 2 values")],
)  # fmt: skip
def test_a_faulty_table_of_points_is_one_line(tmp_path, text, words):
    (tmp_path / "points.csv").write_text(text)
    with pytest.raises(UserError, match=words):
        read_points(tmp_path / "points.csv")
