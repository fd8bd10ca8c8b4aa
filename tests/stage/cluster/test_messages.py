"""Valid messages are decoded, all others refused."""

import math

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.dive.presented import Presented
from subsea.stage.cluster import messages
from subsea.stage.cluster.messages import (
    MAGIC,
    Diverged,
    Hello,
    Identity,
    NodeReport,
    NodeRequest,
    Picture,
    PictureDrawn,
    Refused,
    Resume,
    StatePart,
    Swap,
    WorldState,
    encode,
    from_master,
    from_node,
    picture_of,
    ticks_of,
)
from subsea.stage.theatre.line_up import LineUpState
from subsea.stage.theatre.theatre_file import Adjustment, Corners
from subsea.submarine.vessel import Helm

IDENTITY = Identity("0.2.0", {"scenario": "Bucht, früh", "subsea/fish": "#f0"})
SHOWN = Presented(0.5, True, "Good evening", 1.0, (2, 17))
FROM_NODE = [
    Hello("left", IDENTITY, "dive", 7),
    PictureDrawn(12),
    Diverged(900),
    StatePart(9, 3, b"\x00bytes"),
    NodeReport("hall.toml: no space is left"),
    NodeRequest(b'{"command": "line-up-undo"}'),
]
LINE_UP = LineUpState(
    {"left": Adjustment(corners_px=Corners(upper_left=(1.5, -2.0)), gamma=2.4)},
    open=True,
    channel="left",
    point="2,3",
)
FROM_MASTER = [
    WorldState("dive", 3, b"\x00bytes"),
    Picture(
        4,
        77,
        0.5,
        [(0.1, -1.0, 1.0, 0.0, True)],
        [(*(1.0,) * 8, True)],
        "checksum",
        True,
        SHOWN,
        LINE_UP,
    ),
    Swap(4),
    Resume(3),
    Refused("because"),
]


READERS = [*((one, from_node, from_master) for one in FROM_NODE),
           *((one, from_master, from_node) for one in FROM_MASTER)]  # fmt: skip


@pytest.mark.parametrize(("message", "read", "other"), READERS)
def test_messages_are_decoded_by_their_receiver(message, read, other):
    assert read(encode(message)) == message
    with pytest.raises(UserError, match="not one of subsea"):
        other(encode(message))


def test_a_picture_carries_input_and_rails():
    carried, steered = ticks_of(FROM_MASTER[1])
    assert steered == Helm(0.1, -1.0, 1.0, 0.0, True)
    assert [*carried.position, *carried.velocity, *carried.angles] == [1.0] * 8
    assert carried.cut
    rebuilt = picture_of(
        4,
        77,
        np.float32(0.5),
        [carried, steered._replace(yaw=-7)],
        "checksum",
        True,
        SHOWN,
        LINE_UP,
    )
    assert rebuilt == FROM_MASTER[1]


@given(st.binary(max_size=300))
def test_garbage_is_refused(data):
    for read in (from_node, from_master):
        for bytes_ in (data, MAGIC + data):
            try:
                message = read(bytes_)
            except UserError as fault:
                assert "expected" in str(fault) or "not one of subsea" in str(fault)
            else:  # a few bytes may be a message, but only a complete one
                assert read(encode(message)) == message


@given(st.integers(0, 200), st.binary(min_size=1, max_size=4))
def test_cut_or_longer_messages_are_refused(at, more):
    for message, read, _ in READERS:
        data = encode(message)
        for wrong in (data[: at % len(data)], data + more):
            with pytest.raises(UserError):
                read(wrong)


def test_errors_about_messages_are_printable():
    content = {"type": "drawn", "number": 1, "\x1b[2J": 1}
    with pytest.raises(UserError, match=r"not one of subsea.*\?\[2J"):
        from_node(MAGIC + msgspec.msgpack.encode(content))


@pytest.mark.parametrize("opening", [b"\x91", b"\x81\xa1x", b"\x81\xa4type"])
def test_deeply_nested_messages_are_refused(opening):
    for read in (from_node, from_master):
        with pytest.raises(UserError, match="not one of subsea"):
            read(MAGIC + opening * 1300)


def test_another_protocol_is_refused():
    data = encode(PictureDrawn(1))
    with pytest.raises(UserError, match=r"protocol 9, expected 8: .* version .* than \d"):
        from_node(data[: len(MAGIC) - 1] + b"\x09" + data[len(MAGIC) :])


@pytest.mark.parametrize(
    ("kind", "fields"),
    [
        ("picture", {"alpha": 1.5}),
        ("picture", {"alpha": math.nan}),
        ("picture", {"helms": [[0.0, 0.0, 0.0, math.nan, False]]}),
        ("picture", {"helms": [[0.0, 0.0, 0.0, 1.01, False]]}),
        ("picture", {"helms": [[0.0, 0.0, 0.0, 0.0]]}),
        ("picture", {"helms": [[0.0, 0.0, 0.0, 0.0, 1]]}),
        ("picture", {"helms": [[0.0, 0.0, 0.0, 0.0, False]] * (messages.MAX_HELMS + 1)}),
        ("picture", {"rails": [[0.0] * 8]}),
        ("picture", {"rails": [[0.0] * 7 + [math.inf, False]]}),
        ("picture", {"rails": [[0.0] * 8 + [1]]}),
        ("picture", {"rails": [[0.0] * 8 + [False]] * (messages.MAX_HELMS + 1)}),
        ("picture", {"number": -1}),
        ("picture", {"number": True}),
        ("picture", {"tick": 2**60}),
        ("picture", {"checksum": "a" * 100}),
        ("picture", {"surprise": 1}),
        ("hello", {"node": ""}),
        ("hello", {"node": "left\n"}),
        ("hello", {"node": "\x1b[2J"}),
        ("hello", {"node": "n" * 65}),
        ("hello", {"identity": {}}),
        ("hello", {"identity": {"version": "1", "parts": {"seed": "7\x1b[2J"}}}),
        ("hello", {"identity": {"version": "1", "parts": {"seed": "7" * 61}}}),
        ("hello", {"identity": {"version": "1", "parts": {"a\nb": "7"}}}),
        ("hello", {"identity": {"version": "1", "parts": {f"part{k}": "" for k in range(65)}}}),
        ("hello", {"tick": -1}),
        ("part", {"data": b""}),
        ("part", {"data": bytes(messages.PART + 1)}),
        ("part", {"size": -1}),
    ],
)
def test_values_beyond_their_limits_are_refused(kind, fields):
    good = {"picture": FROM_MASTER[1], "hello": FROM_NODE[0], "part": FROM_NODE[3]}[kind]
    read = from_master if kind == "picture" else from_node
    content = {"type": kind} | msgspec.structs.asdict(good)
    assert read(MAGIC + msgspec.msgpack.encode(content)) == good
    with pytest.raises(UserError, match="not one of subsea"):
        read(MAGIC + msgspec.msgpack.encode(content | fields))
