"""Stone around a place: roofs and walls."""

import numpy as np
import pytest

from subsea.sound.ambience import SIGHT_CM, enclosure

NO_PILLARS, NO_ROCKS = np.zeros((0, 4)), np.zeros((0, 7))


def rock(x, y, z, size):
    return np.array([[x, y, z, size, size, size, 0.0]])


def test_open_water_has_neither_roof_nor_walls():
    assert enclosure(NO_PILLARS, NO_ROCKS, (0.0, 0.0, -300.0)) == (0.0, 0.0)
    far = rock(0.0, 0.0, -300.0 + 2.0 * SIGHT_CM, 100.0)
    assert enclosure(NO_PILLARS, far, (0.0, 0.0, -300.0)) == (0.0, 0.0)


def test_stone_above_is_a_roof_and_pillars_are_walls():
    roof, walls = enclosure(NO_PILLARS, rock(0.0, 0.0, -100.0, 150.0), (0.0, 0.0, -300.0))
    assert roof > 0.5 and walls == 0.0
    pillars = np.array([[100.0 * np.cos(a), 100.0 * np.sin(a), 50.0, 0.0]
                        for a in np.arange(4) * np.pi / 2])  # fmt: skip
    roof, walls = enclosure(pillars, NO_ROCKS, (0.0, 0.0, -300.0))
    assert walls > 0.35


@pytest.mark.parametrize("step", [1.0, 5.0])
def test_a_way_under_stone_changes_the_roof_little_by_little(step):
    stone = rock(0.0, 0.0, -100.0, 150.0)
    roofs = [
        enclosure(NO_PILLARS, stone, (x, 0.0, -300.0))[0] for x in np.arange(-600.0, 600.0, step)
    ]
    assert max(roofs) > 0.5 and roofs[0] == roofs[-1] == 0.0
    # Two slanting rays may meet the edge at once; the mixer takes CHANGE_S for it.
    assert np.abs(np.diff(roofs)).max() < 0.3
