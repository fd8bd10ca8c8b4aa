"""A dive in an exhibition: nothing that a visitor does can strand it, and one key leaves it."""

from collections.abc import Sequence
from typing import Any

import glfw
import imgui_bundle  # noqa: F401  # before glfw: it brings the one libglfw that both share
import msgspec

from subsea.core.errors import UserError
from subsea.dive.bindings import COMMANDS, Command, bindings_of, input_name
from subsea.dive.settings import Settings
from subsea.ui.window import GlWindow

# What visitors may wish for. The rest has no inputs.
ALLOWED: tuple[Command, ...] = (
    "help", "menu", "ride", "look", "follow", "reins", "alight", "lights", "leave",
)  # fmt: skip
POINTER_S = 3.0  # a pointer that has rested so long is hidden
AGAIN_S = 1.0  # so often the keyboard is asked for while another program has it


def kiosk_settings(settings: Settings) -> Settings:
    """The same settings for a kiosk: inputs mean what visitors may wish for, the operator's key
    leaves. A UserError if that is an input of visitors.
    """
    nothing: dict[str, list[str]] = {wish: [] for wish in COMMANDS if wish not in ALLOWED}
    controls = settings.controls | nothing
    key = input_name(settings.kiosk.leave)
    if others := bindings_of(controls | {"leave": []}).controls.get(key):
        raise UserError(
            f"--kiosk: {key!r} cannot be both 'leave' and {others[0]!r}, "
            "at `kiosk.leave` of the settings"
        )
    return msgspec.structs.replace(settings, controls=controls | {"leave": [key]})


class Kiosk:
    """Keeps windows open and before all others, and hides a pointer that rests."""

    def __init__(self, windows: Sequence[GlWindow]) -> None:
        """From now on."""
        self._windows = windows
        self._rested_s = self._away_s = 0.0
        self._hidden = False
        for window in windows:
            window.stays = True
            glfw.set_window_attrib(window.handle, glfw.AUTO_ICONIFY, False)

    def update(self, moved: bool, dt: float) -> None:
        """`dt` seconds later; whether a hand has `moved` anything meanwhile."""
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
            self._take_back(self._windows[0].handle)

    @staticmethod
    def _take_back(handle: Any) -> None:
        """Ask for the keyboard again."""
        if glfw.get_window_attrib(handle, glfw.ICONIFIED):
            glfw.restore_window(handle)
        glfw.focus_window(handle)
