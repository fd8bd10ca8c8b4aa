"""All nodes get a version, or none does: over real connections with keys."""

import threading
import time
from contextlib import ExitStack, closing
from importlib.metadata import requires

import msgspec
import pytest
import zmq

from subsea.base.errors import UserError
from subsea.stage.cluster import link
from subsea.stage.cluster.keys import read_keys, write_keys
from subsea.stage.cluster.messages import Hello, Identity
from subsea.stage.cluster.messages import encode as encode_dive
from subsea.stage.cluster.roll_call import RollCall
from subsea.stage.fleet import rollout, updates
from subsea.stage.fleet.installing import LinkedEnvironment
from subsea.stage.fleet.messages import NodeFacts, WheelOffer, WheelPart, encode, from_master
from subsea.stage.fleet.rollout import Rollout
from subsea.stage.fleet.updates import Updates
from subsea.stage.fleet.wheel import read_wheel
from tests.stage.console.conftest import free_port
from tests.stage.fleet.test_installing import make_wheel

NODES = "left", "right"


class NodeThread(threading.Thread):
    """A node that waits for its master, with an environment of its own."""

    def __init__(self, name, folder, address, keys):
        super().__init__(daemon=True)
        self.node, self.version, self.on_duty, self.broken = name, "1.0", True, False
        (folder / "first").mkdir(parents=True)
        (folder / "current").symlink_to("first")
        self.place = LinkedEnvironment(folder / "current", folder)
        self.updates = Updates(lambda: self.place)
        self._context = zmq.Context()
        self._socket, self._monitor = link.calling(self._context, address, keys, "middle", 1 << 22)
        self.start()

    def run(self):
        hello = encode_dive(Hello(self.node, Identity("1.0", {})))
        while self.on_duty:
            if self.broken and self.updates.restarts:
                time.sleep(0.02)  # it does not come back
                continue
            if self.updates.restarts:
                self.version = (self.place.link / "version").read_text()
                self.updates.restarts = self.updates._switched = False
            for message in (hello, encode(NodeFacts(self.version, 8))):
                try:
                    self._socket.send(message, zmq.NOBLOCK)
                except zmq.Again:
                    break
            while self._socket.poll(20):
                self.updates.hear(from_master(self._socket.recv()))
                for answer in self.updates.take_answers():
                    self._socket.send(encode(answer))
            for answer in self.updates.take_answers():
                self._socket.send(encode(answer))

    def close(self):
        self.on_duty = False
        self.join(30.0)
        self._monitor.close(0)
        self._socket.disable_monitor()
        self._socket.close(0)
        self._context.term()
        self.updates.close()


def environment(folder, version):
    folder.mkdir(exist_ok=True)
    (folder / "version").write_text(version)
    return folder


@pytest.fixture
def hall(tmp_path, monkeypatch):
    """A rollout on the master, two nodes, and installations that take no time."""
    write_keys(tmp_path / "keys", ["middle", *NODES])
    monkeypatch.setattr(
        updates.installing, "install",
        lambda wheel, place: environment(place.link.parent / "second", wheel.version),
    )  # fmt: skip
    monkeypatch.setattr(
        updates.installing, "version_before", lambda place: (place.before / "version").read_text()
    )
    monkeypatch.setattr(rollout, "WORK_S", 20.0)
    address = f"127.0.0.1:{free_port()}"
    with ExitStack() as stack:
        nodes = {
            name: stack.enter_context(
                closing(NodeThread(name, tmp_path / name, address,
                                   read_keys(tmp_path / "keys", name, ["middle"])))
            )
            for name in NODES
        }  # fmt: skip
        (tmp_path / "own/first").mkdir(parents=True)
        (tmp_path / "own/current").symlink_to("first")
        own = LinkedEnvironment(tmp_path / "own/current", tmp_path)
        for place in (own, *(node.place for node in nodes.values())):
            environment(place.link.resolve(), "1.0")
        roll_call = stack.enter_context(
            closing(RollCall(address, read_keys(tmp_path / "keys", "middle", NODES)))
        )
        mine = stack.enter_context(closing(Updates(lambda: own)))
        made = Rollout(roll_call, NODES, mine, lambda line: None)
        assert made.gather() == []
        yield made, nodes, own


def version(place):
    return (place.link / "version").read_text()


@pytest.fixture
def wheel(tmp_path):
    return read_wheel(make_wheel(tmp_path, needs=requires("subsea")))


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
