"""Put the fishes of a scenario into the sea."""

from collections.abc import Sequence

import numpy as np

from subsea.base.arrays import Array
from subsea.behavior.mental_state import (
    apply_individual,
    character_of,
    set_character,
    set_temperament,
)
from subsea.fish.species import Species
from subsea.geometry.vector import vector
from subsea.habitat.contact import out_of_solids
from subsea.habitat.reef import KINDS as KINDS_OF_GROWTH
from subsea.motor.containment import contain
from subsea.motor.playback import TEMPO
from subsea.repertoire import SEGMENTS
from subsea.repertoire.library import Library
from subsea.scenario.schema import Scenario, Shoal
from subsea.scenario.school_rules import SchoolRules
from subsea.state import (
    BATHES,
    CLEANS,
    HIDES,
    KINDS,
    PREDATOR,
    SITES,
    TRAITS,
    Fishes,
    Minds,
    Reef,
    Sea,
)
from subsea.state.school_rules import rule_row
from subsea.state.wants import ITCH_BEGINS
from subsea.world.periodic import wrap
from subsea.world.world import TICK_S, World

ROOM_BL = 0.6  # distance of a new fish from every solid, body lengths
FLAT_BL = 0.4  # bodies at least this tall, over their length, row with their pectoral fins
HOME_CM = 400.0  # distance within which a fish finds a home
STATIONS, ABOVE_STATION_CM = ("staghorn", "table", "brain"), 25.0  # corals of cleaners
ABOVE_HOME_CM = 15.0  # height of the home over the growth
LET_OUT = 40  # steps out of a solid, a quarter of the body each, for a fish that begins in one
FIRST_LULL_S = 2.0, 3.0  # until predators hunt
RESOLVE_S = 60.0  # initial patience of fishes with a destination


