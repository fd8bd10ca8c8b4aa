"""Wide pictures join the faces of a cube without a seam."""

import numpy as np
import pytest

from subsea.render import Renderer
from subsea.render.output.target import ResolvePass
from subsea.view.display_rigs import display_rig
from subsea.view.rig import pose_from_angles
from subsea.view.surround import ALL_ROUND, Surround, directions
from subsea.view.theatre.warp import mesh, sources_at

SIZES = {"equirectangular": (160, 80), "dome": (120, 100), "panorama": (160, 40)}


def shown(light):
    """Screen colours of linear light: filmic curve, with most of the hue, and sRGB."""
    peak = np.maximum(light.max(axis=-1, keepdims=True), 1e-4)
    x, top = (
        np.clip(y * (2.51 * y + 0.03) / (y * (2.43 * y + 0.59) + 0.14), 0, 1) for y in (light, peak)
    )
    x += (0.4 - 0.4 * top**2) * (light * top / peak - x)
    return 255 * np.where(x < 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


@pytest.mark.parametrize("display", SIZES)
@pytest.mark.parametrize("surround", [ALL_ROUND, Surround(angle_deg=300.0, tilt_deg=0.0)])
def test_every_pixel_shows_what_lies_in_its_direction(context, display, surround, directions_on):
    """Compare views and shader together with the closed form."""
    size = SIZES[display]
    rig = display_rig(display, size, surround=surround)
    canvas = directions_on(rig, pose_from_angles(np.zeros(3), 0.0, 0.0))
    picture = context.texture((canvas.shape[1], canvas.shape[0]), 3, canvas.astype("f2").tobytes(),
                              dtype="f2", alignment=1)  # fmt: skip
    target = context.simple_framebuffer(size)
    resolve = ResolvePass(context, rig.patches)
    resolve.draw(picture, target, size, 0)
    found = np.frombuffer(target.read(alignment=1), np.uint8).reshape(size[1], size[0], 3)
    row, column = np.mgrid[: size[1], : size[0]]
    d = directions(display, size, surround, np.stack([column + 0.5, row + 0.5], -1).reshape(-1, 2))
    light = shown(0.5 + 0.5 * d).reshape(found.shape)
    # Smoothing between the canvas' pixels, half precision and the grain: two grey levels.
    np.testing.assert_allclose(found, np.nan_to_num(light), atol=2.5)
    for held in (resolve, target, picture):
        held.release()


@pytest.mark.parametrize("display", SIZES)
def test_wide_pictures(context, scene, make_packet, fish, same_picture, display):
    fishes = [fish(1, (0, 45, -200)), fish(0, (45, 2, -205)), fish(0, (-30, -32, -190))]
    packet = make_packet(fishes, display=display, size=SIZES[display])
    renderer = Renderer(context, scene, display_rig(display, SIZES[display]))
    renderer.draw(packet)
    same_picture(display, renderer.read_pixels())
    renderer.release()


@pytest.mark.parametrize("display", SIZES)
def test_a_mesh_bends_a_wide_picture(context, display, directions_on):
    """A dome through a projector and mirror; the mesh of a dome has shares of a square."""
    size = SIZES[display]
    canvas = directions_on(display_rig(display, size), pose_from_angles(np.zeros(3), 0.0, 0.0))
    picture = context.texture((canvas.shape[1], canvas.shape[0]), 3, canvas.astype("f2").tobytes(),
                              dtype="f2", alignment=1)  # fmt: skip
    target = context.simple_framebuffer(size)
    target.clear()
    corners = np.array([[0.25, 0.0], [1.0, 0.0], [1.0, 1.0], [0.25, 1.0]])
    turned = np.array([[0.8, 0.2], [0.8, 0.9], [0.1, 0.9], [0.1, 0.2]])  # a quarter turn
    warp = mesh(corners, turned, np.array([[0, 1, 2], [0, 2, 3]]))
    rig = display_rig(display, size, surround=ALL_ROUND)
    resolve = ResolvePass(context, [rig.patches[0]._replace(warp=warp)])
    resolve.draw(picture, target, size, 0)
    found = np.frombuffer(target.read(alignment=1), np.uint8).reshape(size[1], size[0], 3)
    row, column = np.mgrid[: size[1], : size[0]]
    places = np.stack([(column + 0.5) / size[0], (row + 0.5) / size[1]], -1).reshape(-1, 2)
    shares = sources_at(warp, places)
    square = (size[1], size[1]) if display == "dome" else size
    d = directions(display, square, ALL_ROUND, np.nan_to_num(shares) * square)
    light = np.nan_to_num(shown(0.5 + 0.5 * d))
    light[np.isnan(shares[:, 0])] = 0.0
    assert (found[:, : size[0] // 4] == 0).all()
    np.testing.assert_allclose(found, light.reshape(found.shape), atol=2.5)
