"""The hook's shape and its position in the picture."""

from dataclasses import replace

import numpy as np
import pytest

from subsea.rendering.sea.hook import BAIT, BEND_CM, LINE, METAL, SHANK_CM, WIRE_CM, shape

SIZE = (320, 180)


def test_the_wire_has_its_thickness_and_is_shaped_like_a_j():
    vertices, triangles = shape()
    middle, normal, radius, kind = np.split(vertices, (3, 6, 7), axis=1)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0)
    metal = (kind == METAL)[:, 0]
    assert radius[metal].max() == pytest.approx(WIRE_CM)
    x, z = middle[metal][:, 0], middle[metal][:, 2]
    assert z.min() == pytest.approx(0, abs=1e-9)  # the bend is the origin
    assert x.max() == pytest.approx(BEND_CM)
    assert z.max() > SHANK_CM  # the shank is longer than ...
    assert z[x > 0.5 * BEND_CM].max() < 0.7 * SHANK_CM  # ... the point
    assert set(np.unique(kind)) == {METAL, BAIT, LINE}
    assert triangles.min() == 0
    assert triangles.max() == len(vertices) - 1


def test_triangles_of_one_tube_keep_to_it():
    vertices, triangles = shape()
    kinds = vertices[triangles, 7]
    assert (kinds == kinds[:, :1]).all()


@pytest.fixture
def picture(drawn, make_packet):
    """A picture with or without a hook before the eye."""

    def picture(hook, bait=True):
        packet = make_packet([])
        place = None if hook is None else packet.views[0].eye + (0.0, 40.0, -3.0) + hook
        return drawn(replace(packet, hook=place, bait=bait))

    return picture


def test_it_is_drawn_where_it_is_with_a_line_to_the_surface(picture):
    without, there = picture(None), picture((0.0, 0.0, 0.0))
    changed = np.abs(there - without).max(axis=2) > 6
    rows, columns = np.nonzero(changed)
    assert np.abs(columns - SIZE[0] / 2).max() < 12
    assert rows.min() == 0  # the line leaves the picture above
    assert SIZE[1] / 2 < rows.max() < 0.75 * SIZE[1]
    aside = np.nonzero(np.abs(picture((-15.0, 0.0, 0.0)) - without).max(axis=2) > 6)[1]
    assert aside.max() < columns.min()  # left of the eye, left in the picture


def test_without_bait_the_worm_is_gone(picture):
    baited, bare = picture((0.0, 0.0, 0.0)), picture((0.0, 0.0, 0.0), bait=False)
    red = baited[..., 0] - bare[..., 0]
    assert (red > 20).sum() > 10
