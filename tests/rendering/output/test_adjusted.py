"""Adjusted patches on the screen: moved by pixels, turned, masked and coloured."""

import numpy as np
import pytest

from subsea.rendering.output.marks import MarkRenderer
from subsea.rendering.output.target import ResolvePass
from subsea.stage.theatre.adjusting import patch_adjustment
from subsea.stage.theatre.theatre_file import Adjustment, Corners
from subsea.view.rig import DisplayPatch, Projection

SIZE = (120, 80)


def waves(size=SIZE):
    """A canvas (h, w, 3) of smooth waves, top row first."""
    x, y = np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5)
    light = 0.5 + 0.2 * np.sin(x / 5.0) + 0.2 * np.cos(y / 6.0 + x / 11.0)
    return np.stack([light, 0.9 * light, 0.8 * light], axis=-1)


@pytest.fixture
def shown(context):
    """(adjustment, fields of the patch) -> grey levels (h, w, 3), top row first."""

    def shown(adjustment, size=SIZE, canvas=None, marks=None, **fields):
        canvas = waves() if canvas is None else canvas
        place = (0, 0, *size)
        source = (0, 0, canvas.shape[1], canvas.shape[0])
        upright = size if adjustment is None or adjustment.rotate % 180 == 0 else size[::-1]
        made = None if adjustment is None else patch_adjustment(adjustment, upright)
        patch = DisplayPatch(place, source, source, adjustment=made, **fields)
        data = np.ascontiguousarray(canvas[::-1], "f2").tobytes()
        texture = context.texture(source[2:], 3, data, dtype="f2", alignment=1)
        texture.repeat_x = texture.repeat_y = False
        target = context.simple_framebuffer(size)
        target.clear()
        resolve = ResolvePass(context, [patch])
        resolve.draw(texture, target, size, 0, unit=None)
        if marks is not None:
            drawn = MarkRenderer(context)
            drawn.draw(marks, place)
            drawn.release()
        data = np.frombuffer(target.read(alignment=1), np.uint8)
        context.detect_framebuffer(0).use()
        for thing in (texture, target, resolve):
            thing.release()
        return data.reshape(size[1], size[0], 3)[::-1].astype(float)

    return shown


def everywhere(right, down):
    return Corners(**dict.fromkeys(Corners.__struct_fields__, (right, down)))


@pytest.mark.parametrize(
    "adjustment",
    [
        Adjustment(corners_px=everywhere(7, -4)),
        Adjustment(points_px=[[(7, -4)] * 3] * 2),
        Adjustment(corners_px=everywhere(10, 0), points_px=[[(-3, -4)] * 4] * 4),
    ],
)
def test_a_picture_moves_by_that_many_pixels_and_leaves_black_behind(shown, adjustment):
    before, after = shown(None), shown(adjustment)
    assert np.abs(after[:-4, 7:] - before[4:, :-7]).max() <= 1.0
    assert after[:, :6].max() <= 1.0
    assert after[-3:].max() <= 1.0


def test_a_moved_corner_moves_its_surroundings_and_leaves_the_others(shown):
    before = shown(None)
    after = shown(Adjustment(corners_px=Corners(upper_left=(6, 3))))
    # The picture's own corner is now 6 pixels to the right and 3 down; beyond it is dark.
    assert after[1, :5].max() <= 1.0
    assert np.abs(after[4, 8] - before[0, 1]).max() < 12.0
    for corner in ((0, -1), (-1, 0), (-1, -1)):
        assert np.abs(after[corner] - before[corner]).max() <= 12.0
    # Along a homography: a place is lit where the matrix says.
    made = patch_adjustment(Adjustment(corners_px=Corners(upper_left=(6, 3))), SIZE)
    x, y, w = made.corners @ [0.3, 0.6, 1.0]
    column, row = x / w * SIZE[0], (1.0 - y / w) * SIZE[1]
    assert after[int(row), int(column)] == pytest.approx(before[32, 36], abs=10.0)


def test_half_a_pixel_moves_the_picture_by_half(shown):
    before, after = shown(None), shown(Adjustment(corners_px=everywhere(0.5, 0)))
    mixed = (before[:, 1:] + before[:, :-1]) / 2.0
    assert np.abs(after[:, 1:] - mixed).max() <= 1.5


