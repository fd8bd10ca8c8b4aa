"""How long the film is that a scenario's directions make: it is played once to know.

A trial, as Tu proposes to find out when fishes mate (§11.6.1): nobody can say that beforehand.
"""

from pathlib import Path

from subsea.core import interrupts
from subsea.core.console import say
from subsea.core.errors import UserError
from subsea.dive.directed_camera import directed, is_over
from subsea.dive.start import awake
from subsea.scenario.schema import Scenario
from subsea.world.step import step
from subsea.world.world import TICK_S

MOST_S = 900.0


def rehearsed_s(scenario: Scenario, source: Path, seed: int | None) -> float:
    """After so many seconds the film of a scenario's directions is over (`directed.is_over`).

    A UserError if it is not within a quarter of an hour. `source` is the scenario's file.
    """
    say("rehearsing the directions, to know how long the film is")
    world = awake(scenario, source, seed)
    with interrupts.deferred() as check:
        steer = directed(world)
        while not is_over(world):
            check()
            step(world, steer(world))
            if world.state.tick * TICK_S > MOST_S:
                raise UserError(
                    f"{source}: its directions are not over after {MOST_S / 60:g} minutes: "
                    "a `camera` or `caption` has not come, or no `end`; tell --seconds"
                )
    return world.state.tick * TICK_S
