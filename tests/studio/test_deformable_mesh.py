"""Deformable meshes over pictures (Tu appendix A)."""

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from subsea.studio.deformable_mesh import (
    BODY,
    DEFAULT,
    DORSAL,
    FishMeshes,
    attach_fins,
    copy_meshes,
    edge_field,
    forces,
    make_fin,
    make_mesh,
    relax,
    set_rest_shape,
    step,
    transform,
)
from subsea.studio.side_view import mesh_outlines


def grid(m=9, n=21, size=10.0, corner=(60.0, 60.0)):
    """A regular grid of nodes."""
    y, x = np.mgrid[:m, :n] * size
    return np.stack([x, y], axis=2) + corner


def bare(nodes=None):
    return FishMeshes(make_mesh(grid() if nodes is None else nodes), {})


def finned():
    body = make_mesh(grid())
    places = np.linspace(5.0, 14.5, 12)
    edge = np.stack([60.0 + 10.0 * places, np.full(12, 40.0)], axis=1)
    return FishMeshes(body, {DORSAL: make_fin(body, 0, places, edge)})


def disc(size=400, middle=(200.0, 190.0), radius=110.0, inner=0.2, outer=0.8):
    """A picture of a disc whose border is one pixel wide."""
    y, x = np.mgrid[:size, :size]
    far = np.hypot(x - middle[0], y - middle[1])
    return inner + (outer - inner) * np.clip(far - radius + 0.5, 0.0, 1.0)


def energy(meshes, picture=None):
    """Potential energy of all forces, pixels²."""
    total = 0.0
    for one in meshes.parts.values():
        x = one.nodes
        for axis, rest in ((1, one.along), (0, one.across)):
            stretch = np.linalg.norm(np.diff(x, axis=axis), axis=2) - rest
            total += 0.5 * DEFAULT.tension * (stretch**2).sum()
        bends = (
            np.diff(x, 2, axis=1) - one.bend_along[:, 1:-1],
            np.diff(x, 2, axis=0) - one.bend_across[1:-1],
        )
        total += 0.5 * DEFAULT.rigidity * sum((bend**2).sum() for bend in bends)
        total += 0.5 * DEFAULT.anchor * np.nansum((one.anchors - x) ** 2)
        total += 0.5 * DEFAULT.mouse * np.nansum((one.mouse - x) ** 2)
        if picture:
            seen = map_coordinates(picture.height, [x[..., 1], x[..., 0]], order=1, mode="nearest")
            total -= DEFAULT.picture * (one.edge_weight * seen).sum()
    return total


def test_nothing_moves_without_forces():
    bent = grid() + 5.0 * np.sin(grid()[..., ::-1] / 17.0)  # any shape may be that at rest
    for meshes in (bare(), bare(bent), finned()):
        before = copy_meshes(meshes)
        assert step(meshes, None, times=50) < 1e-9
        np.testing.assert_allclose(meshes.body.nodes, before.body.nodes, atol=1e-9)


def test_tension_vanishes_undeformed_and_pulls_back_what_is_stretched():
    meshes = bare(grid(1, 5))
    params = DEFAULT._replace(rigidity=0.0)
    assert np.abs(forces(meshes, None, params)[BODY]).max() < 1e-12
    meshes.body.nodes[0, 4, 0] += 8.0
    pushed = forces(meshes, None, params)[BODY]
    # A.2 with its sign turned: the last spring, 8 pixels too long, pulls at both ends.
    np.testing.assert_allclose(pushed[0, :, 0], [0, 0, 0, 8 * params.tension, -8 * params.tension])
    np.testing.assert_allclose(pushed[0, :, 1], 0.0, atol=1e-12)


def test_rigidity_vanishes_unbent_and_is_the_fourth_difference():
    meshes = bare(grid(1, 9))
    params = DEFAULT._replace(tension=0.0)
    meshes.body.nodes[0, :, 0] = np.linspace(0, 50, 9)  # stretched, but straight
    assert np.abs(forces(meshes, None, params)[BODY]).max() < 1e-12
    meshes.body.nodes[0, 4, 1] += 3.0
    pushed = forces(meshes, None, params)[BODY][0, :, 1]
    beta = params.rigidity * 3.0 * np.array([0, 0, 1, -4, 6, -4, 1, 0, 0])  # A.3
    np.testing.assert_allclose(pushed, -beta, atol=1e-12)


def test_forces_are_the_negative_gradient_of_the_energy():
    rng = np.random.default_rng(3)
    meshes = finned()
    meshes.body.nodes[:] += rng.normal(0.0, 2.0, meshes.body.nodes.shape)
    meshes.body.anchors[0, 3] = 85.0, 50.0
    meshes.body.mouse[4, 4] = 120.0, 90.0

    attach_fins(meshes)
    pushed = forces(meshes, None)[BODY]
    for k, j in ((0, 3), (0, 8), (4, 4), (8, 20), (2, 0)):
        for axis in (0, 1):
            ends = []
            for off in (1e-4, -1e-4):
                other = copy_meshes(meshes)
                other.body.nodes[k, j, axis] += off
                attach_fins(other)
                ends.append(energy(other))
            assert pushed[k, j, axis] == pytest.approx((ends[1] - ends[0]) / 2e-4, abs=1e-5)


