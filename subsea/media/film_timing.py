"""Times of the frames of a film, and stepping the world to them."""

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

from subsea.base import interrupts
from subsea.base.console import say
from subsea.base.errors import UserError
from subsea.dive.directed_camera import directed_steering, is_over
from subsea.dive.start import ready_world
from subsea.dive.tour import Steer
from subsea.media.film_options import FilmOptions
from subsea.scenario.schema import AUTOPILOT, DIRECTED, Scenario
from subsea.submarine.course import course_of
from subsea.world.step import step
from subsea.world.world import TICK_S, World

Check = Callable[[], None]

DEFAULT_S = 10.0
MAX_DIRECTED_S = 900.0


def film_length_s(scenario: Scenario, source: Path, options: FilmOptions) -> float:
    """Length of a film: as given, or to the end of a finite tour."""
    if options.seconds is not None:
        return options.seconds
    if options.tour == AUTOPILOT:
        return DEFAULT_S
    if options.tour == DIRECTED:
        end = directed_length_s(scenario, source, options.seed)
    else:
        end = course_of(scenario, options.tour).seconds
    return max(end - options.start, 0.0)


def directed_length_s(scenario: Scenario, source: Path, seed: int | None) -> float:
    """Seconds until a scenario's directions are over, measured by playing them once.

    A trial, as in Tu §11.6.1: when fishes mate cannot be known beforehand. `source` is the
    scenario's file. A UserError after a quarter of an hour.
    """
    say("rehearsing the directions to find the length of the film")
    world = ready_world(scenario, source, seed)
    with interrupts.deferred_interrupts() as check:
        steer = directed_steering(world)
        while not is_over(world):
            check()
            step(world, steer(world))
            if world.state.tick * TICK_S > MAX_DIRECTED_S:
                raise UserError(
                    f"its directions are not over after {MAX_DIRECTED_S / 60:g} minutes: "
                    "a `camera`, `caption` or `end` never came; give --seconds",
                    file=source,
                )
    return world.state.tick * TICK_S


def instants(start: float, seconds: float, rate: Fraction) -> list[float]:
    """Times of the frames in seconds since the dive began; at least one."""
    return [start + float(k / rate) for k in range(max(round(seconds * rate), 1))]


def reach(
    world: World, instant: float, steer: Steer, check: Check, before: Check = lambda: None,
    after: Check = lambda: None,
) -> float:  # fmt: skip
    """Step the world until `instant` lies between its last two ticks; returns where, 0 to 1.

    `before` and `after` are called around every tick, and `check`, which may raise, also once at
    the beginning.
    """
    ticks, alpha = divmod(instant / TICK_S, 1.0)
    check()
    while world.state.tick < ticks + 1:  # tick 1 is the start of the dive
        check()
        before()
        step(world, steer(world))
        after()
    return alpha
