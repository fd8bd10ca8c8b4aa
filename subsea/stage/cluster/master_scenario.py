"""Open the scenario of a master on its nodes, when a show or a presenter changes it."""

from pathlib import Path
from typing import Protocol

from subsea.base.errors import UserError, unknown
from subsea.dive.tick_source import TickSource
from subsea.scenario.load import load_scenario, scenario_names
from subsea.scenario.schema import Scenario


class NodeDive(Protocol):
    """The parts of a node's dive that a master changes."""

    tick_source: TickSource

    def open_world(
        self, scenario: Scenario, source: Path, seed: int | None = None, keep: bool = False
    ) -> bool:
        """Replace the world by that of a scenario; False, with a note, if it has a fault."""

    def note(self, text: str) -> None:
        """Show a line on the terminal, and for a while in the window."""


class MasterScenario:
    """Opens the scenario that the master of a node waits with."""

    def __init__(self) -> None:
        self._tried: tuple[str, int] | None = None
        self._told = False  # that it did not help

    def follow(self, dive: NodeDive) -> None:
        """Open it once; a fault is one line, and the sea of before goes on."""
        wanted, dive.tick_source.wanted = dive.tick_source.wanted, None
        if wanted is None or (wanted == self._tried and self._told):
            return
        name, seed = wanted
        try:
            if wanted == self._tried:
                raise UserError("its file, or those that it names, differ from the master's")
            if name not in (known := scenario_names()):  # not a path
                raise unknown("scenario", name, known)
            self._tried, self._told = wanted, False
            scenario, source, _ = load_scenario(name)
        except UserError as fault:
            self._tried, self._told = wanted, True
            dive.note(f"the master opens {name!r}: {fault}; this node waits for the next one")
            return
        before = dive.tick_source.presented
        dive.open_world(scenario, source, seed)
        dive.tick_source.presented = before  # until the master's first picture
