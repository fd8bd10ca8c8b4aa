"""Peers that lie, flood, stall, or come and go do not stop the master or its nodes."""

import resource
import socket
import threading
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
import zmq

from subsea.stage.cluster import gate
from subsea.stage.cluster.identity import identity_of
from subsea.stage.cluster.messages import Diverged, Hello, Identity, PictureDrawn, encode

LONGEST_S = 0.5  # of a picture, on a busy machine


@pytest.fixture
def lively(make_harness, seas, address):
    """A master with a node in step."""
    harness = make_harness(seas[0], address)
    harness.left = harness.node(seas[1], "left")
    harness.show_until(lambda: harness.master.in_step() == ["left"])
    return harness


@pytest.fixture
def peer(lively):
    """A maker of hostile sockets."""
    with zmq.Context() as context:
        made = []

        def connect():
            one = context.socket(zmq.DEALER)
            one.linger, one.sndhwm = 0, 10
            one.connect(f"tcp://{lively.address}")
            made.append(one)
            return one

        yield connect
        for one in made:
            one.close()


@contextmanager
def repeated(action):
    """Call `action` again and again in a thread."""
    ended = threading.Event()

    def run():
        while not ended.is_set():
            action()

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def send(one, *parts):
    """Send if there is room."""
    try:
        one.send_multipart(parts, zmq.NOBLOCK)
    except zmq.Again:
        time.sleep(0.001)


def memory():
    """Resident memory, MB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 2**20


def told(harness, words):
    return sum(words in line for line in harness.told)


def dive_on(harness, true=lambda: False, seconds=1.0):
    """Show pictures until `true` or the time is over; the longest time of one, s."""
    longest, end = 0.0, time.monotonic() + seconds
    while not true() and time.monotonic() < end:
        start = time.monotonic()
        harness.show_pictures()
        longest = max(longest, time.monotonic() - start)
        time.sleep(0.002)
    return longest


def assert_in_step(harness):
    """Assert that the node has not missed a picture."""
    assert harness.master.in_step() == ["left"]
    assert "late" not in harness.master.report()[0]
    assert "dropped" not in harness.master.report()[0]
    number = harness.master._number
    assert harness.left.seen[number] == harness.seen[number]


def test_divergence_said_again_and_again_is_refused(lively, peer, seas):
    hello, liar = encode(Hello("right", identity_of(seas[0]))), peer()
    for message in (hello, encode(PictureDrawn(1)), *[encode(Diverged(5))] * 4, hello):
        liar.send(message)
    dive_on(lively, lambda: told(lively, "node right: its world differed from the master's again"))
    for _ in range(3):
        liar = peer()
        for message in (hello, encode(Diverged(5)), hello, encode(Diverged(5))):
            liar.send(message)
        dive_on(lively, seconds=0.1)
    assert told(lively, "node right: its world differed from the master's again") == 1
    assert_in_step(lively)


def test_a_node_that_comes_and_goes_is_put_out(lively, peer, seas):
    hello = encode(Hello("right", identity_of(seas[0])))
    for _ in range(30):
        one = peer()
        one.send(hello)
        dive_on(lively, seconds=0.03)
        one.close()
    assert told(lively, "node right: came or asked for the state") == 1
    assert told(lively, "node right") <= 20
    assert_in_step(lively)


def test_a_peer_that_asks_for_states_and_reads_none_is_put_out(lively, peer, seas):
    hello, deaf = encode(Hello("right", identity_of(seas[0]))), peer()
    with repeated(lambda: (send(deaf, hello), time.sleep(0.03))):
        longest = dive_on(lively, lambda: told(lively, "put out for 10 s"), seconds=10.0)
    assert told(lively, "node right: came or asked for the state 20 times in 10 s") == 1
    assert longest < LONGEST_S
    assert_in_step(lively)


def raw(address, content):
    """A connection that has greeted as a node, in ZeroMQ's protocol, and sent `content`."""
    host, port = address.split(":")
    one = socket.create_connection((host, int(port)), 1.0)
    ready = b"\x05READY\x0bSocket-Type\x00\x00\x00\x06DEALER"
    one.sendall(b"\xff" + bytes(8) + b"\x7f\x03\x00NULL" + bytes(48))
    one.sendall(b"\x04" + bytes([len(ready)]) + ready + content)
    return one


@pytest.mark.parametrize("size", [0, 200])
def test_a_message_of_endless_parts_ends_the_connection(lively, size):
    part = bytes([1, size]) + bytes(size)  # more follow
    parts, before, ended = part * (2**16 // len(part)), memory(), []

    def flood():
        with suppress(OSError), raw(lively.address, parts) as one:
            while True:
                one.sendall(parts)
        ended.append(True)

    with repeated(flood):
        longest = dive_on(lively, lambda: len(ended) > 4, seconds=10.0)
    dive_on(lively, seconds=0.1)
    assert len(ended) > 4
    assert memory() - before < 50.0
    assert longest < LONGEST_S
    assert told(lively, "refused: ") >= 1
    assert_in_step(lively)


def test_a_flood_of_garbage_ends_its_connections(lively):
    begun = []

    def flood():
        begun.append(True)
        with suppress(OSError), raw(lively.address, b"") as one:
            while True:
                one.sendall(b"\x00\x0agarbage..." * 10)

    with repeated(flood):
        longest = dive_on(lively, lambda: len(begun) > 5, seconds=10.0)
    dive_on(lively, seconds=0.1)
    assert len(begun) > 5
    assert told(lively, "refused: ") <= 4
    assert longest < LONGEST_S
    assert_in_step(lively)


def test_a_flood_of_connections_ends_the_oldest(lively):
    opened = []

    def connect():
        with suppress(OSError):
            opened.append(raw(lively.address, b""))

    with repeated(connect):
        longest = dive_on(lively, lambda: len(opened) > 2 * gate.MAX_STRANGERS, seconds=10.0)
    dive_on(lively, seconds=0.1)
    for one in opened:
        one.close()
    assert told(lively, "refused: too many connections") >= 1
    assert longest < LONGEST_S
    assert_in_step(lively)


def test_lies_of_many_kinds_do_not_flood_the_log(lively, peer, seas):
    liar, ours = peer(), identity_of(seas[0])
    liar.sndhwm = 100
    for seed in range(60):
        other = Identity(ours.version, ours.parts | {"seed": f"{seed + 100}"})
        liar.send(encode(Hello("right", other)))
    dive_on(lively, seconds=0.3)
    assert told(lively, "node right: has subsea") == 5
