"""The renderer's public interface."""

import gc

import moderngl
import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.rendering.fish.speck import dot, speck
from subsea.rendering.output.quality import PRESETS, Quality
from subsea.rendering.renderer import Renderer
from subsea.view.display_rigs import display_rig


@pytest.fixture
def renderer(make_renderer):
    """One for all tests; what they change is changed back."""
    renderer = make_renderer((160, 90))
    yield renderer
    renderer.arrange(display_rig("mono", (160, 90)))
    renderer.adapt(PRESETS["medium"])


def test_it_draws_into_the_framebuffer_that_it_is_given(renderer, context, make_packet, fish):
    packet = make_packet([fish(0, (0, 40, -200))], size=(160, 90))
    renderer.draw(packet)
    own = renderer.read_pixels()
    target = context.simple_framebuffer((160, 90), components=3)
    renderer.draw(packet, into={0: target})
    given = np.frombuffer(target.read(components=3, alignment=1), np.uint8)
    np.testing.assert_array_equal(given.reshape(90, 160, 3)[::-1], own)
    target.release()


def test_the_top_row_comes_first(renderer, make_packet):
    renderer.draw(make_packet([], pitch=0.0, size=(160, 90)))
    rows = renderer.read_pixels().mean(axis=(1, 2))
    assert rows[0] > rows[45]  # light comes from above


def test_a_new_size(renderer, make_packet, fish):
    for size in [(64, 48), (160, 90), (1, 1)]:
        renderer.arrange(display_rig("mono", size))
        renderer.draw(make_packet([fish(1, (0, 40, -200))], size=size))
        assert renderer.read_pixels().shape == (size[1], size[0], 3)


def test_a_size_beyond_the_gpu_changes_nothing(renderer, make_packet, fish, monkeypatch):
    packet = make_packet([fish(1, (0, 40, -200))], size=(160, 90))
    renderer.draw(packet)
    before, quality = renderer.read_pixels().copy(), renderer.quality

    def refuse(*_):
        raise moderngl.Error("out of memory")

    with monkeypatch.context() as patch:
        patch.setattr("subsea.rendering.renderer.RenderTarget", refuse)
        for change in (
            lambda: renderer.adapt(Quality(samples=4)),
            lambda: renderer.arrange(display_rig("mono", (9, 9))),
        ):
            with pytest.raises(UserError, match="more than this GPU can hold"):
                change()
    assert (renderer.quality, renderer.size) == (quality, (160, 90))
    renderer.draw(packet)
    np.testing.assert_array_equal(renderer.read_pixels(), before)


def test_drawing_is_repeatable(renderer, make_packet, fish):
    packet = make_packet([fish(1, (0, 40, -200)), fish(0, (9, 50, -200), level=2)], size=(160, 90))
    renderer.draw(packet)
    first = renderer.read_pixels().copy()
    renderer.draw(make_packet([fish(0, (5, 30, -203))], size=(160, 90)))
    renderer.draw(packet)
    np.testing.assert_array_equal(renderer.read_pixels(), first)


@pytest.mark.nightly
def test_multisampling_changes_edges_only(drawn, make_packet, fish):
    packet = make_packet([fish(1, (0, 60, -200))], size=(160, 90))
    plain, smooth = (drawn(packet, quality=Quality(samples=samples)) for samples in (0, 4))
    changed = (np.abs(plain - smooth).max(axis=2) > 8).mean()
    assert 0.0 < changed < 0.08


def test_triangles_are_counted(renderer, make_packet, fish):
    renderer.adapt(Quality(shadows=False))  # otherwise each fish here would cast one
    renderer.draw(make_packet([], size=(160, 90)))
    without = renderer.triangles
    counts = []
    for level in range(6):
        renderer.draw(make_packet([fish(0, (0, 40, -200), level=level)] * 7, size=(160, 90)))
        fishes, rest = divmod(renderer.triangles - without, 7)
        assert rest == 0
        counts.append(fishes)
    assert 2000 < counts[0] < 3000
    # Then the body's control points alone, those of the fins too, and every second of these.
    assert 900 < counts[1] < 1050
    assert 700 < counts[2] < 850  # fins are counted on both sides
    assert 160 <= counts[3] < 230
    assert counts[4:] == [len(speck().triangles), len(dot().triangles)] == [40, 10]


@pytest.mark.nightly
def test_release_frees_every_object(context, scene, make_packet, fish):
    """Unreleased objects are collected in `context.objects`, in this mode."""
    gc.collect()
    usual, context.gc_mode = context.gc_mode, "context_gc"
    try:
        renderer = Renderer(context, scene, display_rig("mono", (64, 48)), PRESETS["high"])
        for size in [(64, 48), (32, 32)]:
            renderer.arrange(display_rig("mono", size))
            renderer.draw(make_packet([fish(0, (0, 40, -200))], size=size))
        renderer.release()
        del renderer
        gc.collect()
        left = [thing for thing in context.objects if hasattr(thing, "release")]
        assert left == []
    finally:
        context.objects.clear()
        context.gc_mode = usual


def test_no_error_is_left_behind(renderer, context, make_packet, fish):
    renderer.draw(make_packet([fish(0, (0, 40, -200))], size=(160, 90)))
    renderer.arrange(display_rig("mono", (64, 64)))
    assert context.error == "GL_NO_ERROR"
