"""The mesh of a spherical mirror against the law of reflection."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.stage.theatre.lenses import MIRROR_NODES, mirror_setup, nodes_text, traced
from subsea.stage.theatre.measured_mesh import dome_shares
from subsea.stage.theatre.mesh_formats import parse_bourke
from subsea.view.rig import sources_at
from subsea.view.surround import Surround, directions

SIZE = 1920, 1080
RADIUS, MIRROR = 300.0, 30.0


def mirror_points(lens, centre, radius, targets):
    """The points (n, 3) of a mirror that send light from a lens to targets, by bisection.

    Each lies in the plane of lens, centre and target, where the normal halves the angle between the
    ways to both: a search that knows nothing of rays (Alhazen's problem).
    """
    first, second = of_length_one(lens - centre), of_length_one(targets - centre)
    across = second @ first
    side = of_length_one(second - across[:, None] * first)
    low, high = np.zeros(len(targets)), np.arccos(np.clip(across, -1, 1))
    for _ in range(80):
        turn = (low + high) / 2
        normal = np.cos(turn)[:, None] * first + np.sin(turn)[:, None] * side
        points = centre + radius * normal
        ways = of_length_one(lens - points), of_length_one(targets - points)
        own, other = (np.arccos((way * normal).sum(axis=1)) for way in ways)
        low, high = np.where(own < other, turn, low), np.where(own < other, high, turn)
    return points


def of_length_one(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


@given(mirror=st.floats(15, 60), throw=st.floats(0.8, 3), tilt=st.floats(0, 0.7),
       seed=st.integers(0, 10**6))  # fmt: skip
def test_light_is_reflected_at_equal_angles_toward_what_the_mesh_shows(mirror, throw, tilt, seed):
    setup = mirror_setup(RADIUS, mirror, throw, 16 / 9, tilt)
    flat = setup.nodes.reshape(-1, 5)
    used = np.flatnonzero(flat[:, 4] > 0)
    node = flat[np.random.default_rng(seed).choice(used)]
    # The direction that the fisheye of the dome has at u and v, by the shader's formula.
    pixel = node[2:4] * 1000.0
    way = directions("dome", (1000, 1000), Surround(tilt_deg=np.degrees(tilt)), pixel[None])[0]
    if np.isnan(way).any():  # below the rim
        return
    [point] = mirror_points(setup.lens.place, setup.centre, mirror, RADIUS * way[None])
    normal = (point - setup.centre) / mirror
    to_lens, to_dome = setup.lens.place - point, RADIUS * way - point
    assert to_lens @ normal / np.linalg.norm(to_lens) == pytest.approx(
        to_dome @ normal / np.linalg.norm(to_dome), abs=1e-6
    )
    # The projector's pixel of the node is on the line from the lens to that point.
    own = (point - setup.lens.place) @ setup.lens.axes.T
    seen = own[:2] / own[2] / np.array(setup.lens.half)
    np.testing.assert_allclose(seen * [16 / 9, 1.0], node[:2], atol=2e-5)


def test_between_nodes_the_mesh_is_right_within_a_quarter_of_a_degree():
    setup = mirror_setup(RADIUS, MIRROR, 1.5, SIZE[0] / SIZE[1])
    warp, mask, *_ = parse_bourke(nodes_text(setup.nodes).encode(), SIZE, "test")
    rng = np.random.default_rng(2)
    places = rng.uniform(0.1, 0.9, (400, 2)) * [1.0, 0.8]
    x, y = (2 * places - 1).T
    own = np.stack([x * setup.lens.half[0], y * setup.lens.half[1], np.ones_like(x)], axis=1)
    ways = own / np.linalg.norm(own, axis=1, keepdims=True) @ setup.lens.axes
    _, _, points = traced(setup.lens.place, ways, setup.centre, MIRROR, RADIUS)
    expected = dome_shares(points, 0.0)
    inside = np.hypot(*(expected - 0.5).T) < 0.49
    assert inside.sum() > 200
    shown = sources_at(warp, places[inside])
    error = np.linalg.norm(shown - expected[inside], axis=1) * 180.0
    assert error.max() < 0.25
    assert mask[..., :3].max() <= 1.0


def test_the_mesh_is_a_grid_whose_light_covers_nearly_all_of_the_dome():
    setup = mirror_setup(RADIUS, MIRROR, 1.5, SIZE[0] / SIZE[1])
    assert setup.nodes.shape == (MIRROR_NODES[1], MIRROR_NODES[0], 5)
    ways = np.random.default_rng(1).normal(size=(3000, 3))
    ways = ways[ways[:, 1] > 0] / np.linalg.norm(ways[ways[:, 1] > 0], axis=1, keepdims=True)
    warp = parse_bourke(nodes_text(setup.nodes).encode(), SIZE, "test").warp
    points = mirror_points(setup.lens.place, setup.centre, MIRROR, RADIUS * ways)
    own = (points - setup.lens.place) @ setup.lens.axes.T
    seen = np.abs(own[:, :2] / own[:, 2:] / np.array(setup.lens.half))
    lit = (seen <= 1.0).all(axis=1)
    assert setup.lit == pytest.approx(lit.mean(), abs=0.02)
    assert setup.lit > 0.9
    assert len(warp.triangles) > 5000
