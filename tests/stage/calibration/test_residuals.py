"""Pictures of residuals."""

import numpy as np

from subsea.stage.calibration.meshes import MeasuredProjector
from subsea.stage.calibration.residuals import UNSEEN, WIDE, WORST_PX, coloured, residual_picture


def test_colours_tell_how_far_off_each_part_is():
    size = 640, 400
    x, y = np.meshgrid(np.arange(5.0, 640, 5), np.arange(5.0, 200, 5))
    shown = np.column_stack([x.ravel(), y.ravel()])
    error = np.where(shown[:, :1] < 320, [[0.0, 0.0]], [[WORST_PX, WORST_PX]])
    nodes = np.zeros((5, 5, 2))
    measured = MeasuredProjector(None, size, nodes, np.ones((5, 5), bool), shown, error)
    picture = residual_picture("left", measured)
    assert picture.shape[1] == WIDE and picture.dtype == np.uint8
    body = picture[-400:]
    assert not (body[:180] == UNSEEN).all(axis=2).any()
    np.testing.assert_array_equal(body[100, 100], coloured(np.zeros(1))[0].astype(int))
    np.testing.assert_array_equal(body[100, 500], coloured(np.full(1, WORST_PX))[0].astype(int))
    np.testing.assert_array_equal(body[300, 300], UNSEEN)
