"""Attack the master of a cluster by peers that lie, flood and stall, while a node is in step.

    python tools/fuzz_peers.py [ATTACK…] [--rounds N] [--seconds S] [--seed S]

The peers run in a process of their own and may do all that a computer may that is let in. A finding
is: an exception of the master, a picture of more than LONGEST_S, more than MEMORY_MB of growth, a
healthy node that loses step, or a start that takes more than WAIT_S. Exit code 1 if there is any.
"""

import argparse
import multiprocessing
import os
import random
import resource
import socket
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import msgspec
import zmq

from subsea.base.errors import UserError
from subsea.scenario.load import load_scenario
from subsea.stage.cluster import messages
from subsea.stage.cluster.follower import Follower
from subsea.stage.cluster.identity import identity_of
from subsea.stage.cluster.master import FETCH_S, GATHER_S, Master
from subsea.submarine.vessel import NEUTRAL, Helm
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import World

LONGEST_S = 0.5  # of a picture, on a busy machine
MEMORY_MB = 50
WAIT_S = GATHER_S + FETCH_S + 1.0  # to resume a dive
PICTURE_S = 1 / 60
GREETING = b"\xff" + bytes(8) + b"\x7f\x03\x00NULL" + bytes(16 + 1 + 31)
READY = b"\x05READY\x0bSocket-Type\x00\x00\x00\x06DEALER\x08Identity\x00\x00\x00\x00"
FORK = multiprocessing.get_context("fork")


class Target(msgspec.Struct):
    """The master to attack."""

    address: str
    hello: bytes  # a valid one of the node "evil"
    state: bytes  # a valid snapshot
    identity: messages.Identity
    random: random.Random
    peers: int  # at once


# Attacks: each runs until its process is ended


