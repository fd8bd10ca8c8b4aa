"""Load a scenario into a world that is ready to run; draw without a window."""

import math
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from subsea.base.language import marked
from subsea.base.progress import say
from subsea.dive.warm_up import warm_up
from subsea.frame.packet import make_scene, pack
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Scenario
from subsea.submarine.vessel import NEUTRAL
from subsea.view.display_rigs import cockpit, views_for
from subsea.view.rig import CameraRig
from subsea.world.build import LIVE_REACH_CM, create_world
from subsea.world.step import step
from subsea.world.world import World

if TYPE_CHECKING:
    from subsea.rendering.output.quality import Quality
    from subsea.rendering.renderer import Renderer

Say = Callable[[str], None]
WAKING = marked("waking the fishes")  # line on the progress


def start_world(
    scenario: str, seed: int | None = None, fish: int | None = None, tell: Say = say,
    motor: str | None = None, changes: Sequence[str] = (),
) -> World:  # fmt: skip
    """The world of a named scenario after its first tick and packet, with kernels compiled.

    The motor "playback" simulates no fish, "dynamics" every one as soon as its motion allows,
    None: as the scenario says. `changes` are those of `--set`.
    """
    chosen, path = load_scenario(scenario, changes)
    number = sum(shoal.number for shoal in chosen.fish) if fish is None else fish
    if motor is None:
        return ready_world(chosen, path, seed, tell, fish)
    live = number if motor == "dynamics" else 0
    return ready_world(chosen, path, seed, tell, fish, live, math.inf)


def ready_world(
    scenario: Scenario, source: Path, seed: int | None = None, tell: Say = say,
    fish: int | None = None, live: int | None = None, live_reach_cm: float = LIVE_REACH_CM,
) -> World:  # fmt: skip
    """The world of a scenario after its first tick and packet, with kernels compiled.

    `source` is the scenario's file; for the others see :func:`subsea.world.build.create_world`.
    """
    warm_up(tell)
    world = create_world(scenario, seed, fish, tell, live, live_reach_cm, str(source))
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
    # Messages of Mesa would hide the line that says what to install.
    os.environ.setdefault("EGL_LOG_LEVEL", "fatal")
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
