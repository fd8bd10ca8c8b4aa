"""Find things of a scenario inside the seabed, solids or one another."""

import math

import numpy as np

from subsea.base.errors import UserError
from subsea.fish.species import load_species
from subsea.geometry.solids import rock_tops, skyline_of
from subsea.habitat.sea import solids_on
from subsea.perception.grid import REACH_CM
from subsea.perception.vision import FARTHEST
from subsea.scenario.checks import Findings, check_scenario
from subsea.scenario.schema import MAX_SOLIDS, Scenario
from subsea.state import HULL_CM, Sea
from subsea.submarine.vessel import check_tours, gaps_at

# Distance at which no fish perceives the wall of the sea or the submarine: constant, and per length
# of the longest fish.
EDGE_CM, EDGE_BL = 200.0, 4.0


def check_in_sea(scenario: Scenario, sea: Sea) -> None:
    """Raise the first of the findings for a scenario on the seabed of an existing `sea`."""
    check_scenario(scenario)
    there, owners = with_solids(scenario, sea)
    check_sea(scenario, there, owners)


def with_solids(scenario: Scenario, sea: Sea) -> tuple[Sea, list[str]]:
    """Replace the solids of a `sea` by those of a scenario, with the table of each rock."""
    pillars, rocks, owners = solids_on(scenario, sea.heights, sea.half_width)
    tops = rock_tops(rocks, sea.half_width)
    skyline = skyline_of(sea.heights, sea.half_width, pillars, rocks)
    return sea._replace(pillars=pillars, rocks=rocks, tops=tops, skyline=skyline), owners


def check_sea(scenario: Scenario, sea: Sea, owners: list[str]) -> None:
    """Raise the first of the findings."""
    for finding in findings(scenario, sea, owners):
        raise finding


def tour_fault(
    scenario: Scenario, sea: Sea, owners: list[str], stored: bool = True
) -> UserError | None:
    """Find the first tour that does not fit the sea of a scenario; None if all fit.

    Do not refuse a scenario for it: what stands there may be moved before the tour is. `owners` is
    the scenario's table of each rock; `stored`: use the disk cache.
    """
    try:
        check_tours(scenario, sea, owners, stored)
    except UserError as fault:
        return fault
    return None


def _misfits_in_box(scenario: Scenario) -> Findings:
    """Find fishes that see too far for a periodic box, or need a reef, and what is too near to it.

    A fish that sees farther than half the box would see itself, and others twice.
    """
    sides = scenario.bounds.periodic_cm
    if sides is None:
        return
    nature, longest, reach = scenario.nature, 0.0, REACH_CM
    for k, shoal in enumerate(scenario.fish):
        species, rules = load_species(shoal.species), scenario.rules_of(shoal)
        kind = shoal.kind or species.kind
        if kind == "predator":
            reach = max(reach, nature.smell_cm)
        if kind == "pacifist" or species.home_cm is not None:
            key, name = f"fish[{k}].species", shoal.species
            fault = "it lives at a reef, expected prey or predators in a box with periodic sides"
            yield UserError(f"`{key}` {name!r}: {fault}", key=key)
        length = max(*(shoal.size_cm or species.size_cm), shoal.leader_cm or 0.0)
        longest = max(longest, length)
        schools = species.schooling if shoal.schooling is None else shoal.schooling
        if schools or any(one.schooling for one in scenario.individual):
            felt = max(rules.sight_bl or 0.0, rules.lateral_line_bl or 0.0)
            reach = max(reach, felt * length)
    for k, one in enumerate(scenario.individual):
        if one.kind == "pacifist":
            key = f"individual[{k}].kind"
            fault = "expected prey or predators in a box with periodic sides"
            yield UserError(f"`{key}` 'pacifist': {fault}", key=key)
    reach = max(reach, nature.vision_cm * min(longest / nature.standard_cm, FARTHEST))
    least = math.ceil(2.0 * (reach + longest))
    if min(sides) < least:
        key = "bounds.periodic_cm"
        yield UserError(
            f"`{key}` {list(sides)}: fishes of {longest:g} cm perceive others at {reach:.0f} cm, "
            f"expected at least {least} along x and y (twice the sum), or a shorter "
            "`nature.vision_cm`, `nature.smell_cm` or `school.sight_bl`",
            key=key,
        )
    edge = EDGE_CM + EDGE_BL * longest
    least = math.ceil(0.5 * math.hypot(*sides) + edge)
    if scenario.bounds.radius_cm < least:
        key = "bounds.radius_cm"
        yield UserError(
            f"`{key}` {scenario.bounds.radius_cm:g}: expected at least {least}, so that no fish "
            f"in the corners of the box perceives the wall of the sea",
            key=key,
        )
    place = scenario.submarine.position_cm
    beyond = [max(abs(x) - 0.5 * side, 0.0) for x, side in zip(place, sides, strict=False)]
    if math.hypot(*beyond) < edge:
        key = "submarine.position_cm"
        yield UserError(
            f"`{key}` {place} lies in the box with periodic sides or near it, expected at least "
            f"{edge:.0f} cm outside",
            key=key,
        )


def findings(scenario: Scenario, sea: Sea, owners: list[str]) -> Findings:
    """Find too many rocks, pillars above the surface, and places inside the seabed or a solid.

    The scenario has no finding of `scenario.checks`; `owners` is its table of each rock.
    """
    yield from _misfits_in_box(scenario)
    if len(owners) > MAX_SOLIDS:
        yield UserError(
            f"{len(owners)} rocks in all, those of outcrops and arches counted, "
            f"expected at most {MAX_SOLIDS}"
        )
    for k, top in enumerate(sea.pillars[: len(scenario.pillar), 3]):
        if top > 0.0:
            height, key = scenario.pillar[k].height_cm, f"pillar[{k}].height_cm"
            yield UserError(
                f"`{key}` {height:g} reaches above the surface, "
                f"expected at most {np.floor(height - top):g} there",
                key=key,
            )
    places = [("submarine.position_cm", scenario.submarine.position_cm, HULL_CM)]
    for k, shoal in enumerate(scenario.fish):
        if shoal.position_cm is not None:
            places.append((f"fish[{k}].position_cm", shoal.position_cm, 0.0))
        if shoal.toward_cm is not None:
            places.append((f"fish[{k}].toward_cm", shoal.toward_cm, 0.0))
    if scenario.hook is not None:
        places.append(("hook", scenario.hook.bait_cm, 0.0))
    for k, direction in enumerate(scenario.direction):
        here, camera = f"direction[{k}]", direction.camera
        if camera is not None and camera.position_cm is not None:
            places.append((f"{here}.camera.position_cm", camera.position_cm, HULL_CM))
        if direction.place_cm is not None:
            places.append((f"{here}.place_cm", direction.place_cm, 0.0))
        for i, point in enumerate(direction.path_cm or ()):
            places.append((f"{here}.path_cm[{i}]", point, 0.0))
    for key, place, room in places:
        gaps = gaps_at(place, sea, owners)
        if not room:  # fishes are moved out of the reef
            del gaps["the reef"]
        for name, gap in gaps.items():
            if gap < room:
                inside, outside = "inside", "outside"
                if name in ("the seabed", "the reef"):
                    inside, outside = "below", "above"
                down = np.floor(10.0 * gap) / 10.0  # rounded down: it is less than expected
                where = f"lies {inside} {name}" if gap < 0.0 else f"is {down:.1f} cm from {name}"
                expected = f"at least {room:g} cm off it" if room else f"{outside} it"
                yield UserError(f"`{key}` {place} {where}, expected {expected}", key=key)
