"""Sources of ticks: this computer, or the master of a cluster."""

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from subsea.base.progress import say
from subsea.behavior.teleop import TeleopCommand
from subsea.dive.idle_timer import TickClock
from subsea.dive.pilot import Pilot, Prediction
from subsea.dive.presented import NOTHING, Presented
from subsea.dive.timeline import Timeline
from subsea.dive.tour import Steer
from subsea.scenario.load import scenario_file, scenario_names
from subsea.stage.theatre.theatre_file import Theatre
from subsea.submarine.vessel import NEUTRAL, Helm, Rail
from subsea.view.display_rigs import cockpit
from subsea.view.rig import CameraPose
from subsea.world.step import Order
from subsea.world.world import TICK_S, World

if TYPE_CHECKING:  # loaded only in a cluster
    from subsea.stage.cluster.follower import Follower
    from subsea.stage.cluster.master import Master

PATIENCE_S = 0.02  # a follower waits for the next picture before it handles window events
HOLD_S = 0.25  # the same while the master is silent


class NodeStatus(msgspec.Struct, frozen=True):
    """A node of a cluster, and how long the master waited for it."""

    name: str
    connected: bool
    in_step: bool
    last_ms: float  # of the last picture
    mean_ms: float
    longest_ms: float
    late: int  # times that the master went on without it
    dropped: int  # lost connections
    diverged: int  # times that its world differed


class TickSource(ABC):
    """Makes the ticks of each picture, and synchronises when it is shown."""

    has_pilot = True  # True on the pilot's computer
    shared = False  # True in a cluster
    steered_fish: int | None = None  # the fish that the pilot steers; None in a cluster
    timeline: Timeline | None = None  # controls time; None in a cluster
    steering: "SteeringSource | None" = None  # None: the master steers
    waiting = ""  # the cause of a wait; empty while the dive runs
    idle_s = 0.0  # time that the last call of `advance` spent waiting
    presented: Presented = NOTHING  # over the sea; of a cluster, the master's
    wanted: tuple[str, int] | None = None  # name and seed of the scenario that a master waits with

    @abstractmethod
    def advance(self, elapsed_s: float) -> float | None:
        """Make the ticks that are due `elapsed_s` after the last picture.

        Returns the point between the last two ticks at which to draw, in [0, 1]; None
        if there is nothing new to draw.
        """

    @abstractmethod
    def eye(self) -> CameraPose:
        """The pose of the pilot's eye in that picture."""

    def resume(self, check: Callable[[], object]) -> None:  # noqa: B027 - only a master does
        """Go on with a dive that has lost its master, before a tour and the first picture.

        `check` is called while waiting, and may raise.
        """

    def offer(self, scenario: Path) -> None:  # noqa: B027 - only a master does
        """Let nodes open the scenario of this file, if it has a name, to take part."""

    def set_tour(self, tour: Steer | None) -> None:
        """Let a tour steer from the next tick on, until there is input; None: the pilot steers."""
        if self.steering:
            self.steering.tour = tour

    def swap(self, drawn: Callable[[], None]) -> None:  # noqa: B027 - one computer never waits
        """Wait until the picture may be shown; `drawn` waits until it is drawn."""

    def nodes(self) -> list[NodeStatus]:
        """The nodes that a master leads."""
        return []

    def close(self) -> list[str]:
        """End the dive; returns lines to report."""
        return []


class SteeringSource:
    """Steers the submarine: a tour until there is input, then the pilot."""

    def __init__(self, world: World, pilot: Pilot, tour: Steer | None) -> None:
        self.tour = tour
        self._world, self._pilot = world, pilot

    def ticks(self, number: int) -> Iterator[Helm | Rail]:
        """Commands for the next ticks; take each one when the tick before is made."""
        for _ in range(number):
            helm = self._pilot.helm(TICK_S)
            if helm != NEUTRAL:
                self.tour = None
            yield self.tour(self._world) if self.tour else helm


class LocalTicks(TickSource):
    """Ticks by this computer's clock and pilot, or a tour until there is input."""

    timeline: Timeline
    steering: SteeringSource

    def __init__(self, world: World, pilot: Pilot, tour: Steer | None = None) -> None:
        self.timeline = Timeline(world)
        self._world, self._pilot = world, pilot
        self.steering, self._prediction = SteeringSource(world, pilot, tour), Prediction()

    def advance(self, elapsed_s: float) -> float:
        """Make the ticks that are due."""
        for one in self._orders(self.timeline.due(elapsed_s)):
            self.timeline.make(one)
        carried = self.steering.tour or self.steered_fish is not None
        self._prediction.update(elapsed_s, not carried and not self.timeline.paused)
        return self.timeline.alpha

    def eye(self) -> CameraPose:
        """Predict the pose, unless on a tour or while time is paused."""
        return self._prediction.eye(self._world, self.timeline.alpha, self._pilot.predicted(TICK_S))

    def _orders(self, number: int) -> Iterator[Order]:
        """Commands to the submarine, or to the fish that is steered."""
        if self.steered_fish is None:
            return self.steering.ticks(number)
        return (
            teleop_command(self._pilot.commanded(TICK_S), self.steered_fish) for _ in range(number)
        )


def teleop_command(helm: Helm, fish: int) -> TeleopCommand:
    """The command to a fish for a helm: it rises if the submarine would pitch up or rise."""
    if helm.full_stop:
        return TeleopCommand(fish)
    rise = min(max(helm.pitch + helm.heave, -1.0), 1.0)
    return TeleopCommand(fish, helm.yaw, rise, helm.surge)


