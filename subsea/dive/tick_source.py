"""Whose clock and hands make the ticks of a dive: this computer's, or the master's of several."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from subsea.behavior.teleop import TeleopCommand
from subsea.core.console import say
from subsea.dive.clock import Clock
from subsea.dive.pilot import Pilot
from subsea.dive.prediction import Present
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


class Crew(Protocol):
    """Makes the ticks of each picture, and has it shown at the right moment."""

    steered: int | None  # the fish whose reins the hands hold, where nobody shares the dive

    @property
    def hands(self) -> bool:
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

    def picture(self, elapsed_s: float) -> float | None:
        """Make the ticks that are due; the point between the last two at which to draw.

        `elapsed_s` is the time since the last picture. None if there is nothing new to draw.
        """

    def eye(self) -> CameraPose:
        """Where the pilot's eye is in that picture."""

    def carry(self, tour: Steer | None) -> None:
        """Have a tour take the submarine along from now on, until a hand moves; None: hands do."""

    def swap(self, drawn: Callable[[], None]) -> None:
        """Return when the picture is to be shown; `drawn` returns when it is drawn."""

    def close(self) -> list[str]:
        """End the dive; what is to be told of it."""


class _Course:
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


class Alone:
    """This computer's clock and hands; a tour until these move, if there is one."""

    hands, shared, waiting, idle_s = True, False, "", 0.0

    def __init__(self, world: World, pilot: Pilot, tour: Steer | None = None) -> None:
        self.timeline = Timeline(world)
        self.steered: int | None = None  # the fish whose reins the hands hold
        self._world, self._pilot = world, pilot
        self._course, self._present = _Course(world, pilot, tour), Present()

    def picture(self, elapsed_s: float) -> float:
        """As many ticks as have become due."""
        for one in self._orders(self.timeline.due(elapsed_s)):
            self.timeline.make(one)
        carried = self._course.tour or self.steered is not None
        self._present.go_on(elapsed_s, not carried and not self.timeline.paused)
        return self.timeline.alpha

    def eye(self) -> CameraPose:
        """In the present, unless it is on a tour or time stands still."""
        return self._present.eye(self._world, self.timeline.alpha, self._pilot.foreseen(TICK_S))

    def _orders(self, number: int) -> Iterator[Order]:
        """What the course or the hands ask for; hands that hold reins ask it of their fish."""
        if self.steered is None:
            return self._course.ticks(number)
        return (reins_of(self._pilot.asked(TICK_S), self.steered) for _ in range(number))

    def carry(self, tour: Steer | None) -> None:
        """From the next tick on."""
        self._course.tour = tour

    def swap(self, drawn: Callable[[], None]) -> None:
        """At once: nobody is waited for."""

    def close(self) -> list[str]:
        """Nothing to tell."""
        return []


def reins_of(helm: Helm, fish: int) -> TeleopCommand:
    """What hands at a helm ask of a fish: it rises where the submarine would pitch up or rise."""
    if helm.full_stop:
        return TeleopCommand(fish)
    rise = min(max(helm.pitch + helm.heave, -1.0), 1.0)
    return TeleopCommand(fish, helm.yaw, rise, helm.surge)


class Leading:
    """This computer's clock and hands, or the tour until these move, which others follow."""

    hands, shared, waiting, idle_s = True, True, "", 0.0
    timeline = None
    steered: int | None = None

    def __init__(self, master: "Master", pilot: Pilot, tour: Steer | None = None) -> None:
        self._master, self._clock = master, Clock(TICK_S)
        self._course = _Course(master.world, pilot, tour)

    def picture(self, elapsed_s: float) -> float:
        """As many ticks as have become due, here and on all nodes."""
        ticks = self._course.ticks(self._clock.advance(elapsed_s))
        # Hands do not look at the world: what they do can be told ahead.
        self._master.picture(ticks if self._course.tour else list(ticks), self._clock.alpha)
        return self._clock.alpha

    def eye(self) -> CameraPose:
        """A tick late, where all nodes see it."""
        return cockpit(self._master.world.state.submarine, self._clock.alpha)

    def carry(self, tour: Steer | None) -> None:
        """From the next tick on, for all."""
        self._course.tour = tour

    def swap(self, drawn: Callable[[], None]) -> None:
        """When all nodes have drawn theirs."""
        drawn()
        self._master.swap()

    def close(self) -> list[str]:
        """How long each node was waited for."""
        report = self._master.report()
        self._master.close()
        return report


class Following:
    """The clock and hands of the master."""

    hands, shared, timeline = False, True, None
    steered: int | None = None

    def __init__(self, node: "Follower") -> None:
        self._node = node
        self._alpha = 1.0
        self.idle_s = 0.0

    @property
    def waiting(self) -> str:
        """What the node waits for."""
        return self._node.waiting

    def picture(self, elapsed_s: float) -> float | None:
        """The master's next ticks; its time counts, not `elapsed_s`."""
        start = time.perf_counter()
        alpha = self._node.picture(HOLD_S if self._node.waiting else PATIENCE_S)
        self.idle_s = time.perf_counter() - start
        self._alpha = self._alpha if alpha is None else alpha
        return alpha

    def eye(self) -> CameraPose:
        """Where the master's is."""
        return cockpit(self._node.world.state.submarine, self._alpha)

    def carry(self, tour: Steer | None) -> None:
        """That is the master's to do."""

    def swap(self, drawn: Callable[[], None]) -> None:
        """When the master and all other nodes have drawn theirs."""
        drawn()
        self._node.swap()

    def close(self) -> list[str]:
        """Nothing to tell: the master does."""
        self._node.close()
        return []


def muster(
    theatre: Theatre,
    path: Path,
    node: str | None,
    view: str = "",
) -> Callable[[World, Pilot], Crew]:
    """Who makes the ticks on the computer `node` of a theatre, from the file `path`.

    None shows all of its windows on this computer, alone. All need the same `view`.
    Keys that are missing and an address that needs some are UserErrors, here rather than when the
    world is there.
    """
    cluster = theatre.cluster
    if node is None or cluster is None:
        return Alone
    from subsea.dive.cluster.credentials import credentials
    from subsea.dive.cluster.follower import Follower
    from subsea.dive.cluster.master import Master

    keys = credentials(cluster, theatre.nodes, node, path)
    address, timeout_s, master = cluster.address, cluster.timeout_s, cluster.master
    others = [name for name in theatre.nodes if name != node]

    def made(world: World, pilot: Pilot) -> Crew:
        if node == master:
            led = Master(world, others, address, keys, timeout_s, say, view)
            return Leading(led, pilot)
        return Following(Follower(world, node, master, address, keys, timeout_s, say, view))

    return made
