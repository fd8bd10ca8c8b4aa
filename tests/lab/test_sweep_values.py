"""Seeds and values on the command line."""

import pytest

from subsea.base.errors import UserError
from subsea.lab.sweep import read_seeds, read_values, split_values


@pytest.mark.parametrize(
    ("text", "seeds"),
    [("1:4", (1, 2, 3, 4)), ("7", (7,)), ("1,5, 9:10", (1, 5, 9, 10)), ("0:0", (0,))],
)
def test_seeds(text, seeds):
    assert read_seeds(text) == seeds


@pytest.mark.parametrize(
    "text", ["", "a", "4:1", "-1", "1:", "1,1", "1:2:3", "4294967296", "0:1000000"]
)
def test_faulty_seeds_are_one_line(text):
    with pytest.raises(UserError, match="--seeds") as fault:
        read_seeds(text)
    assert "\n" not in str(fault.value)


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("1,2.5", ("1", "2.5")),
        ("[1,2],[3, 4]", ("[1,2]", "[3, 4]")),
        ("{ a = 1, b = [2, 3] }, {}", ("{ a = 1, b = [2, 3] }", "{}")),
        ('"a,b",c', ('"a,b"', "c")),
        (r'"a\",b",c', (r'"a\",b"', "c")),
        (r"'a\',b", (r"'a\'", "b")),
        ("[1,", ("[1,",)),
        ("a,", ("a", "")),
    ],
)
def test_commas_in_brackets_and_quotes_belong_to_a_value(text, values):
    assert split_values(text) == values


def test_values_of_several_keys():
    found = read_values(["fish.0.number=1,2", " nature.keen = 0.4"])
    assert found == {"fish.0.number": ("1", "2"), "nature.keen": ("0.4",)}


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["fish.0.number"], "expected KEY=VALUE,VALUE"),
        (["a=1,"], "expected KEY=VALUE,VALUE"),
        (["a=1", "a=2"], "is given twice"),
        (["a=1,1"], "a value is there twice"),
        (["seed=1,2"], "--seeds"),
    ],
)
def test_faulty_values_are_one_line(settings, words):
    with pytest.raises(UserError, match=words):
        read_values(settings)
