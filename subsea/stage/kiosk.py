"""Kiosk mode for exhibitions: only a key of the operator ends the dive."""

from collections.abc import Sequence

import glfw
import imgui_bundle  # noqa: F401  # before glfw: it brings the one libglfw that both share

from subsea.ui.window import GlWindow

POINTER_S = 3.0  # until a resting pointer is hidden
AGAIN_S = 1.0  # between attempts to take the keyboard back


class Kiosk:
    """Keeps windows open and in front, and hides a resting pointer."""

    def __init__(self, windows: Sequence[GlWindow]) -> None:
        self._windows = windows
        self._rested_s = self._away_s = 0.0
        self._hidden = False
        for window in windows:
            window.stays = True
            glfw.set_window_attrib(window.handle, glfw.AUTO_ICONIFY, False)

    def update(self, moved: bool, dt: float) -> None:
        """Update `dt` seconds later; `moved`: there was input."""
        self._rested_s = 0.0 if moved else self._rested_s + dt
        hidden = self._rested_s > POINTER_S
        if hidden != self._hidden:
            self._hidden = hidden
            mode = glfw.CURSOR_HIDDEN if hidden else glfw.CURSOR_NORMAL
            for window in self._windows:
                glfw.set_input_mode(window.handle, glfw.CURSOR, mode)
        self._away_s += dt
        if any(window.focused for window in self._windows):
            self._away_s = 0.0
        elif self._away_s > AGAIN_S:
            self._away_s = 0.0
            handle = self._windows[0].handle
            if glfw.get_window_attrib(handle, glfw.ICONIFIED):
                glfw.restore_window(handle)
            glfw.focus_window(handle)
