"""Find scenarios by name or path and load them."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from subsea.base.system import (
    is_path,
    own_path,
    resource_names,
    resource_path,
    stems,
    unknown_name,
)
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
        raise unknown_name("scenario", name, known, ".toml")
    shipped = resource_path(SHIPPED) / f"{name}.toml"
    return shipped if shipped.exists() else own_scenarios() / f"{name}.toml"


class LoadedScenario(NamedTuple):
    """A scenario as a command has loaded it. Nothing below a command loads it again."""

    scenario: Scenario
    path: Path
    changes: Sequence[str] = ()  # of --set, which the scenario has already


def load_scenario(name: str, changes: Sequence[str] = ()) -> LoadedScenario:
    """Load the scenario called `name`, or from the path `name`.

    `changes` such as ``fish.0.number=20`` are applied to it. Any fault is a UserError.
    """
    path = scenario_file(name)
    scenario = load_toml(path, Scenario, changes)
    with locate_errors(scenario, path, changes):
        check_scenario(scenario)
    return LoadedScenario(scenario, path, changes)
