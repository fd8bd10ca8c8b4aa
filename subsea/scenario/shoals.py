"""Number the fishes of a scenario: shoal by shoal, in the order of its tables."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace

from subsea.base.errors import UserError, unknown
from subsea.fish.species import load_species
from subsea.scenario.directions import FishSelector, renumbered
from subsea.scenario.schema import Scenario


class Shoals(NamedTuple):
    """The species and the size of each shoal, and the kind of each fish where it is needed."""

    species: Sequence[str]
    numbers: Sequence[int]
    kind: Sequence[str] = ()  # of each fish, such as "prey"


def shoals_of(scenario: Scenario) -> Shoals:
    """Read the species of a scenario for the kinds of its fishes."""
    kinds: list[str] = []
    for shoal in scenario.fish:
        kinds += [shoal.kind or load_species(shoal.species).kind] * shoal.number
    for table in scenario.individual:
        kinds[table.fish] = table.kind or kinds[table.fish]
    numbers = [shoal.number for shoal in scenario.fish]
    return Shoals([shoal.species for shoal in scenario.fish], numbers, kinds)


def numbers_of(fishes: FishSelector, shoals: Shoals) -> list[int]:
    """List the numbers of the selected fishes that exist."""
    numbers: list[int] = []
    first = 0
    for k, (species, size) in enumerate(zip(shoals.species, shoals.numbers, strict=True)):
        shoal = range(first, first + size)
        if k == fishes.shoal or species == fishes.species:
            numbers += shoal
        elif fishes.fish is not None and fishes.fish in shoal:
            numbers.append(fishes.fish)
        first += size
    return numbers


def shoal_sizes(scenario: Scenario, fish: int | None) -> list[int]:
    """Return the number of fishes of each shoal, scaled to `fish` in all if given."""
    numbers = [shoal.number for shoal in scenario.fish]
    return numbers if fish is None or not any(numbers) else share_out(fish, numbers)


def with_total(scenario: Scenario, fish: int | None) -> Scenario:
    """Scale the shoals of a scenario to `fish` in all; None: return it as it is."""
    if fish is None:
        return scenario
    shoals = zip(scenario.fish, shoal_sizes(scenario, fish), strict=True)
    return replace(scenario, fish=[replace(shoal, number=number) for shoal, number in shoals])


def with_shoal_size(scenario: Scenario, index: int, number: int) -> Scenario:
    """Set the number of fishes of a shoal; tables of single fishes follow their fishes."""
    first = sum(shoal.number for shoal in scenario.fish[:index])
    last, more = first + scenario.fish[index].number, number - scenario.fish[index].number

    def then(fish: int) -> int:
        """Return the new number of a fish; -1 for a removed one."""
        if fish >= last:
            return fish + more
        return fish if fish < first + number else -1

    tables = [replace(table, fish=then(table.fish)) for table in scenario.individual]
    shoals = list(scenario.fish)
    shoals[index] = replace(shoals[index], number=number)
    return replace(
        scenario,
        fish=shoals,
        individual=[table for table in tables if table.fish >= 0],
        direction=renumbered(scenario.direction, then, lambda shoal: shoal),
        physics=replace(scenario.physics, fish=then(scenario.physics.fish)),
    )


def share_out(number: int, shares: Sequence[int]) -> list[int]:
    """Divide a number in proportion to shares (k,) by largest remainder; equally if all are 0."""
    if not shares:
        return []
    old = np.array(shares, float) if any(shares) else np.ones(len(shares))
    exact = number * old / old.sum()
    parts = np.floor(exact).astype(int)
    for k in np.argsort(parts - exact, kind="stable")[: number - int(parts.sum())]:
        parts[k] += 1
    return [int(part) for part in parts]


def find_fish(name: str, scenario: Scenario) -> int:
    """Return the number of a fish given as a number, a species or SPECIES:NUMBER.

    Fishes of a species are counted from 0 in the order of their numbers. An unknown fish is a
    UserError.
    """
    shoals = Shoals([shoal.species for shoal in scenario.fish], shoal_sizes(scenario, None))
    numbers, of, count = list(range(sum(shoals.numbers))), "", name
    if not name.isdecimal():
        species, colon, count = name.partition(":")
        if species not in (known := scenario.species):
            raise unknown("fish", species, known)
        if colon and not count.isdecimal():
            raise UserError(f"fish {name!r}: expected a number, a species or SPECIES:NUMBER")
        numbers, of = numbers_of(FishSelector(species=species), shoals), f" of {species}"
    number = int(count or 0)
    if number >= len(numbers):
        last = f"0 to {len(numbers) - 1}" if numbers else "none, there is no such fish"
        raise UserError(f"no fish {number}{of}: expected {last}")
    return numbers[number]
