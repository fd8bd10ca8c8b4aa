"""Check places, names and totals across the tables of a scenario."""

import math
from collections.abc import Iterator

from subsea.base.errors import UserError, unknown
from subsea.fish.species import load_species, species_names
from subsea.scenario.directions import Shoals, check_directions
from subsea.scenario.schema import (
    AUTOPILOT,
    DIRECTED,
    MAX_FISHES,
    MAX_GROWTHS,
    MAX_SEAWEED,
    Bounds,
    Scenario,
)

# Tables with a place.
PLACED = (
    "fish", "pillar", "rock", "outcrop", "ridge", "arch", "vent", "reef", "coral", "seaweed",
)  # fmt: skip


def check_scenario(scenario: Scenario) -> None:
    """Raise a UserError with its key for impossible places, names and totals.

    `world.create_world` finds the faults that need a world, such as overlapping objects.
    """
    bounds, known = scenario.bounds, species_names()
    for key, place in _places(scenario):
        _inside(key, place, bounds)
    for k, shoal in enumerate(scenario.fish):
        if shoal.species not in known:
            key = f"fish[{k}].species"
            fault = unknown("species", shoal.species, known).message
            raise UserError(f"`{key}`: {fault}", key=key)
        if shoal.size_cm is not None and shoal.size_cm[0] > shoal.size_cm[1]:
            key, sizes = f"fish[{k}].size_cm", list(shoal.size_cm)
            raise UserError(f"`{key}` {sizes}: expected the smallest first", key=key)
    leaves = sum(group.clusters * group.leaves for group in scenario.seaweed)
    if leaves > MAX_SEAWEED:
        raise UserError(
            f"`seaweed` has {leaves} leaves, expected at most {MAX_SEAWEED}", key="seaweed"
        )
    growths = sum(table.number for table in scenario.reef) + len(scenario.coral)
    if growths > MAX_GROWTHS:
        raise UserError(f"`reef` has {growths} growths, expected at most {MAX_GROWTHS}", key="reef")
    _check_tours(scenario)
    number = sum(shoal.number for shoal in scenario.fish)
    if number > MAX_FISHES:
        raise UserError(f"{number} fishes in all, expected at most {MAX_FISHES}")
    seen: set[int] = set()
    for k, one in enumerate(scenario.individual):
        key = f"individual[{k}].fish"
        if one.fish >= number:
            expected = f"expected 0 to {number - 1}" if number else "but there are none"
            raise UserError(f"`{key}` {one.fish}: there is no such fish, {expected}", key=key)
        if one.fish in seen:
            raise UserError(
                f"`{key}` {one.fish}: has a table already, expected one for each fish", key=key
            )
        seen.add(one.fish)
    if scenario.direction:
        check_directions(
            scenario.direction,
            shoals_of(scenario),
            [tour.name for tour in scenario.tour],
            scenario.hook is not None,
            lambda key, place: _inside(key, place, bounds),
        )


def shoals_of(scenario: Scenario) -> Shoals:
    """The shoals of a scenario, as directions refer to them."""
    kinds: list[str] = []
    for shoal in scenario.fish:
        kinds += [shoal.kind or load_species(shoal.species).kind] * shoal.number
    for one in scenario.individual:
        kinds[one.fish] = one.kind or kinds[one.fish]
    numbers = [shoal.number for shoal in scenario.fish]
    return Shoals([shoal.species for shoal in scenario.fish], numbers, kinds)


def _places(scenario: Scenario) -> Iterator[tuple[str, tuple[float, ...]]]:
    """Key and place of everything in a scenario, except tours."""
    yield "submarine.position_cm", scenario.submarine.position_cm
    if scenario.hook is not None:
        yield "hook", scenario.hook.bait_cm
    for name in PLACED:
        for k, one in enumerate(getattr(scenario, name)):
            if one.position_cm is not None:
                yield f"{name}[{k}].position_cm", one.position_cm
            if getattr(one, "toward_cm", None) is not None:
                yield f"{name}[{k}].toward_cm", one.toward_cm


def _check_tours(scenario: Scenario) -> None:
    """Raise a UserError for a tour that is impossible in any sea."""
    living = scenario.species
    for k, tour in enumerate(scenario.tour):
        here = f"tour[{k}]"
        if tour.name in (AUTOPILOT, DIRECTED, *(other.name for other in scenario.tour[:k])):
            raise UserError(
                f"`{here}`: the name {tour.name!r} is taken, expected another", key=here
            )
        before = None
        for i, point in enumerate(tour.waypoint):
            key = f"{here}.waypoint[{i}]"
            _inside(f"{key}.position_cm", point.position_cm, scenario.bounds)
            expected = ""
            if before is None and point.time_s != 0.0:
                expected = "0 at the first"
            elif before is not None and point.time_s <= before:
                expected = f"more than {before:g}, that of the one before"
            if expected:
                key = f"{key}.time_s"
                raise UserError(f"`{key}` {point.time_s:g}: expected {expected}", key=key)
            before = point.time_s
            if point.look_at_cm is not None:
                _inside(f"{key}.look_at_cm", point.look_at_cm, scenario.bounds)
            if point.follow is not None and point.follow not in living:
                key = f"{key}.follow"
                fault = unknown("fish", point.follow, living).message
                raise UserError(f"`{key}`: {fault}", key=key)
        first, last = tour.waypoint[0].position_cm, tour.waypoint[-1].position_cm
        if tour.loop and (first != last or len(tour.waypoint) < 4):
            raise UserError(
                f"`{here}` is a loop: expected four waypoints or more, the last where the first "
                f"is, at {first}",
                key=here,
            )


def _inside(key: str, place: tuple[float, ...], bounds: Bounds) -> None:
    """Raise a UserError for a place (x, y) or (x, y, z) outside the cylinder of the sea."""
    expected = f"at most {bounds.radius_cm:g} cm from the middle"
    if len(place) == 3:
        expected += f" and 0 to {-bounds.depth_cm:g} cm high"
    height_fits = all(-bounds.depth_cm <= z <= 0 for z in place[2:])
    if math.hypot(*place[:2]) > bounds.radius_cm or not height_fits:
        raise UserError(f"`{key}` {place} lies outside the sea: expected {expected}", key=key)
