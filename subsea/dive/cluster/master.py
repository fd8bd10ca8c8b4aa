"""The master of a cluster: sends the ticks of every picture and waits until all have drawn."""

import math
import secrets
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import zmq
from zmq.auth.thread import ThreadAuthenticator

from subsea.core.errors import UserError
from subsea.dive.cluster import link
from subsea.dive.cluster.identity import difference, identity_of
from subsea.dive.cluster.keys import Keys
from subsea.dive.cluster.messages import (
    SMALL,
    Diverged,
    FromMaster,
    FromNode,
    Hello,
    Refused,
    Swap,
    WorldState,
    encode,
    from_node,
    picture_of,
    ticks_of,
)
from subsea.dive.cluster.waits import WaitStatistics
from subsea.submarine.helm import Helm
from subsea.submarine.rail import Rail
from subsea.world import snapshot
from subsea.world.step import step
from subsea.world.world import World

Say = Callable[[str], None]

CHECK_TICKS = 30  # interval of checksums of the world: once a second
NUDGE_S = 0.02  # interval at which late nodes are probed
NEAR = 30  # most pictures that a node may be behind to be waited for again
LONGEST_PROBATION_S = 60.0  # longest time without waiting for a late node
SOON_S = 60.0  # a node that diverges twice within this time is refused
AT_ONCE = 1000  # most messages read at a time, so that a flood does not stop the dive


@dataclass
class _Node:
    """The state of a node as the master sees it."""

    name: str
    route: bytes | None = None  # its connection; None: not connected
    in_step: bool = False  # whether the master waits for it
    drawn: int = 0  # number of its last picture ...
    drawn_s: float = 0.0  # ... and when it was drawn
    not_before_s: float = 0.0  # the master does not wait for it before
    diverged_s: float = -SOON_S
    came: bool = False  # whether it has been in step before
    refusal: str = ""  # why a node of its name was refused ...
    refused_s: float = 0.0  # ... and when that was reported
    waits: WaitStatistics = field(default_factory=WaitStatistics)


