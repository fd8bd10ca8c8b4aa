"""A restarted master goes on with the dive of its nodes, unless what they send is wrong."""

import math
import threading
import time
from contextlib import closing

import pytest
import zmq

from subsea.base.errors import UserError
from subsea.stage.cluster import master
from subsea.stage.cluster.follower import Follower
from subsea.stage.cluster.identity import identity_of
from subsea.stage.cluster.messages import (
    PART,
    SLICE,
    Hello,
    Resume,
    StatePart,
    encode,
    from_master,
)
from subsea.submarine.vessel import NEUTRAL
from subsea.world import snapshot
from subsea.world.step import step

LATE_TICK = 10**6


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    """Wait long for nodes of a busy machine; all nodes come, so no test waits that long."""
    monkeypatch.setattr(master, "GATHER_S", 60.0)
    monkeypatch.setattr(master, "FETCH_S", 60.0)


def drifted(harness, node, ticks):
    """Let a node drift and call; returns its tick and checksum."""
    node.rest()
    node.node.drift(ticks)
    node.node._heard_s = node.node._called_s = -1e9
    node.asleep = False
    return node.node.world.state.tick, snapshot.checksum(node.node.world)


def end_master(harness):
    """End the master and leave the nodes."""
    harness.master.close()
    harness._stack.pop_all()


def told(harness, words):
    return sum(words in line for line in harness.told)


@pytest.mark.parametrize("fish", [4, 250])
def test_a_restarted_master_resumes_at_the_tick_of_the_last_node(
    make_harness, make_sea, address, fish
):
    seas = [make_sea(fish=fish) for _ in range(4)]
    harness = make_harness(seas[0], address, timeout_s=1.0)
    left, right = harness.node(seas[1], "left"), harness.node(seas[2], "right")
    harness.show_until(lambda: len(harness.master.in_step()) == 2)
    end_master(harness)
    drifted(harness, left, 20)
    furthest = drifted(harness, right, 40)
    state = snapshot.take(right.node.world)
    assert (len(state) > SLICE) == (fish > 4)  # more than one request
    another = make_harness(seas[3], address)
    another.master.resume()
    assert (seas[3].state.tick, snapshot.checksum(seas[3])) == furthest
    assert another.told == [f"resumed the dive of node right at tick {furthest[0]}"]
    another.show_until(lambda: len(another.master.in_step()) == 2)
    another.show_pictures(5)
    number = another.master._number
    another.show_pictures()
    for node in (left, right):
        assert node.seen[number] == another.seen[number]
        node.close()
    assert not told(another, "differs")


def test_new_nodes_do_not_delay_the_start(make_harness, seas, address):
    harness = make_harness(seas[0], address)
    tick = seas[0].state.tick
    harness.node(seas[1], "left"), harness.node(seas[2], "right")
    start = time.monotonic()
    harness.master.resume()
    assert time.monotonic() - start < 30.0  # it does not wait for more
    assert (seas[0].state.tick, harness.told) == (tick, [])


def test_absent_nodes_are_not_waited_for_long(make_harness, seas, address, monkeypatch):
    monkeypatch.setattr(master, "GATHER_S", 0.2)
    harness = make_harness(seas[0], address)
    checks = []
    harness.master.resume(lambda: checks.append(True))
    assert checks
    assert harness.told == []


class Liar(threading.Thread):
    """A node that claims a late tick and answers requests with parts that `answer` makes."""

    def __init__(self, address, identity, answer):
        super().__init__(daemon=True)
        self.address, self.identity, self.answer = address, identity, answer
        self.ended = threading.Event()
        self.start()

    def run(self):
        with zmq.Context() as context, context.socket(zmq.DEALER) as one:
            one.linger = 0
            one.connect(f"tcp://{self.address}")
            one.send(encode(Hello("left", self.identity, "", LATE_TICK)))
            while not self.ended.is_set():
                if one.poll(10):
                    message = from_master(one.recv())
                    if isinstance(message, Resume):
                        for part in self.answer(message.offset):
                            one.send(encode(part))

    def close(self):
        self.ended.set()
        self.join(60.0)


@pytest.fixture
def resumed_from(make_harness, make_sea, address):
    """A function that resumes from a liar; returns harness and the checksum before."""
    liars = []

    def resume(answer):
        world = make_sea()
        harness = make_harness(world, address, nodes=["left"])
        before = snapshot.checksum(world)
        liars.append(Liar(address, identity_of(world), answer))
        harness.master.resume()
        return harness, before

    yield resume
    for liar in liars:
        liar.close()


def parts_of(state):
    """A function that answers requests with slices of a state."""
    return lambda offset: [
        StatePart(len(state), at, state[at : at + PART])
        for at in range(offset, min(offset + SLICE, len(state)), PART)
    ]


@pytest.mark.parametrize(
    ("answer", "fault"),
    [
        (parts_of(b"garbage"), "not a snapshot of this dive: it does not begin as one"),
        (parts_of(snapshot.MAGIC + bytes(5000)), "not a snapshot of this dive"),
    ],
)  # fmt: skip
def test_after_a_wrong_state_the_dive_starts_from_its_beginning(resumed_from, answer, fault):
    harness, before = resumed_from(answer)
    assert snapshot.checksum(harness.master.world) == before
    [line] = harness.told
    assert line.startswith(f"node left: {fault}")
    assert line.endswith("; the dive starts from its beginning")
    harness.show_pictures(5)


def test_a_state_that_never_comes_is_not_waited_for_long(resumed_from, monkeypatch):
    monkeypatch.setattr(master, "FETCH_S", 0.3)
    harness, before = resumed_from(lambda offset: [])
    assert snapshot.checksum(harness.master.world) == before
    assert harness.told == [
        "node left: has not sent its state in 0.3 s; the dive starts from its beginning"
    ]


def test_a_node_calls_as_soon_as_it_is_connected(seas, address):
    with closing(Follower(seas[1], "left", "master", address)) as node:
        for _ in range(3):
            node.picture(0.0)
        assert node._called_s == -math.inf  # the next picture calls again


def test_a_leaving_pilot_ends_the_wait(make_harness, seas, address):
    harness = make_harness(seas[0], address)

    def leave():
        raise UserError("closed")

    with pytest.raises(UserError, match="closed"):
        harness.master.resume(leave)


def test_a_node_that_was_in_no_dive_claims_no_tick(make_harness, make_sea, address):
    world = make_sea()
    for _ in range(30):
        step(world, NEUTRAL)
    harness = make_harness(make_sea(), address, nodes=["left"])
    harness.node(world, "left")
    harness.master.resume()
    assert harness.told == []
    assert harness.master.world.state.tick == 1
