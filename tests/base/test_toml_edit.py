"""The TOML editor: values change, every other byte stays."""

import tomllib

import pytest

from subsea.base.errors import UserError
from subsea.base.toml_edit import edit_toml, toml_value

TEXT = """\
# a reef
title = "old"   # its name
numbers = [
    1,  # first
    2,
]

[skin]
eye = { at = 0.1, size = 2.0 }

[skin.fins.tail]
edge = [1.0]
# the end
"""


def edited(text, change):
    """The text after `change` was made to its content, checked to say that."""
    old, new = tomllib.loads(text), tomllib.loads(text)
    change(new)
    after = edit_toml(text, old, new)
    assert tomllib.loads(after) == new
    return after


def test_only_the_bytes_of_changed_values_change():
    after = edited(TEXT, lambda new: new.update(title="new", numbers=[1, 3]))
    assert after == TEXT.replace('"old"', '"new"').replace("    2,", "    3,")
    assert edited(TEXT, lambda new: new["skin"]["eye"].update(size=3.0)) == TEXT.replace(
        "2.0", "3.0"
    )
    assert edited(TEXT, lambda new: new.pop("title")) == TEXT.replace(
        'title = "old"   # its name\n', ""
    )


def test_new_tables_follow_the_style_of_others():
    fin = {"edge": [2.0]}
    after = edited(TEXT, lambda new: new["skin"]["fins"].update(dorsal=fin))
    assert "[skin.fins.dorsal]\nedge = [2.0]" in after
    assert after.endswith("# the end\n")
    after = edit_toml("[surface]\n# fins\n", {}, {"dorsal": fin}, ("surface",))
    assert after == "[surface]\ndorsal = { edge = [2.0] }\n# fins\n"


def test_a_text_that_cannot_be_edited_is_an_error_about_its_file():
    with pytest.raises(UserError, match=r"^fish\.toml: its tables cannot be edited"):
        edit_toml(TEXT, {}, {"x": 1}, ("no", "such"), "fish.toml")


def test_long_lists_of_tables_have_a_line_for_each():
    rows = [{"time_s": float(k), "position_cm": (1.0, 2.0, 3.0)} for k in range(3)]
    text = toml_value(rows)
    assert text.count("\n") == 4
    assert tomllib.loads(f"x = {text}")["x"][2] == {"time_s": 2.0, "position_cm": [1.0, 2.0, 3.0]}
    assert toml_value(rows[:1]) == "[{ time_s = 0.0, position_cm = [1.0, 2.0, 3.0] }]"


def test_keys_are_quoted_where_they_must_be():
    for key in ("Region 1", "", 'a"b', "a.b", "ö"):
        table = {key: {"a-b": 1}}
        assert tomllib.loads(f"x = {toml_value(table)}") == {"x": table}
