"""A window that shows pictures which a program makes, such as those of a learning environment."""

import time
from contextlib import AbstractContextManager, ExitStack
from typing import Any

from subsea.base.arrays import Bytes
from subsea.dive.pilot import Pilot
from subsea.dive.settings import DEFAULTS
from subsea.rendering.gl.context import window_context
from subsea.rendering.gl.textures import upload
from subsea.rendering.output.target import Presenter
from subsea.ui import glfw
from subsea.ui.monitors import Screen, on_display
from subsea.ui.window import GlWindow

NO_WINDOW: Any = None  # the types of glfw know no such argument


class PictureWindow:
    """A window whose pictures follow each other at a rate; a TransientError without a display."""

    _shown = 0  # windows of this process; the last one closes the display
    _display: AbstractContextManager[Any] | None = None

    def __init__(self, title: str, size: tuple[int, int], fps: float, without: str) -> None:
        """Open it for pictures of `size`; `without` is what works without a display."""
        self._size, self._interval_s, self._next_s = size, 1.0 / fps, 0.0
        self._open = False
        if PictureWindow._display is None:
            display = on_display(without)
            display.__enter__()
            PictureWindow._display = display
        PictureWindow._shown += 1
        with ExitStack() as undo:
            undo.callback(self._leave_display)
            self._window = GlWindow(Screen(title, size), Pilot(DEFAULTS), [])
            undo.callback(self._window.close)
            self._context = window_context(self._window.get_proc_address)
            self._presenter = Presenter(self._context)
            undo.pop_all()
        self._open = True
        glfw.make_context_current(NO_WINDOW)  # pictures are drawn in a context of their own

    @property
    def is_open(self) -> bool:
        """False once somebody has closed it."""
        return self._open

    def show(self, picture: Bytes) -> bool:
        """Show a picture (h, w, 3), top row first, when it is due; False once it was closed."""
        if not self._open:
            return False
        time.sleep(min(max(self._next_s - time.monotonic(), 0.0), self._interval_s))
        self._next_s = max(self._next_s, time.monotonic() - self._interval_s) + self._interval_s
        glfw.poll_events()
        if not self._window.open:
            self.close()
            return False
        self._window.make_current()
        texture = upload(self._context, picture[::-1])
        self._presenter.show([texture], self._window.size)
        self._window.present()
        texture.release()
        glfw.make_context_current(NO_WINDOW)
        return True

    def close(self) -> None:
        """Close the window; a second time does no harm."""
        if not self._open:
            return
        self._open = False
        self._window.make_current()
        self._presenter.release()
        self._context.release()
        self._window.close()
        self._leave_display()

    def _leave_display(self) -> None:
        """Stop the window library after the last window."""
        PictureWindow._shown -= 1
        if not PictureWindow._shown and PictureWindow._display is not None:
            display, PictureWindow._display = PictureWindow._display, None
            display.__exit__(None, None, None)
