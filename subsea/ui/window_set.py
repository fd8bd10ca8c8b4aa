"""The windows of a dive: one for each output of the rig.

All drawing uses the context of the front window, which is the pilot's. The others have contexts
that share its textures.
"""

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from typing import Any, NamedTuple

import glfw
import numpy as np
from numpy.typing import NDArray

from subsea.dive.pilot import Pilot
from subsea.dive.settings import Command
from subsea.rendering.gl.context import page_switch, window_context
from subsea.rendering.output.target import Presenter
from subsea.ui.gamepad import Gamepads, add_mappings
from subsea.ui.monitors import Monitor, Screen, monitor_name, monitors
from subsea.ui.window import GlWindow, PointerRange
from subsea.view.front_screen import one_page


class _Shown(NamedTuple):
    """A window, its context and its presenter."""

    window: GlWindow
    context: Any
    presenter: Presenter


class WindowSet:
    """Windows on `screens`, in the order of the outputs that they show."""

    def __init__(
        self,
        screens: Sequence[tuple[Screen, Monitor | None]],
        pilot: Pilot,
        paged: bool = False,
        front: int = 0,
    ) -> None:
        """Open all. `front`: index of the pilot's window; `paged`: with a buffer for each eye.

        A UserError without OpenGL. If anything fails, all that was opened is closed again.
        """
        self.pilot = pilot
        self._commands: list[Command] = []
        shown: dict[int, _Shown] = {}
        with ExitStack() as undo:
            others = [number for number in range(len(screens)) if number != front]
            for number in (front, *others):
                share = shown[front].window if shown else None
                screen, monitor = screens[number]
                window = GlWindow(screen, pilot, self._commands, monitor, paged, share)
                undo.callback(window.close)
                context = window_context(window.get_proc_address)
                undo.callback(context.release)
                self.page = page_switch(context) if paged else one_page
                shown[number] = _Shown(window, context, Presenter(context, self.page, 1 + paged))
                # Release while the window exists and is current: later it would crash.
                undo.callback(shown[number].presenter.release)
                undo.callback(window.make_current)
                # Only the window presented last waits for its display: otherwise a frame would
                # take one refresh for each window.
                glfw.swap_interval(1 if number == (others or [front])[-1] else 0)
                context.clear()
                window.present()
            self._monitors_changed = False
            glfw.set_monitor_callback(self.on_monitor)
            no_callback: Any = None
            undo.callback(glfw.set_monitor_callback, no_callback)
            self._undo = undo.pop_all()
        # From here on errors of the desktop must not end the dive.
        glfw.ERROR_REPORTING = "ignore"
        self._front, self._others = shown[front], [(k, shown[k]) for k in others]
        self._number = front
        self.front, self.context = self._front.window, self._front.context
        self.windows = [shown[number].window for number in range(len(screens))]
        if others:
            glfw.focus_window(self.front.handle)
        self.front.make_current()
        self._notes: list[str] = []
        self._hiding: set[str] = set()  # reasons to hide the pointer
        add_mappings(self._notes.append)
        self.gamepads = Gamepads(pilot, self._commands)

    @property
    def open(self) -> bool:
        """True if no window was asked to close."""
        return all(window.open for window in self.windows)

    def poll(self, wait_s: float = 0.0) -> list[Command]:
        """Process all events since the last call; returns the commands.

        If there are none, wait for one at most `wait_s`.
        """
        if len(self.windows) > 1:
            self._share_pointer()
        inside, focused = self._pointer_and_focus()
        if wait_s > 0.0:
            glfw.wait_events_timeout(wait_s)
        else:
            glfw.poll_events()
        for window in self.windows:
            window.finger.update()
        now_inside, now_focused = self._pointer_and_focus()
        if inside and not now_inside:
            self.pilot.pointer_left()
        if focused and not now_focused:
            self.pilot.release_all()
        if self._monitors_changed:
            self._settle()
        self._notes += self.gamepads.poll(self.front.listener)
        commands = list(self._commands)
        self._commands.clear()
        return commands

    def notes(self) -> list[str]:
        """Lines on monitors and inputs since the last call."""
        lines, self._notes = self._notes, []
        return lines

    def show(self, pictures: Mapping[tuple[int, int], Any]) -> None:
        """Draw pictures, by output and page, in all windows; `present` shows them.

        The front window is current afterwards.
        """
        if self._others:  # their contexts need a complete picture
            self.context.finish()
        for number, shown in [*self._others, (self._number, self._front)]:
            shown.window.make_current()
            pages = [picture for (output, _), picture in pictures.items() if output == number]
            shown.presenter.show(pages, shown.window.size)
            if shown is not self._front:
                shown.context.finish()

    def darken(self, shade: tuple[float, float, float, float]) -> None:
        """Blend a colour with opacity over all windows. The front one is current afterwards."""
        for _, shown in [*self._others, (self._number, self._front)]:
            shown.window.make_current()
            shown.presenter.darken(shade, shown.window.size)

    def hide_pointer(self, reason: str, hidden: bool) -> None:
        """Hide the pointer over all windows as long as any reason holds."""
        before = bool(self._hiding)
        (self._hiding.add if hidden else self._hiding.discard)(reason)
        if bool(self._hiding) != before:
            mode = glfw.CURSOR_HIDDEN if self._hiding else glfw.CURSOR_NORMAL
            for window in self.windows:
                glfw.set_input_mode(window.handle, glfw.CURSOR, mode)

    def wait_for_display(self, on: bool) -> None:
        """Set whether presenting waits for the display; not if a headset sets the pace."""
        glfw.swap_interval(int(on))

    def present(self) -> None:
        """Show all windows, at about the same time."""
        self.front.present()
        for _, shown in self._others:
            shown.window.make_current()
            shown.window.present()
        if self._others:
            self.front.make_current()

    def picture(self) -> NDArray[np.uint8]:
        """The picture about to be shown in the front window: (h, w, 3), top row first."""
        width, height = self.front.size
        data = self.context.screen.read((0, 0, width, height), components=3, alignment=1)
        self.context.error  # clear it: moderngl asks for an attachment that windows lack  # noqa: B018
        return np.frombuffer(data, np.uint8).reshape(height, width, 3)[::-1]

    def close(self) -> None:
        """Destroy the windows."""
        self._undo.close()

    def on_monitor(self, handle: Any, event: int) -> None:
        """A monitor was connected or disconnected: the callback of the window library."""
        what = "is gone" if event == glfw.DISCONNECTED else "is there"
        self._notes.append(f"the monitor {monitor_name(handle)!r} {what}")
        self._monitors_changed = True

    def _settle(self) -> None:
        self._monitors_changed = False
        for window in self.windows:
            filled = [other.filled for other in self.windows]
            window.settle([monitor for monitor in monitors() if monitor.position not in filled])

    def _pointer_and_focus(self) -> tuple[bool, bool]:
        """True if any window has the pointer, and any the keyboard."""
        return (
            any(window.inside for window in self.windows),
            any(window.focused for window in self.windows),
        )

    def _share_pointer(self) -> None:
        """Share the pointer between all windows; straight ahead is the middle of the front one."""
        corners = [window.position for window in self.windows]
        ends = [
            (x + window.points[0], y + window.points[1])
            for (x, y), window in zip(corners, self.windows, strict=True)
        ]
        left, top = min(x for x, _ in corners), min(y for _, y in corners)
        right, bottom = max(x for x, _ in ends), max(y for _, y in ends)
        (x, y), (across, down) = self.front.position, self.front.points
        middle = x + across / 2, y + down / 2
        for window, (own_x, own_y) in zip(self.windows, corners, strict=True):
            window.pointer_range = PointerRange(
                (left - own_x, top - own_y),
                (middle[0] - own_x, middle[1] - own_y),
                (right - own_x, bottom - own_y),
            )
