"""The master of a cluster: sends the ticks of every picture and waits until all have drawn."""

import math
import secrets
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import zmq

from subsea.base.errors import UserError, printable
from subsea.dive.presented import NOTHING
from subsea.stage.cluster import link, messages
from subsea.stage.cluster.identity import NO_VIEW, difference, identity_of, may_open
from subsea.stage.cluster.keys import Keys
from subsea.stage.theatre.line_up import LineUpState
from subsea.submarine.vessel import Helm, Rail
from subsea.world import snapshot
from subsea.world.step import step
from subsea.world.world import World

RECENT = 10_000  # pictures in the 95th percentile


@dataclass
class WaitStatistics:
    """Wait times of one node in seconds, and counts of events."""

    frames: int = 0  # pictures shown in step
    total_s: float = 0.0
    longest_s: float = 0.0
    recent_s: deque[float] = field(default_factory=lambda: deque(maxlen=RECENT))
    late: int = 0  # timeouts
    dropped: int = 0  # lost connections
    rejoined: int = 0  # returns
    diverged: int = 0  # times that its world differed

    def add(self, wait_s: float) -> None:
        """Add the time from the master's picture to the node's."""
        self.frames += 1
        self.total_s += wait_s
        self.longest_s = max(self.longest_s, wait_s)
        self.recent_s.append(wait_s)

    @property
    def mean_s(self) -> float:
        """Mean wait time."""
        return self.total_s / max(self.frames, 1)

    def words(self) -> str:
        """One line with the number of pictures, the wait times and the events."""
        late = float(np.percentile(self.recent_s, 95)) if self.frames else 0.0
        line = (
            f"{self.frames} picture{'s' * (self.frames != 1)}, "
            f"waited for {1e3 * self.mean_s:.1f} ms on average, "
            f"p95 {1e3 * late:.1f} ms, at most {1e3 * self.longest_s:.1f} ms"
        )
        for what in ("late", "dropped", "rejoined", "diverged"):
            count = getattr(self, what)
            line += f"; {what} {'once' if count == 1 else f'{count} times'}" if count else ""
        return line


SOON_S = 60.0  # a node that diverges twice within this time is refused


@dataclass
class NodeRecord:
    """The state of a node as the master sees it."""

    name: str
    route: bytes | None = None  # its connection; None: not connected
    tick: int = 0  # of its world when it came, if that is of a dive
    asks: bool = False  # True if it needs the state
    sent_s: float = -math.inf  # when the state was sent
    in_step: bool = False  # True if the master waits for it
    drawn: int = 0  # number of its last picture ...
    drawn_s: float = 0.0  # ... and when it was drawn
    not_before_s: float = 0.0  # the master does not wait for it before
    diverged_s: float = -SOON_S
    came: bool = False  # True if it has been in step before
    refusal: str = ""  # the last reported reason to refuse a node of its name
    waits: WaitStatistics = field(default_factory=WaitStatistics)


Say = Callable[[str], None]

