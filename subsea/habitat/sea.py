"""The sea of a scenario: seabed, solids, climate, plankton."""

import numpy as np
from numpy.typing import NDArray

from subsea.base.disk_cache import cached
from subsea.geometry.solids import height_at
from subsea.habitat import hook, plankton
from subsea.habitat.rocks import Floor, rock_rows
from subsea.habitat.terrain import crest, drifted, half_width, make_terrain
from subsea.scenario.schema import Scenario
from subsea.state import Sea, empty


def pillar_rows(scenario: Scenario, floor: Floor) -> NDArray[np.float64]:
    """All pillars (k, 4) on this seabed, as in `state.Sea`."""
    rows = np.zeros((len(scenario.pillar), 4))
    for k, pillar in enumerate(scenario.pillar):
        x, y = pillar.position_cm
        rows[k] = x, y, pillar.radius_cm, floor(x, y) + pillar.height_cm
    return rows


def make_sea(scenario: Scenario, rng: np.random.Generator) -> Sea:
    """All that surrounds the fishes at tick 0; pillars and rocks stand on the seabed."""
    heights, width = make_terrain(scenario), half_width(scenario)
    bounds, water = scenario.bounds, scenario.water

    def floor(x: float, y: float) -> float:
        return float(height_at(heights, width, x, y))

    pillars = pillar_rows(scenario, floor)
    rocks, _ = rock_rows(scenario, floor)
    heights = cached(drifted, heights, width, pillars, rocks, water.current_cm_s)
    lowered = any(one.hook == "down" for one in scenario.direction)
    specks = plankton.scatter(rng, water.plankton, bounds.radius_cm, heights, width, pillars, rocks)
    return empty(
        Sea,
        given={
            "heights": heights,
            "floor": heights,
            "half_width": width,
            "radius": bounds.radius_cm,
            "pillars": pillars,
            "rocks": rocks,
            "climate": np.array([*water.temperature_c, bounds.depth_cm, water.light_depth_cm]),
            "plankton": specks,
            "tackle": hook.hook_constants(scenario.hook, lowered),
            "crest": crest(heights, width, bounds.radius_cm),
        },
        p=water.plankton,
        c=0,
    )
