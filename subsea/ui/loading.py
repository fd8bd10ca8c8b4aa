"""Create a world, and show it at rest until its fishes can move."""

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from subsea.dive.start import WAKING, wake
from subsea.dive.warm_up import WarmUp
from subsea.jobs.background import run_in_background
from subsea.scenario.schema import Scenario
from subsea.world.build import create_world
from subsea.world.world import World

T = TypeVar("T")
Tell = Callable[[str], None]


class Loader:
    """Loads worlds in a thread.

    The first start compiles kernels. A world can be created and drawn when those for that are
    compiled; its fishes need all.
    """

    def __init__(self, look: Callable[[str | None], None]) -> None:
        """`look` handles events meanwhile, shows lines on the progress, and may raise."""
        self.at_rest = False  # True while a world is shown whose fishes cannot move yet
        self._look = look
        self._warm_up: WarmUp

    def create(self, scenario: Scenario, source: Path, seed: int | None) -> World:
        """The world of a scenario at tick 0."""
        self._warm_up = WarmUp()

        def work(tell: Tell) -> World:
            self._warm_up.wait_for_first(tell)
            return create_world(scenario, seed, progress=tell, source=str(source))

        return self._run(work)

    def wake(self, world: World) -> None:
        """Make the first tick of a world that was created last, which is drawn already."""

        def work(tell: Tell) -> None:
            tell(WAKING)  # shows the world at once
            self._warm_up.wait(tell)
            wake(world)

        self.at_rest = True
        try:
            self._run(work)
        finally:
            self.at_rest = False

    def _run(self, work: Callable[[Tell], T]) -> T:
        try:
            return run_in_background(work, self._look)
        except BaseException:
            self._warm_up.cancel()
            raise