class Master:
    """The connections to the nodes: call `picture`, draw, `swap`, show, in turn."""

    def __init__(
        self,
        world: World,
        nodes: Sequence[str],
        address: str,
        keys: Keys | None = None,
        timeout_s: float = 2.0,
        tell: Say = lambda message: None,
        view: str = "",
    ) -> None:
        """Listen at `address` for `nodes`, which are all but the master itself.

        A node is waited for up to `timeout_s`. With `keys` only nodes with known keys may
        connect, without keys only this computer. `view` describes the theatre and the display;
        nodes with another view are refused. Raises UserErrors.
        """
        self.world = world
        self._timeout_s, self._tell, self._keys = timeout_s, tell, keys
        self._identity = identity_of(world, view)
        self._nodes = {name: _Node(name) for name in nodes}
        self._dive = secrets.token_hex(8)
        self._number = 0
        self._checked = -CHECK_TICKS  # the tick of the last checksum
        self._refusals = 0
        self._context: Any = zmq.Context()
        self._authenticator = None
        try:
            if keys:
                self._authenticator = ThreadAuthenticator(self._context)
                self._authenticator.start()
                self._authenticator.configure_curve_callback(credentials_provider=_KnownKeys(keys))
            self._socket = link.listening(self._context, address, keys, SMALL)
        except BaseException:
            self._leave()
            raise
        self._failures = link.failures(self._socket)

    def picture(self, ticks: Iterable[Helm | Rail], alpha: float) -> None:
        """Send the next picture to all nodes and step its ticks here.

        A sequence is sent first, so that all computers step at the same time. From any other
        iterable, as of a tour that depends on the world, each tick is taken after the previous
        one was stepped.
        """
        self._hear(0.0)
        state = self.world.state
        tick, check, lights = state.tick, "", bool(state.submarine.lights[0])
        if tick - self._checked >= CHECK_TICKS:
            check, self._checked = snapshot.checksum(self.world), tick
        self._number += 1
        if isinstance(ticks, Sequence):
            picture = picture_of(self._number, tick, alpha, ticks, check, lights)
            self._send_all(picture)
            for one in ticks_of(picture):
                step(self.world, one)
            return
        made = []
        for one in ticks:
            [exact] = ticks_of(picture_of(self._number, tick, alpha, [one], check))
            step(self.world, exact)
            made.append(exact)
        self._send_all(picture_of(self._number, tick, alpha, made, check, lights))

    def swap(self) -> None:
        """Wait until all nodes in step have drawn, or time out, and tell them to show it."""
        start = time.monotonic()
        late: list[_Node] = []
        while missing := [node for node in self._present() if self._awaited(node)]:
            waited = time.monotonic() - start
            if waited >= self._timeout_s:
                late = missing
                break
            self._hear(min(NUDGE_S, self._timeout_s - waited))
            for node in missing:
                if self._awaited(node):
                    # A repeated message: only whether it can be sent matters.
                    self._send(node, encode(Swap(self._number - 1)))
        now = time.monotonic()
        for node in late:
            node.in_step = False
            node.waits.late += 1
            probation_s = min(2.0 * node.waits.late * self._timeout_s, LONGEST_PROBATION_S)
            node.not_before_s = now + probation_s
            self._tell(f"node {node.name}: has not drawn in {self._timeout_s:g} s; going on")
        message = encode(Swap(self._number))
        for node in self._present():
            if node.in_step:
                node.waits.add(max(node.drawn_s - start, 0.0))
            self._send(node, message)

    def report(self) -> list[str]:
        """One line for each node with its wait times and events."""
        return [f"node {node.name}: {node.waits.words()}" for node in self._nodes.values()]

    def in_step(self) -> list[str]:
        """The names of the nodes that are waited for."""
        return [node.name for node in self._present() if node.in_step]

    def close(self) -> None:
        """Close all connections."""
        self._failures.close(0)
        self._socket.disable_monitor()
        self._socket.close()
        self._leave()

    def _hear(self, wait_s: float) -> None:
        """Handle messages of nodes, waiting up to `wait_s` for the first."""
        while link.failed(self._failures):
            self._report_refused("a connection without a key that is known, or none of subsea's")
        if not self._socket.poll(math.ceil(1000.0 * wait_s)):
            return
        asking: dict[str, _Node] = {}
        for _ in range(AT_ONCE):
            try:
                frames = self._socket.recv_multipart(zmq.NOBLOCK, copy=False)
            except zmq.Again:
                break
            try:
                if len(frames) != 2:
                    raise UserError("what was received is no message of subsea")
                message = from_node(frames[1].bytes)
            except UserError as fault:
                self._report_refused(str(fault))
                self._reply(frames[0].bytes, Refused(str(fault)[:200]))
                continue
            node = self._answer(frames[0].bytes, message, frames[1])
            if node:
                asking[node.name] = node
        if asking:
            state = encode(WorldState(self._dive, self._number, snapshot.take(self.world)))
            for node in asking.values():
                self._send(node, state)

    def _answer(self, route: bytes, message: FromNode, frame: Any) -> _Node | None:
        """Handle one message; return the node if it needs the state."""
        if isinstance(message, Hello):
            return self._welcome(route, message, frame)
        node = next((node for node in self._present() if node.route == route), None)
        if node is None:
            return None  # a message of a dropped connection
        if isinstance(message, Diverged):
            return self._resynchronize(node, message.tick)
        now = time.monotonic()
        node.drawn, node.drawn_s = min(message.number, self._number), now
        if not node.in_step and self._number - node.drawn <= NEAR and now >= node.not_before_s:
            node.waits.rejoined += node.came
            self._tell(f"node {node.name}: is in step{' again' * node.came}")
            node.in_step = node.came = True
        return None

    def _welcome(self, route: bytes, hello: Hello, frame: Any) -> _Node | None:
        reason = self._objection(hello, frame)
        if reason:
            self._refuse(hello.node, reason)
            self._reply(route, Refused(f"the master refuses node {hello.node}: it {reason}"))
            return None
        node = self._nodes[hello.node]
        if node.route == route and hello.dive == self._dive:
            return None  # the master was only silent for a while
        if node.route not in (None, route):
            reason = f"another computer has come as node {node.name}"
            self._reply(node.route, Refused(reason))
            self._drop(node, reason)
        node.route, node.in_step = route, False
        return node

    def _refuse(self, name: str, reason: str) -> None:
        """Report a refused node, at most once in `SOON_S`, as it may try again and again."""
        now = time.monotonic()
        if name not in self._nodes:
            self._report_refused(f"node {name}: {reason}")
        elif (node := self._nodes[name]).refusal != reason or now - node.refused_s > SOON_S:
            node.refusal, node.refused_s = reason, now
            self._tell(f"node {name}: {reason}: refused")

    def _objection(self, hello: Hello, frame: Any) -> str:
        """Why a node may not take part, to follow its name; empty if it may."""
        if hello.node not in self._nodes:
            return f"is not among the nodes of the theatre: {', '.join(self._nodes)}"
        if self._keys and frame.get("User-Id").encode() != self._keys.others[hello.node]:
            return "has the key of another node"
        return difference(hello.identity, self._identity)

    def _resynchronize(self, node: _Node, tick: int) -> _Node | None:
        """Send the state again to a node whose world differs; refuse it the second time."""
        now = time.monotonic()
        node.waits.diverged += 1
        node.in_step = False
        if now - node.diverged_s < SOON_S:
            reason = (
                f"its world differed from the master's again at tick {tick}; its processor or its "
                "packages compute otherwise"
            )
            self._reply(node.route, Refused(f"the master refuses node {node.name}: {reason}"))
            self._drop(node, reason)
            return None
        node.diverged_s = now
        self._tell(f"node {node.name}: its world differs at tick {tick}; it fetches the state")
        return node

    def _present(self) -> list[_Node]:
        return [node for node in self._nodes.values() if node.route is not None]

    def _awaited(self, node: _Node) -> bool:
        return node.in_step and node.drawn < self._number

    def _send(self, node: _Node, data: bytes) -> None:
        """Send to a node, or drop it if it does not read."""
        try:
            self._socket.send_multipart([node.route, data], zmq.NOBLOCK)
        except zmq.Again:
            self._drop(node, "takes no messages any more")
        except zmq.ZMQError as fault:
            if fault.errno != zmq.EHOSTUNREACH:
                raise
            self._drop(node, "is gone")

    def _send_all(self, message: FromMaster) -> None:
        data = encode(message)
        for node in self._present():
            self._send(node, data)

    def _reply(self, route: bytes | None, message: FromMaster) -> None:
        """Send to a connection, ignoring errors."""
        with suppress(zmq.ZMQError):
            self._socket.send_multipart([route, encode(message)], zmq.NOBLOCK)

    def _drop(self, node: _Node, reason: str) -> None:
        node.route, node.in_step = None, False
        node.waits.dropped += 1
        self._tell(f"node {node.name}: {reason}; going on without it")

    def _report_refused(self, reason: str) -> None:
        """Report a refused message the 1st, 10th, 100th time, so that the log is not flooded."""
        self._refusals += 1
        if str(self._refusals).strip("0") == "1":
            self._tell(f"refused: {reason} ({self._refusals} so far)")

    def _leave(self) -> None:
        if self._authenticator:
            self._authenticator.stop()
        self._context.term()


class _KnownKeys:
    """The known public keys, for the ZeroMQ authenticator."""

    def __init__(self, keys: Keys) -> None:
        self._public = set(keys.others.values())

    def callback(self, domain: str, key: bytes) -> bool:
        """Whether a key in Z85 is known; called by the authenticator."""
        return key in self._public
