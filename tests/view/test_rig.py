"""Which patch is the front one, and parts of a rig."""

import numpy as np
import pytest

from subsea.view.camera import off_axis
from subsea.view.rig import Eye, Patch, Rig, Shape, front, part_of, seen_by, seen_part
from subsea.view.rigs import DISPLAYS, display_rig
from subsea.view.surround import ALL_ROUND, directions


def turned(degrees):
    """Axes of an eye that is turned right."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])


def row(*degrees):
    """A rig of square windows, each with a view turned so far."""
    eyes, patches = [], []
    for k, angle in enumerate(degrees):
        part = (10 * k, 0, 10, 10)
        eyes.append(Eye(part, np.zeros(3), turned(angle), off_axis(-1.0, 1.0, -1.0, 1.0)))
        patches.append(Patch((0, 0, 10, 10), part, part, output=k, channel=k))
    n = len(degrees)
    return Rig((10 * n, 10), ((10, 10),) * n, tuple(eyes), tuple(patches))


@pytest.mark.parametrize(
    ("degrees", "number"), [((-60, 0, 60), 1), ((0, 90), 0), ((-90, 180, 20), 2), ((-30, 30), 0)]
)
def test_the_front_is_what_is_most_straight_ahead(degrees, number):
    assert front(row(*degrees)).output == number


def test_a_frustum_that_leans_aside_is_not_the_front():
    rig = row(0, 0)
    leaning = rig.eyes[0]._replace(projection=off_axis(1.0, 3.0, -1.0, 1.0))
    assert front(rig._replace(eyes=(leaning, rig.eyes[1]))).output == 1


@pytest.mark.parametrize("display", DISPLAYS)
def test_every_display_has_a_front(display):
    assert front(display_rig(display, (64, 48))).output == 0


def test_a_part_has_its_outputs_and_only_the_eyes_that_they_need():
    rig = row(-60, 0, 60)
    part = part_of(rig, [2, 1])
    assert [patch.output for patch in part.patches] == [1, 0]
    assert [patch.channel for patch in part.patches] == [1, 2]
    assert part.eyes == (rig.eyes[1], rig.eyes[2])
    assert len(part.outputs) == 2
    for patch in part.patches:
        assert seen_by(part, patch)[0].viewport == patch.left


@pytest.mark.parametrize("display", DISPLAYS)
def test_the_whole_is_a_part(display):
    rig = display_rig(display, (64, 48))
    assert part_of(rig, [0]) == rig


@pytest.mark.parametrize("size", [(800, 600), (600, 800), (501, 499)])
@pytest.mark.parametrize("squeezed", [(1.0, 1.0), (2.0, 1.0), (1.0, 2.0)])
def test_of_a_dome_all_is_seen_in_the_square_within_its_circle(size, squeezed):
    (patch,) = display_rig("dome", size).patches
    assert seen_part(patch._replace(shape=Shape.PANORAMA)) == patch.place
    across, up = (int(n / by) for n, by in zip(size, squeezed, strict=True))
    x, y, width, height = seen_part(patch._replace(place=(7, 9, across, up), squeezed=squeezed))
    corners = np.array([(a, b) for a in (x, x + width) for b in (y, y + height)], float)
    off = (corners - [7, 9]) * squeezed - np.array(size) / 2  # from the middle, on the screen
    radius = min(size) / 2
    np.testing.assert_allclose(np.linalg.norm(off, axis=1), radius, atol=3.0)
    shown = directions("dome", size, ALL_ROUND, np.array(size) / 2 + 0.98 * off)
    assert not np.isnan(shown).any()