CHECK_TICKS = 30  # interval of checksums of the world: once a second
NUDGE_S = 0.02  # interval at which late nodes are probed
FLEET_HEARD = 1000  # messages of the fleet that nobody has taken
NEAR = 30  # most pictures that a node may be behind to be waited for again
LONGEST_PROBATION_S = 60.0  # longest time without waiting for a late node
LINE_UP_S = 1.0  # longest time between two messages with the line-up
STATE_S = 1.0  # shortest time between two states sent to a node
GATHER_S = 1.5  # longest time in which nodes come that may know the dive: they call once a second
FETCH_S = 3.0  # longest time that one takes to send its state


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
        view: Mapping[str, str] = NO_VIEW,
    ) -> None:
        """Listen at `address` for `nodes`, which are all but the master itself.

        A node is waited for up to `timeout_s`. With `keys` only nodes with known keys may
        connect, without keys only this computer. `view` names parts of the theatre and the display;
        nodes with another view are refused. Raises UserErrors.
        """
        self.world, self.presented = world, NOTHING
        self.line_up: LineUpState | None = None  # of the theatre, for all nodes
        self._lined_up: tuple[LineUpState | None, float] = None, 0.0  # sent last, and when
        self.reports: deque[str] = deque(maxlen=64)  # lines of nodes for the presenter
        self.asked: deque[bytes] = deque(maxlen=64)  # commands of the nodes' keyboards
        self.fleet_heard: deque[tuple[str, bytes]] = deque(maxlen=FLEET_HEARD)  # node, message
        self.offers = ""  # the scenario that nodes may open to take part; empty: none
        self._timeout_s, self._tell, self._keys = timeout_s, tell, keys
        self._identity = identity_of(world, view)
        self.nodes = {name: NodeRecord(name) for name in nodes}
        self._dive = secrets.token_hex(8)
        self._number = self._refusals = 0
        self._checked = -CHECK_TICKS  # the tick of the last checksum
        self._source: NodeRecord | None = None  # the node whose state was asked for ...
        self._parts: deque[messages.StatePart] = deque(maxlen=64)  # ... and its parts
        self._context: Any = zmq.Context()
        self._authenticator: Any = None
        try:
            if keys:
                self._authenticator = link.authenticator(self._context, keys)
            self._socket, self._failures = link.listening(
                self._context, address, keys, messages.SMALL
            )
            self._begun_s = time.monotonic()
        except BaseException:
            self._leave()
            raise

    def resume(self, check: Callable[[], object] = lambda: None) -> None:
        """Go on from the nodes' latest state, if they are in a dive whose master has gone.

        To be called before the first picture. It returns at once when all nodes have come and are
        new, else GATHER_S after the master began to listen. `check` is called while waiting, and
        may raise. A state that does not come or does not fit is reported; the world then stays as
        it is.
        """
        end = self._begun_s + GATHER_S
        while len(self._present()) < len(self.nodes) and time.monotonic() < end:
            check()
            self._hear(NUDGE_S)
        source = max(self._present(), key=lambda node: node.tick, default=None)
        if source is None or source.tick <= self.world.state.tick:
            return
        try:
            snapshot.restore(self.world, self._fetch(source, check))
        except UserError as fault:
            self._tell(f"node {source.name}: {fault}; the dive starts from its beginning")
        else:
            self._tell(f"resumed the dive of node {source.name} at tick {self.world.state.tick}")

    def _fetch(self, source: NodeRecord, check: Callable[[], object]) -> bytes:
        """Fetch a node's state in slices, as messages to the master are small; or a UserError."""
        self._source, route, end = source, source.route, time.monotonic() + FETCH_S
        data, size, asked = bytearray(), 1, 0
        while len(data) < size:
            if len(data) == asked:
                self._send(source, messages.encode(messages.Resume(asked)))
                asked += messages.SLICE
            check()
            self._hear(NUDGE_S)
            if source.route != route:
                raise UserError("has gone before it sent its state")
            if time.monotonic() > end:
                raise UserError(f"has not sent its state in {FETCH_S:g} s")
            while self._parts:
                part = self._parts.popleft()
                size = part.size
                data += part.data
        return bytes(data)

    def picture(self, ticks: Iterable[Helm | Rail], alpha: float) -> None:
        """Send the next picture to all nodes and step its ticks here.

        A sequence is sent first, so that all computers step at the same time. From any other
        iterable, as of a tour that depends on the world, each tick is taken after the previous
        one was stepped.
        """
        self._hear(0.0)
        self._send_states()
        state = self.world.state
        tick, check, lights = state.tick, "", bool(state.submarine.lights[0])
        if tick - self._checked >= CHECK_TICKS:
            check, self._checked = snapshot.checksum(self.world), tick
        self._number += 1
        lined_up = self._news_of_line_up()
        if isinstance(ticks, Sequence):
            picture = messages.picture_of(
                self._number, tick, alpha, ticks, check, lights, self.presented, lined_up
            )
            self._send_all(picture)
            for steered in messages.ticks_of(picture):
                step(self.world, steered)
            return
        made = []
        for steered in ticks:
            [exact] = messages.ticks_of(
                messages.picture_of(self._number, tick, alpha, [steered], check)
            )
            step(self.world, exact)
            made.append(exact)
        self._send_all(
            messages.picture_of(
                self._number, tick, alpha, made, check, lights, self.presented, lined_up
            )
        )

    def _news_of_line_up(self) -> LineUpState | None:
        """The line-up if it has changed, and now and then, as nodes may have come; else None."""
        sent, sent_s = self._lined_up
        now = time.monotonic()
        if self.line_up is None or (self.line_up is sent and now - sent_s < LINE_UP_S):
            return None
        self._lined_up = self.line_up, now
        return self.line_up

    def renew_view(self, view: Mapping[str, str]) -> None:
        """Take other parts of the view that nodes must have, after a file was saved."""
        self._identity = identity_of(self.world, view)

    def swap(self) -> None:
        """Wait until all nodes in step have drawn, or time out, and tell them to show it."""
        start = time.monotonic()
        late: list[NodeRecord] = []
        while missing := [node for node in self._present() if self._awaited(node)]:
            waited = time.monotonic() - start
            if waited >= self._timeout_s:
                late = missing
                break
            self._hear(min(NUDGE_S, self._timeout_s - waited))
            for node in missing:
                if self._awaited(node):
                    # A repeated message: only whether it can be sent matters.
                    self._send(node, messages.encode(messages.Swap(self._number - 1)))
        now = time.monotonic()
        for node in late:
            node.in_step = False
            node.waits.late += 1
            probation_s = min(2.0 * node.waits.late * self._timeout_s, LONGEST_PROBATION_S)
            node.not_before_s = now + probation_s
            self._tell(f"node {node.name}: has not drawn in {self._timeout_s:g} s; going on")
        for node in self._present():
            if node.in_step:
                node.waits.add(max(node.drawn_s - start, 0.0))
            self._send(node, messages.encode(messages.Swap(self._number)))

    def send_fleet(self, name: str, data: bytes) -> None:
        """Send a message of the fleet to a node, if it is connected."""
        node = self.nodes[name]
        if node.route is not None:
            self._send(node, data)

    def report(self) -> list[str]:
        """One line for each node with its wait times and events."""
        return [f"node {node.name}: {node.waits.words()}" for node in self.nodes.values()]

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
        """Handle messages of nodes, waiting up to `wait_s` for the first.

        Messages that never end are left for the next call, as others wait for this thread.
        """
        end = time.monotonic() + wait_s + NUDGE_S
        while link.failed(self._failures) and time.monotonic() < end:
            self._report_refused("a connection without a key that is known, or none of subsea's")
        while self._socket.poll(math.ceil(1000.0 * wait_s)):
            self._handle(*self._socket.recv_multipart(copy=False))
            if time.monotonic() > end:
                return
            wait_s = 0.0

    def _handle(self, sender: Any, *content: Any) -> None:
        """Handle one message: the frames of its route and its content."""
        route = sender.bytes
        try:
            if len(content) != 1:
                raise UserError("the message received is not one of subsea")
            data = content[0].bytes
            if data.startswith(messages.FLEET):
                self.fleet_heard += [(node.name, data) for node in self._from(route)]
                return
            message = messages.from_node(data)
        except UserError as fault:
            self._report_refused(str(fault))
            self._reply(route, messages.Refused(str(fault)[:200]))
            return
        if isinstance(message, messages.Hello):
            self._welcome(route, message, content[0])
        else:
            for node in self._from(route):
                self._answer(node, message)

    def _answer(
        self,
        node: NodeRecord,
        message: messages.PictureDrawn
        | messages.Diverged
        | messages.StatePart
        | messages.NodeReport
        | messages.NodeRequest,
    ) -> None:
        if isinstance(message, messages.NodeRequest):
            self.asked.append(message.command)
            return
        if isinstance(message, messages.NodeReport):
            self.reports.append(f"node {node.name}: {printable(message.words)}")
            return
        if isinstance(message, messages.Diverged):
            self._resynchronize(node, message.tick)
            return
        if isinstance(message, messages.StatePart):
            if node is self._source:
                self._parts.append(message)
            return
        now = time.monotonic()
        node.drawn, node.drawn_s = min(message.number, self._number), now
        near = not node.asks and self._number - node.drawn <= NEAR
        if not node.in_step and near and now >= node.not_before_s:
            node.waits.rejoined += node.came
            self._tell(f"node {node.name}: is in step{' again' * node.came}")
            node.in_step = node.came = True

    def _send_states(self) -> None:
        """Send the state to the nodes that need it."""
        now = time.monotonic()
        asking = [node for node in self._present() if node.asks and now - node.sent_s > STATE_S]
        if not asking:
            return
        state = messages.encode(
            messages.WorldState(self._dive, self._number, snapshot.take(self.world))
        )
        for node in asking:
            node.asks, node.sent_s = False, now
            self._send(node, state)

    def _welcome(self, route: bytes, hello: messages.Hello, frame: Any) -> None:
        if not (reason := self._objection(hello, frame)):
            reason = difference(hello.identity, self._identity)
            if reason and self.offers and may_open(hello.identity, self._identity):
                self._reply(route, messages.OpenSea(self.offers, self.world.state.seed))
                return
        if reason:
            self._refuse(hello.node, reason)
            self._reply(
                route, messages.Refused(f"the master refuses node {hello.node}: it {reason}")
            )
            return
        node = self.nodes[hello.node]
        if node.route == route and hello.dive == self._dive:
            return  # the master was only silent for a while
        if node.route not in (None, route):
            reason = f"another computer has come as node {node.name}"
            self._reply(node.route, messages.Refused(reason))
            self._drop(node, reason)
        node.route, node.tick, node.refusal = route, hello.tick, ""
        node.asks, node.in_step = True, False

    def _refuse(self, name: str, reason: str) -> None:
        """Report each reason to refuse a node once, as the node may try again and again."""
        if name not in self.nodes:
            self._report_refused(f"node {name}: {reason}")
        elif self.nodes[name].refusal != reason:
            self.nodes[name].refusal = reason
            self._tell(f"node {name}: {reason}: refused")

    def _objection(self, hello: messages.Hello, frame: Any) -> str:
        """Why a computer is not a node of this theatre, to follow its name; empty if it is."""
        if hello.node not in self.nodes:
            return f"is not among the nodes of the theatre: {', '.join(self.nodes)}"
        if self._keys and frame.get("User-Id").encode() != self._keys.others[hello.node]:
            return "has the key of another node"
        return ""

    def _resynchronize(self, node: NodeRecord, tick: int) -> None:
        """Send the state again to a node whose world differs; refuse it the second time."""
        now = time.monotonic()
        node.waits.diverged += 1
        if now - node.diverged_s < SOON_S:
            reason = f"its world differed from the master's again at tick {tick}; its processor or "
            reason += "its packages compute otherwise"
            self._reply(
                node.route, messages.Refused(f"the master refuses node {node.name}: {reason}")
            )
            self._drop(node, reason)
            return
        node.diverged_s = now
        self._tell(f"node {node.name}: its world differs at tick {tick}; it fetches the state")
        node.asks, node.in_step = True, False

    def _from(self, route: bytes) -> list[NodeRecord]:
        """The node of a connection; none of a dropped one."""
        return [node for node in self._present() if node.route == route]

    def _present(self) -> list[NodeRecord]:
        return [node for node in self.nodes.values() if node.route is not None]

    def _awaited(self, node: NodeRecord) -> bool:
        return node.in_step and node.drawn < self._number

    def _send(self, node: NodeRecord, data: bytes) -> None:
        """Send to a node, or drop it if it does not read."""
        try:
            self._socket.send_multipart([node.route, data], zmq.NOBLOCK)
        except zmq.Again:
            self._drop(node, "takes no messages any more")
        except zmq.ZMQError as fault:
            if fault.errno != zmq.EHOSTUNREACH:
                raise
            self._drop(node, "is gone")

    def _send_all(self, message: messages.FromMaster) -> None:
        data = messages.encode(message)
        for node in self._present():
            self._send(node, data)

    def _reply(self, route: bytes | None, message: messages.FromMaster) -> None:
        """Send to a connection, ignoring errors."""
        with suppress(zmq.ZMQError):
            self._socket.send_multipart([route, messages.encode(message)], zmq.NOBLOCK)

    def _drop(self, node: NodeRecord, reason: str) -> None:
        node.route, node.in_step, node.asks = None, False, False
        node.waits.dropped += 1
        self._tell(f"node {node.name}: {reason}; going on without it")

    def _report_refused(self, reason: str) -> None:
        """Report the 1st, 10th, 100th refusal, so that the log is not flooded."""
        self._refusals += 1
        if str(self._refusals).rstrip("0") == "1":
            self._tell(f"refused: {reason} ({self._refusals} so far)")

    def _leave(self) -> None:
        if self._authenticator:
            self._authenticator.stop()
        self._context.term()
