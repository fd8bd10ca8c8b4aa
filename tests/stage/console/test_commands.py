"""Commands are decoded from JSON and from words, or refused."""

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
    PresenterCommand,
    SetQuality,
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
def test_any_values_are_a_command_or_one_line(name, values):
    try:
        assert isinstance(from_words(name, values), PresenterCommand)
    except UserError as fault:
        assert "\n" not in str(fault)


@given(st.binary(max_size=100) | st.text().map(lambda text: text.encode("utf-8", "replace")))
def test_any_bytes_are_a_command_or_one_line(data):
    try:
        assert isinstance(from_json(data), PresenterCommand)
    except UserError as fault:
        assert "\n" not in str(fault)
