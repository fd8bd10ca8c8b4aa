"""Deformable meshes over pictures (Tu appendix A)."""

import numpy as np
import pytest

from subsea.fish.photo.deformable_mesh import (
    BODY,
    DORSAL,
    LAW,
    Net,
    copied,
    energy,
    field,
    fin,
    forces,
    mesh,
    nearest,
    relax,
    root,
    settle,
    smoothed,
    step,
    transform,
)


def grid(m=9, n=21, size=10.0, corner=(60.0, 60.0)):
    """A regular grid of nodes."""
    y, x = np.mgrid[:m, :n] * size
    return np.stack([x, y], axis=2) + corner


def bare(nodes=None):
    return Net(mesh(grid() if nodes is None else nodes), {})


def finned():
    body = mesh(grid())
    places = np.linspace(5.0, 14.5, 12)
    edge = np.stack([60.0 + 10.0 * places, np.full(12, 40.0)], axis=1)
    return Net(body, {DORSAL: fin(body, 0, places, edge)})


def disc(size=400, middle=(200.0, 190.0), radius=110.0, inner=0.2, outer=0.8):
    """A picture of a disc whose border is one pixel wide."""
    y, x = np.mgrid[:size, :size]
    far = np.hypot(x - middle[0], y - middle[1])
    return inner + (outer - inner) * np.clip(far - radius + 0.5, 0.0, 1.0)


def border(nodes):
    return np.concatenate([nodes[0], nodes[1:, -1], nodes[-1, -2::-1], nodes[-2:0:-1, 0]])


def test_nothing_moves_without_forces():
    bent = grid() + 5.0 * np.sin(grid()[..., ::-1] / 17.0)  # any shape may be that at rest
    for net in (bare(), bare(bent), finned()):
        before = copied(net)
        assert step(net, None, times=50) < 1e-9
        np.testing.assert_allclose(net.body.nodes, before.body.nodes, atol=1e-9)


def test_tension_vanishes_undeformed_and_pulls_back_what_is_stretched():
    net = bare(grid(1, 5))
    law = LAW._replace(rigidity=0.0)
    assert np.abs(forces(net, None, law)[BODY]).max() < 1e-12
    net.body.nodes[0, 4, 0] += 8.0
    pushed = forces(net, None, law)[BODY]
    # A.2 with its sign turned: the last spring, 8 pixels too long, pulls at both ends.
    np.testing.assert_allclose(pushed[0, :, 0], [0, 0, 0, 8 * law.tension, -8 * law.tension])
    np.testing.assert_allclose(pushed[0, :, 1], 0.0, atol=1e-12)


def test_rigidity_vanishes_unbent_and_is_the_fourth_difference():
    net = bare(grid(1, 9))
    law = LAW._replace(tension=0.0)
    net.body.nodes[0, :, 0] = np.linspace(0, 50, 9)  # stretched, but straight
    assert np.abs(forces(net, None, law)[BODY]).max() < 1e-12
    net.body.nodes[0, 4, 1] += 3.0
    pushed = forces(net, None, law)[BODY][0, :, 1]
    beta = law.rigidity * 3.0 * np.array([0, 0, 1, -4, 6, -4, 1, 0, 0])  # A.3
    np.testing.assert_allclose(pushed, -beta, atol=1e-12)


def test_forces_are_what_lets_the_energy_fall():
    rng = np.random.default_rng(3)
    net = finned()
    net.body.nodes[:] += rng.normal(0.0, 2.0, net.body.nodes.shape)
    net.body.anchors[0, 3] = 85.0, 50.0
    net.body.pulls[4, 4] = 120.0, 90.0

    root(net)
    pushed = forces(net, None)[BODY]
    for k, j in ((0, 3), (0, 8), (4, 4), (8, 20), (2, 0)):
        for axis in (0, 1):
            ends = []
            for off in (1e-4, -1e-4):
                other = copied(net)
                other.body.nodes[k, j, axis] += off
                root(other)
                ends.append(energy(other, None))
            assert pushed[k, j, axis] == pytest.approx((ends[1] - ends[0]) / 2e-4, abs=1e-5)


def test_the_border_finds_the_outline_of_a_disc():
    picture = disc()
    t = np.linspace(-1.0, 1.0, 13)
    x, y = np.meshgrid(t, t)
    # A square laid onto a disc: its corners outside the outline, its sides inside.
    round_ = np.stack([x * np.sqrt(1 - y**2 / 2), y * np.sqrt(1 - x**2 / 2)], 2)
    net = bare(np.array([206.0, 185.0]) + 104.0 * round_)
    before = energy(net, field(picture, 8.0))
    for sigma in (8.0, 4.0, 2.0):
        settle(net)
        assert relax(net, field(picture, sigma)) is not None
    far = np.hypot(*(border(net.body.nodes) - (200.0, 190.0)).T)
    assert np.abs(far - 110.0).max() < 1.5
    assert energy(net, field(picture, 8.0)) < before


