"""The technician's desk and a station: facts, pictures, restarts, and nodes that are gone."""

import socket
import time
from contextlib import closing
from io import BytesIO

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from subsea.base.errors import UserError
from subsea.stage.cluster.messages import SMALL
from subsea.stage.fleet import messages
from subsea.stage.fleet.desk import GONE_S, PICTURE_S, FleetDesk
from subsea.stage.fleet.messages import (
    MAGIC,
    MOST_PICTURE,
    NodeFacts,
    PicturePart,
    PictureWanted,
    Restart,
    Rollback,
    encode,
    from_master,
    from_node,
)
from subsea.stage.fleet.pictures import PictureJoin, bounded_jpeg, parts_of
from subsea.stage.fleet.projectors import Projectors
from subsea.stage.fleet.station import FleetStation, FrameTimes
from subsea.stage.theatre.theatre_file import NodeTable

FACTS = NodeFacts("2.0", 8, "Debian, Linux 6", "llvmpipe", 63.5, 120.25, 16.7, 31.0, 3600.0,
                  "no sound device", 30.0)  # fmt: skip


class Hall:
    """A desk with a clock of its own, and the connections of its nodes."""

    def __init__(self, cards=()):
        self.now = 1000.0
        self.connected = {"left": True, "right": True}
        self.refusals = {"left": "", "right": ""}
        names = "middle", "left", "right"
        self.desk = FleetDesk(names, "middle", cards, Projectors([], []), lambda: self.now)

    def after(self, seconds=0.0):
        self.now += seconds
        self.desk.update(
            {"name": name, "connected": at, "refusal": self.refusals[name]}
            for name, at in self.connected.items()
        )

    def node(self, name):
        return next(one for one in self.desk.describe()["nodes"] if one["name"] == name)

    def orders(self):
        return [(name, from_master(data)) for name, data in self.desk.take_orders()]


@pytest.fixture
def hall():
    made = Hall()
    made.after()
    with closing(made.desk):
        yield made


def test_facts_of_a_node(hall):
    assert hall.node("left")["version"] is None
    hall.desk.hear("left", encode(FACTS))
    left = hall.node("left")
    assert (left["version"], left["protocol"], left["temperature_c"]) == ("2.0", 8, 63.5)
    assert (left["fault"], left["fault_at"]) == ("no sound device", 970)
    assert (left["connected"], left["since"], left["seen"]) == (True, 1000, 1000)
    assert hall.node("middle")["own"]
    assert hall.node("middle")["connected"]


def test_a_node_that_is_gone_stays_with_when_it_was_seen(hall):
    hall.desk.hear("left", encode(FACTS))
    hall.connected["left"] = False
    hall.refusals["left"] = "has subsea 1.0 with other code"
    hall.after(GONE_S - 1.0)
    assert hall.node("left")["connected"]  # the next scenario may be loading
    hall.after(2.0)
    gone = hall.node("left")
    assert (gone["connected"], gone["since"], gone["seen"]) == (False, None, 1000)
    assert gone["version"] == "2.0"
    hall.connected["left"] = True
    hall.after(1.0)
    assert hall.node("left")["since"] == 1000 + GONE_S + 2.0


def test_a_node_that_was_refused_says_why(hall):
    hall.connected["right"] = False
    hall.refusals["right"] = "has the key of another node"
    hall.after(2 * GONE_S)
    assert hall.node("right")["fault"] == "has the key of another node"
    assert hall.node("right")["fault_at"] is None


def test_pictures_are_asked_for_now_and_then(hall):
    for _ in range(3):
        hall.desk.want_picture("left")
    hall.desk.want_picture("nobody")
    assert hall.orders() == [("left", PictureWanted())]
    hall.after(PICTURE_S)
    hall.desk.want_picture("left")
    assert hall.orders() == [("left", PictureWanted())]
    jpeg = bounded_jpeg(np.zeros((18, 32, 4), np.uint8))
    for part in parts_of(jpeg):
        hall.desk.hear("left", encode(part))
    assert hall.desk.pictures == {"left": jpeg}
    assert hall.node("left")["pictured"] == 1000 + PICTURE_S


def test_one_or_all_restart(hall):
    assert hall.desk.restart("left") == "restarts left"
    assert hall.orders() == [("left", Restart())]
    assert not hall.desk.restarts
    hall.connected["right"] = False
    hall.after(2 * GONE_S)
    with pytest.raises(UserError, match="node right: is not connected"):
        hall.desk.restart("right")
    assert hall.desk.restart("all") == "restarts middle, left; not connected: right"
    assert hall.orders() == [("left", Restart())]
    assert hall.desk.restarts
    hall.desk.restart("left")  # before this computer has begun
    assert hall.desk.restarts
    with pytest.raises(UserError, match="unknown node 'lft'; did you mean 'left'"):
        hall.desk.restart("lft")


