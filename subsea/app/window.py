"""The window: made, resized and closed here; what hands do in it goes to the pilot."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any, NamedTuple

import glfw
import imgui_bundle  # noqa: F401  # before glfw: it brings the one libglfw that both share

from subsea.app.install import INSTALL
from subsea.app.pilot import Action, Button, Pilot
from subsea.errors import UserError
from subsea.view.stereo import OTHER_STEREO

KEYS: dict[int, Action] = {
    glfw.KEY_W: "ahead",
    glfw.KEY_S: "astern",
    glfw.KEY_A: "left",
    glfw.KEY_D: "right",
    glfw.KEY_LEFT: "left",
    glfw.KEY_RIGHT: "right",
    glfw.KEY_UP: "up",
    glfw.KEY_DOWN: "down",
    glfw.KEY_E: "rise",
    glfw.KEY_Q: "dive",
    glfw.KEY_PAGE_UP: "rise",
    glfw.KEY_PAGE_DOWN: "dive",
    glfw.KEY_SPACE: "full stop",
}
HELP_KEYS = (glfw.KEY_H, glfw.KEY_F1)
QUALITY_KEYS = (glfw.KEY_P,)
FULLSCREEN_KEYS = (glfw.KEY_F, glfw.KEY_F11)
BUTTONS: dict[int, Button] = {
    glfw.MOUSE_BUTTON_LEFT: "left",
    glfw.MOUSE_BUTTON_RIGHT: "right",
    glfw.MOUSE_BUTTON_MIDDLE: "middle",
}
PLATFORMS = {
    glfw.PLATFORM_X11: "X11",
    glfw.PLATFORM_WAYLAND: "Wayland",
    glfw.PLATFORM_COCOA: "macOS",
    glfw.PLATFORM_WIN32: "Windows",
}


class Display(NamedTuple):
    """Where windows open."""

    platform: str  # "X11", "Wayland", …
    monitors: list[str]  # name, pixels and rate of each


@contextmanager
def on_display() -> Iterator[Display]:
    """Start the window library, and stop it in the end. No display is a UserError."""
    glfw.ERROR_REPORTING = "exception"
    try:
        if not glfw.init():
            raise glfw.GLFWError("the window library cannot start")
    except glfw.GLFWError as fault:
        raise UserError(
            f"no display to open a window on ({_reason(fault)}); "
            "without one, `subsea film dive.mp4` makes a film"
        ) from fault
    try:
        monitors = []
        for monitor in glfw.get_monitors():
            mode = glfw.get_video_mode(monitor)
            width, height = mode.size
            name: Any = glfw.get_monitor_name(monitor)
            name = name.decode("utf-8", "replace") if isinstance(name, bytes) else name
            rate = f" at {mode.refresh_rate} Hz" if mode.refresh_rate else ""
            monitors.append(f"{name} {width}x{height}{rate}")
        yield Display(PLATFORMS.get(glfw.get_platform(), "unknown"), monitors)
    finally:
        glfw.terminate()


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


class Window:
    """One window with an OpenGL 3.3 context, current in this thread.

    `help_wanted` and `quality_wanted` count how often the visitor asked for the help, and for
    another quality of the picture.
    """

    def __init__(
        self,
        title: str,
        size: tuple[int, int],
        fullscreen: bool,
        pilot: Pilot,
        paged: bool = False,
    ) -> None:
        """Open it. No display or no OpenGL is a UserError that says what to do.

        `paged` asks for a buffer for each eye.
        """
        with ExitStack() as undo:
            undo.enter_context(on_display())
            _context_hints()
            glfw.window_hint(glfw.STEREO, paged)
            try:
                self.handle = glfw.create_window(*size, title, None, None)
                if not self.handle:
                    raise glfw.GLFWError("no window was made")
            except glfw.GLFWError as fault:
                if paged:
                    raise UserError(
                        "the graphics driver offers no window with a buffer for each eye "
                        f"(quad-buffered stereo: {_reason(fault)}); try --display {OTHER_STEREO}"
                    ) from fault
                raise UserError(
                    f"no window with OpenGL 3.3 ({_reason(fault)}); try: {INSTALL}"
                ) from fault
            undo.callback(glfw.destroy_window, self.handle)
            self._undo = undo.pop_all()
        self.pilot = pilot
        self.help_wanted = 0
        self.quality_wanted = 0
        self._windowed = (0, 0, *size)
        # From here on a hiccup of the desktop must not end the dive.
        glfw.ERROR_REPORTING = "ignore"
        glfw.make_context_current(self.handle)
        glfw.swap_interval(1)
        glfw.set_key_callback(self.handle, self._on_key)
        glfw.set_mouse_button_callback(self.handle, self._on_button)
        glfw.set_cursor_pos_callback(self.handle, self._on_pointer)
        glfw.set_cursor_enter_callback(self.handle, self._on_enter)
        glfw.set_scroll_callback(self.handle, self._on_scroll)
        glfw.set_window_focus_callback(self.handle, self._on_focus)
        if fullscreen:
            self.toggle_fullscreen()

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

    def poll(self) -> None:
        """Hand all events since the last call to the pilot."""
        glfw.poll_events()

    def present(self) -> None:
        """Show what was drawn."""
        glfw.swap_buffers(self.handle)

    def close(self) -> None:
        """Destroy the window and leave the display."""
        self._undo.close()

    def toggle_fullscreen(self) -> None:
        """Fill the screen that the window is on, or go back to the former place and size."""
        windowed: Any = None
        if glfw.get_window_monitor(self.handle):
            glfw.set_window_monitor(self.handle, windowed, *self._windowed, glfw.DONT_CARE)
            return
        self._windowed = (*glfw.get_window_pos(self.handle), *self.points)
        monitor = self._monitor()
        mode = glfw.get_video_mode(monitor)
        glfw.set_window_monitor(
            self.handle, monitor, 0, 0, mode.size.width, mode.size.height, mode.refresh_rate
        )

    def _monitor(self) -> Any:
        """The monitor that holds the middle of the window."""
        x, y = glfw.get_window_pos(self.handle)
        x, y = x + self.points[0] // 2, y + self.points[1] // 2
        for monitor in glfw.get_monitors():
            left, top = glfw.get_monitor_pos(monitor)
            mode = glfw.get_video_mode(monitor)
            if left <= x < left + mode.size.width and top <= y < top + mode.size.height:
                return monitor
        return glfw.get_primary_monitor()

    def _on_key(self, handle: object, key: int, scancode: int, action: int, mods: int) -> None:
        down = action == glfw.PRESS
        if key in KEYS and action != glfw.REPEAT:
            self.pilot.key(KEYS[key], down)
        elif down and key == glfw.KEY_ESCAPE:
            glfw.set_window_should_close(self.handle, True)
        elif down and key in HELP_KEYS:
            self.help_wanted += 1
        elif down and key in QUALITY_KEYS:
            self.quality_wanted += 1
        elif down and key in FULLSCREEN_KEYS:
            self.toggle_fullscreen()

    def _on_button(self, handle: object, button: int, action: int, mods: int) -> None:
        if button in BUTTONS:
            self.pilot.button(BUTTONS[button], action == glfw.PRESS)

    def _on_pointer(self, handle: object, x: float, y: float) -> None:
        width, height = self.points
        self.pilot.point(2.0 * x / width - 1.0, 1.0 - 2.0 * y / height)

    def _on_enter(self, handle: object, entered: int) -> None:
        if not entered:
            self.pilot.leave()

    def _on_scroll(self, handle: object, dx: float, dy: float) -> None:
        self.pilot.wheel(dy)

    def _on_focus(self, handle: object, focused: int) -> None:
        if not focused:
            self.pilot.let_go()


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


def _reason(fault: Exception) -> str:
    """The window library's own words, without its error number, quotes and final stop."""
    text = str(fault)
    words = text.partition(") ")[2] or text
    return words.removeprefix("b").strip("'\"").rstrip(".")
