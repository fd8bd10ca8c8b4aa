"""The technician's desk on the master: state and power of all computers and projectors."""

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from subsea.base.errors import UserError, printable, unknown
from subsea.stage.fleet import messages
from subsea.stage.fleet.pictures import PictureJoin
from subsea.stage.fleet.projectors import ALL, Projectors
from subsea.stage.fleet.wake import wake
from subsea.stage.theatre.theatre_file import NodeTable

GONE_S = 10.0  # without a connection, after which a node is gone: the next scenario may load
PICTURE_S = 3.0  # shortest time between two pictures of a node


@dataclass
class _Computer:
    """A computer as the desk knows it; times are seconds since 1970, 0 for never."""

    facts: messages.NodeFacts | None = None
    heard: float = 0.0  # when the facts came
    since: float = 0.0  # connected from then on; 0: gone
    seen: float = 0.0  # connected last
    refusal: str = ""  # why the master refused it last
    asked: float = 0.0  # for a picture
    pictured: float = 0.0  # when its last picture came
    join: PictureJoin = field(default_factory=PictureJoin)


class FleetDesk:
    """Collects what nodes report, and gives orders to nodes and projectors."""

    def __init__(
        self, names: Sequence[str], own: str, cards: Sequence[NodeTable], projectors: Projectors,
        clock: Callable[[], float] = time.time,
    ) -> None:  # fmt: skip
        """`names` are the nodes and `own` is this computer's; `cards` tell how to wake them.

        `clock` gives seconds since 1970.
        """
        self.own, self.projectors = own, projectors
        self.pictures: dict[str, bytes] = {}  # the last JPEG of each node
        self.restarts = False  # True if this computer is to start again
        self._clock = clock
        self._computers = {name: _Computer() for name in names}
        self._cards = {one.name: one for one in cards}
        self._orders: list[tuple[str, messages.FromMaster]] = []

    def hear(self, name: str, data: bytes) -> None:
        """Take a message of a node; a UserError for one that is faulty."""
        message = messages.from_node(data)
        if isinstance(message, messages.NodeFacts):
            self.note_facts(name, message)
        elif not isinstance(message, messages.PicturePart):
            return  # an answer to an update that has ended
        elif (jpeg := self._computers[name].join.add(message)) is not None:
            self.pictures[name] = jpeg
            self._computers[name].pictured = self._clock()

    def note_facts(self, name: str, facts: messages.NodeFacts) -> None:
        """Note the state of a node, or of this computer."""
        computer = self._computers[name]
        computer.facts, computer.heard = facts, self._clock()

    def update(self, nodes: Iterable[Mapping[str, Any]]) -> None:
        """Note which nodes are connected, as `LeaderTicks.nodes` says; call it for each picture."""
        now = self._clock()
        self._follow(self.own, True, now)
        for node in nodes:
            self._follow(node["name"], node["connected"], now)
            self._computers[node["name"]].refusal = node["refusal"]

    def _follow(self, name: str, connected: bool, now: float) -> None:
        computer = self._computers[name]
        if connected:
            computer.since, computer.seen = computer.since or now, now
        elif now - computer.seen > GONE_S:
            computer.since = 0.0

    def want_picture(self, name: str) -> None:
        """Ask a node for a picture, if the last request is old enough."""
        computer, now = self._computers.get(name), self._clock()
        if computer is not None and computer.since and now - computer.asked >= PICTURE_S:
            computer.asked = now
            self._orders.append((name, messages.PictureWanted()))

    def take_orders(self) -> list[tuple[str, bytes]]:
        """Take the messages for nodes: name, message."""
        orders = [(name, messages.encode(order)) for name, order in self._orders]
        self._orders.clear()
        return orders

    def restart(self, name: str) -> str:
        """Restart the dive of a computer, or of `all`; returns what was done, or a UserError."""
        self._check_name(name)
        chosen = [one for one in self._computers if name in (ALL, one)]
        gone = [one for one in chosen if not self._computers[one].since]
        if len(gone) == len(chosen):
            raise UserError(f"node {name}: is not connected, so it cannot restart")
        self._orders += [
            (one, messages.Restart()) for one in chosen if one != self.own and one not in gone
        ]
        self.restarts = self.restarts or self.own in chosen
        left = f"; not connected: {', '.join(gone)}" if gone else ""
        return f"restarts {', '.join(one for one in chosen if one not in gone)}{left}"

    def wake(self, name: str) -> str:
        """Switch a computer on, or `all` with a `mac`; returns what was done, or a UserError."""
        self._check_name(name)
        chosen = [card for one, card in self._cards.items() if name in (ALL, one)]
        if not chosen:
            where = "no node has" if name == ALL else f"node {name} has not"
            raise UserError(f"{where} a `mac` in a table [[node]] of the theatre file")
        for card in chosen:
            wake(card)
        return f"wakes {', '.join(card.name for card in chosen)}"

    def _check_name(self, name: str) -> None:
        if name != ALL and name not in self._computers:
            raise unknown("node", name, [*self._computers, ALL])

    def describe(self) -> dict[str, Any]:
        """The state of all: docs/reference/console-interface.md."""
        return {
            "nodes": [self._described(name) for name in self._computers],
            "projectors": self.projectors.describe(),
        }

    def _described(self, name: str) -> dict[str, Any]:
        computer = self._computers[name]
        facts = computer.facts
        fault, when = computer.refusal, 0.0
        if facts is not None and facts.fault:
            fault, when = printable(facts.fault), computer.heard - facts.fault_ago_s
        about: dict[str, Any] = {
            "name": name,
            "own": name == self.own,
            "connected": computer.since > 0.0,
            "since": round(computer.since) or None,
            "seen": round(computer.seen) or None,
            "fault": fault,
            "fault_at": round(when) or None,
            "pictured": round(computer.pictured) or None,
            "wakes": name in self._cards,
        }
        for key in KEYS:
            about[key] = None if facts is None else getattr(facts, key)
        return about

    def close(self) -> None:
        """Stop asking the projectors."""
        self.projectors.close()


KEYS = (
    "version", "protocol", "system", "renderer", "temperature_c", "free_disk_gb", "frame_ms",
    "longest_ms", "up_s",
)  # fmt: skip
"""The facts of a node that the console shows as they are."""
