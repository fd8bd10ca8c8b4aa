"""Lenses: pictures that take in what they must light, and meshes over them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.stage.theatre.lenses import (
    aimed,
    nodes_text,
    on_cylinder,
    on_sphere,
    placed,
    rays,
    warp_nodes,
)

SQUARE = np.array([[-60.0, -40, 300], [60, -40, 300], [60, 40, 310], [-60, 40, 310]])
inside = st.floats(-0.5, 0.5)


def seen_from(lens, points):
    """Places (n, 2) of points in a lens's picture."""
    own = (points - lens.place) @ lens.axes.T
    return 0.5 + 0.5 * own[:, :2] / own[:, 2:] / np.array(lens.half)


@given(x=st.floats(-200, 200), y=st.floats(-200, 200), z=st.floats(-200, 150),
       aspect=st.floats(0.5, 3))  # fmt: skip
def test_an_aimed_picture_takes_in_its_points_and_hardly_more(x, y, z, aspect):
    lens = aimed(np.array([x, y, z]), SQUARE, aspect)
    places = seen_from(lens, SQUARE)
    assert places.min() > 0.0
    assert places.max() < 1.0
    assert lens.half[0] / lens.half[1] == pytest.approx(aspect)
    assert max(np.ptp(places, axis=0)) > 0.8


@given(x=inside, y=inside, z=inside, s=st.floats(0, 1), t=st.floats(0, 1))
def test_light_arrives_where_it_was_sent(x, y, z, s, t):
    lens = aimed(300.0 * np.array([x, y, z]), SQUARE, 1.6)
    ways = rays(lens, np.array([[s, t]]))
    hit = on_sphere(lens.place, ways, 500.0)
    assert np.linalg.norm(hit[0]) == pytest.approx(500.0)
    np.testing.assert_allclose(seen_from(lens, hit), [[s, t]], atol=1e-9)
    wall = on_cylinder(lens.place, ways, 500.0)
    assert np.hypot(*wall[0, [0, 2]]) == pytest.approx(500.0)
    np.testing.assert_allclose(seen_from(lens, wall), [[s, t]], atol=1e-9)


def test_a_lens_stands_where_its_throw_ratio_lights_enough():
    tries = [np.array([0.0, 0.0, 250.0 - d]) for d in range(0, 600, 10)]
    lens = placed(tries, SQUARE, 1.6, 2.0, "the wall")
    assert lens.throw == pytest.approx(2.0)
    nearer = aimed(lens.place + [0, 0, 10], SQUARE, 1.6)
    assert nearer.throw < 2.0 <= aimed(lens.place, SQUARE, 1.6).throw
    assert placed(tries, SQUARE, 1.6, 0.0, "the wall").place[2] == tries[-1][2]
    with pytest.raises(UserError, match=r"--throw 9 lights too little of the wall, expected \d"):
        placed(tries, SQUARE, 1.6, 9.0, "the wall")


def test_a_mesh_marks_light_that_arrives_nowhere():
    lens = aimed(np.zeros(3), SQUARE, 1.5)

    def left_half(place, ways):
        return np.where(ways[:, :1] < 0.0, ways[:, :2], np.nan)

    nodes = warp_nodes(lens, (5, 3), left_half)
    assert nodes.shape == (3, 5, 5)
    assert (nodes[:, :2, 4] == 1.0).all()
    assert (nodes[:, 3:, 4] == -1.0).all()
    assert nodes[0, 0, :2].tolist() == pytest.approx([-1.5, -1.0])
    first, second, *rows = nodes_text(nodes).splitlines()
    assert (first, second, len(rows)) == ("2", "5 3", 15)
