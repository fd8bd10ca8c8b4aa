"""Whose clock and hands make the ticks of a dive: this computer's, or the master's of several."""

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

if TYPE_CHECKING:  # those who dive alone need not load it
    from subsea.dive.cluster.follower import Follower
    from subsea.dive.cluster.master import Master

PATIENCE_S = 0.02  # for so long a node looks for the next picture before it looks at its window
HOLD_S = 0.25  # the same while the master is silent: the picture that is held is drawn so often


class TickSource(Protocol):
    """Makes the ticks of each picture, and has it shown at the right moment."""

    steered_fish: int | None  # the fish whose reins the hands hold, where nobody shares the dive

    @property
    def has_pilot(self) -> bool:
        """Whether the pilot is here."""

    @property
    def shared(self) -> bool:
        """Whether other computers show the same dive, so that all look from the same place."""

    @property
    def timeline(self) -> Timeline | None:
        """Stops time and takes it back; None where others share it."""

    @property
    def waiting(self) -> str:
        """What the dive waits for, in words; nothing while it goes on."""

    @property
    def idle_s(self) -> float:
        """Time of the last call of `picture` in which there was nothing to do."""

    def advance(self, elapsed_s: float) -> float | None:
        """Make the ticks that are due; the point between the last two at which to draw.

        `elapsed_s` is the time since the last picture. None if there is nothing new to draw.
        """

    def eye(self) -> CameraPose:
        """Where the pilot's eye is in that picture."""

    def set_tour(self, tour: Steer | None) -> None:
        """Have a tour take the submarine along from now on, until a hand moves; None: hands do."""

    def swap(self, drawn: Callable[[], None]) -> None:
        """Return when the picture is to be shown; `drawn` returns when it is drawn."""

    def close(self) -> list[str]:
        """End the dive; what is to be told of it."""


class SteeringSource:
    """What the submarine does: a tour, if there is one, until a hand moves."""

    def __init__(self, world: World, pilot: Pilot, tour: Steer | None) -> None:
        self.tour = tour
        self._world, self._pilot = world, pilot

    def ticks(self, number: int) -> Iterator[Helm | Rail]:
        """What to do in each of the next ticks; to be asked for when the tick before is made."""
        for _ in range(number):
            helm = self._pilot.helm(TICK_S)
            if helm != HANDS_OFF:
                self.tour = None
            yield self.tour(self._world) if self.tour else helm


class LocalTicks:
    """This computer's clock and hands; a tour until these move, if there is one."""

    has_pilot, shared, waiting, idle_s = True, False, "", 0.0

    def __init__(self, world: World, pilot: Pilot, tour: Steer | None = None) -> None:
        self.timeline = Timeline(world)
        self.steered_fish: int | None = None  # the fish whose reins the hands hold
        self._world, self._pilot = world, pilot
        self.steering, self._prediction = SteeringSource(world, pilot, tour), Prediction()

    def advance(self, elapsed_s: float) -> float:
        """As many ticks as have become due."""
        for one in self._orders(self.timeline.due(elapsed_s)):
            self.timeline.make(one)
        carried = self.steering.tour or self.steered_fish is not None
        self._prediction.go_on(elapsed_s, not carried and not self.timeline.paused)
        return self.timeline.alpha

    def eye(self) -> CameraPose:
        """In the present, unless it is on a tour or time stands still."""
        return self._prediction.eye(self._world, self.timeline.alpha, self._pilot.predicted(TICK_S))

    def _orders(self, number: int) -> Iterator[Order]:
        """What the course or the hands ask for; hands that hold reins ask it of their fish."""
        if self.steered_fish is None:
            return self.steering.ticks(number)
        return (
            teleop_command(self._pilot.commanded(TICK_S), self.steered_fish) for _ in range(number)
        )

    def set_tour(self, tour: Steer | None) -> None:
        """From the next tick on."""
        self.steering.tour = tour

    def swap(self, drawn: Callable[[], None]) -> None:
        """At once: nobody is waited for."""

    def close(self) -> list[str]:
        """Nothing to tell."""
        return []


def teleop_command(helm: Helm, fish: int) -> TeleopCommand:
    """What hands at a helm ask of a fish: it rises where the submarine would pitch up or rise."""
    if helm.full_stop:
        return TeleopCommand(fish)
    rise = min(max(helm.pitch + helm.heave, -1.0), 1.0)
    return TeleopCommand(fish, helm.yaw, rise, helm.surge)


class LeaderTicks:
    """This computer's clock and hands, or the tour until these move, which others follow."""

    has_pilot, shared, waiting, idle_s = True, True, "", 0.0
    timeline = None
    steered_fish: int | None = None

    def __init__(self, master: "Master", pilot: Pilot, tour: Steer | None = None) -> None:
        self._master, self._clock = master, TickClock(TICK_S)
        self.steering = SteeringSource(master.world, pilot, tour)

    def advance(self, elapsed_s: float) -> float:
        """As many ticks as have become due, here and on all nodes."""
        ticks = self.steering.ticks(self._clock.advance(elapsed_s))
        # Hands do not look at the world: what they do can be told ahead.
        self._master.picture(ticks if self.steering.tour else list(ticks), self._clock.alpha)
        return self._clock.alpha

    def eye(self) -> CameraPose:
        """A tick late, where all nodes see it."""
        return cockpit(self._master.world.state.submarine, self._clock.alpha)

    def set_tour(self, tour: Steer | None) -> None:
        """From the next tick on, for all."""
        self.steering.tour = tour

    def swap(self, drawn: Callable[[], None]) -> None:
        """When all nodes have drawn theirs."""
        drawn()
        self._master.swap()

    def close(self) -> list[str]:
        """How long each node was waited for."""
        report = self._master.report()
        self._master.close()
        return report


class FollowerTicks:
    """The clock and hands of the master."""

    has_pilot, shared, timeline = False, True, None
    steered_fish: int | None = None

    def __init__(self, node: "Follower") -> None:
        self._node = node
        self._alpha = 1.0
        self.idle_s = 0.0

    @property
    def waiting(self) -> str:
        """What the node waits for."""
        return self._node.waiting

    def advance(self, elapsed_s: float) -> float | None:
        """The master's next ticks; its time counts, not `elapsed_s`."""
        start = time.perf_counter()
        alpha = self._node.picture(HOLD_S if self._node.waiting else PATIENCE_S)
        self.idle_s = time.perf_counter() - start
        self._alpha = self._alpha if alpha is None else alpha
        return alpha

    def eye(self) -> CameraPose:
        """Where the master's is."""
        return cockpit(self._node.world.state.submarine, self._alpha)

    def set_tour(self, tour: Steer | None) -> None:
        """That is the master's to do."""

    def swap(self, drawn: Callable[[], None]) -> None:
        """When the master and all other nodes have drawn theirs."""
        drawn()
        self._node.swap()

    def close(self) -> list[str]:
        """Nothing to tell: the master does."""
        self._node.close()
        return []


def tick_source_maker(
    theatre: Theatre,
    path: Path,
    node: str | None,
    view: str = "",
) -> Callable[[World, Pilot], TickSource]:
    """Who makes the ticks on the computer `node` of a theatre, from the file `path`.

    None shows all of its windows on this computer, alone. All need the same `view`.
    Keys that are missing and an address that needs some are UserErrors, here rather than when the
    world is there.
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
