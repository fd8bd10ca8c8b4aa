"""Structured light: every pixel of a projector has a code of its own."""

import numpy as np
import pytest

from subsea.view.display_rigs import display_rig
from subsea.view.structured_light import (
    COLUMNS,
    ROWS,
    STRIPE_PX,
    UNIFORM,
    bare,
    from_gray,
    gray,
    light_patterns,
    light_picture,
    lit_picture,
)


def test_neighbours_in_the_gray_code_differ_in_one_bit():
    codes = gray(np.arange(5000))
    changes = codes[1:] ^ codes[:-1]
    assert (changes & (changes - 1) == 0).all() and (changes > 0).all()
    np.testing.assert_array_equal(from_gray(codes), np.arange(5000))


@pytest.mark.parametrize("size", [(192, 128), (333, 50), (16, 4096)])
def test_the_pictures_tell_every_stripe(size):
    patterns = light_patterns(size)
    assert patterns[: len(UNIFORM)] == UNIFORM
    codes = np.zeros((2, size[1], size[0]), int)
    stripes = patterns[len(UNIFORM) :]
    for bit, inverse in zip(stripes[::2], stripes[1::2], strict=True):
        picture = light_picture(bit, size)
        assert inverse == bit._replace(name=f"{bit.name}-inverse", inverse=True)
        np.testing.assert_array_equal(picture, 255 - light_picture(inverse, size))
        codes[bit.axis] = 2 * codes[bit.axis] + (picture[..., 0] > 0)
    y, x = np.mgrid[: size[1], : size[0]]
    np.testing.assert_array_equal(from_gray(codes[COLUMNS]), x // STRIPE_PX)
    np.testing.assert_array_equal(from_gray(codes[ROWS]), y // STRIPE_PX)


def test_one_channel_shines_and_the_others_are_black():
    rig = display_rig("mono", (64, 48))
    (patch,) = rig.patches
    wall = rig._replace(
        outputs=((64, 48), (64, 48)),
        patches=(patch, patch._replace(output=1, channel=3, mask=np.zeros((1, 1, 4)))),
    )
    plain = bare(wall)
    assert all(one.mask is None and one.warp is None for one in plain.patches)
    picture = lit_picture(plain, 3, 0)
    left, right = (picture[:, one.left[0] : one.left[0] + 64] for one in plain.patches)
    assert (left == 0).all() and (right == 255).all()
    assert not lit_picture(plain, 3, 1000).any()
