"""Commands are decoded from JSON and from words, or refused."""

from contextlib import suppress

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.rendering.output.quality import CHOICES
from subsea.stage.console.commands import (
    COMMANDS,
    NAMES,
    BlankScreens,
    FollowFish,
    LeaveFish,
    NextItem,
    PresenterCommand,
    RideFish,
    SetQuality,
    SetVolume,
    ShowLineUp,
    StartCue,
    StartTour,
    described,
    from_json,
    from_words,
)


def test_both_ways_give_the_same_commands():
    for one in (BlankScreens(True), SetQuality("low")):
        data = msgspec.json.encode(one)
        name, *values = msgspec.json.decode(data).values()
        assert from_json(data) == from_words(name, values) == one


def test_every_command_is_described():
    assert len(NAMES) == len(COMMANDS)
    for one in described():
        kind = NAMES[one["command"]]
        assert one["what"] and [p["name"] for p in one["parameters"]] == [*kind.__struct_fields__]


@pytest.mark.parametrize("quality", CHOICES)
def test_every_quality_can_be_set(quality):
    assert from_words("quality", [quality]) == SetQuality(quality)


anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.binary(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=5,
)


@given(st.sampled_from(sorted(NAMES)), st.lists(anything, max_size=3))
def test_any_values_are_a_command_or_refused(name, values):
    with suppress(UserError):
        assert isinstance(from_words(name, values), PresenterCommand | None)


@given(st.binary(max_size=100) | st.text().map(lambda text: text.encode("utf-8", "replace")))
def test_any_bytes_are_a_command_or_refused(data):
    with suppress(UserError):
        assert isinstance(from_json(data), PresenterCommand)


@pytest.mark.parametrize(
    ("name", "values", "command"),
    [
        ("blank", [1.0], BlankScreens(True)),
        ("line-up", [0.0], ShowLineUp(False)),
        ("cue", [2.0], StartCue(2)),
        ("follow", [3.0], FollowFish("3")),
        ("ride", [3], RideFish("3")),
        ("follow", ["nearest"], FollowFish("nearest")),
        ("volume", [1], SetVolume(1.0)),
    ],
)
def test_senders_that_know_only_floats_are_understood(name, values, command):
    assert from_words(name, values) == command
    [key] = NAMES[name].__struct_fields__
    assert from_json(msgspec.json.encode({"command": name, key: values[0]})) == command


@pytest.mark.parametrize(
    ("name", "values", "command"),
    [
        ("next-item", [], NextItem()),
        ("helm", [], LeaveFish()),
        ("tour", ["reef"], StartTour("reef")),
        ("cue", [-1.0], StartCue(-1)),
        ("blank", [1.0], BlankScreens(True)),
    ],
)
def test_a_button_triggers_when_it_is_pressed_and_not_when_it_is_released(name, values, command):
    for pressed in (1.0, 1, True):
        assert from_words(name, [*values, pressed]) == command
    for released in (0.0, 0, False):
        assert from_words(name, [*values, released]) is None


@pytest.mark.parametrize("values", [[0.5], [2], ["on"], [1.0, 1.0, 1.0], [float("nan")]])
def test_other_numbers_are_no_answer_to_yes_or_no(values):
    with pytest.raises(UserError, match="expected"):
        from_words("blank", values)
