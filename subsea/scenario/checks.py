"""Find the faults of a scenario that need no world: places, names, totals and directions."""

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

from subsea.base.errors import UserError, unknown
from subsea.fish.species import species_names
from subsea.scenario.directions import INFLUENCES, MOVES, Direction, FishSelector
from subsea.scenario.schema import (
    AUTOPILOT,
    DIRECTED,
    MAX_FISHES,
    MAX_GROWTHS,
    MAX_SEAWEED,
    Scenario,
)
from subsea.scenario.school_rules import MAX_RULES, SchoolRules
from subsea.scenario.shoals import Shoals, numbers_of, shoals_of

# Tables with a place.
PLACED = (
    "fish", "pillar", "rock", "outcrop", "ridge", "arch", "wreck", "vent", "reef", "coral",
    "seaweed",
)  # fmt: skip
# Kind of fish that an influence needs among those that it is about.
NEEDED = {"hunts": "predator", "rests": "predator", "fear": "prey", "libido": "pacifist"}

Findings = Iterator[UserError]


def check_scenario(scenario: Scenario) -> None:
    """Raise the first of the findings."""
    for finding in findings(scenario):
        raise finding


def findings(scenario: Scenario) -> Findings:
    """Find the faults of a scenario, each an error with its key.

    `world.checks` finds those that need a seabed, such as overlapping objects.
    """
    for key, place in _places(scenario):
        yield from _outside(key, place, scenario)
    yield from _untanked(scenario)
    yield from _not_periodic(scenario)
    yield from _misnamed(scenario)
    yield from _misfits(scenario)
    yield from _unruly(scenario)
    for k, tour in enumerate(scenario.tour):
        before = None
        for i, point in enumerate(tour.waypoint):
            expected = ""
            if before is None and point.time_s != 0.0:
                expected = "0 at the first"
            elif before is not None and point.time_s <= before:
                expected = f"more than {before:g}, that of the one before"
            if expected:
                key = f"tour[{k}].waypoint[{i}].time_s"
                yield UserError(f"`{key}` {point.time_s:g}: expected {expected}", key=key)
            before = point.time_s
        first, last = tour.waypoint[0].position_cm, tour.waypoint[-1].position_cm
        if tour.loop and (first != last or len(tour.waypoint) < 4):
            yield UserError(
                f"`tour[{k}]` is a loop: expected four waypoints or more, the last where the first "
                f"is, at {first}",
                key=f"tour[{k}]",
            )
    if scenario.direction:
        yield from _misdirected(scenario)


def _places(scenario: Scenario) -> Iterator[tuple[str, tuple[float, ...] | None]]:
    """List key and place of everything in a scenario, in the order of its tables."""
    yield "submarine.position_cm", scenario.submarine.position_cm
    if scenario.hook is not None:
        yield "hook", scenario.hook.bait_cm
    for name in PLACED:
        for k, table in enumerate(getattr(scenario, name)):
            yield f"{name}[{k}].position_cm", table.position_cm
            yield f"{name}[{k}].toward_cm", getattr(table, "toward_cm", None)
    for k, tour in enumerate(scenario.tour):
        for i, point in enumerate(tour.waypoint):
            yield f"tour[{k}].waypoint[{i}].position_cm", point.position_cm
            yield f"tour[{k}].waypoint[{i}].look_at_cm", point.look_at_cm
    for k, direction in enumerate(scenario.direction):
        yield f"direction[{k}].gate_cm", direction.gate_cm
        yield f"direction[{k}].place_cm", direction.place_cm
        for i, place in enumerate(direction.path_cm or ()):
            yield f"direction[{k}].path_cm[{i}]", place
        if direction.camera is not None:
            yield f"direction[{k}].camera.position_cm", direction.camera.position_cm
            yield f"direction[{k}].camera.look_at_cm", direction.camera.look_at_cm


def _outside(key: str, place: tuple[float, ...] | None, scenario: Scenario) -> Findings:
    """Find a place (x, y) or (x, y, z) outside the cylinder of the sea."""
    radius, depth = scenario.bounds.radius_cm, scenario.bounds.depth_cm
    if place is None:
        return
    if math.hypot(*place[:2]) > radius or not all(-depth <= z <= 0 for z in place[2:]):
        expected = f"at most {radius:g} cm from the middle"
        if len(place) == 3:
            expected += f" and 0 to {depth:g} cm high"
        yield UserError(f"`{key}` {place} lies outside the sea: expected {expected}", key=key)


