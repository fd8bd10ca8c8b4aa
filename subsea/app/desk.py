"""The desk: a bar over the world from which panels are opened (Tu §9.3), and what they may do.

While it is open the pointer is the desk's: on a panel the panel's, elsewhere it picks and drags
what is in the sea. Keys steer on.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from imgui_bundle import imgui

from subsea.app.bindings import Wish
from subsea.app.gui import Gui
from subsea.app.overlay import Overlay
from subsea.app.panels import PANELS
from subsea.app.sight import Sight
from subsea.scenario import Scenario
from subsea.world import World

STEP = 1.6  # by which each further panel opens lower and more to the right, in heights of letters


class Host(Protocol):
    """The dive that a desk is in."""

    world: World
    scenario: Scenario  # which the world began with
    source: Path  # and its file
    gui: Gui
    overlay: Overlay
    diagrams: set[str]  # names of `diagrams.DIAGRAMS` that are drawn over the sea
    wireframe: bool  # whether the sea is drawn as the edges of its triangles

    @property
    def sight(self) -> Sight | None:
        """What the screen ahead shows now; None where that is no flat picture."""

    def enter(self, scenario: Scenario, source: Path, seed: int | None = None) -> bool:
        """Leave this world for the one that a scenario begins with; whether there is such a one."""

    def grant(self, wish: Wish) -> None:
        """Do what a key of that name would."""

    def note(self, text: str) -> None:
        """Tell a line, on the terminal and for a while in the window."""


class Desk:
    """What panels see and may do. A panel is drawn within a frame, and acts at once on the world
    that it finds here; what would replace that waits until the frame has ended.
    """

    def __init__(self, host: Host) -> None:
        """Closed, in this dive."""
        self.host = host
        self.shown: set[str] = set()  # the panels that are open
        self.chosen: int | None = None  # the fish that panels are about
        self._later: list[Callable[[], object]] = []

    @property
    def open(self) -> bool:
        """Whether the pointer is the desk's."""
        return self.host.gui.open

    def toggle(self) -> None:
        """Open or close it; its panels are where they were when it is opened again."""
        gui = self.host.gui
        gui.open = not gui.open
        if not gui.open:
            gui.let_go()

    def enter(self) -> None:
        """There is another world: forget what was chosen in the last."""
        self.chosen = None

    def draw(self) -> None:
        """The bar and the panels that are open, in the present frame of the gui."""
        if not self.open:
            return
        if imgui.begin_main_menu_bar():
            for name in PANELS:
                chosen, _ = imgui.menu_item(name, "", name in self.shown)
                if chosen:
                    self.shown ^= {name}
            imgui.separator()
            if imgui.menu_item("To the helm", "Tab", False)[0]:
                self.toggle()
            imgui.end_main_menu_bar()
        line = imgui.get_font_size()
        for number, (name, panel) in enumerate(PANELS.items()):
            if name not in self.shown:
                continue
            corner = (1.0 + STEP * number) * line, (2.5 + STEP * number) * line
            imgui.set_next_window_pos(corner, imgui.Cond_.first_use_ever.value)
            drawn, stays = imgui.begin(name, True, imgui.WindowFlags_.always_auto_resize.value)
            if drawn:
                panel(self)
            imgui.end()
            if not stays:
                self.shown.discard(name)

    def later(self, act: Callable[[], object]) -> None:
        """Do it when the present frame has ended."""
        self._later.append(act)

    def afterwards(self) -> None:
        """Do what waited for the end of the frame."""
        waiting, self._later = self._later, []
        for act in waiting:
            act()
