"""Refuse scenarios that put things inside the seabed, solids or one another."""

import numpy as np

from subsea.base.errors import UserError
from subsea.geometry.solids import from_pillar, from_rock, height_at
from subsea.habitat.reef import grow_reefs
from subsea.habitat.rocks import rock_rows
from subsea.habitat.sea import make_sea, pillar_rows
from subsea.habitat.seaweed import plant_seaweed
from subsea.scenario.checks import check_scenario
from subsea.scenario.schema import MAX_SOLIDS, Scenario
from subsea.state import HULL_CM, Reef, Sea, Seaweed
from subsea.submarine.vessel import check_tours


def check_world(scenario: Scenario, seed: int | None = None) -> None:
    """Raise the UserError of `create_world` for a scenario that passes `check_scenario`."""
    seed = scenario.seed if seed is None else seed
    make_surroundings(scenario, np.random.default_rng([seed, 0x5EA]), seed)


def check_in_sea(scenario: Scenario, sea: Sea) -> None:
    """As `check_world`, but fast: on the seabed and beside the reef of an existing `sea`."""

    def floor(x: float, y: float) -> float:
        return float(height_at(sea.heights, sea.half_width, x, y))

    check_scenario(scenario)
    _check_number(scenario)
    rows, _ = rock_rows(scenario, floor)
    there = sea._replace(pillars=pillar_rows(scenario, floor), rocks=rows)
    _check_heights(scenario, there)
    _check_places(scenario, there)


def tour_fault(scenario: Scenario, sea: Sea, stored: bool = True) -> UserError | None:
    """The first tour that does not fit the solids of a scenario on the seabed of `sea`, or None.

    Do not refuse a scenario for it: what stands there may be moved before the tour is.
    """

    def floor(x: float, y: float) -> float:
        return float(height_at(sea.heights, sea.half_width, x, y))

    rows, rocks = rock_rows(scenario, floor)
    there = sea._replace(pillars=pillar_rows(scenario, floor), rocks=rows) if not stored else sea
    try:
        check_tours(scenario, there, rocks, stored)
    except UserError as fault:
        return fault
    return None


def make_surroundings(
    scenario: Scenario, rng: np.random.Generator, seed: int
) -> tuple[Sea, Reef, Seaweed]:
    """Make sea, reef and seaweed; raises a UserError for misplaced things."""
    _check_number(scenario)
    sea = make_sea(scenario, rng)
    _check_heights(scenario, sea)
    sea, reef = grow_reefs(scenario, sea)
    _check_places(scenario, sea)
    sea, seaweed = plant_seaweed(scenario, sea, reef, seed)
    return sea, reef, seaweed


def _check_number(scenario: Scenario) -> None:
    """Raise a UserError for more rocks than a sea may have."""
    number = len(rock_rows(scenario, lambda x, y: 0.0)[0])
    if number > MAX_SOLIDS:
        raise UserError(
            f"{number} rocks in all, those of outcrops and arches counted, "
            f"expected at most {MAX_SOLIDS}"
        )


def _check_heights(scenario: Scenario, sea: Sea) -> None:
    """Raise a UserError for a pillar higher than the depth of the sea there."""
    for k, top in enumerate(sea.pillars[:, 3]):
        if top > 0.0:
            given = scenario.pillar[k].height_cm
            raise UserError(
                f"`pillar[{k}].height_cm` {given:g} reaches above the surface, "
                f"expected at most {np.floor(given - top):g} there",
                key=f"pillar[{k}].height_cm",
            )


def _check_places(scenario: Scenario, sea: Sea) -> None:
    """Raise a UserError for a place inside the seabed, the reef, a rock or a pillar."""
    _, rocks = rock_rows(scenario, lambda x, y: 0.0)
    places = [("submarine.position_cm", scenario.submarine.position_cm, HULL_CM)]
    for k, shoal in enumerate(scenario.fish):
        if shoal.position_cm is not None:
            places.append((f"fish[{k}].position_cm", shoal.position_cm, 0.0))
        if shoal.toward_cm is not None:
            places.append((f"fish[{k}].toward_cm", shoal.toward_cm, 0.0))
    if scenario.hook is not None:
        places.append(("hook", scenario.hook.bait_cm, 0.0))
    for k, one in enumerate(scenario.direction):
        here = f"direction[{k}]"
        if one.camera is not None and one.camera.position_cm is not None:
            places.append((f"{here}.camera.position_cm", one.camera.position_cm, HULL_CM))
        if one.place_cm is not None:
            places.append((f"{here}.place_cm", one.place_cm, 0.0))
        for i, point in enumerate(one.path_cm or ()):
            places.append((f"{here}.path_cm[{i}]", point, 0.0))
    for key, place, room in places:
        floor = height_at(sea.heights, sea.half_width, place[0], place[1])
        gaps = {"the seabed": place[2] - floor}
        if room:  # fishes are moved out of the reef
            over = height_at(sea.floor, sea.half_width, place[0], place[1])
            gaps["the reef"] = place[2] - over
        gaps |= {f"`pillar[{k}]`": from_pillar(row, place)[1] for k, row in enumerate(sea.pillars)}
        for name, row in zip(rocks, sea.rocks, strict=True):
            gaps[name] = min(from_rock(row, place)[1], gaps.get(name, np.inf))
        for name, gap in gaps.items():
            if gap < room:
                inside, outside = "inside", "outside"
                if name in ("the seabed", "the reef"):
                    inside, outside = "below", "above"
                down = np.floor(10.0 * gap) / 10.0  # rounded down: it is less than expected
                where = f"lies {inside} {name}" if gap < 0.0 else f"is {down:.1f} cm from {name}"
                expected = f"at least {room:g} cm off it" if room else f"{outside} it"
                raise UserError(f"`{key}` {place} {where}, expected {expected}", key=key)
