"""Compare each eye's picture in every display mode with two plain pictures."""

from dataclasses import replace

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.renderer import Renderer
from subsea.view.display_rigs import DISPLAYS, display_rig
from subsea.view.stereo import LAYOUTS

SIZE = (96, 64)
EXACT = replace(PRESETS["medium"], smooth=False)  # woven pictures are not smoothed
TALL = ["anaglyph", "anaglyph-comfort", "checkerboard"]


@pytest.fixture(scope="module")
def rendered(drawn, make):
    """A display, and a size -> the picture."""
    return lambda display, size=SIZE: drawn(
        make(display, size), size, display=display, quality=EXACT
    )


@pytest.fixture(scope="module")
def make(make_packet, fish):
    def packet(display, size=SIZE):
        return make_packet([fish(1, (0, 70, -200))], display=display, size=size)

    return packet


@pytest.fixture(scope="module")
def eyes(drawn, make):
    """The left and the right eye's picture, each in full."""
    packet = make("checkerboard")
    views = [replace(view, viewport=(0, 0, *SIZE)) for view in packet.views]
    return [drawn(replace(packet, views=(view,)), quality=EXACT) for view in views]


def rows_and_columns():
    width, height = SIZE
    return np.mgrid[:height, :width]


def linear(picture):
    x = picture / 255.0
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def test_the_eyes_see_different_pictures(eyes):
    assert np.abs(eyes[0] - eyes[1]).max() > 40


def test_red_comes_from_the_left_eye_and_cyan_from_the_right(rendered, eyes):
    picture = rendered("anaglyph")
    np.testing.assert_allclose(picture[..., 0], eyes[0][..., 0], atol=1)
    np.testing.assert_allclose(picture[..., 1:], eyes[1][..., 1:], atol=1)


def test_pixels_take_turns_in_a_checkerboard(rendered, eyes):
    row, column = rows_and_columns()
    left = ((row + column) % 2 == 0)[..., None]
    np.testing.assert_allclose(rendered("checkerboard"), np.where(left, *eyes), atol=1)


@pytest.mark.parametrize("height", [64, 65])
def test_rows_take_turns_when_interlaced_and_the_topmost_is_left(rendered, height):
    stacked, picture = (rendered(name, (96, height)) for name in ("top-bottom", "interlaced"))
    half = height - height // 2
    np.testing.assert_allclose(picture[0::2], stacked[:half], atol=1)
    np.testing.assert_allclose(picture[1::2], stacked[half:], atol=1)


def test_comfortable_colours_are_dubois_mixture(rendered, eyes):
    left = [[0.4561, 0.500484, 0.176381], [-0.0400822, -0.0378246, -0.0157589],
            [-0.0152161, -0.0205971, -0.00546856]]  # fmt: skip
    right = [[-0.0434706, -0.0879388, -0.00155529], [0.378476, 0.73364, -0.0184503],
             [-0.0721527, -0.112961, 1.2264]]  # fmt: skip
    picture = rendered("anaglyph-comfort")
    light = linear(eyes[0]) @ np.transpose(left) + linear(eyes[1]) @ np.transpose(right)
    np.testing.assert_allclose(linear(picture), np.clip(light, 0, 1), atol=0.012)
    # Each eye is about as bright as the other through its filter: red, and green with blue.
    plain = rendered("anaglyph")
    seen, rival = (linear(p)[..., 0].mean() / linear(p)[..., 1].mean() for p in (picture, plain))
    assert rival < 0.65 * seen


def test_shutter_glasses_get_one_full_picture_each(context, scene, make, eyes):
    """Each buffer of the window is chosen before the eye's picture is drawn into it."""
    kept, window = [], context.simple_framebuffer(SIZE)

    def shown():
        data = np.frombuffer(window.read(alignment=1), np.uint8)
        kept.append(data.reshape(SIZE[1], SIZE[0], 3)[::-1].astype(int))

    def page(number):
        if number:  # the right eye's turn: the buffer holds the left eye's picture
            shown()

    renderer = Renderer(context, scene, display_rig("stereo", SIZE), EXACT, page)
    renderer.draw(make("stereo"), {0: window})
    shown()
    for seen, expected in zip(kept, eyes, strict=True):
        np.testing.assert_allclose(seen, expected, atol=1)
    # Without a window both buffers exist.
    renderer.draw(make("stereo"))
    for number, expected in enumerate(eyes):
        np.testing.assert_allclose(renderer.read_pixels(page=number), expected, atol=1)
    renderer.release()
    context.detect_framebuffer(0).use()  # the next framebuffer must not follow a freed one
    window.release()


@pytest.mark.parametrize("display", [name for name in LAYOUTS if name != "side-by-side"])
def test_every_mode_as_it_is_shown(make_renderer, make, same_picture, display):
    renderer = make_renderer(SIZE, display=display)
    renderer.draw(make(display))
    pages = [renderer.read_pixels(page=page) for page in range(renderer.rig.pages)]
    same_picture(display, np.hstack(pages))


@pytest.mark.parametrize("display", DISPLAYS)
def test_the_picture_follows_its_size_in_every_mode(context, make_renderer, make, display):
    renderer = make_renderer((40, 30))
    for size in ((64, 48), (33, 21), (64, 9), (64, 4), (1, 1)):
        renderer.arrange(display_rig(display, size))
        renderer.draw(make(display, size))
        assert renderer.read_pixels().shape == (size[1], size[0], 3)
        assert renderer.read_pixels().mean() > 5
    assert context.error == "GL_NO_ERROR"


def test_a_canvas_too_large_for_the_gpu_is_one_line(context, scene, monkeypatch):
    held = dict(context.info, GL_MAX_TEXTURE_SIZE=100)
    monkeypatch.setattr(type(context), "info", held)
    with pytest.raises(UserError, match="96x128 pixels, this GPU holds at most 100"):
        Renderer(context, scene, display_rig("anaglyph", SIZE))


@pytest.mark.parametrize("display", DISPLAYS)
def test_a_canvas_is_as_large_as_the_views_of_the_mode(make, display):
    width, height = display_rig(display, SIZE).canvas
    right = max(x + w for x, _, w, _ in (v.viewport for v in make(display).views))
    top = max(y + h for _, y, _, h in (v.viewport for v in make(display).views))
    assert (right, top) == (width, height)
    assert (height == 2 * SIZE[1]) == (display in [*TALL, "stereo"])
