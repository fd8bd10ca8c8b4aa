"""A camera is found by what it sees, whatever its lens."""

import numpy as np
import pytest

from subsea.stage.calibration.meshes import measure_projector
from subsea.stage.calibration.optics import (
    FISHEYE,
    ORDINARY,
    ReferencePoint,
    SeenLight,
    fit_projector,
    solve_camera,
)
from subsea.stage.calibration.surface import LitSurface
from subsea.stage.theatre.screens import Curved
from tests.support.daily import only
from tests.support.lit_room import LampLens, look

SIZE = 320, 200
SPHERE = LitSurface(None, 400.0, 20.0)
CYLINDER = LitSurface(Curved((0.0, 20.0), 300.0, -1.0, 1.0, -100.0, 100.0))


@pytest.mark.parametrize(
    ("lens", "bend"), [(ORDINARY, (-0.2, 0.05)), (ORDINARY, (0.1, 0.0)), (FISHEYE, (-0.05, 0.004))]
)
def test_rays_and_pixels_are_inverse(lens, bend):
    camera = look((10, 20, 30), (0, 100, 400), (900, 600), lens, 400, bend, (5, -7))
    pixels = np.random.default_rng(1).uniform((0, 0), (900, 600), (300, 2))
    seen = camera.seen(camera.place + 700.0 * camera.rays(pixels))
    np.testing.assert_allclose(seen, pixels, atol=1e-3)


def hung(place, target, half, bend):
    """A projector at a place that shines at a point."""
    axes = look(place, target, SIZE, ORDINARY, 1.0).axes
    return LampLens(np.array(place), axes, half, SIZE, bend=bend)


def blocks(lamp, surface, camera, channel=0, noise_px=0.15):
    """The blocks that a camera sees of a projector, without photographs."""
    x, y = (np.linspace(2, side - 2, 40) for side in lamp.size)
    shown = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    points = surface.meet(lamp.place, lamp.rays(shown))
    pixels = camera.seen(points)
    inside = ((pixels > 0) & (pixels < camera.size)).all(axis=1)
    error = np.random.default_rng(2).normal(0, noise_px, (inside.sum(), 2))
    light = np.zeros((inside.sum(), 7, 3))
    return SeenLight(channel, 0, pixels[inside], shown[inside] + error, light)


def test_a_projector_is_a_lens_with_distortion():
    lamp = LampLens(np.array([30.0, 120.0, -50.0]), np.eye(3), (0.5, 0.3), SIZE, bend=0.02)
    shown = np.random.default_rng(3).uniform((0, 0), SIZE, (500, 2))
    points = CYLINDER.meet(lamp.place, lamp.rays(shown))
    fitted, error = fit_projector(CYLINDER, points, shown, SIZE, 0.02)
    assert np.abs(error).max() < 1e-5
    places = CYLINDER.places(points)
    np.testing.assert_allclose(fitted.pixels(CYLINDER, places), fitted.straight(shown), atol=1e-5)
    assert np.abs(fit_projector(CYLINDER, points, shown, SIZE, 0.0)[1]).max() > 0.4


@pytest.mark.parametrize("share", [0.1, 0.25, 0.35])
def test_light_that_was_reflected_does_not_move_a_projector(share):
    """A part of the picture falls by way of a glossy floor on another part of the screen."""
    lamp = LampLens(np.array([30.0, 120.0, -50.0]), np.eye(3), (0.5, 0.3), SIZE, bend=0.02)
    random = np.random.default_rng(4)
    shown = random.uniform((0, 0), SIZE, (500, 2))
    points = CYLINDER.meet(lamp.place, lamp.rays(shown))
    lower = shown[:, 1] > np.quantile(shown[:, 1], 1.0 - share)
    points[lower, 1] = 2.0 * points[lower, 1].max() + 20.0 - points[lower, 1]
    shown += random.normal(0.0, 0.15, shown.shape)
    error = fit_projector(CYLINDER, points, shown, SIZE, 0.02)[1]
    assert np.sqrt(np.mean(error[~lower] ** 2)) < 0.2
    assert np.hypot(*error[lower].T).min() > 5.0


@pytest.mark.parametrize("kind", only(["dome"], ["cylinder", "dome"]))
def test_lens_and_place_follow_from_points_and_light(kind):
    if kind == "cylinder":
        surface, camera = (
            CYLINDER,
            look((30, 20, -150), (0, 0, 300), (1200, 800), ORDINARY, 700, (-0.15, 0.03), (6, -9)),
        )
        places = np.array([(s, t) for s in (0.1, 0.5, 0.9) for t in (0.1, 0.9)])
        at = surface.points(places)
        lamps = [
            hung((x, 130.0, 0.0), (2 * x, 0.0, 300.0), (0.45, 0.3), 0.01) for x in (-80.0, 80.0)
        ]
    else:
        surface, camera = (
            SPHERE,
            look(
                (20, -30, 25), (30, 400, 120), (1200, 1200), FISHEYE, 370, (-0.03, 0.003), (6, -9)
            ),
        )
        turns = np.radians(np.arange(0, 360, 60))
        rays = np.stack([np.sin(turns), np.full(6, 0.3), np.cos(turns)], axis=1)
        at = 400.0 * np.vstack([rays / np.hypot(1, 0.3), [0, 1, 0]])
        lamps = [
            hung((-0.8 * x, 0.0, -200.0), (x, 250.0, 150.0), (0.55, 0.35), -0.01)
            for x in (-150.0, 150.0)
        ]
    marked = camera.seen(at) + np.random.default_rng(4).normal(0, 0.2, (len(at), 2))
    points = [ReferencePoint(f"{k}", *pair) for k, pair in enumerate(zip(at, marked, strict=True))]
    seen = [blocks(lamp, surface, camera, k) for k, lamp in enumerate(lamps)]
    sizes = dict.fromkeys(range(2), SIZE)
    solved = solve_camera(camera.size, points, seen, dict.fromkeys(range(2), surface), sizes)
    assert solved.point_px.max() < 1.0 and solved.light_px < 0.4
    for lamp, one in zip(lamps, seen, strict=True):
        measured = measure_projector(surface, SIZE, [(one, solved.camera)])
        x, y = np.meshgrid(*measured.corners)
        shown = np.column_stack([x.ravel(), y.ravel()])
        true = surface.meet(lamp.place, lamp.rays(shown))
        away = np.linalg.norm(surface.points(measured.nodes.reshape(-1, 2)) - true, axis=1)
        pixel = np.linalg.norm(true - surface.meet(lamp.place, lamp.rays(shown + [1, 0])), axis=1)
        known = measured.known.ravel()
        assert np.sqrt(np.mean((away / pixel)[known] ** 2)) < 0.7
