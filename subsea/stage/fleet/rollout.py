"""The master's side of an update: all computers get a version, or none does."""

import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress

from subsea.base.errors import UserError
from subsea.stage.cluster.roll_call import RollCall
from subsea.stage.fleet import messages
from subsea.stage.fleet.messages import (
    WHEEL_PART,
    Answer,
    FromMaster,
    Install,
    NodeFacts,
    Rollback,
    Switch,
    UpdateOrder,
    WheelOffer,
    WheelPart,
)
from subsea.stage.fleet.updates import Updates
from subsea.stage.fleet.wheel import Wheel

CALL_S = 30.0  # in which all nodes call
ORDER_S = 15.0  # longest time for an answer to a short order
WORK_S = 600.0  # longest time to install, or to come back after a restart: kernels may be compiled
AHEAD = 8  # parts of a wheel that are sent before the first of them is answered
HEAR_S = 0.2

Tell = Callable[[str], object]


class Rollout:
    """Orders for all nodes, and for this computer, whose own steps run here."""

    def __init__(self, roll_call: RollCall, nodes: Sequence[str], own: Updates, tell: Tell) -> None:
        """`nodes` are all but this computer's."""
        self._call, self._nodes, self._own, self._tell = roll_call, tuple(nodes), own, tell
        self.facts: dict[str, NodeFacts] = {}
        self._heard_s: dict[str, float] = {}
        self._answers: list[tuple[str, Answer]] = []

    def gather(self) -> list[str]:
        """Wait until all nodes have told their version; returns those that have not."""
        end = time.monotonic() + CALL_S
        while len(self.facts) < len(self._nodes) and time.monotonic() < end:
            self._hear()
        return [name for name in self._nodes if name not in self.facts]

    def update(self, wheel: Wheel) -> None:
        """Install a wheel everywhere, then switch; a UserError before which nothing has changed."""
        offer = WheelOffer(
            wheel.path.name, wheel.version, wheel.size, wheel.digest, list(wheel.requires)
        )
        self._everywhere(offer, ORDER_S)
        self._send_wheel(wheel)
        self._tell(f"installs {wheel.version} on {', '.join(self._nodes)} and this computer")
        self._everywhere(Install(), WORK_S)
        self._switched(Switch(), dict.fromkeys(self._nodes, wheel.version))

    def roll_back(self) -> None:
        """Return everywhere to the version before; a UserError if a computer has none."""
        versions = self._everywhere(Rollback(only_check=True), ORDER_S)
        for name, version in versions.items():
            self._tell(f"{name}: returns to {version}")
        self._switched(Rollback(), versions)

    def _switched(self, order: Switch | Rollback, versions: Mapping[str, str]) -> None:
        """Let the nodes switch and come back, then this computer."""
        for name in self._nodes:
            self._call.send(name, messages.encode(order))
        late = self._come_back(versions)
        if late:
            names = ", ".join(late)
            raise UserError(
                f"{names}: not back with another version in {WORK_S:g} s. This computer has not "
                "switched. Look at the messages there, then try again or `subsea fleet rollback`"
            )
        self._ask_own(order)
        self._tell("all computers have switched")

    def _come_back(self, versions: Mapping[str, str]) -> list[str]:
        """Wait until all nodes call with their new version; returns those that do not."""
        asked_s = time.monotonic()
        end = asked_s + WORK_S

        def is_back(name: str) -> bool:
            """True if a dive that has begun since then says that version."""
            if name not in self.facts or self.facts[name].version != versions[name]:
                return False
            return self._heard_s[name] - self.facts[name].up_s >= asked_s

        def waiting() -> list[str]:
            return [name for name in self._nodes if not is_back(name)]

        told: set[str] = set()
        while (missing := waiting()) and time.monotonic() < end:
            list(self._heard(""))  # a refusal ends it; answers before the restart may be lost
            for name in {*self._nodes} - {*missing} - told:
                told.add(name)
                self._tell(f"{name}: is back with {versions[name]}")
        return missing

    def _send_wheel(self, wheel: Wheel) -> None:
        """Send a wheel to all nodes and to this computer, a few parts ahead of their answers."""
        self._tell(f"sends {wheel.path.name}, {wheel.size / 1e6:.1f} MB")
        with wheel.path.open("rb") as file:
            sent, done = 0, Counter(dict.fromkeys(self._nodes, 0))
            end = time.monotonic() + WORK_S
            while min(done.values(), default=wheel.size) < wheel.size or sent < wheel.size:
                slowest = min(done.values(), default=sent)
                while sent < wheel.size and sent - slowest < AHEAD * WHEEL_PART:
                    part = WheelPart(sent, file.read(WHEEL_PART))
                    for name in self._nodes:
                        self._call.send(name, messages.encode(part))
                    self._ask_own(part)
                    sent += len(part.data)
                for name, answer in self._heard("wheel"):
                    done[name] = max(done[name], answer.offset)
                if time.monotonic() > end:
                    late = [name for name, size in done.items() if size < wheel.size]
                    raise UserError(f"{', '.join(late)}: has not taken the wheel")

    def _everywhere(self, order: UpdateOrder, limit_s: float) -> dict[str, str]:
        """Give an order to all computers; their words by node, or a UserError if one refuses."""
        words = self._ask_nodes(order, limit_s)
        self._ask_own(order)
        return words

    def _ask_nodes(self, order: FromMaster, limit_s: float) -> dict[str, str]:
        tag, end = str(order.__struct_config__.tag), time.monotonic() + limit_s
        for name in self._nodes:
            self._call.send(name, messages.encode(order))
        words: dict[str, str] = {}
        while len(words) < len(self._nodes) and time.monotonic() < end:
            words |= {name: answer.words for name, answer in self._heard(tag)}
        if missing := [name for name in self._nodes if name not in words]:
            raise UserError(f"{', '.join(missing)}: no answer in {limit_s:g} s")
        return words

    def _ask_own(self, order: UpdateOrder) -> None:
        """Carry out an order on this computer."""
        self._own.hear(order)
        end = time.monotonic() + WORK_S
        while not (answers := self._own.take_answers()):
            if time.monotonic() > end:
                raise UserError("this computer: no answer")
            time.sleep(0.01)
        for answer in answers:
            if not answer.done:
                raise UserError(f"this computer: {answer.words}")

    def _heard(self, tag: str) -> Iterator[tuple[str, Answer]]:
        """Hear the nodes, and give their answers to an order; a UserError for a refusal."""
        self._hear()
        answers, self._answers = self._answers, []
        for name, answer in answers:
            if not answer.done:
                raise UserError(f"{name}: {answer.words}")
            if answer.order == tag:
                yield name, answer

    def _hear(self) -> None:
        for name, data in self._call.hear(HEAR_S):
            if name not in self._nodes:
                continue
            with suppress(UserError):  # of another version
                message = messages.from_node(data)
                if isinstance(message, NodeFacts):
                    self.facts[name], self._heard_s[name] = message, time.monotonic()
                elif isinstance(message, Answer):
                    self._answers.append((name, message))