@pytest.mark.parametrize("inner, outer", [(0.2, 0.8), (0.8, 0.2), (0.5, 0.55)])
def test_dark_light_and_faint_edges_attract_alike(inner, outer):
    net = bare(np.array([200.0, 100.0]) + np.zeros((1, 1, 2)))
    relax(net, field(disc(inner=inner, outer=outer), 6.0))
    # The top of the disc is at y = 80; the node began 20 pixels inside.
    assert np.abs(net.body.nodes[0, 0, 1] - 80.0) < 1.0


def test_energy_falls_at_every_step():
    picture = field(disc(), 6.0)
    net = bare(np.array([200.0, 190.0]) + 1.05 * (grid(9, 9, 20.0) - grid(9, 9, 20.0).mean((0, 1))))
    net.body.pulls[0, 4] = 200.0, 60.0
    last = energy(net, picture)
    for _ in range(100):
        step(net, picture, LAW._replace(step=0.05))
        assert energy(net, picture) <= last + 1e-6
        last = energy(net, picture)


def test_an_anchor_holds_against_the_picture():
    picture = field(disc(), 6.0)
    net = bare(np.array([200.0, 190.0]) + 80.0 * (grid(9, 9, 0.25, (-1.0, -1.0))))
    net.body.anchors[0, 4] = 200.0, 130.0  # inside the disc, 50 pixels from its outline
    relax(net, picture)
    assert np.hypot(*(net.body.nodes[0, 4] - (200.0, 130.0))) < 6.0


def test_the_mouse_pulls_a_node_and_lets_go():
    net = bare()
    net.body.pulls[0, 10] = 160.0, 20.0
    step(net, None, times=200)
    assert np.hypot(*(net.body.nodes[0, 10] - (160.0, 20.0))) < 12.0
    assert net.body.nodes[0, 9, 1] < 58.0  # its neighbours come along
    assert abs(net.body.nodes[8, 0, 1] - 140.0) < 5.0  # those far away hardly
    net.body.pulls[0, 10] = np.nan
    held = energy(net, None)
    step(net, None, times=2000)
    assert energy(net, None) < 0.05 * held
    assert net.body.nodes[0, 10, 1] > 52.0


def test_fins_stay_rooted_on_the_body():
    net = finned()
    net.body.pulls[0, 10] = 160.0, 90.0
    net.fins[DORSAL].mesh.pulls[1, 3] = 100.0, 10.0
    step(net, None, times=100)
    one = net.fins[DORSAL]
    np.testing.assert_allclose(one.mesh.nodes[0], one.share @ net.body.nodes[0])
    assert one.mesh.nodes[1, 3, 1] < 30.0
    # What pulls at a fin pulls at its body.
    alone = finned()
    alone.fins[DORSAL].mesh.pulls[1, 3] = 100.0, 10.0
    step(alone, None, times=100)
    assert alone.body.nodes[0, 8, 1] < 59.5


def test_the_whole_is_turned_scaled_and_shifted_at_rest():
    net = finned()
    about = np.array([160.0, 100.0])
    turn = 1.3 * np.array([[0.6, -0.8], [0.8, 0.6]])
    before = net.body.nodes.copy()
    transform(net, turn, about, np.array([7.0, -3.0]))
    np.testing.assert_allclose(net.body.nodes[4, 10], about + (7.0, -3.0))
    np.testing.assert_allclose(
        np.hypot(*(net.body.nodes[0, 0] - net.body.nodes[8, 20])),
        1.3 * np.hypot(*(before[0, 0] - before[8, 20])),
    )
    assert step(net, None, times=10) < 1e-9


def test_the_nearest_node_is_found_for_the_mouse():
    net = finned()
    assert nearest(net, np.array([61.0, 62.0]))[:3] == (BODY, 0, 0)
    assert nearest(net, np.array([111.0, 41.0]))[:3] == (DORSAL, 1, 0)
    assert nearest(net, np.array([101.0, 99.0]))[:3] == (BODY, 4, 4)
    part, k, j, far = nearest(net, np.array([71.0, 99.0]), border=True)
    assert (part, k, j) == (BODY, 4, 0)
    assert far == pytest.approx(np.hypot(11.0, 1.0))


def test_smoothing_is_a_gaussian():
    point = np.zeros((61, 61), np.float32)
    point[30, 30] = 1.0
    out = smoothed(point, 4.0)
    assert out.sum() == pytest.approx(1.0, abs=1e-4)
    assert out[30, 34] / out[30, 30] == pytest.approx(np.exp(-0.5), abs=1e-3)