class LeaderTicks(TickSource):
    """Ticks as `LocalTicks`, made by all computers of a cluster together."""

    shared = True
    steering: SteeringSource

    def __init__(
        self, master: "Master", pilot: Pilot, tour: Steer | None = None, resumes: bool = True,
        leads: bool = False,
    ) -> None:  # fmt: skip
        """`leads`: nodes open the scenario that this computer shows."""
        self._master, self._clock, self._resumes = master, TickClock(TICK_S), resumes
        self._leads = leads
        self.steering = SteeringSource(master.world, pilot, tour)

    def offer(self, scenario: Path) -> None:
        """Let nodes open this scenario, if they can by its name."""
        named = scenario.stem in scenario_names() and scenario_file(scenario.stem) == scenario
        self._master.offers = scenario.stem if self._leads and named else ""

    def resume(self, check: Callable[[], object]) -> None:
        """Go on from the state of the nodes, unless the dive is to start from its beginning."""
        if self._resumes:
            self._master.resume(check)

    def advance(self, elapsed_s: float) -> float:
        """Make the ticks that are due, here and on all nodes."""
        ticks = self.steering.ticks(self._clock.advance(elapsed_s))
        self._master.presented = self.presented
        # The pilot's commands do not depend on the world: they can be sent ahead of the ticks.
        self._master.picture(ticks if self.steering.tour else list(ticks), self._clock.alpha)
        return self._clock.alpha

    def eye(self) -> CameraPose:
        """Interpolate as on all nodes, a tick late."""
        return cockpit(self._master.world.state.submarine, self._clock.alpha)

    def swap(self, drawn: Callable[[], None]) -> None:
        """Wait until all nodes have drawn."""
        drawn()
        self._master.swap()

    def nodes(self) -> list[NodeStatus]:
        """All nodes of the theatre but the master's own."""
        return [
            NodeStatus(
                name=one.name,
                connected=one.route is not None,
                in_step=one.in_step,
                last_ms=1e3 * one.waits.recent_s[-1] if one.waits.frames else 0.0,
                mean_ms=1e3 * one.waits.mean_s,
                longest_ms=1e3 * one.waits.longest_s,
                late=one.waits.late,
                dropped=one.waits.dropped,
                diverged=one.waits.diverged,
            )
            for one in self._master.nodes.values()
        ]

    def close(self) -> list[str]:
        """Report the wait times for each node."""
        report = self._master.report()
        self._master.close()
        return report


class FollowerTicks(TickSource):
    """The ticks of the master; while it is lost the world drifts on."""

    has_pilot, shared = False, True

    def __init__(self, node: "Follower") -> None:
        self._node, self._alpha, self.waiting = node, 1.0, node.waiting
        self._clock = TickClock(TICK_S)  # while the master is lost

    def advance(self, elapsed_s: float) -> float | None:
        """Make the master's next ticks, independent of `elapsed_s` unless it is lost."""
        start = time.perf_counter()
        alpha = self._node.picture(HOLD_S if self.waiting and not self._node.lost else PATIENCE_S)
        self.waiting = self._node.waiting
        if alpha is None and self._node.lost:
            self._node.drift(self._clock.advance(elapsed_s))
            alpha = self._clock.alpha
        self.idle_s = time.perf_counter() - start
        self._alpha = self._alpha if alpha is None else alpha
        self.wanted = self._node.wanted
        if self._node.waiting == "":
            self.presented = self._node.presented
        return alpha

    def eye(self) -> CameraPose:
        """The pose of the master's eye."""
        return cockpit(self._node.world.state.submarine, self._alpha)

    def swap(self, drawn: Callable[[], None]) -> None:
        """Wait until the master and all other nodes have drawn."""
        drawn()
        if not self._node.lost:
            self._node.swap()

    def close(self) -> list[str]:
        """Report nothing: the master does."""
        self._node.close()
        return []


TickSourceMaker = Callable[[World, Pilot], TickSource]


def tick_source_maker(
    theatre: Theatre, path: Path, node: str | None, view: Mapping[str, str], resumes: bool = True,
    leads: bool = False,
) -> TickSourceMaker:  # fmt: skip
    """The maker of the tick source on the computer `node` of a theatre.

    None: this computer shows all windows. `view` names parts of theatre and display that are equal
    on all computers. A master that `resumes` goes on with the dive of its nodes; one that `leads`
    has nodes open its scenarios. A UserError if
    keys are missing, raised here rather than after the world is loaded. `path` is the theatre's.
    """
    cluster = theatre.cluster
    if node is None or cluster is None:
        return LocalTicks
    from subsea.stage.cluster.follower import Follower
    from subsea.stage.cluster.link import credentials
    from subsea.stage.cluster.master import Master

    keys = credentials(cluster, theatre.nodes, node, path)
    address, timeout_s, master = cluster.address, cluster.timeout_s, cluster.master
    others = [name for name in theatre.nodes if name != node]
    resuming = [resumes]  # only the first sea of a master goes on with that of its nodes

    def made(world: World, pilot: Pilot) -> TickSource:
        if node == master:
            led = Master(world, others, address, keys, timeout_s, say, view)
            return LeaderTicks(led, pilot, None, bool(resuming and resuming.pop()), leads)
        return FollowerTicks(Follower(world, node, master, address, keys, timeout_s, say, view))

    return made