def _untanked(scenario: Scenario) -> Findings:
    """Find a tank that is larger than the sea, and currents through its walls."""
    bounds, water = scenario.bounds, scenario.water
    if bounds.tank_cm is None:
        return
    corner = 0.5 * math.hypot(*bounds.tank_cm)
    if corner > bounds.radius_cm:
        yield UserError(
            f"`bounds.tank_cm` {list(bounds.tank_cm)}: its corners are {corner:.0f} cm from the "
            f"middle, expected at most {bounds.radius_cm:g}, the radius of the sea",
            key="bounds.tank_cm",
        )
    for name in ("current_cm_s", "stream_cm_s"):
        if any(getattr(water, name)):
            key = f"water.{name}"
            yield UserError(f"`{key}`: expected 0 in a tank, whose walls let no water in", key=key)


# Tables of things at a place. In a periodic box their images would have to be there, too.
FIXED = (
    "pillar", "rock", "outcrop", "ridge", "arch", "wreck", "hook", "seaweed", "vent", "reef",
    "coral", "tour", "direction",
)  # fmt: skip


def _not_periodic(scenario: Scenario) -> Findings:
    """Find what a box with periodic sides cannot have: places that differ from their images."""
    if scenario.bounds.periodic_cm is None:
        return
    for name in FIXED:
        if getattr(scenario, name):
            yield UserError(f"`{name}`: expected none in a box with periodic sides", key=name)
    for table, names in (
        ("terrain", ("dune_height_cm", "shelf_cm")),
        ("water", ("plankton",)),
        ("nature", ("submarine_cm", "curiosity_cm")),
    ):
        for name in names:
            if value := getattr(getattr(scenario, table), name):
                key, expected = f"{table}.{name}", "expected 0 in a box with periodic sides"
                yield UserError(f"`{key}` {value:g}: {expected}", key=key)
    if scenario.bounds.tank_cm is not None:
        key = "bounds.tank_cm"
        yield UserError(f"`{key}`: expected none beside `bounds.periodic_cm`", key=key)
    for k, shoal in enumerate(scenario.fish):
        for name in ("position_cm", "toward_cm"):
            place = getattr(shoal, name)
            if place is not None and any(
                abs(x) > 0.5 * side
                for x, side in zip(place, scenario.bounds.periodic_cm, strict=False)
            ):
                key = f"fish[{k}].{name}"
                sides = " and ".join(f"±{0.5 * side:g}" for side in scenario.bounds.periodic_cm)
                yield UserError(
                    f"`{key}` {place} lies outside the box: expected x and y within {sides} cm",
                    key=key,
                )


def _misnamed(scenario: Scenario) -> Findings:
    """Find names that nothing has, and names that two things have."""
    known, living = species_names(), scenario.species
    names = [
        (f"fish[{k}].species", "species", shoal.species, known)
        for k, shoal in enumerate(scenario.fish)
    ]
    names += [
        (f"tour[{k}].waypoint[{i}].follow", "fish", point.follow, living)
        for k, tour in enumerate(scenario.tour)
        for i, point in enumerate(tour.waypoint)
        if point.follow is not None
    ]
    tours = [tour.name for tour in scenario.tour]
    names += [(f"school.species.{name}", "fish", name, living) for name in scenario.school.species]
    directions = [direction.name for direction in scenario.direction]
    for k, direction in enumerate(scenario.direction):
        if direction.after is not None:
            others = [name for name in directions if name]
            names.append((f"direction[{k}].after", "direction", direction.after, others))
        if direction.camera is not None and direction.camera.tour is not None:
            names.append((f"direction[{k}].camera.tour", "tour", direction.camera.tour, tours))
        names += [
            (f"direction[{k}].{key}.species", "fish", fishes.species, living)
            for key, fishes in _selectors(direction)
            if fishes.species is not None
        ]
    for key, kind, name, choices in names:
        if name not in choices:
            yield UserError(f"`{key}`: {unknown(kind, name, choices).message}", key=key)
    for k, name in enumerate(tours):
        if name in (AUTOPILOT, DIRECTED, *tours[:k]):
            key = f"tour[{k}]"
            yield UserError(f"`{key}`: the name {name!r} is taken, expected another", key=key)
    for k, name in enumerate(directions):
        if name and name in directions[:k]:
            key = f"direction[{k}].name"
            yield UserError(f"`{key}`: the name {name!r} is taken, expected another", key=key)