def populate(world: World, rng: np.random.Generator) -> None:
    """Set places, sizes, leaders, traits and phases of all fishes at tick 0."""
    scenario, library, sea = world.scenario, world.library, world.state.sea
    fishes, minds = world.state.fishes, world.state.minds
    species = dict(zip(scenario.species, world.species, strict=True))
    slow = SEGMENTS.index("swim_slow")
    rules: list[SchoolRules] = []
    first = 0
    for shoal, number in zip(scenario.fish, world.shoal_sizes, strict=True):
        kind = list(species).index(shoal.species)
        these = slice(first, first + number)
        fishes.species[these] = kind
        smallest, largest = shoal.size_cm or species[shoal.species].size_cm
        fishes.length[these] = rng.uniform(smallest, largest, number)
        if shoal.leader_cm and number:
            fishes.length[first] = shoal.leader_cm
        fishes.identity[these] = rng.uniform(0, 1, number)
        schooling = species[shoal.species].schooling if shoal.schooling is None else shoal.schooling
        minds.schools[these], minds.led[these] = schooling, shoal.is_led
        own = scenario.rules_of(shoal)
        rules += [] if own in rules else [own]
        minds.school_rule[these] = rules.index(own)
        fishes.burst[these] = burst_speed(library, kind)
        fishes.ram[these] = species[shoal.species].least_speed
        if heights := species[shoal.species].cruise_height:
            minds.cruise_height[these] = fishes.length[these, None] * np.array(heights)
        places = _places(shoal, number, bool(schooling), scenario, rng)
        if shoal.leader_cm and shoal.position_cm:
            places[:1] = shoal.position_cm
        common = rng.uniform(-np.pi, np.pi)
        if shoal.heading_deg is not None:
            common = np.radians(shoal.heading_deg)
        together = schooling or shoal.heading_deg is not None
        for i, place in enumerate(places, start=first):
            room = ROOM_BL * float(fishes.length[i])
            place[:] = out_of_solids(sea, vector(place), room, 40.0, 40.0)
            turn = common + rng.normal(0, 0.2) if together else rng.uniform(-np.pi, np.pi)
            fishes.position[i] = place
            fishes.orientation[i] = heading_quaternion(turn)
            fishes.goal_direction[i] = np.cos(turn), np.sin(turn), 0.0
            row = int(rng.integers(library.length[kind, slow]))
            fishes.row_a[i] = library.first[kind, slow] + row
            fishes.row_b[i] = library.first[kind, slow] + (row + 1) % library.length[kind, slow]
        if schooling:
            minds.leader[first + 1 : first + number] = first
            minds.leads[first : first + 1] = number > 1
        minds.kind[these] = KINDS.index(shoal.kind or species[shoal.species].kind)
        traits = character_of(shoal, species[shoal.species], world.state.seed, first, number)
        set_character(minds, these, traits)
        hunts = minds.kind[these] == PREDATOR
        low, high = FIRST_LULL_S
        minds.lull[these] = hunts * (low + (high - low) * fishes.identity[these])
        minds.scavenges[these] = species[shoal.species].scavenges | hunts
        set_temperament(shoal, fishes, minds, these, rng)
        minds.waypoint[these] = fishes.position[these]
        if shoal.toward_cm:
            minds.waypoint[these] = shoal.toward_cm
            minds.patience[these] = RESOLVE_S
        first += number
    for row, one in enumerate(rules):
        minds.rules[row] = rule_row(one)
    for table in scenario.individual:
        if table.fish < len(fishes.species):  # fewer fishes were asked for than the scenario has
            apply_individual(fishes, minds, table, 0.0)
    minds.urge[:] = fishes.goal_direction
    fishes.goal_speed[:] = 0.5
    fishes.segment[:] = slow
    fishes.wanted_segment[:] = slow
    fishes.scale[:] = fishes.length / library.recorded_length[fishes.species]
    fishes.snout[:] = fishes.scale * library.nodes[library.first[fishes.species, slow], 0, 0]
    fishes.girth[:] = fishes.length[:, None] * _girths(world.species, library)[fishes.species]
    # Froude similarity: a fish α times as long beats 1/√α as often.
    fishes.size_rate[:] = 1.0 / np.sqrt(fishes.scale)
    fishes.rate[:] = fishes.size_rate * np.array([s.pace for s in world.species])[fishes.species]
    recorded = library.speed[fishes.species, SEGMENTS.index("swim_fast")]
    fishes.fast[:] = recorded * fishes.scale * fishes.rate
    fishes.breath[:] = 2 * np.pi * fishes.identity
    fishes.fin_phase[:] = fishes.breath[:, None]
    flat = np.array([s.surface.depth > FLAT_BL for s in world.species])
    fishes.oars[:] = flat[fishes.species]
    flaps = np.array([s.row is not None and s.row.flaps for s in world.species])
    fishes.flaps[:] = flaps[fishes.species]
    for name in ("position", "orientation", "row_a", "row_b", "weight", "span", "fins"):
        getattr(fishes, f"previous_{name}")[:] = getattr(fishes, name)
    wrap(fishes, minds)
    _let_out(fishes, library, sea)
    settle(world.species, fishes, minds, world.state.reef)
    set_ways(world.species, fishes, minds, world.state.reef)
    world.initial_traits = {name: getattr(minds, name).copy() for name in TRAITS}


def _let_out(fishes: Fishes, library: Library, sea: Sea) -> None:
    """Move bodies that begin with an end in a solid or outside of the sea into free water."""
    everyone = np.arange(len(fishes.species))
    for _ in range(LET_OUT):
        before = fishes.position.copy()
        contain(everyone, fishes, library.nodes, sea, TICK_S)
        if (before == fishes.position).all():
            break
        fishes.previous_position[:] = fishes.position
        fishes.previous_orientation[:] = fishes.orientation
    fishes.velocity[:] = 0.0


def settle(species: Sequence[Species], fishes: Fishes, minds: Minds, reef: Reef) -> None:
    """Give each fish of a species that keeps to a place a home: the nearest anemone, else growth.

    Without a growth within HOME_CM its starting place is its home.
    """
    ranges = np.array([s.home_cm or np.inf for s in species])
    minds.home[:], minds.home_range[:] = fishes.position, ranges[fishes.species]
    tops = reef.place + reef.radius[:, None] * reef.axis
    anemone = reef.kind == list(KINDS_OF_GROWTH).index("anemone")
    for i in np.flatnonzero(np.isfinite(minds.home_range)):
        far = np.linalg.norm(tops - fishes.position[i], axis=1)
        for eligible in (anemone, np.ones_like(anemone)):
            gaps = np.where(eligible, far, np.inf)
            if gaps.min(initial=np.inf) < HOME_CM:
                minds.home[i] = tops[gaps.argmin()] + (0.0, 0.0, ABOVE_HOME_CM)
                break


