"""Find a fish by number or species."""

import numpy as np

from subsea.base.errors import UserError, unknown
from subsea.scenario.schema import Scenario


def find_fish(name: str, scenario: Scenario) -> int:
    """Return the index of a fish given as a number, a species or SPECIES:NUMBER.

    Fishes of a species are counted from 0 in the order of their numbers. An unknown fish is a
    UserError.
    """
    kinds = np.repeat(
        [shoal.species for shoal in scenario.fish], [shoal.number for shoal in scenario.fish]
    )
    found, of, count = np.arange(len(kinds)), "", name
    if not name.isdecimal():
        species, colon, count = name.partition(":")
        if species not in (known := scenario.species):
            raise unknown("fish", species, known)
        if colon and not count.isdecimal():
            raise UserError(f"fish {name!r}: expected a number, a species or SPECIES:NUMBER")
        found, of = np.flatnonzero(kinds == species), f" of {species}"
    number = int(count or 0)
    if number >= len(found):
        last = f"0 to {len(found) - 1}" if len(found) else "none, there is no such fish"
        raise UserError(f"no fish {number}{of}: expected {last}")
    return int(found[number])
