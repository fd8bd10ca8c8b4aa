"""Captions: their times, line breaks, and places in films."""

import numpy as np
import pytest

from subsea.dive.captions import (
    FADE_S,
    STOPS,
    Caption,
    caption_of,
    draw_caption,
    lines_of,
    shown_s,
)
from subsea.scenario.load import load_scenario
from subsea.submarine.vessel import NEUTRAL
from subsea.view.display_rigs import DISPLAYS, display_rig
from subsea.view.front_screen import text_viewports
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S
from tests.support.scenes import scene

WORDS = "A pair courts in front, while a school that a shark stalks passes behind it."


def test_captions_fade_and_the_latest_is_shown(tmp_path):
    file = scene(
        tmp_path,
        "caption = 'One.'\nfor_s = 2.0",
        f"at_s = 1.0\ncaption = '{WORDS}'\nfor_s = 1.8",
        "at_s = 1.5\nlights = true",
    )
    world = create_world(load_scenario(str(file))[0])
    seen = {}
    assert caption_of(world, 1.0).opacity == 0.0
    while world.state.tick * TICK_S < 3.5:
        step(world, NEUTRAL)
        for alpha in (0.5, 1.0):
            seen[(world.state.tick - 1 + alpha) * TICK_S] = caption_of(world, alpha)
    up = [time for time, caption in seen.items() if caption.opacity > 0.0]
    first = [time for time in up if seen[time].words == "One."]
    assert first == [time for time in up if time < 1.0]
    assert max(up) == pytest.approx(2.8, abs=3 * TICK_S)
    assert shown_s(WORDS, None) > 5.0  # enough time for slow readers
    steps = np.abs(np.diff([one.opacity for time, one in seen.items() if time > 1.1]))
    assert steps.max() < 2.0 * TICK_S / FADE_S
    assert {one.opacity for one in seen.values()} >= {0.0, 1.0}
    assert seen[max(seen)].words == ""  # it is over


def test_lines_are_few_and_even():
    lines = lines_of(WORDS, 60.0, len)
    assert " ".join(lines) == WORDS
    assert [len(line) <= 60 for line in lines] == [True, True]
    assert abs(len(lines[0]) - len(lines[1])) < 12
    assert lines_of("short", 60.0, len) == ["short"]
    assert lines_of("Donaudampfschifffahrt to", 9.0, len) == ["Donaudampfschifffahrt", "to"]
    assert lines_of(" ", 9.0, len) == []


def test_lines_of_japanese_break_between_letters_but_not_before_a_stop():
    words = "深い平原の上に、一万匹の魚がいます。"
    for room in range(4, 20):
        lines = lines_of(words, room, len)
        assert "".join(lines) == words
        assert all(line[0] not in STOPS and len(line) <= room for line in lines)
    assert lines_of("ABC 魚 DEF", 5.0, len) == ["ABC 魚", "DEF"]


@pytest.mark.parametrize("display", DISPLAYS)
@pytest.mark.parametrize("ground", [(5, 60, 110), (235, 240, 230)])  # deep water, and sunlit sand
def test_captions_are_legible_in_every_display(display, ground):
    size = (640, 360) if display != "equirectangular" else (1280, 640)
    rig = display_rig(display, size)
    picture = np.full((size[1], size[0], 3), ground, np.uint8)
    shown = draw_caption(picture, rig, 0, Caption(WORDS, 1.0)).astype(int)
    assert (picture == ground).all()  # a copy
    for viewport in text_viewports(rig):
        left, top = round(viewport.x * size[0]), round(viewport.y * size[1])
        part = shown[
            top : top + round(viewport.height * size[1]),
            left : left + round(viewport.width * size[0]),
        ]
        differs = np.abs(part - np.array(ground)).sum(axis=2) > 60
        rows, columns = np.flatnonzero(differs.any(axis=1)), np.flatnonzero(differs.any(axis=0))
        middle = (columns.min() + columns.max()) / 2 / part.shape[1]
        assert middle == pytest.approx(0.5, abs=0.02)
        assert rows.min() > 0.5 * part.shape[0] and rows.max() < 0.95 * part.shape[0]
        letters, shade = part.sum(axis=2).max(), part[differs].sum(axis=1).min()
        assert letters > 600 and shade < 0.55 * letters  # light on dark
    assert (draw_caption(picture, rig, 0, Caption(WORDS, 0.0)) == picture).all()
    faint = draw_caption(picture, rig, 0, Caption(WORDS, 0.3)).astype(int)
    assert np.abs(faint - picture).max() < 0.5 * np.abs(shown - picture).max()
    assert (draw_caption(picture, rig, 1, Caption(WORDS, 1.0)) == picture).all()  # another window