def set_ways(species: Sequence[Species], fishes: Fishes, minds: Minds, reef: Reef) -> None:
    """Give fishes the diet, the cover and the territory of their species.

    Only a fish with a home guards a territory.
    """
    plans = [one.life for one in species]
    diets = [sum(1 << SITES.index(food) for food in set(plan.eats)) for plan in plans]
    ways = [HIDES * plan.hides + BATHES * plan.bathes + CLEANS * plan.cleans for plan in plans]
    minds.diet[:], minds.ways[:] = np.array(diets)[fishes.species], np.array(ways)[fishes.species]
    radii = np.array([plan.territory_cm or 0.0 for plan in plans])[fishes.species]
    minds.territory[:] = np.where(np.isfinite(minds.home_range), radii, 0.0)
    minds.itch[:] = ITCH_BEGINS * fishes.identity
    _give_stations(minds, fishes, reef)


def _give_stations(minds: Minds, fishes: Fishes, reef: Reef) -> None:
    """Give each cleaner a station over the largest coral near it; without one it does not clean."""
    tall = np.isin(reef.kind, [list(KINDS_OF_GROWTH).index(kind) for kind in STATIONS])
    tops = reef.place + reef.radius[:, None] * reef.axis
    for i in np.flatnonzero(minds.ways & CLEANS):
        far = np.linalg.norm(tops - fishes.position[i], axis=1)
        size = np.where(tall & (far < HOME_CM), reef.radius, 0.0)
        if size.max(initial=0.0) > 0.0:
            minds.home[i] = tops[size.argmax()] + (0.0, 0.0, ABOVE_STATION_CM)
        else:
            minds.ways[i] &= 255 - CLEANS


def burst_speed(library: Library, kind: int) -> float:
    """Compute the speed of a burst at full tempo over that of the fast swim, at least 1."""
    fast, burst = (library.speed[kind, SEGMENTS.index(f"swim_{s}")] for s in ("fast", "burst"))
    return max(float(TEMPO[1] * burst / fast), 1.0)


def _girths(species: Sequence[Species], library: Library) -> Array:
    """Measure the widest cross-section of each species: height and width (s, 2), body lengths."""
    rows = library.nodes[library.first[:, SEGMENTS.index("swim_slow")], 1:21]
    sections = rows.reshape(len(species), 5, 4, 3)
    wide = np.ptp(sections[..., 2], axis=2).max(axis=1) / library.recorded_length
    return np.stack([[s.surface.depth for s in species], wide], axis=1)


def _places(
    shoal: Shoal, number: int, schooling: bool, scenario: Scenario, rng: np.random.Generator
) -> Array:
    """Draw the starting places (number, 3) of a shoal inside the cylinder, cm.

    In a box with periodic sides they may lie beyond a side.
    """
    radius, tank = scenario.bounds.radius_cm, scenario.bounds.tank_cm
    sides, share = (tank, 0.4) if tank is not None else (scenario.bounds.periodic_cm, 0.5)
    if shoal.position_cm is None and sides is not None:
        places = rng.uniform((-share, -share, -0.9), (share, share, -0.3), (number, 3))
        return places * (*sides, scenario.bounds.depth_cm)
    if shoal.position_cm is None:
        angle = rng.uniform(0, 2 * np.pi, number)
        reach = 0.85 * radius * np.sqrt(rng.uniform(0, 1, number))
        depth = rng.uniform(-0.9, -0.3, number) * scenario.bounds.depth_cm
        return np.stack([reach * np.cos(angle), reach * np.sin(angle), depth], axis=1)
    # The space per fish stays that of the scenario; fewer fishes stay as dense only in a school.
    more = number / max(shoal.number, 1)
    spread = shoal.spread_cm * (more if schooling else max(more, 1.0)) ** (1 / 3)
    places = rng.normal(0, spread / 2, (number, 3)) * (1, 1, 0.5) + shoal.position_cm
    if scenario.bounds.periodic_cm is None:
        out = np.hypot(places[:, 0], places[:, 1]) / (0.85 * radius)
        places[:, :2] /= np.maximum(out, 1.0)[:, None]
    if tank is not None:
        places[:, :2] = np.clip(places[:, :2], *np.multiply.outer((-0.45, 0.45), tank))
    return np.asarray(places)


def heading_quaternion(heading: float) -> Array:
    """Make the quaternion (4,) of an upright body that heads `heading` rad left of the x axis."""
    # Body y is up and z is right: a quarter turn about x, then the heading about the vertical.
    c, s = np.cos(heading / 2), np.sin(heading / 2)
    r = np.sqrt(0.5)
    return np.array([c * r, c * r, s * r, s * r], np.float32)
