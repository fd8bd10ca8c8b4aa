"""A window with OpenGL; its input goes to the pilot."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import glfw

from subsea.base.errors import UserError
from subsea.base.system import INSTALL_WINDOW
from subsea.dive.pilot import Pilot
from subsea.dive.settings import (
    BUTTONS,
    KEYS,
    REPEATING,
    Command,
    ControlName,
    is_action,
    is_command,
)
from subsea.rendering.gl.context import avoid_full_disk, opengl_remedy
from subsea.ui.gui import Gui
from subsea.ui.monitors import Monitor, Screen, monitors, reason
from subsea.ui.touch import Finger
from subsea.view.stereo import OTHER_STEREO

NUDGE = 3.0  # pointer units: smaller movements are noise


class PointerRange(NamedTuple):
    """The range of the pointer, in its units from the upper left corner of a window."""

    corner: tuple[float, float]  # the upper left
    middle: tuple[float, float]  # straight ahead
    end: tuple[float, float]  # the lower right corner

    def share(self, x: float, y: float) -> tuple[float, float]:
        """A place in [-1, 1] from the middle, right and up; each edge is at 1 or -1."""
        across, down = (
            (at - middle) / (end - middle if at > middle else middle - low)
            for at, low, middle, end in zip((x, y), *self, strict=True)
        )
        return across, -down


@contextmanager
def hidden_window(stereo: bool = False) -> Iterator[Callable[[str], Any] | None]:
    """Make a hidden window current; yield its loader of OpenGL functions, None on failure."""
    _context_hints()
    glfw.window_hint(glfw.VISIBLE, False)
    glfw.window_hint(glfw.STEREO, stereo)
    try:
        handle = glfw.create_window(64, 64, "subsea", None, None)
    except glfw.GLFWError:
        handle = None
    if not handle:
        yield None
        return
    glfw.make_context_current(handle)
    try:
        yield glfw.get_proc_address
    finally:
        glfw.destroy_window(handle)


class GlWindow:
    """A window with an OpenGL 3.3 context, which is made current in this thread.

    Commands of keys and buttons are appended to `commands`.
    """

    def __init__(
        self,
        screen: Screen,
        pilot: Pilot,
        commands: list[Command],
        monitor: Monitor | None = None,
        paged: bool = False,
        share: "GlWindow | None" = None,
    ) -> None:
        """Open it where `screen` says, or filling a monitor.

        `paged`: with a buffer for each eye; `share`: a window to share textures with. A UserError
        without OpenGL.
        """
        _context_hints()
        glfw.window_hint(glfw.STEREO, paged)
        size = screen.size if monitor is None else monitor.size
        if screen.fixed:
            glfw.window_hint(glfw.DECORATED, False)
            glfw.window_hint(glfw.AUTO_ICONIFY, False)  # other windows take the keyboard, too
            glfw.window_hint(glfw.SCALE_TO_MONITOR, False)
            glfw.window_hint(glfw.REFRESH_RATE, monitor.rate if monitor else glfw.DONT_CARE)
        if screen.position is not None:
            glfw.window_hint(glfw.POSITION_X, screen.position[0])
            glfw.window_hint(glfw.POSITION_Y, screen.position[1])
        self.handle: Any
        try:
            self.handle = glfw.create_window(
                *size,
                screen.name,
                None if monitor is None else monitor.handle,
                None if share is None else share.handle,
            )
            if not self.handle:
                raise glfw.GLFWError("no window was made")
        except glfw.GLFWError as fault:
            if paged:
                raise UserError(
                    "the graphics driver offers no window with a buffer for each eye "
                    f"(quad-buffered stereo: {reason(fault)}); try --display {OTHER_STEREO}"
                ) from fault
            raise UserError(
                f"no window with OpenGL 3.3 ({reason(fault)}); {opengl_remedy(INSTALL_WINDOW)}"
            ) from fault
        self.pilot = pilot
        self.inside = False  # True if the pointer is in it
        self.focused = bool(glfw.get_window_attrib(self.handle, glfw.FOCUSED))
        self.listener: Gui | None = None
        self.take_key: Callable[[int, int], bool] | None = None  # before all others, if it uses it
        self.pointer_range: PointerRange | None = None  # if larger than the window
        self._commands = commands
        self.finger = Finger(pilot)  # on a touch screen
        # The last noted place of the pointer; None: it has just entered.
        self._rested: tuple[float, float] | None = None
        self.stays = False  # visitors cannot close it
        self.fixed = screen.fixed  # no full screen
        self._home = monitor  # to fill
        self._filling = False  # full screen was asked for by a command
        self._windowed = (0, 0, *size)
        self.make_current()
        glfw.set_key_callback(self.handle, self._on_key)
        glfw.set_char_callback(self.handle, self._on_character)
        glfw.set_mouse_button_callback(self.handle, self._on_button)
        glfw.set_cursor_pos_callback(self.handle, self._on_pointer)
        glfw.set_cursor_enter_callback(self.handle, self._on_enter)
        glfw.set_scroll_callback(self.handle, self._on_scroll)
        glfw.set_window_focus_callback(self.handle, self._on_focus)
        glfw.set_window_close_callback(self.handle, self._on_close)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture in pixels, at least 1; more than `points` on HiDPI."""
        width, height = glfw.get_framebuffer_size(self.handle)
        return max(width, 1), max(height, 1)

    @property
    def points(self) -> tuple[int, int]:
        """Width and height in the units of the pointer, at least 1."""
        width, height = glfw.get_window_size(self.handle)
        return max(width, 1), max(height, 1)

    @property
    def text_scale(self) -> float:
        """Scale of text of the desktop, relative to 96 dpi, in pointer units."""
        return float(glfw.get_window_content_scale(self.handle)[0]) * self.points[0] / self.size[0]

    @property
    def get_proc_address(self) -> Callable[[str], Any]:
        """The loader of OpenGL functions for the current context."""
        loader: Callable[[str], Any] = glfw.get_proc_address
        return loader

    @property
    def open(self) -> bool:
        """True if it was not asked to close."""
        return not glfw.window_should_close(self.handle)

    @property
    def position(self) -> tuple[int, int]:
        """The upper left corner on the desktop, in pointer units."""
        left, top = glfw.get_window_pos(self.handle)
        return left, top

    def make_current(self) -> None:
        """Make its OpenGL context current."""
        glfw.make_context_current(self.handle)

    def take_keyboard(self) -> None:
        """Take the keyboard focus."""
        if not self.focused:
            glfw.focus_window(self.handle)

    def ask_to_close(self) -> None:
        """End `open`."""
        glfw.set_window_should_close(self.handle, True)

    def present(self) -> None:
        """Show what was drawn."""
        glfw.swap_buffers(self.handle)

    def close(self) -> None:
        """Destroy the window."""
        glfw.destroy_window(self.handle)

    def toggle_fullscreen(self) -> None:
        """Fill the screen that the window is on, or restore the former place and size.

        No effect on a window with a fixed place.
        """
        if self.fixed:
            return
        if self._filling:
            self._go_back()
        elif (monitor := self._monitor()) is not None:
            self._windowed = (*glfw.get_window_pos(self.handle), *self.points)
            self._filling = True
            self._fill(monitor)

    @property
    def filled(self) -> tuple[int, int] | None:
        """The position of the monitor that it fills, or None."""
        monitor = glfw.get_window_monitor(self.handle)
        if not monitor:
            return None
        left, top = glfw.get_monitor_pos(monitor)
        return left, top

    def settle(self, free: Sequence[Monitor]) -> None:
        """Adapt to connected and disconnected monitors; no window fills the `free` ones.

        A window fills its monitor again after reconnection. A window whose full-screen monitor
        was removed gets its former place and size, unless it `stays`.
        """
        if self.filled is not None:
            return
        if self._filling and self.stays:
            for monitor in free[:1]:
                self._fill(monitor)
        elif self._filling:
            self._go_back()
        elif self._home is not None:
            named = [monitor for monitor in free if monitor.name == self._home.name]
            there = [monitor for monitor in named if monitor.position == self._home.position]
            for monitor in (there or named)[:1]:
                self._fill(monitor)

    def _fill(self, monitor: Monitor) -> None:
        glfw.set_window_monitor(self.handle, monitor.handle, 0, 0, *monitor.size, monitor.rate)

    def _go_back(self) -> None:
        """Restore place and size from before the full screen."""
        windowed: Any = None
        self._filling = False
        glfw.set_window_monitor(self.handle, windowed, *self._windowed, glfw.DONT_CARE)

    def _monitor(self) -> Monitor | None:
        """The monitor under the middle of the window, else the first; None without any."""
        x, y = glfw.get_window_pos(self.handle)
        x, y = x + self.points[0] // 2, y + self.points[1] // 2
        there = monitors()
        for monitor in there:
            (left, top), (width, height) = monitor.position, monitor.size
            if left <= x < left + width and top <= y < top + height:
                return monitor
        return there[0] if there else None

    def _on_key(self, handle: object, key: int, scancode: int, action: int, mods: int) -> None:
        if action != glfw.REPEAT:  # a repeated key may be blocked
            self.pilot.note_activity()
        taken = self.take_key is not None and action != glfw.RELEASE and self.take_key(key, mods)
        down = action != glfw.RELEASE
        used = taken or (self.listener is not None and self.listener.keyed(key, down, mods))
        name = KEYS.get(key, "")
        if action == glfw.RELEASE:
            self.pilot.release(name)  # even if the listener used it: it may have been held
        elif not used:
            control = self.pilot.bindings.key(key, mods, self.pilot.riding)
            self._ask(control, name, action == glfw.REPEAT)

    def _on_button(self, handle: object, button: int, action: int, mods: int) -> None:
        self.pilot.note_activity()
        used = self.listener is not None and self.listener.pressed(button, action == glfw.PRESS)
        name = f"mouse {BUTTONS[button]}"
        touched = self.pilot.settings.mouse.touch and button == glfw.MOUSE_BUTTON_LEFT
        if action == glfw.RELEASE:
            self.pilot.release(name)
            self.finger.up()
        elif not used and touched:
            self.finger.down(*glfw.get_cursor_pos(self.handle))
        elif not used:
            self._ask(self.pilot.bindings.control(name, self.pilot.riding), name)

    def _ask(self, control: ControlName | None, name: str, again: bool = False) -> None:
        """The input `name` of a control went down; `again`: by key repeat."""
        if control is None or (again and control not in REPEATING):
            return
        if is_action(control):
            self.pilot.hold(control, name)
        elif control == "fullscreen":
            self.toggle_fullscreen()  # this window, not the pilot's
        elif is_command(control):
            self._commands.append(control)

    def _on_character(self, handle: object, character: int) -> None:
        if self.listener:
            self.listener.typed(character)

    def _on_pointer(self, handle: object, x: float, y: float) -> None:
        width, height = self.points
        span = self.pointer_range or PointerRange(
            (0.0, 0.0), (width / 2, height / 2), (width, height)
        )
        self.inside = True
        if self._rested is None:  # the window may have moved instead
            self._rested = x, y
        elif math.dist((x, y), self._rested) > NUDGE:
            self._rested = x, y
            self.pilot.note_activity()
        if self.listener and self.listener.pointed(x, y):
            self.pilot.pointer_left()
        elif self.pilot.settings.mouse.touch:
            self.finger.moved(x, y, min(width, height))
        else:
            self.pilot.point(*span.share(x, y))

    def _on_enter(self, handle: object, entered: int) -> None:
        self.inside = bool(entered)
        if entered:
            self._rested = None

    def _on_scroll(self, handle: object, dx: float, dy: float) -> None:
        self.pilot.note_activity()
        if not (self.listener and self.listener.scrolled(dx, dy)):
            self.pilot.wheel(dy)

    def _on_close(self, handle: object) -> None:
        if self.stays:
            glfw.set_window_should_close(self.handle, False)

    def _on_focus(self, handle: object, focused: int) -> None:
        self.focused = bool(focused)
        if self.listener and not focused:
            self.listener.release_all()


def _context_hints() -> None:
    avoid_full_disk()
    glfw.default_window_hints()
    for hint, value in (
        (glfw.CONTEXT_VERSION_MAJOR, 3),
        (glfw.CONTEXT_VERSION_MINOR, 3),
        (glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE),
        (glfw.OPENGL_FORWARD_COMPAT, True),
        (glfw.SCALE_TO_MONITOR, True),
    ):
        glfw.window_hint(hint, value)
