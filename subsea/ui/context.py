"""The interface of the dive to panels, the menu and key commands."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol, TypeVar

from subsea.dive.captions import Caption
from subsea.dive.live_sound import LiveSound
from subsea.dive.part import DivePart
from subsea.dive.pilot import Pilot
from subsea.dive.settings import Command
from subsea.dive.tick_source import TickSource
from subsea.dive.timeline import Timeline
from subsea.media.screenshots import ScreenCapture
from subsea.scenario.schema import Scenario
from subsea.ui.gui import Gui
from subsea.ui.overlay import Overlay
from subsea.ui.picture import ScenePicture
from subsea.ui.preferences import Preferences
from subsea.ui.window import GlWindow
from subsea.world.world import World

T = TypeVar("T")


class DiveContext(Protocol):
    """The dive as its panels, menu and commands see it."""

    world: World
    scenario: Scenario  # of the world at its start
    source: Path  # the scenario's file
    known: bytes  # content of that file when it was read or written
    gui: Gui
    overlay: Overlay
    picture: ScenePicture
    preferences: Preferences
    shots: ScreenCapture
    sound: LiveSound
    window: GlWindow  # the pilot's
    pilot: Pilot
    tick_source: TickSource
    parts: list[DivePart]  # which wings add
    see_brightness: bool  # a ridden fish reacts to the light in its eyes

    @property
    def inspector(self) -> "PanelContext":
        """The state that panels share."""

    @property
    def timeline(self) -> Timeline | None:
        """The time of the world; None if another computer controls it."""

    @property
    def shared(self) -> bool:
        """True if other computers show the same dive, so that nothing here may change it."""

    @property
    def steers_fish(self) -> bool:
        """True if the pilot steers the ridden fish."""

    @property
    def caption(self) -> Caption:
        """The caption of the picture."""

    def ride_fish(self, fish: int | None, behind: bool | None = None) -> None:
        """Ride a fish from now on; None: return to the submarine."""

    def open_world(
        self, scenario: Scenario, source: Path, seed: int | None = None, keep: bool = False
    ) -> bool:
        """Replace the world by that of a scenario; False, with a note, if it has a fault.

        With `keep` the submarine and everything alive keep their state.
        """

    def run_command(self, command: Command) -> None:
        """Run the command as a key bound to it does."""

    def note(self, text: str) -> None:
        """Show a line on the terminal, and for a while in the window."""

    def take_picture(self) -> None:
        """Save a picture of the next frame."""


class PanelContext:
    """The interface of a panel to the world, used within a frame of the gui.

    Changes act at once; a replacement of the world waits until after the frame.
    """

    def __init__(self, dive: DiveContext) -> None:
        self.dive = dive
        self.chosen: int | None = None  # the fish that panels are about
        self.dragging = False  # the pointer drags something other than a fish
        self._changed = False
        self._after_frame: list[Callable[[], object]] = []
        self._states: dict[type, Any] = {}

    def state(self, kind: type[T]) -> T:
        """The object of this class that a panel keeps from frame to frame; made on first use."""
        return self._states.setdefault(kind, kind())

    def changed(self) -> None:
        """Report a change to the world between two ticks, so that time can go back to it."""
        self._changed = True

    def later(self, act: Callable[[], object]) -> None:
        """Call it after the current frame."""
        self._after_frame.append(act)
