"""Gains, gammas and black levels from what a camera saw."""

import numpy as np

from subsea.stage.calibration.light_levels import light_levels
from subsea.stage.calibration.optics import SeenLight
from subsea.view.structured_light import UNIFORM


def seen(channel, columns, gain, gamma, black, paint):
    """Blocks of a projector on columns of a camera, with crosstalk of its colours."""
    x, y = np.meshgrid(np.arange(*columns), np.arange(20))
    pixels = 10.0 * np.column_stack([x.ravel(), y.ravel()])
    crosstalk = np.array([[0.8, 0.15, 0.05], [0.1, 0.8, 0.1], [0.02, 0.18, 0.8]])
    dark = np.array([0.01 + 0.001 * black_light(pixels, black)]).T
    light = []
    for pattern in UNIFORM:
        shone = (np.array(pattern.colour) / 255) ** gamma * gain
        light.append(dark + paint(pixels)[:, None] * (crosstalk @ shone))
    return SeenLight(channel, 0, pixels, pixels, np.stack(light, axis=1))


def black_light(pixels, black):
    """Black levels of the projectors that light a pixel, in thousandths."""
    left, right = pixels[:, 0] < 300, pixels[:, 0] >= 200
    return 1000 * paint(pixels) * (left * black[0] * 0.8 + right * black[1] * 0.5)


def paint(pixels):
    """The uneven paint of a screen."""
    return 0.6 + 0.2 * np.sin(pixels[:, 1] / 30)


def test_levels_follow_from_overlaps_and_steps():
    black = 0.004, 0.008
    one = seen(0, (0, 30), (0.8, 0.8, 0.8), (2.2, 2.3, 2.4), black, paint)
    two = seen(1, (20, 50), (0.5, 0.4, 0.8), (2.0, 2.0, 2.0), black, paint)
    first, second = light_levels([one, two], 2)
    np.testing.assert_allclose(first.gain, [0.625, 0.5, 1.0], atol=0.12)
    np.testing.assert_allclose(second.gain, [1.0, 1.0, 1.0], atol=1e-3)
    np.testing.assert_allclose(first.gamma, [2.2, 2.3, 2.4], atol=1e-3)
    np.testing.assert_allclose(second.gamma, [2.0, 2.0, 2.0], atol=1e-3)
    assert abs(first.black - black[0]) < 0.001 and abs(second.black - black[1]) < 0.002


def test_projectors_that_do_not_overlap_keep_their_gains():
    black = 0.0, 0.0
    one = seen(0, (0, 20), (0.8, 0.8, 0.8), (2.2,) * 3, black, paint)
    two = seen(1, (40, 50), (0.5, 0.4, 0.8), (2.2,) * 3, black, paint)
    assert [level.gain for level in light_levels([one, two], 2)] == [(1.0, 1.0, 1.0)] * 2
