"""A hall of two nodes that wait for their master, with environments of their own."""

import threading
import time
from contextlib import ExitStack, closing, suppress
from importlib.metadata import requires

import pytest
import zmq

from subsea.stage.cluster import link
from subsea.stage.cluster.keys import read_keys, write_keys
from subsea.stage.cluster.messages import Hello, Identity
from subsea.stage.cluster.messages import encode as encode_dive
from subsea.stage.cluster.roll_call import RollCall
from subsea.stage.fleet import rollout, updates
from subsea.stage.fleet.installing import LinkedEnvironment
from subsea.stage.fleet.messages import NodeFacts, encode, from_master
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
            self._say(hello, encode(NodeFacts(self.version, 8)))
            while self._socket.poll(20):
                self.updates.hear(from_master(self._socket.recv()))
                self._say(*map(encode, self.updates.take_answers()))
            self._say(*map(encode, self.updates.take_answers()))

    def _say(self, *messages):
        """Send, but do not wait for a master that has gone."""
        with suppress(zmq.Again):
            for message in messages:
                self._socket.send(message, zmq.NOBLOCK)

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
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
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
