"""Messages about content name no types of Python."""

from typing import Annotated, Literal

import msgspec
import pytest
from msgspec import Meta

from subsea.base.errors import UserError
from subsea.base.validation import convert


class Part(msgspec.Struct, forbid_unknown_fields=True):
    y: float


class Whole(msgspec.Struct, forbid_unknown_fields=True):
    count: Annotated[int, Meta(ge=0)] = 0
    share: Annotated[float, Meta(gt=0, le=1)] = 1.0
    name: Annotated[str, Meta(max_length=3)] = ""
    code: Annotated[str, Meta(pattern="^a$")] = "a"
    on: bool = False
    part: Part | None = None
    row: Annotated[list[float], Meta(min_length=2)] = []
    pair: tuple[float, float] = (0.0, 0.0)
    either: int | str = 0
    kind: Literal["x", "y"] = "x"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"count": "many"}, "expected a whole number, got 'many', at `count`"),
        ({"count": 1.5}, "expected a whole number, got 1.5, at `count`"),
        ({"count": -1}, "expected a whole number of at least 0, got -1, at `count`"),
        ({"count": {}}, "expected a whole number, got a table, at `count`"),
        ({"share": 0.0}, "expected a number above 0, got 0.0, at `share`"),
        ({"share": 2}, "expected a number of at most 1, got 2, at `share`"),
        ({"name": "abcd"}, "expected text of at most 3 characters, got 'abcd', at `name`"),
        ({"code": "b"}, "expected text that matches '^a$', got 'b', at `code`"),
        ({"on": 1}, "expected true or false, got 1, at `on`"),
        ({"part": True}, "expected a table, got true, at `part`"),
        ({"part": {}}, "missing key `y`, at `part`"),
        ({"part": {"x": 1}}, "unknown key `x`, at `part`"),
        ({"row": 1}, "expected a list, got 1, at `row`"),
        ({"row": [1]}, "expected a list of at least 2 values, at `row`"),
        ({"row": [1, "a"]}, "expected a number, got 'a', at `row[1]`"),
        ({"pair": [1]}, "expected a list of 2 values, got 1, at `pair`"),
        ({"either": []}, "expected a whole number or text, got a list, at `either`"),
        ({"kind": "z"}, "unknown value 'z', at `kind`; there are: 'x', 'y'"),
        ({"cuont": 3}, "unknown key `cuont`; did you mean 'count'?"),
    ],
)
def test_messages_are_plain_words(content, message):
    with pytest.raises(UserError) as fault:
        convert(content, Whole)
    assert fault.value.message == message
