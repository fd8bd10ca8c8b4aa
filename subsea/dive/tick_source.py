"""Sources of ticks: this computer, or the master of a cluster."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from subsea.behavior.teleop import TeleopCommand
from subsea.core.console import say
from subsea.dive.clock import TickClock
from subsea.dive.pilot import Pilot
from subsea.dive.prediction import Prediction
from subsea.dive.timeline import Timeline
from subsea.dive.tour import Steer
from subsea.submarine.helm import HANDS_OFF, Helm
from subsea.submarine.rail import Rail
from subsea.view.display_rigs import cockpit
from subsea.view.rig import CameraPose
from subsea.view.theatre.theatre_file import Theatre
from subsea.world.step import Order
from subsea.world.world import TICK_S, World

if TYPE_CHECKING:  # loaded only in a cluster
    from subsea.dive.cluster.follower import Follower
    from subsea.dive.cluster.master import Master

PATIENCE_S = 0.02  # a follower waits for the next picture before it handles window events
HOLD_S = 0.25  # the same while the master is silent


class TickSource(Protocol):
    """Makes the ticks of each picture, and synchronises when it is shown."""

    steered_fish: int | None  # the fish that the pilot steers; None in a cluster

    @property
    def has_pilot(self) -> bool:
        """Whether the pilot sits at this computer."""

    @property
    def shared(self) -> bool:
        """Whether other computers show the same dive."""

    @property
    def timeline(self) -> Timeline | None:
        """Controls time; None in a cluster."""

    @property
    def waiting(self) -> str:
        """The cause of a wait, as a text; empty while the dive runs."""

    @property
    def idle_s(self) -> float:
        """Time that the last call of `advance` spent waiting."""

    def advance(self, elapsed_s: float) -> float | None:
        """Make the ticks that are due `elapsed_s` after the last picture.

        Returns the point between the last two ticks at which to draw, in [0, 1]; None
        if there is nothing new to draw.
        """

    def eye(self) -> CameraPose:
        """The pose of the pilot's eye in that picture."""

    def set_tour(self, tour: Steer | None) -> None:
        """Let a tour steer from the next tick on, until there is input; None: the pilot steers."""

    def swap(self, drawn: Callable[[], None]) -> None:
        """Wait until the picture may be shown; `drawn` waits until it is drawn."""

    def close(self) -> list[str]:
        """End the dive; returns lines to report."""


class SteeringSource:
    """Steers the submarine: a tour until there is input, then the pilot."""

    def __init__(self, world: World, pilot: Pilot, tour: Steer | None) -> None:
        self.tour = tour
        self._world, self._pilot = world, pilot

    def ticks(self, number: int) -> Iterator[Helm | Rail]:
        """Commands for the next ticks; take each one when the tick before is made."""
        for _ in range(number):
            helm = self._pilot.helm(TICK_S)
            if helm != HANDS_OFF:
                self.tour = None
            yield self.tour(self._world) if self.tour else helm


class LocalTicks:
    """Ticks by this computer's clock and pilot, or a tour until there is input."""

    has_pilot, shared, waiting, idle_s = True, False, "", 0.0

    def __init__(self, world: World, pilot: Pilot, tour: Steer | None = None) -> None:
        self.timeline = Timeline(world)
        self.steered_fish: int | None = None  # the fish that the pilot steers
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

    def set_tour(self, tour: Steer | None) -> None:
        """See `TickSource.set_tour`."""
        self.steering.tour = tour

    def swap(self, drawn: Callable[[], None]) -> None:
        """Return at once."""

    def close(self) -> list[str]:
        """Report nothing."""
        return []


def teleop_command(helm: Helm, fish: int) -> TeleopCommand:
    """The command to a fish for a helm: it rises if the submarine would pitch up or rise."""
    if helm.full_stop:
        return TeleopCommand(fish)
    rise = min(max(helm.pitch + helm.heave, -1.0), 1.0)
    return TeleopCommand(fish, helm.yaw, rise, helm.surge)


class LeaderTicks:
    """Ticks as `LocalTicks`, made by all computers of a cluster together."""

    has_pilot, shared, waiting, idle_s = True, True, "", 0.0
    timeline = None
    steered_fish: int | None = None

    def __init__(self, master: "Master", pilot: Pilot, tour: Steer | None = None) -> None:
        self._master, self._clock = master, TickClock(TICK_S)
        self.steering = SteeringSource(master.world, pilot, tour)

    def advance(self, elapsed_s: float) -> float:
        """Make the ticks that are due, here and on all nodes."""
        ticks = self.steering.ticks(self._clock.advance(elapsed_s))
        # The pilot's commands do not depend on the world: they can be sent ahead of the ticks.
        self._master.picture(ticks if self.steering.tour else list(ticks), self._clock.alpha)
        return self._clock.alpha

    def eye(self) -> CameraPose:
        """Interpolate as on all nodes, a tick late."""
        return cockpit(self._master.world.state.submarine, self._clock.alpha)

    def set_tour(self, tour: Steer | None) -> None:
        """See `TickSource.set_tour`."""
        self.steering.tour = tour

    def swap(self, drawn: Callable[[], None]) -> None:
        """Wait until all nodes have drawn."""
        drawn()
        self._master.swap()

    def close(self) -> list[str]:
        """Report the wait times for each node."""
        report = self._master.report()
        self._master.close()
        return report


class FollowerTicks:
    """The ticks of the master."""

    has_pilot, shared, timeline = False, True, None
    steered_fish: int | None = None

    def __init__(self, node: "Follower") -> None:
        self._node = node
        self._alpha = 1.0
        self.idle_s = 0.0

    @property
    def waiting(self) -> str:
        """See `TickSource.waiting`."""
        return self._node.waiting

    def advance(self, elapsed_s: float) -> float | None:
        """Make the master's next ticks, whatever `elapsed_s` is."""
        start = time.perf_counter()
        alpha = self._node.picture(HOLD_S if self._node.waiting else PATIENCE_S)
        self.idle_s = time.perf_counter() - start
        self._alpha = self._alpha if alpha is None else alpha
        return alpha

    def eye(self) -> CameraPose:
        """The pose of the master's eye."""
        return cockpit(self._node.world.state.submarine, self._alpha)

    def set_tour(self, tour: Steer | None) -> None:
        """Ignored: the master decides."""

    def swap(self, drawn: Callable[[], None]) -> None:
        """Wait until the master and all other nodes have drawn."""
        drawn()
        self._node.swap()

    def close(self) -> list[str]:
        """Report nothing: the master does."""
        self._node.close()
        return []


def tick_source_maker(
    theatre: Theatre,
    path: Path,
    node: str | None,
    view: str = "",
) -> Callable[[World, Pilot], TickSource]:
    """The maker of the tick source on the computer `node` of a theatre.

    None: this computer shows all windows. `view` must be equal on all computers. A UserError if
    keys are missing, raised here rather than after the world is loaded. `path` is the theatre's.
    """
    cluster = theatre.cluster
    if node is None or cluster is None:
        return LocalTicks
    from subsea.dive.cluster.credentials import credentials
    from subsea.dive.cluster.follower import Follower
    from subsea.dive.cluster.master import Master

    keys = credentials(cluster, theatre.nodes, node, path)
    address, timeout_s, master = cluster.address, cluster.timeout_s, cluster.master
    others = [name for name in theatre.nodes if name != node]

    def made(world: World, pilot: Pilot) -> TickSource:
        if node == master:
            led = Master(world, others, address, keys, timeout_s, say, view)
            return LeaderTicks(led, pilot)
        return FollowerTicks(Follower(world, node, master, address, keys, timeout_s, say, view))

    return made
