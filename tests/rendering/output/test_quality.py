"""Presets: cheaper ones draw less, and a renderer switches between them and back."""

from dataclasses import asdict, replace
from itertools import pairwise

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.rendering.output.quality import (
    CHOICES,
    LADDER,
    PRESETS,
    Quality,
    check_choice,
    first_rung,
    name_of,
)
from subsea.rendering.sea.particles import SNOW

SIZE = (160, 90)


@pytest.fixture
def school(make_packet, fish):
    fishes = [fish(k % 2, (9 * k - 36, 60 + 7 * k, -200), level=k % 3) for k in range(9)]
    return make_packet(fishes, size=SIZE)


def test_no_field_gets_less_from_one_preset_to_the_next():
    assert list(PRESETS) == ["low", "medium", "high", "ultra"]
    for cheap, dear in pairwise(asdict(preset) for preset in PRESETS.values()):
        for field in cheap:
            assert cheap[field] <= dear[field], field
    assert PRESETS["ultra"].snow <= SNOW


def test_the_ladder_climbs_through_scales_to_the_presets():
    assert LADDER[-4:] == tuple(PRESETS.values())
    below = LADDER[:-3]
    assert {replace(rung, scale=1.0) for rung in below} == {PRESETS["low"]}
    steps = np.diff([rung.scale for rung in below])
    assert (steps > 0.0).all() and steps.max() < 0.06
    assert LADDER[first_rung("llvmpipe (LLVM 15.0.6, 256 bits)")] == PRESETS["low"]
    assert LADDER[first_rung("NVIDIA GeForce RTX 3060/PCIe/SSE2")] == PRESETS["high"]


def test_names():
    assert [name_of(preset) for preset in PRESETS.values()] == list(PRESETS)
    assert name_of(LADDER[0]) == "low at 50%"
    assert name_of(Quality(snow=7)) == "own"
    assert all(check_choice(name) == name for name in CHOICES)
    with pytest.raises(UserError, match="unknown quality 'hihg'; did you mean 'high'") as caught:
        check_choice("hihg")
    assert "\n" not in str(caught.value)


def test_a_smaller_canvas_shows_the_same_picture_less_sharply(drawn, make_renderer, school):
    renderer, full = make_renderer(SIZE), drawn(school)
    for scale in (0.5, 2.0):
        renderer.adapt(Quality(scale=scale))
        other = drawn(school)
        assert other.shape == full.shape
        assert (np.abs(other - full).max(axis=2) > 24).any()
        # Nothing is shifted or stretched: blocks of ten pixels have nearly the same mean.
        blocks = [p.reshape(9, 10, 16, 10, 3).mean(axis=(1, 3)) for p in (full, other)]
        assert np.abs(blocks[0] - blocks[1]).mean() < 0.2 * blocks[0].std()
    renderer.adapt(Quality())
    np.testing.assert_array_equal(drawn(school), full)


@pytest.mark.parametrize("display", ["interlaced", "checkerboard", "dome"])
def test_interleaved_displays_keep_the_canvas_exact(drawn, make_packet, fish, display):
    packet = make_packet([fish(1, (0, 60, -200))], size=SIZE, display=display)
    full, half = (
        drawn(packet, SIZE, display=display, quality=Quality(scale=scale)) for scale in (1.0, 0.5)
    )
    np.testing.assert_array_equal(half, full)


def test_without_shadows_the_sand_beneath_a_fish_is_as_bright_as_elsewhere(
    counted, scene, make_packet, fish
):
    ground = float(scene.terrain[len(scene.terrain) // 2, len(scene.terrain) // 2])
    one = make_packet(
        [fish(0, (0.0, 0.0, ground + 12.0))], (0.0, -70.0, ground + 90.0), pitch=-0.9, size=SIZE
    )
    with_one, triangles = counted(one)
    without, fewer = counted(one, quality=Quality(shadows=False))
    assert fewer < triangles
    assert (without - with_one).mean(axis=2).max() > 8
    assert (without - with_one).min() >= -1


def test_every_preset_draws_and_the_first_comes_back_unchanged(
    context, drawn, make_renderer, school
):
    renderer = make_renderer(SIZE)
    renderer.adapt(PRESETS["low"])
    first = drawn(school)
    for preset in (*PRESETS.values(), *LADDER[::4]):
        renderer.adapt(preset)
        assert renderer.quality == preset
        assert drawn(school).std() > 5
    renderer.adapt(PRESETS["low"])
    np.testing.assert_array_equal(drawn(school), first)
    assert context.error == "GL_NO_ERROR"