def endless_parts(target: Target) -> None:
    """One message of parts without end, by raw connections."""
    size = target.random.choice([0, 1, 100, 255, 4000])
    part = frame(bytes(size), 1) * (2**16 // (size + 3))
    flood(target, lambda: part)


def many_parts(target: Target) -> None:
    """Messages of many parts that end."""
    part = frame(b"x", 1) * target.random.choice([3, 1000, 20000]) + frame(b"x", 0)
    flood(target, lambda: part)


def huge_frames(target: Target) -> None:
    """Frames that claim huge lengths, as messages and commands."""
    length = target.random.choice([2**16, 2**31, 2**40, 2**63 - 1])
    kind = target.random.choice([2, 3, 6])
    flood(target, lambda: bytes([kind]) + length.to_bytes(8, "big") + bytes(2**16))


def pings(target: Target) -> None:
    """Heartbeats without end, the answers not read."""
    ping = frame(b"\x04PING\x00\x00" + b"x" * 16, 4) * 1000
    flood(target, lambda: ping)


def garbage(target: Target) -> None:
    """Damaged messages as fast as they go."""
    rng = target.random
    flood(target, lambda: frame(damaged(target.hello, rng), 0) * 50)


def hellos(target: Target) -> None:
    """Requests for the state, the answers not read."""
    rate = target.random.choice([10, 30, 1000])

    def one() -> bytes:
        time.sleep(1 / rate)
        return frame(target.hello, 0)

    flood(target, one)


def liars(target: Target) -> None:
    """Valid messages with false content, the answers read."""
    rng, rate = target.random, target.random.choice([10, 100, 10000])
    with calling(target) as sockets:
        while True:
            one = rng.choice(sockets)
            with suppress(zmq.Again):
                one.send(lie(target), zmq.NOBLOCK)
            while one.poll(0):
                one.recv_multipart()
            time.sleep(1 / rate)


def comers_and_goers(target: Target) -> None:
    """Connections that ask for the state and go."""
    pause_s = target.random.choice([0.0, 0.01, 0.1])
    while True:
        with calling(target) as sockets:
            for one in sockets:
                one.send(target.hello)
                one.send(messages.encode(messages.PictureDrawn(2**40)))
            sockets[0].poll(500)
            time.sleep(pause_s)


def connections(target: Target) -> None:
    """Connections that are opened, and kept or closed."""
    kept, opened = target.random.choice([0, 100, 500]), []
    while True:
        with suppress(OSError):
            opened.append(connect(target))
            if target.random.random() < 0.3:
                opened[-1].sendall((GREETING + frame(READY, 4))[: target.random.randrange(100)])
        if len(opened) > kept:
            opened.pop(0).close()


def stallers(target: Target) -> None:
    """Greetings and messages that stop in the middle."""
    whole = GREETING + frame(READY, 4) + frame(target.hello, 0) * 20
    opened = []
    while True:
        with suppress(OSError):
            opened.append(connect(target))
            opened[-1].sendall(whole[: target.random.randrange(len(whole))])
        time.sleep(0.02)
        opened = opened[-100:]


def resumers(target: Target) -> None:
    """Nodes that claim to be in a dive, and send a false state of it, too much, or nothing."""
    rng, kind = target.random, target.random.randrange(6)
    claim = messages.Hello("evil", target.identity, "", rng.choice([2**20, 2**48]))
    state = target.state
    if kind < 2:  # damaged; otherwise valid
        state = damaged(state, rng)
    with calling(target) as sockets:
        one = sockets[0]
        one.sndhwm = 10**5
        while True:
            with suppress(zmq.Again):
                one.send(messages.encode(claim), zmq.NOBLOCK)
            if not one.poll(500):
                continue
            with suppress(UserError, zmq.Again):
                asked = messages.from_master(one.recv_multipart()[-1])
                if not isinstance(asked, messages.Resume):
                    continue
                if kind == 5:  # many tiny parts of one message
                    one.send_multipart([b"x"] * 10**6, zmq.NOBLOCK)
                size = messages.PART if kind < 4 else 1
                for at in range(asked.offset, len(state), size):
                    if kind != 3:  # silent
                        part = messages.StatePart(len(state), at, state[at : at + size])
                        one.send(messages.encode(part), zmq.NOBLOCK)


ATTACKS: dict[str, Callable[[Target], None]] = {
    one.__name__.replace("_", "-"): one
    for one in (
        *(endless_parts, many_parts, huge_frames, pings, garbage, hellos, liars),
        *(comers_and_goers, connections, stallers, resumers),
    )
}


def frame(content: bytes, flags: int) -> bytes:
    """A frame of ZMTP; flags: 1 for more parts, 4 for a command."""
    if len(content) > 255:
        return bytes([flags | 2]) + len(content).to_bytes(8, "big") + content
    return bytes([flags, len(content)]) + content


def connect(target: Target) -> socket.socket:
    """A new TCP connection."""
    host, _, port = target.address.rpartition(":")
    return socket.create_connection((host, int(port)), 2.0)


def flood(target: Target, make: Callable[[], bytes]) -> None:
    """Send what is made over raw connections, opened again when ended, and read nothing."""
    peers: list[socket.socket | None] = [None] * target.peers
    while True:
        for k, one in enumerate(peers):
            try:
                if one is None:
                    one = peers[k] = connect(target)
                    one.sendall(GREETING + frame(READY, 4))
                    one.settimeout(0.02)
                one.sendall(make())
            except TimeoutError:
                pass
            except OSError:
                if one:
                    one.close()
                peers[k] = None


@contextmanager
def calling(target: Target) -> Iterator[list[Any]]:
    """Sockets as nodes have them."""
    with zmq.Context() as context:
        sockets = [context.socket(zmq.DEALER) for _ in range(target.peers)]
        for one in sockets:
            one.linger = 0
            one.connect(f"tcp://{target.address}")
        yield sockets
        for one in sockets:
            one.close()


def lie(target: Target) -> bytes:
    """A valid message with false content."""
    rng = target.random
    number = rng.choice([0, 1, rng.randrange(1000), 2**48])
    told = msgspec.structs.replace(target.identity, seed=rng.randrange(3))
    name, dive = rng.choice(["evil", "middle", "x" * 64]), rng.choice(["", "f" * 64])
    return messages.encode(
        rng.choice(
            [
                messages.Hello(name, rng.choice([told, target.identity]), dive),
                messages.Hello("evil", target.identity),
                messages.PictureDrawn(number),
                messages.Diverged(number),
                messages.Diverged(number),
            ]
        )
    )


def damaged(sample: bytes, rng: random.Random) -> bytes:
    """A sample cut off, with flipped bits, or noise."""
    made = bytearray(sample[: rng.randrange(1, len(sample))])
    for _ in range(rng.randint(0, 8)):
        made[rng.randrange(len(made))] ^= 1 << rng.randrange(8)
    return rng.choice([bytes(made), rng.randbytes(rng.randrange(4000))])


# Observation


def sea() -> World:
    """A small world."""
    world = create_world(load_scenario("schooling")[0], fish=4)
    step(world, NEUTRAL)
    return world


def follow(world: World, address: str) -> None:
    """A healthy node."""
    node = Follower(world, "left", "master", address)
    while True:
        if node.picture(0.02) is not None:
            node.swap()


def attack(target: Target, name: str) -> None:
    """Attack until the process is ended."""
    try:
        ATTACKS[name](target)
    except BaseException:
        traceback.print_exc()
        os._exit(1)


def memory_mb() -> float:
    """Resident memory."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 2**20


def show(master: Master, seconds: float, until: Callable[[], bool] = lambda: False) -> float:
    """Show pictures for some time; the longest time of one, s."""
    longest, end = 0.0, time.monotonic() + seconds
    while time.monotonic() < end and not until():
        start = time.monotonic()
        master.picture([Helm(surge=0.5)], 0.5)
        master.swap()
        spent = time.monotonic() - start
        longest = max(longest, spent)
        time.sleep(max(PICTURE_S - spent, 0.0))
    return longest


def attacked(name: str, seconds: float, rng: random.Random, worlds: list[World]) -> str:
    """Run one attack; the finding, or an empty text."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{free.getsockname()[1]}"
    identity = identity_of(worlds[0])
    hello = messages.encode(messages.Hello("evil", identity))
    state = snapshot.take(worlds[0])
    target = Target(address, hello, state, identity, rng, rng.choice([1, 2, 8, 40]))
    told: list[str] = []
    node = FORK.Process(target=follow, args=(worlds[1], address), daemon=True)
    evil = FORK.Process(target=attack, args=(target, name), daemon=True)
    node.start()
    evil.start()
    resumes = name == "resumers"
    if not resumes:
        os.kill(evil.pid or 0, 19)  # stopped until the node is in step
    master = Master(worlds[0], ["left", "evil"], address, tell=told.append)
    try:
        before, begun = memory_mb(), time.monotonic()
        if resumes:
            master.resume()
        waited, resumed_mb = time.monotonic() - begun, memory_mb() - before
        show(master, 30.0, lambda: "left" in master.in_step())
        before = memory_mb()
        os.kill(evil.pid or 0, 18)
        longest = show(master, seconds)
        grown = max(memory_mb() - before, resumed_mb)
        [left] = [line for line in master.report() if "node left" in line]
        what = []
        if not evil.is_alive():
            what.append("the attack ended by itself")
        if waited > WAIT_S:
            what.append(f"the dive began after {waited:.1f} s")
        if longest > LONGEST_S:
            what.append(f"a picture of {longest:.2f} s")
        if grown > MEMORY_MB:
            what.append(f"{grown:.0f} MB more memory")
        if "left" not in master.in_step() or "late" in left or "dropped" in left:
            what.append(f"lost step: {left}")
        if len(told) > 40:
            what.append(f"{len(told)} lines in the log")
        print(f"{name}: {target.peers} peers, {1e3 * longest:.0f} ms, {grown:.0f} MB", flush=True)
        for line in told if what else ():
            print("   ", line)
        return "; ".join(what)
    except (UserError, Exception):
        return traceback.format_exc(limit=-4)
    finally:
        evil.kill()
        node.kill()
        evil.join()
        node.join()
        master.close()


def main() -> int:
    """Run from the command line; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("attacks", metavar="ATTACK", nargs="*", help=f"of {', '.join(ATTACKS)}")
    parser.add_argument("--rounds", type=int, default=5, help="of each attack (5)")
    parser.add_argument("--seconds", type=float, default=3.0, help="length of an attack (3)")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    if wrong := set(options.attacks) - ATTACKS.keys():
        parser.error(f"unknown attack {min(wrong)!r}; there are: {', '.join(ATTACKS)}")
    worlds, findings, tried = [sea(), sea()], 0, 0
    for name in options.attacks or ATTACKS:
        for number in range(options.rounds):
            rng = random.Random(f"{options.seed} {name} {number}")
            tried += 1
            if found := attacked(name, options.seconds, rng, worlds):
                findings += 1
                print(f"{name}, round {number}: {found}", flush=True)
    print(f"{tried} attacks, {findings} findings")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
