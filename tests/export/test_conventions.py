"""Axes and rotations of other programs, and the notice of the licence."""

from pathlib import Path

import numpy as np

from subsea.export.conventions import (
    HOLDER,
    SENTENCE,
    Y_UP,
    Z_UP,
    copyright_line,
    rotate_quaternions,
    to_metres,
)
from subsea.geometry.rotation import matrix, normalised

LICENSE = Path(__file__).parents[2] / "LICENSE"


def test_the_axes_are_right_handed_and_rotations_agree() -> None:
    """A fish heads along +z of glTF and along -y of Blender, back up, left along +x."""
    ahead, up, right = np.eye(3) * 100.0
    np.testing.assert_allclose(to_metres(ahead, Y_UP), (0, 0, 1))
    np.testing.assert_allclose(to_metres(ahead, Z_UP), (0, -1, 0))
    np.testing.assert_allclose(to_metres(up, Y_UP), (0, 1, 0))
    np.testing.assert_allclose(to_metres(up, Z_UP), (0, 0, 1))
    np.testing.assert_allclose(to_metres(-right, Y_UP), (1, 0, 0))
    np.testing.assert_allclose(to_metres(-right, Z_UP), (1, 0, 0))
    rotation = np.array(normalised((0.3, -0.5, 0.2, 0.7)))
    for axes in (Y_UP, Z_UP):
        assert np.linalg.det(axes) > 0.0
        point = to_metres(matrix(rotation) @ ahead, axes)
        np.testing.assert_allclose(
            matrix(rotate_quaternions(rotation, axes)) @ to_metres(ahead, axes), point
        )


def test_the_holder_is_that_of_the_licence() -> None:
    lines = LICENSE.read_text().splitlines()
    assert lines[0] == "MIT License" and HOLDER in lines
    assert SENTENCE.startswith("MIT licence")


def test_a_species_of_the_user_stays_his() -> None:
    ours = f"{HOLDER}. {SENTENCE}"
    assert copyright_line(["fusilier", "clownfish"]) == ours
    mixed = copyright_line(["my_guppy", "fusilier", "my_guppy"])
    assert mixed == f"{ours} Shapes and skins of my_guppy: their author."
