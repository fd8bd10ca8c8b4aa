"""A touch screen at the helm: drag to look, hold to go, tap a fish for its card.

The desktop sends touches as events of the left mouse button (X11 does so for the first finger).
"""

import math
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from imgui_bundle import imgui

from subsea.dive.pilot import Pilot
from subsea.ui.gui import GLASS, INK, colour, ground

if TYPE_CHECKING:
    from subsea.ui.dive import Dive

HOLD_S = 0.35  # after which a resting finger goes ahead
STILL = 0.02  # share of the window's smaller side within which a finger rests
FULL = 0.25  # drag that turns fastest, in the same
NAME = "touch"  # of its input at the pilot
BUTTON = 2.6  # side of the menu's button, in heights of letters


class Finger:
    """Steers for a finger on a window."""

    def __init__(self, pilot: Pilot, now: Callable[[], float] = time.monotonic) -> None:
        """Start without a finger."""
        self._pilot, self._now = pilot, now
        self._begun: tuple[float, float] | None = None  # where it was put down ...
        self._since_s = 0.0  # ... and when
        self._dragged = self._goes = False
        self._tapped = False

    def down(self, x: float, y: float) -> None:
        """A finger was put down at a place in pointer units."""
        self._begun, self._since_s = (x, y), self._now()
        self._dragged = self._goes = False
        self._pilot.point(0.0, 0.0)

    def moved(self, x: float, y: float, side: float) -> None:
        """The finger moved, on a window whose smaller `side` is that long, in pointer units."""
        if self._begun is None:
            return
        across, down = x - self._begun[0], y - self._begun[1]
        self._dragged |= math.hypot(across, down) > STILL * side
        if self._dragged:
            self._pilot.point(across / (FULL * side), -down / (FULL * side))

    def update(self) -> None:
        """Go ahead when the finger has rested for long enough; call it often."""
        if self._begun is None or self._dragged or self._goes:
            return
        if self._now() - self._since_s >= HOLD_S:
            self._goes = True
            self._pilot.hold("ahead", NAME)

    def up(self) -> None:
        """The finger was lifted."""
        if self._begun is None:
            return
        self._tapped = not self._dragged and not self._goes
        self._begun = None
        self._pilot.release(NAME)
        self._pilot.pointer_left()

    def take_tap(self) -> bool:
        """True if there was a tap since the last call, where the pointer is."""
        tapped, self._tapped = self._tapped, False
        return tapped


class TouchScreen:
    """Acts on taps at the helm, and draws a button for the menu."""

    def __init__(self, dive: "Dive") -> None:
        self._dive = dive

    def draw(self) -> None:
        """Act on a tap, and draw the button, in the current frame."""
        dive = self._dive
        tapped = dive.window.finger.take_tap()
        if not dive.pilot.settings.mouse.touch or dive.menu.open or dive.inspector.open:
            return
        size, line = imgui.get_io().display_size, imgui.get_font_size()
        left, top, side = size.x - (BUTTON + 0.6) * line, 0.6 * line, BUTTON * line
        canvas = imgui.get_background_draw_list()
        corners = (left, top), (left + side, top + side)
        canvas.add_rect_filled(*corners, colour(GLASS, ground(0.7)), 0.4 * line)
        for row in (0.3, 0.5, 0.7):
            ends = (left + 0.25 * side, top + row * side), (left + 0.75 * side, top + row * side)
            canvas.add_line(*ends, colour(INK), max(0.14 * line, 2.0))
        if tapped:
            (x, y), card = dive.gui.pointer, dive.card
            x, y = x * size.x, y * size.y
            if _within(corners, x, y):
                dive.inspector.later(lambda: dive.run_command("menu"))
            elif dive.picture.ride is not None:
                dive.inspector.later(lambda: dive.run_command("alight"))
            elif card.fish is not None and _within(card.area, x, y):
                dive.inspector.later(lambda: dive.run_command("follow"))
            else:
                card.tap()


def _within(corners: tuple[tuple[float, float], tuple[float, float]], x: float, y: float) -> bool:
    (left, top), (right, foot) = corners
    return left <= x <= right and top <= y <= foot
