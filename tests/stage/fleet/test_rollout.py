"""All nodes get a version, or none does: over real connections with keys."""

from contextlib import closing

import msgspec
import pytest
import zmq

from subsea.base.errors import UserError
from subsea.stage.cluster import link
from subsea.stage.cluster.keys import read_keys, write_keys
from subsea.stage.fleet import rollout, updates
from subsea.stage.fleet.installing import LinkedEnvironment
from subsea.stage.fleet.messages import NodeFacts, WheelOffer, WheelPart, encode, from_master
from subsea.stage.fleet.updates import Updates
from subsea.stage.fleet.wheel import read_wheel
from tests.stage.fleet.conftest import NODES, version
from tests.stage.fleet.test_installing import make_wheel


def test_all_computers_get_a_version_and_the_one_before_back(hall, wheel, monkeypatch):
    monkeypatch.setattr(rollout, "WHEEL_PART", 100)  # several parts
    made, nodes, own = hall
    assert {name: facts.version for name, facts in made.facts.items()} == dict.fromkeys(
        NODES, "1.0"
    )
    made.update(wheel)
    assert [version(place) for place in (own, *(one.place for one in nodes.values()))] == [
        "2.0", "2.0", "2.0",
    ]  # fmt: skip
    assert all(node.version == "2.0" for node in nodes.values())
    made.roll_back()
    assert version(own) == "1.0"
    assert all(node.version == "1.0" for node in nodes.values())


def test_one_that_refuses_leaves_all_as_they_are(hall, wheel, monkeypatch):
    made, nodes, own = hall
    full = updates.installing.install

    def install(wheel, place):
        if place.link.parent.name == "right":
            raise UserError("the disk is full")
        return full(wheel, place)

    monkeypatch.setattr(updates.installing, "install", install)
    with pytest.raises(UserError, match="right: the disk is full"):
        made.update(wheel)
    assert version(own) == "1.0"
    assert all(version(node.place) == "1.0" for node in nodes.values())


def test_packages_that_are_missing_are_found_before_anything_is_sent(hall, tmp_path):
    made, _, _ = hall
    other = read_wheel(make_wheel(tmp_path, "3.0", needs=["magic"]))
    with pytest.raises(UserError, match="needs other packages than this version: magic"):
        made.update(other)
    assert not list(tmp_path.glob("*/.incoming/*.whl"))


def test_a_node_that_does_not_come_back_keeps_the_master_as_it_is(hall, wheel, monkeypatch):
    monkeypatch.setattr(rollout, "WORK_S", 3.0)
    made, nodes, own = hall
    nodes["left"].broken = True
    with pytest.raises(UserError, match=r"left: not back with another version in 3 s\. This"):
        made.update(wheel)
    assert version(own) == "1.0"


def test_a_changed_wheel_is_not_installed(tmp_path, wheel):
    (tmp_path / "first").mkdir()
    (tmp_path / "current").symlink_to("first")
    place = LinkedEnvironment(tmp_path / "current", tmp_path)
    data = bytearray(wheel.path.read_bytes())
    offer = WheelOffer(wheel.path.name, "2.0", wheel.size, wheel.digest, list(wheel.requires))
    with closing(Updates(lambda: place)) as node:
        node.hear(offer)
        data[len(data) // 2] ^= 1
        node.hear(WheelPart(0, bytes(data)))
        assert [answer.done for answer in node.take_answers()] == [True, True]
        node.hear(from_master(encode(rollout.Install())))
        while not (answers := node.take_answers()):
            pass
        [answer] = answers
        assert not answer.done
        assert "not a wheel" in answer.words or "not the one that was offered" in answer.words
        node.hear(msgspec.structs.replace(WheelPart(0, b"x"), offset=7))
        assert "does not follow" in node.take_answers()[0].words
        node.hear(rollout.Switch())
        while not (answers := node.take_answers()):
            pass
        assert "no version is installed" in answers[0].words


def test_a_stranger_with_another_key_is_not_heard(hall, tmp_path):
    made, _, _ = hall
    write_keys(tmp_path / "strange", ["left", "middle"])
    strange = read_keys(tmp_path / "strange", "left", ["middle"])
    real = read_keys(tmp_path / "keys", "left", ["middle"])
    keys = strange._replace(others=real.others)
    context = zmq.Context()
    socket, monitor = link.calling(context, made._call.address, keys, "middle", 1 << 20)
    try:
        with pytest.raises(zmq.Again):
            for _ in range(20):
                socket.poll(50)
                socket.send(encode(NodeFacts("6.6", 8)), zmq.NOBLOCK)
    finally:
        monitor.close(0)
        socket.disable_monitor()
        socket.close(0)
        context.term()
    made.facts.clear()
    assert made.gather() == []
    assert {facts.version for facts in made.facts.values()} == {"1.0"}