def test_the_border_finds_the_outline_of_a_disc():
    picture = disc()
    t = np.linspace(-1.0, 1.0, 13)
    x, y = np.meshgrid(t, t)
    # A square laid onto a disc: its corners outside the outline, its sides inside.
    round_ = np.stack([x * np.sqrt(1 - y**2 / 2), y * np.sqrt(1 - x**2 / 2)], 2)
    meshes = bare(np.array([206.0, 185.0]) + 104.0 * round_)
    before = energy(meshes, edge_field(picture, 8.0))
    for sigma in (8.0, 4.0, 2.0):
        set_rest_shape(meshes)
        assert relax(meshes, edge_field(picture, sigma)) is not None
    far = np.hypot(*(mesh_outlines(meshes, 1)[0] - (200.0, 190.0)).T)
    assert np.abs(far - 110.0).max() < 1.5
    assert energy(meshes, edge_field(picture, 8.0)) < before


@pytest.mark.parametrize("inner, outer", [(0.2, 0.8), (0.8, 0.2), (0.5, 0.55)])
def test_dark_light_and_faint_edges_attract_alike(inner, outer):
    meshes = bare(np.array([200.0, 100.0]) + np.zeros((1, 1, 2)))
    relax(meshes, edge_field(disc(inner=inner, outer=outer), 6.0))
    # The top of the disc is at y = 80; the node began 20 pixels inside.
    assert np.abs(meshes.body.nodes[0, 0, 1] - 80.0) < 1.0


def test_energy_falls_at_every_step():
    picture = edge_field(disc(), 6.0)
    meshes = bare(
        np.array([200.0, 190.0]) + 1.05 * (grid(9, 9, 20.0) - grid(9, 9, 20.0).mean((0, 1)))
    )
    meshes.body.mouse[0, 4] = 200.0, 60.0
    last = energy(meshes, picture)
    for _ in range(100):
        step(meshes, picture, DEFAULT._replace(step=0.05))
        assert energy(meshes, picture) <= last + 1e-6
        last = energy(meshes, picture)


def test_an_anchor_holds_against_the_picture():
    picture = edge_field(disc(), 6.0)
    meshes = bare(np.array([200.0, 190.0]) + 80.0 * (grid(9, 9, 0.25, (-1.0, -1.0))))
    meshes.body.anchors[0, 4] = 200.0, 130.0  # inside the disc, 50 pixels from its outline
    relax(meshes, picture)
    assert np.hypot(*(meshes.body.nodes[0, 4] - (200.0, 130.0))) < 6.0


def test_the_mouse_pulls_a_node_and_lets_go():
    meshes = bare()
    meshes.body.mouse[0, 10] = 160.0, 20.0
    step(meshes, None, times=200)
    assert np.hypot(*(meshes.body.nodes[0, 10] - (160.0, 20.0))) < 12.0
    assert meshes.body.nodes[0, 9, 1] < 58.0  # its neighbours come along
    assert abs(meshes.body.nodes[8, 0, 1] - 140.0) < 5.0  # those far away hardly
    meshes.body.mouse[0, 10] = np.nan
    held = energy(meshes)
    step(meshes, None, times=2000)
    assert energy(meshes) < 0.05 * held
    assert meshes.body.nodes[0, 10, 1] > 52.0


def test_fins_stay_rooted_on_the_body():
    meshes = finned()
    meshes.body.mouse[0, 10] = 160.0, 90.0
    meshes.fins[DORSAL].mesh.mouse[1, 3] = 100.0, 10.0
    step(meshes, None, times=100)
    one = meshes.fins[DORSAL]
    np.testing.assert_allclose(one.mesh.nodes[0], one.root_weights @ meshes.body.nodes[0])
    assert one.mesh.nodes[1, 3, 1] < 30.0
    # Forces on a fin pull at its body too.
    alone = finned()
    alone.fins[DORSAL].mesh.mouse[1, 3] = 100.0, 10.0
    step(alone, None, times=100)
    assert alone.body.nodes[0, 8, 1] < 59.5


def test_the_whole_is_turned_scaled_and_shifted_at_rest():
    meshes = finned()
    about = np.array([160.0, 100.0])
    turn = 1.3 * np.array([[0.6, -0.8], [0.8, 0.6]])
    before = meshes.body.nodes.copy()
    transform(meshes, turn, about, np.array([7.0, -3.0]))
    np.testing.assert_allclose(meshes.body.nodes[4, 10], about + (7.0, -3.0))
    np.testing.assert_allclose(
        np.hypot(*(meshes.body.nodes[0, 0] - meshes.body.nodes[8, 20])),
        1.3 * np.hypot(*(before[0, 0] - before[8, 20])),
    )
    assert step(meshes, None, times=10) < 1e-9
