"""Surface nets against shapes in closed form."""

import numpy as np

from subsea.rendering.reef.coral_mesh import surface_net


def ball(number=33, radius=0.7):
    axis = np.linspace(-1, 1, number)
    x, y, z = np.meshgrid(axis, axis, axis, indexing="ij")
    return np.sqrt(x * x + y * y + z * z) - radius, 2 / (number - 1)


def test_a_ball_has_its_radius_area_and_volume():
    field, cell = ball()
    places, triangles = surface_net(field)
    corners = (places * cell - 1)[triangles]
    np.testing.assert_allclose(np.linalg.norm(corners, axis=2), 0.7, atol=0.01)
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(face, axis=1).sum() / 2
    np.testing.assert_allclose(area, 4 * np.pi * 0.7**2, rtol=0.02)
    # Outward is counter-clockwise: else the volume is negative.
    volume = (corners.mean(axis=1) * face).sum() / 6
    np.testing.assert_allclose(volume, 4 / 3 * np.pi * 0.7**3, rtol=0.02)


def test_it_is_closed():
    _, triangles = surface_net(ball(17)[0])
    edges = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    there = {tuple(edge) for edge in edges.tolist()}
    assert len(there) == len(edges)
    assert {(b, a) for a, b in there} == there


def test_it_ends_where_the_grid_ends():
    field, _ = ball(17)
    places, triangles = surface_net(field[:, :, 8:])
    assert len(triangles) > 100
    assert places[:, 2].min() < 1.0
    assert triangles.max() < len(places)


def test_nothing_inside_is_nothing():
    places, triangles = surface_net(np.ones((4, 5, 6)))
    assert places.shape == (0, 3)
    assert triangles.shape == (0, 3)