@pytest.mark.parametrize(
    ("adjustment", "turned"),
    [
        (Adjustment(flip="horizontal"), lambda p: p[:, ::-1]),
        (Adjustment(flip="vertical"), lambda p: p[::-1]),
        (Adjustment(rotate=180), lambda p: p[::-1, ::-1]),
        (Adjustment(flip="horizontal", rotate=180), lambda p: p[::-1]),
        (Adjustment(rotate=90), lambda p: np.rot90(p, -1)),
        (Adjustment(rotate=270), np.rot90),
        (Adjustment(flip="horizontal", rotate=90), lambda p: np.rot90(p[:, ::-1], -1)),
    ],
)
def test_pictures_are_mirrored_and_turned(shown, adjustment, turned):
    before = shown(None)
    size = SIZE if adjustment.rotate % 180 == 0 else SIZE[::-1]
    assert np.abs(shown(adjustment, size) - turned(before)).max() <= 1.0


def test_a_shift_is_one_that_the_audience_sees(shown):
    """Right is right on the wall, whatever the projector's own right is."""
    before = shown(None)
    after = shown(Adjustment(flip="horizontal", corners_px=everywhere(9, 0)))
    assert np.abs(after[:, ::-1][:, 9:] - before[:, :-9]).max() <= 1.0


def test_a_blend_moves_with_its_picture(shown):
    mask = np.ones((80, 120, 4), np.float32)
    mask[:, :60, :3], mask[..., 3] = 0.0, 0.0
    white = np.ones((80, 120, 3))
    after = shown(Adjustment(corners_px=everywhere(10, 0)), canvas=white, mask=mask)
    assert after[:, :68].max() <= 2.0
    assert after[:, 72:].min() >= 253.0


@pytest.mark.parametrize("flip", [None, "horizontal"])
def test_it_is_dark_beyond_the_edge_mask_which_stays(shown, flip):
    triangle = [(10, 10), (100, 10), (10, 70)]
    white = np.ones((80, 120, 3))
    for corners in (None, everywhere(5, 0)):
        adjustment = Adjustment(edge_mask=triangle, edge_soft_px=1, flip=flip, corners_px=corners)
        after = shown(adjustment, canvas=white)[..., 1]
        after = after[:, ::-1] if flip else after
        x, y = np.meshgrid(np.arange(120) + 0.5, np.arange(80) + 0.5)
        away = np.minimum(
            np.minimum(x - 10, y - 10), (0.5 * (60 * (100 - x) - 90 * (y - 10)) / 54.1)
        )
        assert after[away > 1.5].min() >= 253.0
        assert after[away < -1.5].max() <= 1.0


def test_the_edge_mask_fades_in_light(shown):
    square = [(40, -500), (500, -500), (500, 500), (40, 500)]
    white = np.ones((80, 120, 3))
    after = shown(Adjustment(edge_mask=square, edge_soft_px=40), canvas=white, gamma=2.0)[40, :, 0]
    light = (after / 255.0) ** 2.0
    wanted = np.clip(0.5 + (np.arange(120) + 0.5 - 40) / 40, 0, 1)
    assert np.abs(light - wanted).max() < 0.01


def test_gain_is_a_factor_on_light(shown):
    grey = np.full((80, 120, 3), 0.8)
    after = shown(Adjustment(gain=(1.0, 0.5, 0.0)), canvas=grey, gamma=2.2)[40, 60] / 255.0
    assert after[0] == pytest.approx(0.8, abs=0.005)
    assert after[1] ** 2.2 == pytest.approx(0.5 * 0.8**2.2, abs=0.005)
    assert after[2] < 0.005


@pytest.mark.parametrize(
    "shape", [Projection.DOME, Projection.EQUIRECTANGULAR, Projection.PANORAMA]
)
def test_a_surround_picture_that_is_not_moved_is_the_same_through_a_mesh(shown, shape):
    canvas = waves((96, 64))
    before = shown(None, canvas=canvas, shape=shape)
    after = shown(Adjustment(rotate=180), canvas=canvas, shape=shape)
    assert np.abs(after[::-1, ::-1] - before).mean() < 1.0
    assert before.max() > 50.0


def test_marks_lie_over_the_picture(shown):
    corners = np.array([[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.0], [0.5, 0.5], [0.0, 0.5]])
    marks = np.column_stack([corners, np.tile([1.0, 0.0, 0.5], (6, 1))])
    before, after = shown(None), shown(None, marks=marks)
    assert (after[41:, :59] == [255.0, 0.0, 128.0]).all()
    np.testing.assert_array_equal(after[:39], before[:39])
