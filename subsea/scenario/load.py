"""Find scenarios by name or path and load them.

Find a fish by number or species.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from subsea.base.errors import UserError, unknown
from subsea.base.system import is_path, own_path, resource_names, resource_path, stems
from subsea.base.toml_files import load_toml, locate_errors
from subsea.scenario.checks import check_scenario
from subsea.scenario.schema import Scenario

SHIPPED = "assets/scenarios"  # the folder of the shipped scenarios


def own_scenarios() -> Path:
    """The folder of the user's own scenarios, which may be missing."""
    return own_path("scenarios")


def scenario_names() -> list[str]:
    """Names that `load_scenario` accepts: the shipped ones, then the user's own."""
    shipped = resource_names(SHIPPED, ".toml")
    return shipped + [name for name in stems(own_scenarios(), ".toml") if name not in shipped]


def scenario_file(name: str) -> Path:
    """The file of the scenario `name`, or the path `name` if it has a slash or ends in ``.toml``.

    An unknown name is a UserError.
    """
    if is_path(name, ".toml"):
        return Path(name)
    if name not in (known := scenario_names()):
        raise unknown("scenario", name, known)
    shipped = resource_path(SHIPPED) / f"{name}.toml"
    return shipped if shipped.exists() else own_scenarios() / f"{name}.toml"


def load_scenario(name: str, changes: Sequence[str] = ()) -> tuple[Scenario, Path]:
    """Load the scenario called `name`, or from the path `name`; return it with its file.

    `changes` such as ``fish.0.number=20`` are applied to it. Any fault is a UserError.
    """
    path = scenario_file(name)
    scenario = load_toml(path, Scenario, changes)
    with locate_errors(scenario, path, changes):
        check_scenario(scenario)
    return scenario, path


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
