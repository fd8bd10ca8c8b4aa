"""Count fishes, seaweed and pillars of a scenario (Tu §9.1), and change their numbers.

A number counts all shoals of a species, or all groups of a kind of seaweed. A new number is divided
among them in proportion to their old numbers.
"""

import math
from dataclasses import dataclass
from typing import get_args

from msgspec.structs import replace

from subsea.fish.species import species_names
from subsea.scenario.schema import Pillar, Scenario, SeaweedTable, Shoal
from subsea.scenario.shoals import share_out, with_shoal_size
from subsea.state import HULL_CM

ROOM_CM = 3.0 * HULL_CM  # from a new pillar to other things
KINDS: tuple[str, ...] = get_args(SeaweedTable.__annotations__["kind"])
DEFAULT_SEAWEED = SeaweedTable()
SPREAD = 0.7549, 0.5698  # their multiples, modulo 1, are evenly spread
TRIES = 400


@dataclass
class Counts:
    """Numbers of things in a scenario, and its seed."""

    fishes: dict[str, int]  # by species, of all species
    plankton: int
    clusters: dict[str, int]  # of seaweed, by kind
    leaves: dict[str, int]  # of a cluster, in the largest group of a kind
    pillars: int
    seed: int


def counts(scenario: Scenario) -> Counts:
    """Count the things of a scenario."""
    # A species of the visitor may have been deleted since the scenario was read.
    numbers = dict.fromkeys([*species_names(), *scenario.species], 0)
    for shoal in scenario.fish:
        numbers[shoal.species] += shoal.number
    groups = {kind: [g for g in scenario.seaweed if g.kind == kind] for kind in KINDS}
    return Counts(
        fishes=numbers,
        plankton=scenario.water.plankton,
        clusters={kind: sum(group.clusters for group in groups[kind]) for kind in KINDS},
        leaves={
            kind: max(
                groups[kind], key=lambda group: group.clusters, default=DEFAULT_SEAWEED
            ).leaves
            for kind in KINDS
        },
        pillars=len(scenario.pillar),
        seed=scenario.seed,
    )


def with_counts(scenario: Scenario, wanted: Counts) -> Scenario:
    """Change the numbers of a scenario; unchanged numbers leave their tables as they are."""
    was = counts(scenario)
    for species, number in wanted.fishes.items():
        if number != was.fishes[species]:
            scenario = with_fishes(scenario, species, number)
    for kind in KINDS:
        both = wanted.clusters[kind], wanted.leaves[kind]
        if both != (was.clusters[kind], was.leaves[kind]):
            scenario = with_seaweed(scenario, kind, *both)
    if wanted.pillars != was.pillars:
        scenario = with_pillars(scenario, wanted.pillars)
    water = replace(scenario.water, plankton=wanted.plankton)
    return replace(scenario, water=water, seed=wanted.seed)


def with_fishes(scenario: Scenario, species: str, number: int) -> Scenario:
    """Set the number of fishes of a species; a new shoal is spread over the whole sea.

    Tables of single fishes stay with these fishes.
    """
    shoals = [*scenario.fish]
    if number and not any(shoal.species == species for shoal in shoals):
        shoals.append(Shoal(species=species, number=0))
    these = [k for k, shoal in enumerate(shoals) if shoal.species == species]
    scenario = replace(scenario, fish=shoals)
    for k, share in zip(these, share_out(number, [shoals[k].number for k in these]), strict=True):
        scenario = with_shoal_size(scenario, k, share)
    return scenario


def with_seaweed(scenario: Scenario, kind: str, clusters: int, leaves: int) -> Scenario:
    """Set clusters and leaves of a kind; a new group is spread over the whole sea."""
    groups = [*scenario.seaweed]
    if clusters and not any(group.kind == kind for group in groups):
        high = {"kelp": 400.0, "grass": 32.0, "red": 32.0}.get(kind, 90.0)
        groups.append(SeaweedTable(kind=kind, clusters=0, height_cm=high))  # type: ignore[arg-type]
    these = [k for k, group in enumerate(groups) if group.kind == kind]
    shares = share_out(clusters, [groups[k].clusters for k in these])
    for k, share in zip(these, shares, strict=True):
        groups[k] = replace(groups[k], clusters=share, leaves=leaves)
    return replace(scenario, seaweed=groups)


def with_pillars(scenario: Scenario, number: int) -> Scenario:
    """Set the number of pillars: remove the last, put new ones where there is room."""
    pillars, radius, high = scenario.pillar[:number], 35.0, round(0.4 * scenario.bounds.depth_cm)
    for k in range(1, TRIES):
        if len(pillars) >= number:
            break
        far = 0.8 * scenario.bounds.radius_cm * math.sqrt(SPREAD[0] * k % 1.0)
        angle = 2.0 * math.pi * (SPREAD[1] * k % 1.0)
        place = (float(round(far * math.cos(angle))), float(round(far * math.sin(angle))))
        occupied = _occupied(replace(scenario, pillar=pillars))
        if all(math.dist(place, other) > room + radius for other, room in occupied):
            pillars = [*pillars, Pillar(position_cm=place, radius_cm=radius, height_cm=high)]
    return replace(scenario, pillar=pillars)


def _occupied(scenario: Scenario) -> list[tuple[tuple[float, ...], float]]:
    """List the occupied places (x, y) and the distance to keep from each, cm."""
    occupied: list[tuple[tuple[float, ...], float]]
    places = [scenario.submarine.position_cm]
    places += [at for shoal in scenario.fish for at in (shoal.position_cm, shoal.toward_cm) if at]
    occupied = [(place[:2], ROOM_CM) for place in places]
    occupied += [(p.position_cm, p.radius_cm + ROOM_CM) for p in scenario.pillar]
    occupied += [(r.position_cm, max(r.size_cm[:2]) + ROOM_CM) for r in scenario.rock]
    occupied += [(r.position_cm, max(r.size_cm[:2]) + ROOM_CM) for r in scenario.outcrop]
    occupied += [(a.position_cm, a.span_cm + ROOM_CM) for a in scenario.arch]
    occupied += [(w.position_cm, 0.5 * w.length_cm + ROOM_CM) for w in scenario.wreck]
    if scenario.hook is not None:
        occupied.append((scenario.hook.position_cm, ROOM_CM))
    occupied += [(p.position_cm[:2], ROOM_CM) for tour in scenario.tour for p in tour.waypoint]
    return occupied
