"""A window: made, resized and closed here; what hands do in it goes to the pilot."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple, Protocol

import glfw
import imgui_bundle  # noqa: F401  # before glfw: it brings the one libglfw that both share

from subsea.core.errors import UserError
from subsea.dive.bindings import (
    BUTTONS,
    KEYS,
    REPEATING,
    Command,
    ControlName,
    is_action,
    is_command,
)
from subsea.dive.pilot import Pilot
from subsea.ui.monitors import Monitor, Screen, monitors, reason
from subsea.ui.system_packages import INSTALL
from subsea.view.stereo import OTHER_STEREO

NUDGE = 3.0  # units of the pointer by which it moves without a hand


class Listener(Protocol):
    """Hears of everything that hands do in a window before the pilot does.

    Where it answers True that was for it, and the pilot does not hear of it.
    """

    def pointed(self, x: float, y: float) -> bool:
        """The pointer is there, in its units from the upper left corner."""

    def pressed(self, button: int, down: bool) -> bool:
        """A mouse button went down or up."""

    def scrolled(self, dx: float, dy: float) -> bool:
        """The wheel turned."""

    def keyed(self, key: int, down: bool, modifiers: int) -> bool:
        """A key went down or up."""

    def moved(self, name: str, amount: float) -> bool:
        """The part of a gamepad that bindings call `name` is at `amount` of its way, in [0, 1]."""

    def typed(self, character: int) -> None:
        """A character was typed."""

    def release_all(self) -> None:
        """The window lost the keyboard."""


class PointerRange(NamedTuple):
    """Where the pointer may go, in its units from the upper left corner of a window."""

    corner: tuple[float, float]  # the upper left
    middle: tuple[float, float]  # straight ahead
    end: tuple[float, float]  # the lower right corner

    def share(self, x: float, y: float) -> tuple[float, float]:
        """The place in [-1, 1] from the middle, right and up; each edge is at 1 or -1."""
        across, down = (
            (at - middle) / (end - middle if at > middle else middle - low)
            for at, low, middle, end in zip((x, y), *self, strict=True)
        )
        return across, -down


@contextmanager
def hidden_window(stereo: bool = False) -> Iterator[Callable[[str], Any] | None]:
    """A window nobody sees, current, and its loader of OpenGL functions; None if there is none."""
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
    """One window with an OpenGL 3.3 context, current in this thread when it is made.

    What the visitor asks for by a key is added to the list `commands`.
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

        `paged` asks for a buffer for each eye; with `share` it has textures in common with another
        window. No OpenGL is a UserError that says what to do.
        """
        _context_hints()
        glfw.window_hint(glfw.STEREO, paged)
        size = screen.size if monitor is None else monitor.size
        if screen.fixed:
            glfw.window_hint(glfw.DECORATED, False)
            glfw.window_hint(glfw.AUTO_ICONIFY, False)  # other windows have the keyboard too
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
                f"no window with OpenGL 3.3 ({reason(fault)}); try: {INSTALL}"
            ) from fault
        self.pilot = pilot
        self.inside = False  # whether the pointer is in it
        self.focused = bool(glfw.get_window_attrib(self.handle, glfw.FOCUSED))
        self.listener: Listener | None = None
        self.reach: PointerRange | None = None  # of the pointer, if that is more than the window
        self._commands = commands
        # Where the pointer was when it last moved; None: it has just entered.
        self._rested: tuple[float, float] | None = None
        self.stays = False  # whether closing it is not for the visitor
        self.fixed = screen.fixed  # whether it stays as it is: no full screen
        self._home = monitor  # that it is to fill
        self._filling = False  # whether a visitor has had it fill the screen
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
        """How much larger than 96 dpi the desktop wants text, in pointer units."""
        return float(glfw.get_window_content_scale(self.handle)[0]) * self.points[0] / self.size[0]

    @property
    def get_proc_address(self) -> Callable[[str], Any]:
        """The loader of OpenGL functions for the current context."""
        loader: Callable[[str], Any] = glfw.get_proc_address
        return loader

    @property
    def open(self) -> bool:
        """Whether nobody has asked to close it."""
        return not glfw.window_should_close(self.handle)

    @property
    def position(self) -> tuple[int, int]:
        """The upper left corner on the desktop, in the units of the pointer."""
        left, top = glfw.get_window_pos(self.handle)
        return left, top

    def make_current(self) -> None:
        """OpenGL works for this window from now on."""
        glfw.make_context_current(self.handle)

    def take_keyboard(self) -> None:
        """Ask for the keyboard, if it has not got it."""
        if not self.focused:
            glfw.focus_window(self.handle)

    def ask_to_close(self) -> None:
        """It is no longer `open`."""
        glfw.set_window_should_close(self.handle, True)

    def present(self) -> None:
        """Show what was drawn."""
        glfw.swap_buffers(self.handle)

    def close(self) -> None:
        """Destroy the window."""
        glfw.destroy_window(self.handle)

    def toggle_fullscreen(self) -> None:
        """Fill the screen that the window is on, or go back to the former place and size.

        A window that has a place of its own stays as it is.
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
        """Where on the desktop the monitor is that it fills; None if it fills none."""
        monitor = glfw.get_window_monitor(self.handle)
        if not monitor:
            return None
        left, top = glfw.get_monitor_pos(monitor)
        return left, top

    def settle(self, free: Sequence[Monitor]) -> None:
        """Monitors have come or gone, and those that no window fills are these.

        A window that is to fill a monitor does so again when that is back; one that a visitor had
        fill a screen that is gone has its former place and size again, unless it `stays`.
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
        """Be as wide and high as before it filled the screen, and there."""
        windowed: Any = None
        self._filling = False
        glfw.set_window_monitor(self.handle, windowed, *self._windowed, glfw.DONT_CARE)

    def _monitor(self) -> Monitor | None:
        """The monitor that holds the middle of the window, else the first; None without any."""
        x, y = glfw.get_window_pos(self.handle)
        x, y = x + self.points[0] // 2, y + self.points[1] // 2
        there = monitors()
        for monitor in there:
            (left, top), (width, height) = monitor.position, monitor.size
            if left <= x < left + width and top <= y < top + height:
                return monitor
        return there[0] if there else None

    def _on_key(self, handle: object, key: int, scancode: int, action: int, mods: int) -> None:
        if action != glfw.REPEAT:  # a key on which something lies is no hand
            self.pilot.note_activity()
        heard = self.listener is not None and self.listener.keyed(key, action != glfw.RELEASE, mods)
        name = KEYS.get(key, "")
        if action == glfw.RELEASE:
            self.pilot.release(name)  # also where the listener heard it: it may have been held
        elif not heard:
            control = self.pilot.bindings.key(key, mods, self.pilot.riding)
            self._ask(control, name, action == glfw.REPEAT)

    def _on_button(self, handle: object, button: int, action: int, mods: int) -> None:
        self.pilot.note_activity()
        heard = self.listener is not None and self.listener.pressed(button, action == glfw.PRESS)
        name = f"mouse {BUTTONS[button]}"
        if action == glfw.RELEASE:
            self.pilot.release(name)
        elif not heard:
            self._ask(self.pilot.bindings.control(name, self.pilot.riding), name)

    def _ask(self, control: ControlName | None, name: str, again: bool = False) -> None:
        """The input `name`, which means that, went down; `again` by itself, as held keys do."""
        if control is None or (again and control not in REPEATING):
            return
        if is_action(control):
            self.pilot.hold(control, name)
        elif control == "fullscreen":
            self.toggle_fullscreen()  # this window, whichever is the pilot's
        elif is_command(control):
            self._commands.append(control)

    def _on_character(self, handle: object, character: int) -> None:
        if self.listener:
            self.listener.typed(character)

    def _on_pointer(self, handle: object, x: float, y: float) -> None:
        width, height = self.points
        reach = self.reach or PointerRange((0.0, 0.0), (width / 2, height / 2), (width, height))
        self.inside = True
        if self._rested is None:  # the window may have come to the pointer
            self._rested = x, y
        elif math.dist((x, y), self._rested) > NUDGE:
            self._rested = x, y
            self.pilot.note_activity()
        if self.listener and self.listener.pointed(x, y):
            self.pilot.pointer_left()
        else:
            self.pilot.point(*reach.share(x, y))

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
    glfw.default_window_hints()
    for hint, value in (
        (glfw.CONTEXT_VERSION_MAJOR, 3),
        (glfw.CONTEXT_VERSION_MINOR, 3),
        (glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE),
        (glfw.OPENGL_FORWARD_COMPAT, True),
        (glfw.SCALE_TO_MONITOR, True),
    ):
        glfw.window_hint(hint, value)
