"""Theatre outputs: seams, blending, both eyes, and the direction of every pixel."""

import numpy as np
import pytest

from subsea.rendering.output.quality import PRESETS
from subsea.rendering.output.target import ResolvePass
from subsea.rendering.renderer import Renderer
from subsea.stage.setup import shrink_theatre
from subsea.stage.theatre.channels import usable_channels
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.screens import points_on
from subsea.stage.theatre.theatre_rig import theatre_rig
from subsea.stage.theatre.warp import mesh
from subsea.view.rig import CUBES, CameraRig, DisplayPatch, pose_from_angles, views
from subsea.view.structured_light import (
    UNIFORM,
    bare,
    light_patterns,
    light_picture,
    lit_picture,
)
from subsea.view.surround import Surround, directions
from subsea.view.test_pattern import lineup

EYE = np.array([0.0, -120.0, -200.0])
GAMMA = 2.2
SMALL = 10  # times fewer pixels than the theatres that are shipped


def opened(tmp_path, name="three-projectors", display="mono", shrink=SMALL):
    """A theatre with a tenth of its pixels, its channels and its rig."""
    theatre = shrink_theatre(load_theatre(name)[0], shrink)
    found, faults = usable_channels(theatre, tmp_path / "theatre.toml")
    assert not faults
    return theatre, found, theatre_rig(theatre, found, range(len(theatre.window)), display)


def shown(context, rig, canvas):
    """The outputs (h, w, 3) of a rig that shows a given canvas (h, w, 3)."""
    data = np.ascontiguousarray(canvas, "f2").tobytes()
    texture = context.texture(rig.canvas, 3, data, dtype="f2", alignment=1)
    resolve, found = ResolvePass(context, rig.patches), []
    for output, size in enumerate(rig.outputs):
        target = context.simple_framebuffer(size)
        target.clear()
        for number, patch in enumerate(rig.patches):
            if patch.output == output:
                resolve.draw(texture, target, size, number, unit=None)
        data = np.frombuffer(target.read(alignment=1), np.uint8)
        found.append(data.reshape(size[1], size[0], 3)[::-1] / 255.0)
        context.detect_framebuffer(0).use()  # the next framebuffer must not follow a freed one
        target.release()
    resolve.release()
    texture.release()
    return found


def on_the_screen(one, size):
    """Positions of the pixels of a channel (h, w, 3) on its screen, upper row first."""
    x, y = (np.arange(n) + 0.5 for n in size)
    places = np.stack(np.meshgrid(x / size[0], 1 - y / size[1]), axis=-1).reshape(-1, 2)
    return points_on(one.screen, places).reshape(size[1], size[0], 3)


@pytest.mark.parametrize("name", ["three-projectors", "cave"])
def test_every_pixel_shows_what_lies_behind_its_place_on_the_screen(
    context, tmp_path, name, directions_on
):
    """Frusta, mesh and shader agree with the geometry, so neighbours agree as well."""
    theatre, found, rig = opened(tmp_path, name)
    bare = rig._replace(patches=tuple(patch._replace(mask=None) for patch in rig.patches))
    canvas = directions_on(rig, pose_from_angles(np.zeros(3), 0.3, 0.1))
    for one, picture in zip(found, shown(context, bare, canvas), strict=True):
        points = on_the_screen(one, theatre.window[one.window].size)
        d = points / np.linalg.norm(points, axis=-1, keepdims=True)
        np.testing.assert_allclose(2 * picture - 1, d, atol=0.012)  # eight bits and the grain


def test_in_the_overlap_neighbours_show_the_same(context, scene, make_packet, fish, tmp_path):
    """Pictures before blending: where projectors overlap, they show the same."""
    theatre, _, rig = opened(tmp_path, shrink=5)
    bare = rig._replace(patches=tuple(patch._replace(mask=None) for patch in rig.patches))
    renderer = Renderer(context, scene, bare, PRESETS["high"])
    seen = views(bare, pose_from_angles(EYE, np.pi / 2, 0.0))
    renderer.draw(make_packet([fish(0, (-70, 60, -200)), fish(1, (60, 60, -190))], views=seen))
    left, middle = (renderer.read_pixels(k).astype(float) for k in (0, 1))
    renderer.release()
    width = theatre.window[0].size[0]
    overlap = round(width * 160 / 1440)
    ours, theirs = left[:, -overlap:], middle[:, :overlap]
    # The same places of the screen, sampled by different views: edges differ by part of a pixel.
    assert np.abs(ours - theirs).mean() < 3.0
    shifted = left[:, -overlap - 6 : -6]
    assert np.abs(ours - theirs).mean() < 0.6 * np.abs(shifted - theirs).mean()
    assert ours.std() > 10.0


