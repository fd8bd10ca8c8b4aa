"""Load a scenario into a world that is ready to run; draw without a window."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from subsea.base.language import marked
from subsea.base.progress import say
from subsea.dive.warm_up import warm_up
from subsea.frame.packet import make_scene, pack
from subsea.scenario.load import LoadedScenario, load_scenario
from subsea.submarine.vessel import NEUTRAL
from subsea.view.display_rigs import cockpit, views_for
from subsea.view.rig import CameraRig
from subsea.world.build import LIVE_REACH_CM, create_world
from subsea.world.levels import has_levels
from subsea.world.step import step
from subsea.world.world import World

if TYPE_CHECKING:
    from subsea.rendering.output.quality import Quality
    from subsea.rendering.renderer import Renderer

Say = Callable[[str], None]
WAKING = marked("waking the fishes")  # line on the progress


def start_world(
    scenario: str, seed: int | None = None, fish: int | None = None, tell: Say = say,
    changes: Sequence[str] = (),
) -> World:  # fmt: skip
    """Load a scenario by name, with changes of `--set`, and make its world as `ready_world`."""
    return ready_world(load_scenario(scenario, changes), seed, tell, fish)


def ready_world(
    loaded: LoadedScenario, seed: int | None = None, tell: Say = say, fish: int | None = None,
    motor: str | None = None, levels: bool = False,
) -> World:  # fmt: skip
    """Make the world of a scenario with its first tick and packet, and kernels compiled.

    `seed` and `fish` (the number of fishes) replace those of the scenario. The motor "playback"
    simulates no fish, "dynamics" every one as soon as its motion allows, None: as the scenario
    says. `levels` lets far fishes of a large sea think less often, unless the scenario says no.
    """
    warm_up(tell)
    live, reach_cm = None, LIVE_REACH_CM
    if motor is not None:
        number = sum(shoal.number for shoal in loaded.scenario.fish) if fish is None else fish
        live, reach_cm = number if motor == "dynamics" else 0, math.inf
    source = str(loaded.path)
    world = create_world(loaded.scenario, seed, fish, tell, live, reach_cm, source)
    world.levels = levels and has_levels(loaded.scenario, world.state)
    tell(WAKING)
    wake(world)
    return world


def wake(world: World) -> None:
    """Make the first tick and packet of a world, which load its kernels."""
    step(world, NEUTRAL)
    pack(world, views_for("mono", (64, 64), cockpit(world.state.submarine, 1.0)), 1.0)


@contextmanager
def headless() -> Iterator[Any]:
    """An OpenGL context without a window; a UserError without OpenGL."""
    from subsea.rendering.gl.context import headless_context

    context = headless_context()
    try:
        yield context
    finally:
        # Detach the context from this thread: no window could open otherwise.
        with context:
            pass
        context.release()


@contextmanager
def picture_maker(
    context: Any, world: World, rig: CameraRig, quality: "Quality"
) -> Iterator["Renderer"]:
    """A renderer for the pictures of a rig."""
    from subsea.rendering.renderer import Renderer

    renderer = Renderer(context, make_scene(world), rig, quality)
    try:
        yield renderer
    finally:
        renderer.release()
