"""The steps of structured light, by key, clock and command."""

import pytest

from subsea.base.command_line import parse_arguments
from subsea.base.errors import UserError
from subsea.cli.main import parsers
from subsea.dive.presented import NOTHING
from subsea.stage.calibration.photographs import LightStep
from subsea.stage.parts import TheatrePart
from subsea.stage.structured_light import DARK_S, StructuredLight
from subsea.view.structured_light import light_patterns

STEPS = [
    LightStep(channel, name, k, pattern)
    for channel, name in enumerate(["left", "right"])
    for k, pattern in enumerate(light_patterns((16, 16)))
]


def test_a_key_goes_through_all_pictures_back_to_the_sea():
    told = []
    light = StructuredLight(STEPS, tell=told.append)
    assert light.shown is None
    shown = []
    for _ in STEPS:
        light.cue()
        shown.append(light.shown)
    assert shown == [(step.channel, step.number) for step in STEPS]
    light.cue()
    assert light.shown is None
    assert told[0] == f"structured light, 1 of {len(STEPS)}: white of 'left'"
    assert told[-1].endswith("the sea")


def test_the_clock_shows_each_picture_equally_long_and_once():
    told = []
    light = StructuredLight(STEPS, 2.0, told.append)
    seen = {}
    for _ in range(1000):
        light.update(0.1)
        seen[light.shown] = seen.get(light.shown, 0) + 0.1
    assert len(seen) == len(STEPS) + 1
    assert all(abs(seen[step.channel, step.number] - 2.0) < 0.11 for step in STEPS)
    assert seen[None] > DARK_S and len(told) == 1


def test_the_clock_keeps_the_pace_of_a_camera():
    light, shown = StructuredLight(STEPS, 1.0, lambda words: None), []
    frame_s = [0.03, 0.05, 0.21]  # pictures are never as long as a step, and some take longer
    time_s = 0.0
    for k in range(2000):
        light.update(frame_s[k % 3])
        time_s += frame_s[k % 3]
        if light.number and light.number != (shown[-1][1] if shown else 0):
            shown.append((time_s, light.number))
    assert [number for _, number in shown] == list(range(1, len(STEPS) + 1))
    late = [at - (DARK_S + number - 1) for at, number in shown]
    assert min(late) > -1e-9 and max(late) < 0.211
    stalled = StructuredLight(STEPS, 1.0, lambda words: None)
    stalled.update(DARK_S + 2.5)
    assert stalled.number == 3


def test_the_option_begins_with_the_first_picture():
    part = made("--theatre", "three-projectors", "--structured-light")
    assert part.light.number == 0 and part.over(NOTHING) == NOTHING
    part.light.show(1)
    assert part.over(NOTHING).light == (0, 0)
    part.cue()
    assert part.over(NOTHING).light == (0, 1)
    later = made("--theatre", "three-projectors", "--structured-light", "0.5")
    later.light.update(DARK_S + 0.1)
    assert later.over(NOTHING).light == (0, 0)
    later.before(None, 0.6)
    assert later.over(NOTHING).light == (0, 1)
    with pytest.raises(UserError, match="--structured-light needs --theatre too"):
        made("--structured-light")


def made(*words):
    """The part of a theatre that options of a dive ask for."""
    options = parse_arguments(*parsers(), ["dive", *words])
    options.shrink = options.shrink or 1  # as the command fills in
    return TheatrePart.made(options, None)


def test_a_command_names_a_picture():
    light = StructuredLight(STEPS)
    assert light.show(len(STEPS)).startswith(f"{len(STEPS)} of {len(STEPS)}: rows-2-inverse")
    assert light.show(-1) == "the screens show the sea"
    assert light.show(0) == "the screens show the sea"
    with pytest.raises(UserError, match=f"expected {len(STEPS)} at most"):
        light.show(len(STEPS) + 1)