def test_computers_with_a_card_are_woken():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as card:
        card.bind(("127.0.0.1", 0))
        card.settimeout(20.0)
        wake = f"127.0.0.1:{card.getsockname()[1]}"
        hall = Hall([NodeTable(name="left", mac="00:1a:2b:3c:4d:5e", wake=wake)])
        with closing(hall.desk):
            assert hall.desk.wake("all") == "wakes left"
            assert card.recv(200).endswith(b"\x00\x1a\x2b\x3c\x4d\x5e")
            with pytest.raises(UserError, match="node right has not a `mac`"):
                hall.desk.wake("right")
            assert hall.node("left")["wakes"]
            assert not hall.node("right")["wakes"]


def test_a_picture_is_bounded_whatever_it_shows():
    noise = np.random.default_rng(1).integers(0, 256, (720, 1280, 4), np.uint8)
    assert len(bounded_jpeg(noise)) <= MOST_PICTURE


def test_a_station_sends_a_picture_and_restarts():
    desk, sea = PictureJoin(), np.zeros((180, 320, 4), np.uint8)
    sea[:, :, 2] = 200
    with closing(FleetStation()) as station:
        station.hear(encode(PictureWanted()))
        assert station.picture_wanted
        station.show(sea)
        assert not station.picture_wanted
        end, parts = time.monotonic() + 30.0, []
        while not parts:
            assert time.monotonic() < end
            parts = station.take_parts()
        assert all(len(part) < SMALL for part in parts)
        [jpeg] = filter(None, (desk.add(from_node(part)) for part in parts))
        station.hear(encode(Restart()))
        assert station.restarts
    with Image.open(BytesIO(jpeg)) as picture:
        assert picture.size == (320, 180)
        assert picture.convert("RGB").getpixel((160, 90))[2] > 180


def test_without_keys_orders_of_an_update_are_refused():
    with closing(FleetStation()) as station:
        station.hear(encode(Rollback()))
        [answer] = map(from_node, station.take_answers())
        assert not answer.done
        assert answer.order == "rollback"
        assert answer.words.startswith("updates need keys: `subsea keys` makes them")
        assert not station.restarts


def test_parts_that_do_not_follow_each_other_are_dropped():
    jpeg = bounded_jpeg(np.random.default_rng(1).integers(0, 256, (90, 160, 4), np.uint8))
    first, second, *others = parts_of(jpeg)
    join = PictureJoin()
    assert [join.add(part) for part in (first, *others)] == [None] * (1 + len(others))
    assert [join.add(part) for part in (first, second, *others)][-1] == jpeg
    assert join.add(PicturePart(4, 0, b"text")) is None  # not a JPEG


def test_frame_times():
    frames = FrameTimes()
    assert frames.take() == (0.0, 0.0)
    for seconds in (0.016, 0.018, 0.05):
        frames.add(seconds)
    assert frames.take() == pytest.approx((28.0, 50.0))
    assert frames.take() == (0.0, 0.0)


@pytest.mark.parametrize("message", [FACTS, PicturePart(9, 3, b"\x00bytes")])
def test_messages_of_nodes(message):
    assert from_node(encode(message)) == message
    with pytest.raises(UserError, match="not one of subsea"):
        from_master(encode(message))


def test_keys_of_a_later_version_are_passed_over():
    content = {"type": "facts", "version": "9.0", "protocol": 99, "a_later_key": 1}
    assert from_node(MAGIC + msgspec.msgpack.encode(content)) == NodeFacts("9.0", 99)


@given(st.binary(max_size=200))
def test_garbage_is_refused(data):
    for read in (from_node, from_master):
        for bytes_ in (data, MAGIC + data):
            try:
                message = read(bytes_)
            except UserError as fault:
                assert "message received" in str(fault)
            else:
                assert isinstance(message, messages.FleetMessage)


@pytest.mark.parametrize(
    "changes",
    [{"version": "a b"}, {"protocol": -1}, {"temperature_c": 1e9}, {"fault": "x" * 201},
     {"free_disk_gb": -1.0}],
)  # fmt: skip
def test_values_beyond_their_limits_are_refused(changes):
    content = {"type": "facts"} | msgspec.structs.asdict(FACTS)
    assert from_node(MAGIC + msgspec.msgpack.encode(content)) == FACTS
    with pytest.raises(UserError, match="not one of subsea"):
        from_node(MAGIC + msgspec.msgpack.encode(content | changes))