@pytest.mark.parametrize("level", [1.0, 0.5])
def test_blended_luminance_is_constant_within_two_percent(context, tmp_path, level):
    theatre, _, rig = opened(tmp_path, shrink=4)
    canvas = np.full((rig.canvas[1], rig.canvas[0], 3), level)
    pictures = shown(context, rig, canvas)
    light = [picture.mean(axis=2).mean(axis=0) ** GAMMA for picture in pictures]
    turn = [np.array([(c.cylinder.left_deg, c.cylinder.right_deg)]) for c in theatre.channel]
    angle = np.linspace(turn[0][0, 0] + 0.1, turn[-1][0, 1] - 0.1, 700)
    total = np.zeros_like(angle)
    for one, row in zip(turn, light, strict=True):
        (left, right), count = one[0], len(row)
        pixel = (angle - left) / (right - left) * count - 0.5
        inside = (pixel > -0.5) & (pixel < count - 0.5)
        total += np.where(inside, np.interp(pixel, np.arange(count), row), 0.0)
    np.testing.assert_allclose(total, level**GAMMA, rtol=0.02)
    assert min(row.min() for row in light) < 0.1 * level**GAMMA  # it was blended at all


def test_gammas_for_each_colour_give_the_light_of_the_usual_one(context):
    place, levels = (0, 0, 5, 1), np.array([0.0, 0.1, 0.3, 0.6, 1.0])
    gammas = np.array([1.8, 2.2, 2.6])
    mask = np.tile([0.9, 0.8, 0.7, 0.05], (1, 5, 1)).astype(np.float32)
    for added in (None, mask):
        patch = DisplayPatch(place, place, place, mask=added, gamma=tuple(gammas.tolist()))
        rig = CameraRig((5, 1), ((5, 1),), (), (patch,))
        (picture,) = shown(context, rig, np.repeat(levels, 3).reshape(1, 5, 3))
        light = np.repeat(levels[:, None] ** 2.2, 3, axis=1)
        if added is not None:
            light = light * np.array([0.9, 0.8, 0.7]) ** gammas + 0.05
        np.testing.assert_allclose(picture[0], light ** (1 / gammas), atol=1.1 / 255)


def test_structured_light_comes_from_one_projector_pixel_by_pixel(context, tmp_path):
    _, _, rig = opened(tmp_path)
    assert all(patch.mask is not None and patch.warp is not None for patch in rig.patches)
    plain, number = bare(rig), len(UNIFORM) + 6  # of a pattern of columns
    picture = lit_picture(plain, 1, number)
    plain = plain._replace(canvas=picture.shape[1::-1])
    left, middle, right = shown(context, plain, picture / 255)
    size = plain.patches[1].place[2:]
    stripes = light_picture(light_patterns(size)[number], size) / 255
    np.testing.assert_allclose(middle, stripes, atol=1.1 / 255)
    assert max(left.max(), right.max()) < 1.1 / 255


@pytest.mark.parametrize("gamma", [1.8, 2.4])
def test_a_mask_adds_light_not_values(context, gamma):
    place, levels = (0, 0, 5, 1), np.array([0.0, 0.1, 0.3, 0.6, 1.0])
    mask = np.tile([0.9, 0.8, 0.7, 0.05], (1, 5, 1)).astype(np.float32)
    patch = DisplayPatch(place, place, place, mask=mask, gamma=gamma)
    rig = CameraRig((5, 1), ((5, 1),), (), (patch,))
    (picture,) = shown(context, rig, np.repeat(levels, 3).reshape(1, 5, 3))
    light = (levels[:, None] * [0.9, 0.8, 0.7]) ** gamma + 0.05
    np.testing.assert_allclose(picture[0], light ** (1 / gamma), atol=1.1 / 255)


