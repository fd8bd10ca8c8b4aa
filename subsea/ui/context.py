"""What the desk and the menu know of the dive that they are in, and may ask of it."""

from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from subsea.dive.bindings import Wish
from subsea.dive.timeline import Timeline
from subsea.scenario.schema import Scenario
from subsea.ui.gui import Gui
from subsea.ui.overlay import Overlay
from subsea.ui.picture import Picture
from subsea.world.world import World

if TYPE_CHECKING:
    from subsea.ui.inspector import Desk


class Host(Protocol):
    """A dive."""

    world: World
    scenario: Scenario  # which the world began with
    source: Path  # and its file ...
    known: bytes  # ... and what that held when it was read or written
    gui: Gui
    overlay: Overlay
    desk: "Desk"
    picture: Picture  # what it shows
    see_brightness: bool  # whether the fish that is ridden goes by the light in its eyes

    @property
    def timeline(self) -> Timeline | None:
        """The time of the world; None where that is another computer's."""

    @property
    def shared(self) -> bool:
        """Whether other computers show the same dive: then nothing here may change it."""

    @property
    def steers_fish(self) -> bool:
        """Whether hands hold the reins of the fish that is ridden."""

    @property
    def can_fill(self) -> bool:
        """Whether there is a window that may fill the screen."""

    def mount(self, fish: int | None, behind: bool | None = None) -> None:
        """Ride a fish of this number from now on, or come back to the submarine."""

    def enter(
        self, scenario: Scenario, source: Path, seed: int | None = None, stay: bool = False
    ) -> bool:
        """Leave this world for the one that a scenario begins with; whether there is such a one.

        With `stay` it goes on from here, where things stand otherwise.
        """

    def grant(self, wish: Wish) -> None:
        """Do what a key of that name would."""

    def note(self, text: str) -> None:
        """Tell a line, on the terminal and for a while in the window."""

    def fill_screen(self) -> None:
        """Have the pilot's window fill the screen, or go back to its former size."""

    def leave(self) -> None:
        """End the dive."""
