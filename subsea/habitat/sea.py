"""The sea of a scenario: seabed, solids, climate, plankton, and a baited hook.

The hook sinks on a line and is drawn up with its catch (Tu §10.1).
"""

import numpy as np

from subsea.base.arrays import Array
from subsea.base.disk_cache import cached
from subsea.geometry.solids import height_at, rock_tops, skyline_of
from subsea.geometry.walls import is_wall, wall_rows
from subsea.habitat import plankton
from subsea.habitat.day import HOURS, daylight_at
from subsea.habitat.rocks import rock_rows
from subsea.habitat.terrain import crest, drifted, half_width, make_terrain
from subsea.kernels import kernel
from subsea.scenario.schema import MAX_SOLIDS, Hook, Scenario
from subsea.state import HANGING, HOOKED, LANDED, SINKING, STOWED, Clock, Sea, empty

OUT_CM = 60.0  # height above the surface at which the hook is out of sight


def solids_on(scenario: Scenario, heights: Array, width: float) -> tuple[Array, Array, list[str]]:
    """Put pillars (k, 4) and rocks (j, 7) on a seabed, as in `state.Sea`; walls follow pillars.

    Also returns the scenario's table of each rock. `width` is half that of the seabed.
    """

    def floor(x: float, y: float) -> float:
        return float(height_at(heights, width, x, y))

    pillars = np.zeros((len(scenario.pillar), 4))
    for k, pillar in enumerate(scenario.pillar):
        x, y = pillar.position_cm
        pillars[k] = x, y, pillar.radius_cm, floor(x, y) + pillar.height_cm
    pillars = np.concatenate([pillars, wall_rows(scenario.bounds.tank_cm)])
    return pillars, *rock_rows(scenario, floor)


def make_sea(scenario: Scenario, rng: np.random.Generator) -> tuple[Sea, list[str]]:
    """Make all that surrounds the fishes at tick 0, with the scenario's table of each rock."""
    heights, width = make_terrain(scenario), half_width(scenario)
    bounds, water = scenario.bounds, scenario.water
    pillars, rocks, owners = solids_on(scenario, heights, width)
    rocks = rocks[:MAX_SOLIDS]  # `world.checks` refuses more
    heights = cached(drifted, heights, width, pillars[~is_wall(pillars)], rocks, water.current_cm_s)
    lowered = any(direction.hook == "down" for direction in scenario.direction)
    specks = plankton.scatter(rng, water.plankton, bounds.radius_cm, heights, width, pillars, rocks)
    sea = empty(
        Sea,
        given={
            "heights": heights,
            "floor": heights,
            "half_width": width,
            "radius": bounds.radius_cm,
            "pillars": pillars,
            "rocks": rocks,
            "tops": rock_tops(rocks, width),
            "skyline": skyline_of(heights, width, pillars, rocks),
            "climate": np.array([*water.temperature_c, bounds.depth_cm, water.light_depth_cm]),
            "plankton": specks,
            "sky": np.array([water.hour % HOURS, daylight_at(water.hour)]),
            "tackle": hook_constants(scenario.hook, lowered),
            "crest": crest(heights, width, bounds.radius_cm),
        },
        p=water.plankton,
        c=0,
        s=0,
        q=0,
    )
    return sea, owners


def bare(sea: Sea) -> Sea:
    """The sea without plankton, seaweed and hour: what grows there does not depend on them."""
    rows = {name: getattr(sea, name)[:0] for name in ("plankton", "absent", "deflection")}
    return sea._replace(**rows, seaweed=sea.seaweed[:0], sky=sea.sky[:0])


def hook_constants(plan: Hook | None, waits: bool = False) -> Array:
    """Return the constants of a hook (5,): x, y, depth, cm, speed, cm/s, start, s.

    Without a hook, or where it `waits` for a direction, the start is infinite.
    """
    if plan is None:
        return np.array([0.0, 0.0, 0.0, 0.0, np.inf])
    start = np.inf if waits else plan.start_s
    return np.array([*plan.position_cm, plan.depth_cm, plan.speed_cm_s, start])


@kernel
def move_hook(sea: Sea, clock: Clock) -> None:
    """Move the hook by one tick: down until it hangs, up once it has caught a fish."""
    x, y, depth, speed, start = sea.tackle
    state = sea.catch[0]
    if state == STOWED and clock.tick * clock.dt >= start:
        sea.hook[0], sea.hook[1], sea.hook[2] = x, y, 0.0
        sea.catch[0] = SINKING
    elif state == SINKING:
        sea.hook[2] = max(sea.hook[2] - speed * clock.dt, -depth)
        if sea.hook[2] == -depth:
            sea.catch[0] = HANGING
    elif state == HOOKED:
        sea.hook[2] += speed * clock.dt
        if sea.hook[2] > OUT_CM:
            sea.catch[0] = LANDED
