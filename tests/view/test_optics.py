"""Lens distortion and flat ports: closed forms, OpenCV, exact projection beside remapping."""

import cv2
import numpy as np
import pytest

from subsea.view.optics import (
    CameraLens,
    FlatPort,
    Optics,
    air_slope,
    canvas_of,
    pixel_grid,
    sources,
)

BARREL = CameraLens(-0.21, 0.06, 0.001, -0.002, -0.008)
PORT = FlatPort(gap_cm=2.0, glass_cm=0.6)
SIZE = (160, 120)


@pytest.fixture
def points():
    rng = np.random.default_rng(5)
    z = rng.uniform(60.0, 600.0, 500)
    x, y = (rng.uniform(-0.5, 0.5, 500) * z for _ in range(2))
    return np.stack([x, 0.7 * y, z], axis=-1)


def test_a_lens_projects_as_opencv_does(points):
    optics = Optics(SIZE, 70.0, BARREL)
    theirs, _ = cv2.projectPoints(
        points, np.zeros(3), np.zeros(3), optics.intrinsics, np.array(BARREL)
    )
    np.testing.assert_allclose(optics.project(points), theirs[:, 0], atol=1e-9)


@pytest.mark.parametrize("port", [None, PORT])
@pytest.mark.parametrize("lens", [CameraLens(), BARREL, CameraLens(k1=0.15)])
def test_points_of_a_pixels_ray_project_to_the_pixel(lens, port):
    optics = Optics(SIZE, 70.0, lens, port)
    for depth in (15.0, 80.0, 2000.0):
        points = optics.points(np.full(SIZE[::-1], depth))
        np.testing.assert_allclose(points[..., 2], depth)
        np.testing.assert_allclose(optics.project(points), pixel_grid(SIZE), atol=1e-5)


def test_light_through_a_port_takes_the_shortest_time():
    """Fermat's principle: no other way from the point to the lens is faster."""
    off, z = 37.0, 90.0
    slope = float(air_slope(PORT, np.array(off), np.array(z)))
    inner = PORT.gap_cm * slope

    def time(first, second):
        air = np.hypot(PORT.gap_cm, first)
        glass = PORT.glass_index * np.hypot(PORT.glass_cm, second - first)
        return air + glass + PORT.water_index * np.hypot(z - PORT.front_cm, off - second)

    sine = slope / np.hypot(1.0, slope) / PORT.glass_index
    outer = inner + PORT.glass_cm * sine / np.sqrt(1.0 - sine**2)
    best = time(inner, outer)
    for change in (-0.01, 0.01):
        assert time(inner + change, outer) > best
        assert time(inner, outer + change) > best


def test_water_magnifies_by_its_index_near_the_axis():
    plain, behind = Optics(SIZE, 60.0), Optics(SIZE, 60.0, port=FlatPort(0.0, 0.0))
    point = np.array([1.0, 0.5, 1000.0])
    ratio = (behind.project(point) - plain.middle) / (plain.project(point) - plain.middle)
    np.testing.assert_allclose(ratio, 1.333, rtol=1e-5)


def test_rays_near_the_axis_seem_to_meet_at_the_virtual_centre():
    begin, way = Optics(SIZE, 5.0, port=PORT).rays(np.array([[90.0, 60.0]]))
    crosses = begin[0, 2] - begin[0, 0] / way[0, 0]
    assert crosses == pytest.approx(PORT.virtual_cm, abs=1e-3)


@pytest.mark.parametrize("port", [None, PORT])
def test_a_remapped_depth_map_agrees_with_exact_projection(port):
    """A slanted plane is drawn by the pinhole of the canvas, and remapped."""
    optics = Optics(SIZE, 75.0, BARREL, port)
    canvas = canvas_of(optics)
    ways = canvas.optics.points(np.ones(canvas.size[::-1]))
    # The plane n·p = 200 in the axes of the camera.
    n = np.array([0.3, -0.2, 1.0])
    depth = (200.0 - n[2] * canvas.ahead_cm) / (ways @ n)
    place = sources(optics, canvas, depth)
    assert (place >= -0.5).all()
    assert (place <= np.array(canvas.size) - 0.5).all()
    x, y = ((place - (np.array(canvas.size) - 1) / 2) / canvas.focal_px)[..., 0:2].swapaxes(0, -1)
    z = (200.0 - n[2] * canvas.ahead_cm) / (n[0] * x.T + n[1] * y.T + n[2])
    seen = np.stack([x.T * z, y.T * z, z + canvas.ahead_cm], axis=-1)
    off = np.linalg.norm(optics.project(seen) - pixel_grid(SIZE), axis=-1)
    assert off.max() < 0.02


def test_the_canvas_is_as_fine_as_the_picture():
    optics = Optics(SIZE, 75.0, BARREL, PORT)
    place = sources(optics, canvas_of(optics), np.full(canvas_of(optics).size[::-1], np.inf))
    assert np.linalg.norm(np.diff(place, axis=1), axis=-1).min() > 0.99


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"field_deg": 0.0}, "field_deg"),
        ({"field_deg": 171.0}, "field_deg"),
        ({"lens": CameraLens(k1=np.nan)}, "finite"),
        ({"port": FlatPort(-1.0)}, "port"),
    ],
)
def test_a_camera_that_cannot_be_is_an_error(change, message):
    with pytest.raises(ValueError, match=message):
        Optics(**{"size": SIZE, "field_deg": 70.0} | change)


def test_a_lens_that_folds_within_the_picture_is_an_error():
    with pytest.raises(ValueError, match="folds"):
        canvas_of(Optics(SIZE, 110.0, CameraLens(k1=-0.6)))
