"""Light spreads around what is very bright, and around nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from subsea.rendering.output.quality import PRESETS
from subsea.rendering.output.target import BLOOM_ROWS, Bloom, ResolvePass
from subsea.view.display_rigs import display_rig

SIZE = WIDE, HIGH = 640, 320
LEAST = 1.6  # as in the shader


@pytest.fixture
def bloom_of(context):
    """Light (h, w) of a part of a canvas -> its bloom (rows, columns)."""
    bloom = Bloom(context)

    def bloom_of(light, part=(0, 0, *SIZE)):
        rgb = np.repeat(light[..., None], 4, axis=2).astype("f2")
        canvas = context.texture(light.shape[::-1], 4, rgb.tobytes(), dtype="f2")
        canvas.repeat_x = canvas.repeat_y = False
        found = bloom.draw(canvas, part)
        data = np.frombuffer(found.read(), np.float16).reshape(*found.size[::-1], 4)
        canvas.release()
        return data[..., 1].astype(float)

    yield bloom_of
    bloom.release()


def test_what_can_be_shown_does_not_bloom(bloom_of):
    assert not bloom_of(np.full((HIGH, WIDE), LEAST)).any()


def test_the_light_above_that_is_kept_and_spread_evenly(bloom_of):
    np.testing.assert_allclose(bloom_of(np.full((HIGH, WIDE), LEAST + 2.0)), 2.0, rtol=0.01)
    light = np.zeros((HIGH, WIDE))
    light[HIGH // 2 - 8 : HIGH // 2 + 8, WIDE // 2 - 8 : WIDE // 2 + 8] = LEAST + 4.0
    found = bloom_of(light)
    cell = HIGH / len(found)
    assert found.sum() * cell * cell == pytest.approx(4.0 * 16 * 16, rel=0.02)
    np.testing.assert_allclose(found, found[::-1], atol=1e-3)
    np.testing.assert_allclose(found, found[:, ::-1], atol=1e-3)
    middle, column = len(found) // 2, found.shape[1] // 2
    row = found[middle, column:]
    assert (np.diff(row) <= 1e-3).all() and row[4] > 0.1 * row[0] > 0.0
    assert not found[0].any()  # not milk


def test_a_glint_lights_up_little_however_bright(bloom_of):
    light = np.zeros((HIGH, WIDE))
    light[100, 200] = 1000.0
    assert bloom_of(light).max() < 0.1


def test_only_the_part_of_the_canvas_counts(bloom_of):
    light = np.zeros((HIGH, 2 * WIDE))
    light[:, :WIDE] = 9.0
    assert not bloom_of(light, (WIDE + 64, 0, WIDE - 64, HIGH)).any()
    assert (bloom_of(light, (0, 0, WIDE, HIGH)) > 1.0).all()


@pytest.mark.parametrize(("size", "rows"), [((1280, 720), 180), ((3840, 2160), 135), ((5, 3), 1)])
def test_it_is_small_whatever_the_size_of_the_picture(context, size, rows):
    bloom, canvas = Bloom(context), context.texture(size, 4, dtype="f2")
    found = bloom.draw(canvas, (0, 0, *size))
    assert found.size[1] == rows <= BLOOM_ROWS
    bloom.release()
    canvas.release()


@pytest.mark.parametrize("display", ["mono", "side-by-side", "anaglyph", "dome"])
def test_pictures_of_several_eyes_or_sides_have_none(context, display):
    rig = display_rig(display, SIZE)
    wide, high = rig.canvas
    light = np.full((high, wide, 4), 0.3)
    light[high // 3 : high // 2, wide // 3 : wide // 2] = 20.0
    canvas = context.texture(rig.canvas, 4, light.astype("f2").tobytes(), dtype="f2")
    canvas.repeat_x = canvas.repeat_y = False
    target = context.simple_framebuffer(SIZE)
    pictures = []
    for bloom in (False, True):
        resolve = ResolvePass(context, rig.patches)
        resolve.adapt(replace(PRESETS["high"], bloom=bloom, smooth=False))
        for number in range(len(rig.patches)):
            resolve.draw(canvas, target, SIZE, number)
        pictures.append(target.read())
        resolve.release()
    assert (pictures[0] == pictures[1]) == (display != "mono")
    for thing in (canvas, target):
        thing.release()