@pytest.mark.parametrize("name", ["dome", "equirectangular"])
def test_in_stereo_a_dome_shows_each_eye_the_ray_through_its_screen(
    context, tmp_path, name, directions_on
):
    """Both eyes' pictures coincide at the screen's distance, in all directions."""
    _, found, rig = opened(tmp_path, name, "top-bottom", shrink=16)
    mono = opened(tmp_path, name, shrink=16)[2]
    assert rig.patches[0].shape in CUBES
    observer = pose_from_angles(np.zeros(3), 0.3, 0.0)
    far = found[0].distance_cm
    straight = directions_on(mono, observer)
    (middle,) = shown(context, mono, straight)
    (both,) = shown(context, rig, directions_on(rig, observer))
    height = both.shape[0] - both.shape[0] // 2
    for half, side in ((both[:height], -1), (both[height:], 1)):
        d = 2 * middle - 1
        lit = np.abs(np.linalg.norm(d, axis=-1) - 1.0) < 0.2  # beyond a dome it is dark
        rows = np.round((np.arange(len(half)) + 0.5) * len(d) / len(half) - 0.5).astype(int)
        expected = far * d[rows] - [side * 3.2, 0.0, 0.0]
        expected /= np.linalg.norm(expected, axis=-1, keepdims=True)
        inside = lit[rows] & (np.abs(np.linalg.norm(2 * half - 1, axis=-1) - 1.0) < 0.2)
        error = np.abs(2 * half - 1 - expected)[inside]
        assert np.percentile(error, 95) < 0.03  # rows of the halves lie between those of the whole


def test_what_a_mesh_leaves_of_a_dome_is_dark(context, scene, make_packet, tmp_path):
    _, _, rig = opened(tmp_path, "dome", shrink=16)
    triangle = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    half = mesh(triangle, triangle, np.array([[0, 1, 2]]))
    rig = rig._replace(patches=tuple(patch._replace(warp=half) for patch in rig.patches))
    renderer = Renderer(context, scene, rig)
    packet = make_packet([], views=views(rig, pose_from_angles(EYE, 0.0, 0.0)))
    for picture in renderer.pictures.values():  # as what was shown before has left it
        picture.write(b"\xff" * 4 * picture.width * picture.height)
    renderer.draw(packet)
    shown = renderer.read_pixels()
    renderer.release()
    size = len(shown)
    row, column = np.mgrid[:size, :size] + 0.5
    assert (shown[column - row > 2] == 0).all()  # above the diagonal, which falls to the right
    lit = np.hypot(column - size / 2, row - size / 2) < 0.45 * size
    assert (shown[(column - row < -2) & lit].max(axis=1) > 0).mean() > 0.9


@pytest.mark.parametrize(
    ("name", "display"),
    [("three-projectors", "mono"), ("three-projectors", "anaglyph-comfort"), ("cave", "mono")],
)
def test_theatres_as_they_are_shown(
    context, scene, make_packet, fish, same_picture, tmp_path, name, display
):
    _, _, rig = opened(tmp_path, name, display)
    renderer = Renderer(context, scene, rig)
    fishes = [fish(1, (0, 45, -200)), fish(0, (-75, 22, -205)), fish(0, (60, 12, -190))]
    renderer.draw(make_packet(fishes, views=views(rig, pose_from_angles(EYE, np.pi / 2, 0.0))))
    pictures = [renderer.read_pixels(k) for k in range(len(rig.outputs))]
    same_picture(f"theatre-{name}-{display}", np.hstack(pictures))
    assert context.error == "GL_NO_ERROR"
    renderer.release()


def test_the_pattern_that_lines_up_three_projectors(context, scene, same_picture, tmp_path):
    _, _, rig = opened(tmp_path, shrink=6)
    renderer = Renderer(context, scene, rig)
    renderer.show(lineup(rig))
    same_picture("pattern", np.hstack([renderer.read_pixels(k) for k in range(len(rig.outputs))]))
    renderer.release()


def test_a_dome_of_another_angle_shows_the_directions_of_its_pixels(
    context, tmp_path, directions_on
):
    """Shader and `surround.directions` agree, as for half a sphere."""
    path = tmp_path / "theatre.toml"
    path.write_text(
        '[[window]]\nname = "a"\nsize = [160, 120]\n[[channel]]\nname = "a"\nwindow = "a"\n'
        "dome = { tilt_deg = 20, angle_deg = 220 }\n"
    )
    theatre = load_theatre(str(path))[0]
    (one,), _ = usable_channels(theatre, path)
    rig = theatre_rig(theatre, [one], [0])
    (picture,) = shown(context, rig, directions_on(rig, pose_from_angles(np.zeros(3), 0.0, 0.0)))
    x, y = np.meshgrid(np.arange(160) + 0.5, 120 - (np.arange(120) + 0.5))
    pixels = np.column_stack([x.ravel(), y.ravel()])
    expected = directions("dome", (160, 120), Surround(tilt_deg=20.0, dome_deg=220.0), pixels)
    inside = np.hypot(*(pixels - [80, 60]).T) < 57
    found = (2 * picture - 1).reshape(-1, 3)
    np.testing.assert_allclose(found[inside], expected[inside], atol=0.03)
    assert (picture.reshape(-1, 3)[np.hypot(*(pixels - [80, 60]).T) > 62] == 0).all()
