"""From a scenario's name to a world that is awake, and to a renderer without a window."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from subsea.app.console import say
from subsea.frame import make_scene, pack
from subsea.ocean import step
from subsea.scenario import load_scenario
from subsea.submarine.helm import HANDS_OFF
from subsea.view.rigs import cockpit, views_for
from subsea.world import World, create_world

if TYPE_CHECKING:
    from subsea.render import Renderer

Say = Callable[[str], None]

WAKING = "waking the fishes (the very first start compiles their code: half a minute)"


def start_world(
    scenario: str, seed: int | None = None, fish: int | None = None, tell: Say = say,
    dynamics: bool = False,
) -> World:  # fmt: skip
    """The world of a scenario after its first tick and packet: every kernel is compiled.

    With `dynamics` every fish is simulated as soon as its motion allows.
    """
    chosen, _ = load_scenario(scenario)
    number = sum(shoal.number for shoal in chosen.fish) if fish is None else fish
    live = number if dynamics else 0
    world = create_world(chosen, seed, fish, tell, live, math.inf)
    tell(WAKING)
    step(world, HANDS_OFF)
    pack(world, views_for("mono", (64, 64), cockpit(world.state.submarine, 1.0)), 1.0)
    return world


@contextmanager
def start_headless(
    world: World, size: tuple[int, int], tell: Say = say, samples: int | None = None
) -> Iterator[tuple[Any, "Renderer"]]:
    """A context without a window and a renderer for pictures of `size`; no OpenGL: UserError.

    `samples` per pixel smooth edges; None leaves the choice to the renderer.
    """
    from subsea.render import Renderer, headless_context

    tell("starting OpenGL")
    context = headless_context()
    try:
        renderer = Renderer(context, make_scene(world), size, samples)
        try:
            yield context, renderer
        finally:
            renderer.release()
    finally:
        # Leaving it takes the context off this thread: while it is there, no window can open.
        with context:
            pass
        context.release()
