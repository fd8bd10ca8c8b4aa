"""Wide pictures join the faces of a cube without a seam."""

import numpy as np
import pytest

from subsea.rendering.output.target import ResolvePass
from subsea.stage.theatre.warp import mesh
from subsea.view.display_rigs import display_rig
from subsea.view.rig import pose_from_angles, sources_at
from subsea.view.surround import ALL_ROUND, Surround, directions

SIZES = {"equirectangular": (160, 80), "dome": (120, 100), "panorama": (160, 40)}


def shown(light):
    """Screen colours of linear light: filmic curve, with most of the hue, and sRGB."""
    peak = np.maximum(light.max(axis=-1, keepdims=True), 1e-4)
    x, top = (
        np.clip(y * (2.51 * y + 0.03) / (y * (2.43 * y + 0.59) + 0.14), 0, 1) for y in (light, peak)
    )
    x += (0.4 - 0.4 * top**2) * (light * top / peak - x)
    return 255 * np.where(x < 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


@pytest.fixture
def resolved(context):
    """(canvas (h, w, 3), patch, size) -> the picture (h, w, 3), the lower row first."""

    def resolved(canvas, patch, size):
        canvas_size, light = canvas.shape[1::-1], canvas.astype("f2").tobytes()
        picture = context.texture(canvas_size, 3, light, dtype="f2", alignment=1)
        target, resolve = context.simple_framebuffer(size), ResolvePass(context, [patch])
        target.clear()
        resolve.draw(picture, target, size, 0)
        found = np.frombuffer(target.read(alignment=1), np.uint8).reshape(size[1], size[0], 3)
        for held in (resolve, target, picture):
            held.release()
        return found

    return resolved


@pytest.mark.parametrize("display", SIZES)
@pytest.mark.parametrize("surround", [ALL_ROUND, Surround(angle_deg=300.0, tilt_deg=0.0)])
def test_every_pixel_shows_what_lies_in_its_direction(resolved, display, surround, directions_on):
    """Compare views and shader together with the closed form."""
    size = SIZES[display]
    rig = display_rig(display, size, surround=surround)
    canvas = directions_on(rig, pose_from_angles(np.zeros(3), 0.0, 0.0))
    found = resolved(canvas, rig.patches[0], size)
    row, column = np.mgrid[: size[1], : size[0]]
    d = directions(display, size, surround, np.stack([column + 0.5, row + 0.5], -1).reshape(-1, 2))
    light = shown(0.5 + 0.5 * d).reshape(found.shape)
    # Smoothing between the canvas' pixels, half precision and the grain: two grey levels.
    np.testing.assert_allclose(found, np.nan_to_num(light), atol=2.5)


@pytest.mark.parametrize("display", SIZES)
def test_wide_pictures(drawn, make_packet, fish, same_picture, display):
    fishes = [fish(1, (0, 45, -200)), fish(0, (45, 2, -205)), fish(0, (-30, -32, -190))]
    packet = make_packet(fishes, display=display, size=SIZES[display])
    same_picture(display, drawn(packet, SIZES[display], display=display))


@pytest.mark.parametrize("display", SIZES)
def test_a_mesh_bends_a_wide_picture(resolved, display, directions_on):
    """A dome through a projector and mirror; the mesh of a dome has shares of a square."""
    size = SIZES[display]
    rig = display_rig(display, size)
    canvas = directions_on(rig, pose_from_angles(np.zeros(3), 0.0, 0.0))
    corners = np.array([[0.25, 0.0], [1.0, 0.0], [1.0, 1.0], [0.25, 1.0]])
    turned = np.array([[0.8, 0.2], [0.8, 0.9], [0.1, 0.9], [0.1, 0.2]])  # a quarter turn
    warp = mesh(corners, turned, np.array([[0, 1, 2], [0, 2, 3]]))
    found = resolved(canvas, rig.patches[0]._replace(warp=warp), size)
    row, column = np.mgrid[: size[1], : size[0]]
    places = np.stack([(column + 0.5) / size[0], (row + 0.5) / size[1]], -1).reshape(-1, 2)
    shares = sources_at(warp, places)
    square = (size[1], size[1]) if display == "dome" else size
    d = directions(display, square, ALL_ROUND, np.nan_to_num(shares) * square)
    light = np.nan_to_num(shown(0.5 + 0.5 * d))
    light[np.isnan(shares[:, 0])] = 0.0
    assert (found[:, : size[0] // 4] == 0).all()
    np.testing.assert_allclose(found, light.reshape(found.shape), atol=2.5)
