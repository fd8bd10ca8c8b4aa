"""Sources of ticks: this computer, or others that a wing adds."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from pathlib import Path

from subsea.behavior.teleop import TeleopCommand
from subsea.dive.pilot import Pilot, Prediction
from subsea.dive.presented import NOTHING, Presented
from subsea.dive.timeline import Timeline
from subsea.dive.tour import Steer
from subsea.submarine.vessel import NEUTRAL, Helm, Rail
from subsea.view.rig import CameraPose
from subsea.world.step import Order
from subsea.world.world import TICK_S, World


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
    gathering = False  # True while other computers open the scenario that this one has opened

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
        """Go on with a dive that lost its master, before a picture; `check` may raise meanwhile."""

    def offer(self, scenario: Path) -> None:  # noqa: B027 - only a master does
        """Let nodes open the scenario of this file, if it has a name, to take part."""

    def change(self) -> None:  # noqa: B027 - only a master does
        """Make the screens of all computers black before another scenario is opened."""

    def set_tour(self, tour: Steer | None) -> None:
        """Let a tour steer from the next tick on, until there is input; None: the pilot steers."""
        if self.steering:
            self.steering.tour = tour

    def swap(self, drawn: Callable[[], None]) -> None:  # noqa: B027 - one computer never waits
        """Wait until the picture may be shown; `drawn` waits until it is drawn."""

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


TickSourceMaker = Callable[[World, Pilot], TickSource]
