"""From linear light to the screen: the curve and the smoothing of edges."""

import numpy as np
import pytest

from subsea.rendering.output.target import ResolvePass
from subsea.scenario.schema import UNGRADED, Grade
from subsea.view.display_rigs import display_rig

SIZE = (48, 48)


@pytest.fixture
def resolved(context):
    """Linear light (h, w, 3) -> grey levels on the screen, smoothed or not."""
    held = []

    def resolved(light, smooth=False, grade=UNGRADED):
        height, width = light.shape[:2]
        picture = context.texture((width, height), 3, light.astype("f2").tobytes(), dtype="f2",
                                  alignment=1)  # fmt: skip
        picture.repeat_x = picture.repeat_y = False
        target = context.simple_framebuffer((width, height))
        patches = display_rig("mono", (width, height)).patches
        resolve = ResolvePass(context, patches, smooth, grade)
        resolve.draw(picture, target, (width, height), 0)
        held.extend((picture, target, resolve))
        data = np.frombuffer(target.read(alignment=1), np.uint8)
        return data.reshape(height, width, 3).astype(float)

    yield resolved
    for thing in held:
        thing.release()


def grey(light):
    return np.repeat(np.asarray(light, float)[..., None], 3, axis=2)


def test_black_is_black_white_is_white_and_more_light_is_never_darker(resolved):
    ramp = grey(np.tile(np.concatenate([[0.0], np.geomspace(1e-3, 100.0, 63)]), (4, 1)))
    shown = resolved(ramp)[2, :, 1]
    assert shown[0] <= 1.0
    assert shown[-1] == 255.0
    assert (np.diff(shown) >= -1.0).all()  # but for the grain
    assert np.ptp(resolved(ramp), axis=2).max() <= 1.0  # grey stays grey


@pytest.mark.parametrize("colour", [(0.6, 0.05, 0.3), (0.7, 0.35, 0.02), (0.02, 0.1, 0.5)])
def test_saturated_colours_keep_their_hue_and_what_is_bright_burns_out(resolved, colour):
    """The order of the channels stays; the brighter, the nearer to white."""
    light = np.array([1.0, 3.0, 40.0])[None, :, None] * np.array(colour)
    shown = resolved(np.tile(light, (2, 1, 1)))[0]
    order = np.argsort(colour)
    assert (np.diff(shown[:2][:, order], axis=1) > 10.0).all()
    ratio = shown.min(axis=1) / shown.max(axis=1)
    assert (np.diff(ratio) > 0.0).all()


RAMP = np.tile(np.geomspace(0.01, 0.9, 48), (4, 1))


def test_exposure_doubles_the_light_with_each_stop(resolved):
    brighter = resolved(grey(RAMP), grade=Grade(exposure_ev=1.0))
    np.testing.assert_allclose(brighter, resolved(grey(2.0 * RAMP)), atol=1.5)


def test_contrast_is_a_power_about_a_middle_grey(resolved):
    steep = resolved(grey(RAMP), grade=Grade(contrast=1.4))
    np.testing.assert_allclose(steep, resolved(grey(0.18 * (RAMP / 0.18) ** 1.4)), atol=1.5)
    middle = grey(np.full((2, 2), 0.18))
    np.testing.assert_allclose(
        resolved(middle, grade=Grade(contrast=1.7)), resolved(middle), atol=1.0
    )


def test_saturation_moves_colours_from_and_to_the_grey_of_their_luminance(resolved):
    light = np.tile(np.array([0.1, 0.3, 0.5]), (2, 2, 1))
    none = resolved(light, grade=Grade(saturation=0.0))
    assert np.ptp(none, axis=2).max() <= 1.0
    luminance = light @ (0.2126, 0.7152, 0.0722)
    np.testing.assert_allclose(none, resolved(grey(luminance)), atol=1.0)
    spread = [np.ptp(resolved(light, grade=Grade(saturation=s))[0, 0]) for s in (0.6, 1.0, 1.3)]
    assert spread[0] < spread[1] < spread[2]


def test_warmth_leads_to_amber_and_cold_to_blue(resolved):
    light = grey(np.full((2, 2), 0.2))
    warm, cold = (resolved(light, grade=Grade(warmth=w))[0, 0] for w in (0.6, -0.6))
    assert warm[0] > warm[1] > warm[2] and cold[0] < cold[1] < cold[2]


def test_smoothing_softens_a_slanting_edge_and_nothing_else(resolved):
    x, y = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    edge = np.where(x > 0.3 * y + 15.0, 0.6, 0.05)
    hard, soft = resolved(grey(edge)), resolved(grey(edge), smooth=True)
    between = (soft > hard.min() + 15.0) & (soft < hard.max() - 15.0)
    assert between[8:40].any(axis=(1, 2)).mean() > 0.5
    far = np.abs(x - 0.3 * y - 15.0) > 5.0
    np.testing.assert_allclose(soft[far], hard[far], atol=1.0)
    # The edge stays where it is: as much light on either side.
    assert soft.mean() == pytest.approx(hard.mean(), rel=0.02)


def test_smoothing_leaves_faint_patterns_and_does_not_spread_a_glint(resolved):
    rng = np.random.default_rng(2)
    faint = 0.3 + 0.004 * rng.uniform(-1.0, 1.0, SIZE)
    np.testing.assert_allclose(resolved(grey(faint), True), resolved(grey(faint)), atol=1.0)
    glint = np.full(SIZE, 0.05)
    glint[24, 24] = 30.0
    hard, soft = resolved(grey(glint)), resolved(grey(glint), True)
    assert (soft - hard).max() < 0.6 * hard.max()
    changed = np.abs(soft - hard).max(axis=2) > 2.0
    assert changed.sum() <= 25
