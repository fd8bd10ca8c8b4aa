"""`subsea list`: list the scenarios, species or theatres."""

import json
from argparse import Namespace
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from subsea.base.command_line import add_command
from subsea.base.errors import UserError
from subsea.base.progress import print_line
from subsea.base.registry import LISTS, load_named, registered

SHIPPED, OWN = "shipped", "own"


class ListedFile(NamedTuple):
    """A file that commands accept by name; a faulty one has no title."""

    name: str
    origin: str  # SHIPPED or OWN
    title: str | None
    fault: str | None = None


GROUP = "scenarios and theatres"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    kinds = (*KINDS, *registered(LISTS))
    parser = add_command(
        commands,
        "list",
        "list the scenarios, species or theatres",
        "Prints name, origin (shipped or own) and title. A faulty file is listed with its error.",
        ["subsea list scenarios", "subsea list species --json"],
    )
    parser.add_argument("what", choices=kinds, metavar="WHAT", help=", ".join(kinds))
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Print the list."""
    entries, folder = KINDS[options.what]() if options.what in KINDS else _others(options.what)
    if options.json:
        print(json.dumps([entry._asdict() for entry in entries], indent=1, ensure_ascii=False))
        return 0
    wide = max(len(entry.name) for entry in entries)
    for name, origin, title, fault in entries:
        print_line(
            f"{name:<{wide}}  {origin:<{len(SHIPPED)}}  {f'error: {fault}' if fault else title}"
        )
    if folder is not None:
        print_line(f"own files: {folder}")
    return 0


def _scenarios() -> tuple[list[ListedFile], Path | None]:
    from subsea.base.system import resource_names
    from subsea.scenario.load import SHIPPED as FOLDER
    from subsea.scenario.load import load_scenario, own_scenarios, scenario_names

    shipped = resource_names(FOLDER, ".toml")
    return [
        *_entries(scenario_names(), shipped, lambda name: load_scenario(name)[0].title),
        *_hidden(own_scenarios(), shipped),
    ], own_scenarios()


def _species() -> tuple[list[ListedFile], Path | None]:
    from subsea.fish.species import load_species, own_species, shipped_species, species_names

    shipped = shipped_species()
    return [
        *_entries(species_names(), shipped, lambda name: load_species(name).name),
        *_hidden(own_species(), shipped),
    ], own_species()


def _others(what: str) -> tuple[list[ListedFile], Path | None]:
    """Shipped files of a kind that a wing or another package has."""
    shipped, title_of = load_named(LISTS, what, "list")()
    return [*_entries(shipped, shipped, title_of)], None


def _entries(
    names: Iterable[str], shipped: list[str], title_of: Callable[[str], str]
) -> Iterator[ListedFile]:
    for name in names:
        origin = SHIPPED if name in shipped else OWN
        try:
            yield ListedFile(name, origin, title_of(name))
        except UserError as fault:
            yield ListedFile(name, origin, None, str(fault))


def _hidden(folder: Path, shipped: list[str]) -> Iterator[ListedFile]:
    """Own files that no name leads to, because a shipped file has it."""
    from subsea.base.system import stems

    for name in stems(folder, ".toml"):
        if name in shipped:
            fault = f"{folder / name}.toml: a shipped file has this name; rename yours"
            yield ListedFile(name, OWN, None, fault)


KINDS = {"scenarios": _scenarios, "species": _species}