def _misfits(scenario: Scenario) -> Findings:
    """Find totals beyond what a sea may have, sizes in the wrong order, and missing fishes."""
    for k, shoal in enumerate(scenario.fish):
        if shoal.size_cm is not None and shoal.size_cm[0] > shoal.size_cm[1]:
            key, sizes = f"fish[{k}].size_cm", list(shoal.size_cm)
            yield UserError(f"`{key}` {sizes}: expected the smallest first", key=key)
    leaves = sum(group.clusters * group.leaves for group in scenario.seaweed)
    growths = sum(table.number for table in scenario.reef) + len(scenario.coral)
    for key, number, what, most in (
        ("seaweed", leaves, "leaves", MAX_SEAWEED),
        ("reef", growths, "growths", MAX_GROWTHS),
    ):
        if number > most:
            yield UserError(f"`{key}` has {number} {what}, expected at most {most}", key=key)
    fishes = sum(shoal.number for shoal in scenario.fish)
    if fishes > MAX_FISHES:
        yield UserError(f"{fishes} fishes in all, expected at most {MAX_FISHES}")
    seen: set[int] = set()
    for k, table in enumerate(scenario.individual):
        key, fault = f"individual[{k}].fish", ""
        if table.fish >= fishes:
            expected = f"expected 0 to {fishes - 1}" if fishes else "but there are none"
            fault = f"there is no such fish, {expected}"
        elif table.fish in seen:
            fault = "has a table already, expected one for each fish"
        if fault:
            yield UserError(f"`{key}` {table.fish}: {fault}", key=key)
        seen.add(table.fish)


def _unruly(scenario: Scenario) -> Findings:
    """Find rules of schools that contradict each other, and too many different ones."""
    different: list[SchoolRules] = []
    for k, shoal in enumerate(scenario.fish):
        rules = scenario.rules_of(shoal)
        different += [] if rules in different else [rules]
        near, far = rules.attraction_bl or 0.0, rules.full_attraction_bl or 0.0
        shares = sum(goal.share for goal in rules.goals or ())
        for name, broken, fault in (
            ("separation_bl", (rules.separation_bl or 0.0) > near,
             f"{rules.separation_bl:g}: expected at most {near:g}, that of `attraction_bl`"),
            ("full_attraction_bl", far <= near,
             f"{far:g}: expected more than {near:g}, that of `attraction_bl`"),
            ("goals", shares > 1.0, f"have shares of {shares:g}: expected at most 1 in all"),
        ):  # fmt: skip
            if broken:
                key = _key_of_rule(scenario, k, name)
                yield UserError(f"`{key}` {fault}", key=key)
        for i, goal in enumerate(rules.goals or ()):
            key = f"{_key_of_rule(scenario, k, 'goals')}[{i}].position_cm"
            yield from _outside(key, goal.position_cm, scenario)
            if goal.position_cm is not None and scenario.bounds.periodic_cm is not None:
                fault = "expected `heading_deg` in a box with periodic sides"
                yield UserError(f"`{key}`: {fault}", key=key)
    if len(different) > MAX_RULES:
        many = len(different)
        yield UserError(f"{many} different rules of schools, expected at most {MAX_RULES}")


def _key_of_rule(scenario: Scenario, shoal: int, name: str) -> str:
    """Return the key of the table that gives a rule to a shoal."""
    species = scenario.fish[shoal].species
    if getattr(scenario.fish[shoal].rules, name) is not None:
        return f"fish[{shoal}].rules.{name}"
    if getattr(scenario.school.species.get(species), name, None) is not None:
        return f"school.species.{species}.{name}"
    return f"school.{name}"


class _Sea(NamedTuple):
    """Collect the names that directions refer to."""

    shoals: Shoals
    hook: bool


class _Rule(NamedTuple):
    """A rule of directions: the key, when it is broken, and what to expect."""

    key: str
    is_broken: Callable[[Direction, _Sea], bool]
    fault: str


def _moves(direction: Direction) -> list[str]:
    """List the influences on the fishes that `who` selects."""
    return [name for name in MOVES if name in direction.influences]


def _has_cast(direction: Direction) -> bool:
    """Return whether a camera can follow the fishes of an event."""
    return any(value is not None for value in (direction.event, direction.after, direction.pair))


def _selectors(direction: Direction) -> list[tuple[str, FishSelector]]:
    """List the selections of fishes in a direction, by key."""
    follow = None if direction.camera is None else direction.camera.follow
    keys = ("of", direction.of), ("who", direction.who), ("hunts", direction.hunts)
    return [(key, fishes) for key, fishes in (*keys, ("camera.follow", follow))
            if isinstance(fishes, FishSelector)]  # fmt: skip


def _lacks(kind: str, direction: Direction, sea: _Sea) -> bool:
    """Return whether `who` selects fishes, but none of a kind."""
    if direction.who is None:
        return False
    kinds = {sea.shoals.kind[i] for i in numbers_of(direction.who, sea.shoals)}
    return bool(kinds) and kind not in kinds


