"""Open the windows of a dive before its modules and its world are loaded.

Nothing here imports the world, so that a window appears within half a second.
"""

import sys
from collections.abc import Callable
from contextlib import ExitStack
from typing import NamedTuple

from subsea.base.progress import say
from subsea.dive.pilot import Pilot
from subsea.dive.settings import DEFAULTS, Settings
from subsea.ui.first_picture import FirstPicture
from subsea.ui.gui import Gui, draw_loading_bar, fill_with_text, set_look, text_at_foot
from subsea.ui.monitors import FILM, Installation, Screen, on_display, placed, prefer_x11
from subsea.ui.window_set import WindowSet
from subsea.view.display_rigs import HEADSET
from subsea.view.rig import CameraRig, front, select_outputs
from subsea.view.stereo import PAGED


class Opening(NamedTuple):
    """Open windows, with the gui of the first one and the pilot."""

    window_set: WindowSet
    gui: Gui
    pilot: Pilot
    rig: CameraRig | None  # fixed; None: it follows the size of the one window
    close: Callable[[], None]  # may be called twice
    first: FirstPicture | None = None  # of the dive

    def show(self, text: str, share: float = 0.0) -> None:
        """Show a line of text and a bar in the pilot's window, over a picture if one is known.

        The bar is filled by a `share` in [0, 1].
        """
        window, known = self.window_set.front, self.first is not None and self.first.known
        if self.first is not None and known:
            texture = self.first.texture(self.window_set.context)
            self.window_set.show({(0, 0): texture})
        self.gui.begin(window.points, window.size, window.text_scale)
        if known:
            text_at_foot(text)
        else:
            fill_with_text(text)
        draw_loading_bar(share)
        self.gui.end()
        self.window_set.present()


def open_windows(
    display: str,
    size: tuple[int, int],
    fullscreen: bool = False,
    settings: Settings = DEFAULTS,
    installation: Installation | None = None,
    title: str = "subsea",
    without: str = FILM,
    first: FirstPicture | None = None,
) -> Opening:
    """Open one window for a `display` mode, or those of an `installation`.

    A single window has the `title`, and shows the `first` picture of the dive if that is known. The
    error without a display suggests the alternative `without` one. If anything fails, all that was
    opened is closed again.
    """
    pilot, rig = Pilot(settings), None
    set_look(settings.display)
    with ExitStack() as undo:
        if display == HEADSET and sys.platform == "linux":
            prefer_x11()
        there = undo.enter_context(on_display(without)).monitors
        if installation is None:
            window_set = WindowSet([(Screen(title, size), None)], pilot, display == PAGED)
        else:
            rig, screens = installation.rig, installation.screens
            shown = placed(screens, there, installation.source, say)
            rig = select_outputs(rig, [number for number, _ in shown])
            window_set = WindowSet(
                [(screens[number], monitor) for number, monitor in shown],
                pilot,
                rig.pages > 1,
                front(rig).output,
            )
        undo.callback(window_set.close)
        if fullscreen and installation is None:
            window_set.front.toggle_fullscreen()
        gui = Gui()
        undo.callback(gui.close)
        window_set.front.listener = gui
        if first is not None:
            undo.callback(first.release)
        opening = Opening(window_set, gui, pilot, rig, undo.pop_all().close, first)
    opening.show("loading")
    return opening