RULES = (
    _Rule("", lambda d, sea: not d.influences and not d.name,
          f"nothing happens: expected one of {', '.join(INFLUENCES)}, or a name that others "
          "follow"),
    _Rule("who", lambda d, sea: bool(_moves(d)) and d.who is None,
          "missing: whom `{moves}` is about"),
    _Rule("who", lambda d, sea: d.who is not None and not _moves(d) and d.pair != "nearest",
          f"nothing moves them: expected one of {', '.join(MOVES)}"),
    _Rule("who", lambda d, sea: d.pair == "nearest" and d.who is None,
          "missing: among whom the nearest two are to be found"),
    _Rule("pair", lambda d, sea: isinstance(d.pair, tuple) and d.pair[0] == d.pair[1],
          "a fish cannot court itself, expected two"),
    _Rule("gate_cm", lambda d, sea: (d.event == "passes") != (d.gate_cm is not None),
          'goes with `event = "passes"`, and that with it'),
    _Rule("of", lambda d, sea: d.of is not None and d.event is None and d.fewer_than is None,
          "expected an `event` or `fewer_than` that is theirs"),
    _Rule("delay_s", lambda d, sea: bool(d.delay_s) and d.after is None,
          "expected the direction `after` which it waits, or a later `at_s`"),
    _Rule("speed_cm_s", lambda d, sea: d.speed_cm_s is not None and d.path_cm is None,
          "expected a `path_cm`"),
    _Rule("loop", lambda d, sea: d.loop and d.path_cm is None, "expected a `path_cm`"),
    _Rule("place_cm", lambda d, sea: d.place_cm is not None and d.pair is None,
          "expected a `pair`"),
    _Rule("pair", lambda d, sea: d.pair is not None and d.path_cm is not None,
          "a pair that courts follows no path, expected `place_cm`"),
    _Rule("rests", lambda d, sea: d.hunts is not None and d.rests,
          "who `hunts` does not rest, expected one of them"),
    _Rule("hook", lambda d, sea: d.hook is not None and not sea.hook,
          "expected a table [hook] that says where it hangs"),
    _Rule("camera.follow",
          lambda d, sea: d.camera is not None and d.camera.follow == "cast" and not _has_cast(d),
          'of "cast": expected an `event`, `pair` or `after`'),
    *(_Rule(name, lambda d, sea, name=name, kind=kind:  # type: ignore[misc]
            name in d.influences and _lacks(kind, d, sea),
            f"there is no {kind} among them, expected one") for name, kind in NEEDED.items()),
    _Rule("pair", lambda d, sea: d.pair == "nearest" and _lacks("pacifist", d, sea),
          "there is no pacifist among them, expected one"),
)  # fmt: skip


def _misdirected(scenario: Scenario) -> Findings:
    """Find directions that nobody can carry out."""
    sea = _Sea(shoals_of(scenario), scenario.hook is not None)
    after = {direction.name: direction.after for direction in scenario.direction if direction.name}
    for k, direction in enumerate(scenario.direction):
        faults = [
            *_strangers(direction, sea.shoals),
            *((rule.key, rule.fault.format(moves=(_moves(direction) or [""])[0]))
              for rule in RULES if rule.is_broken(direction, sea)),
        ]  # fmt: skip
        chain, before = [direction.name], direction.after
        while before is not None and before not in chain:
            chain.append(before)
            before = after.get(before)
        if before is not None:
            fault = f"it waits for itself, by way of {before!r}"
            faults.append(("after", f"{fault}, expected a direction that can begin before it"))
        for key, fault in faults:
            key = f"direction[{k}].{key}" if key else f"direction[{k}]"
            yield UserError(f"`{key}`: {fault}", key=key)


def _strangers(direction: Direction, shoals: Shoals) -> Iterator[tuple[str, str]]:
    """Find key and fault of each fish or shoal in a direction that does not exist."""
    fishes = [(f"{key}.fish", one.fish) for key, one in _selectors(direction)]
    pair = direction.pair if isinstance(direction.pair, tuple) else ()
    for key, number in (*fishes, *(("pair", fish) for fish in sorted(pair, reverse=True)[:1])):
        if number is not None and number >= (many := len(shoals.kind)):
            expected = f"expected 0 to {many - 1}" if many else "expected none"
            yield key, f"{number}: there is no such fish, {expected}"
    for key, one in _selectors(direction):
        if one.shoal is not None and one.shoal >= (many := len(shoals.species)):
            yield f"{key}.shoal", f"{one.shoal}: there is no such shoal, expected 0 to {many - 1}"
    for fish in pair:
        if fish < len(shoals.kind) and (kind := shoals.kind[fish]) != "pacifist":
            yield "pair", f"fish {fish} is a {kind}, expected two pacifists: only they court"
