"""A window for one tool, in which something is edited and saved.

A `Tool` draws its panels and says what is unsaved, undone and redone. `ToolWindow` does the rest:
the window and its OpenGL context, a menu bar with Save, Undo and Redo (Ctrl+S, Ctrl+Z, Ctrl+Y), a
status line, questions, work in the background, and one question about unsaved work when the window
is closed or Ctrl-C is pressed in the terminal.

A frame is drawn on input, when the tool said that something moves, or after `wake`: an idle tool
takes no processor time.
"""

import math
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, closing, contextmanager
from typing import Any, NamedTuple, Protocol, TypeVar

from imgui_bundle import imgui

from subsea.base.errors import UserError
from subsea.base.interrupts import deferred_interrupts
from subsea.base.progress import say
from subsea.studio.questions import Answers, Question
from subsea.ui import glfw
from subsea.ui.gui import MARK, QUIET, TEXT_PT, colour
from subsea.ui.open_windows import open_windows
from subsea.ui.picture import recovering_errors
from subsea.ui.undo import History
from subsea.ui.window import GlWindow

T = TypeVar("T")
Rect = tuple[float, float, float, float]  # left, top, width, height

SIZE = 1280, 800  # of the window when it opens
AWAKE_S = 0.6  # frames go on this long after input: tooltips appear late
POLL_S = 0.25  # between two checks for Ctrl-C while nothing moves
MESSAGE_S = 15.0  # a message stays in the status line this long
LEAST_LINES = 62.0, 40.0  # width and height that a window needs, in text heights, ...
LEAST_TEXT = 0.7  # ... else text shrinks down to this share of its size
STATUS_HEIGHT = 1.7  # text heights
GAP = 0.4  # between panels, text heights
FIXED = (
    imgui.WindowFlags_.no_move.value
    | imgui.WindowFlags_.no_resize.value
    | imgui.WindowFlags_.no_collapse.value
    | imgui.WindowFlags_.no_bring_to_front_on_focus.value
    | imgui.WindowFlags_.no_nav.value
)
UNTITLED = FIXED | imgui.WindowFlags_.no_title_bar.value | imgui.WindowFlags_.no_scrollbar.value
BACKGROUND = 0.012, 0.040, 0.058
PANEL, TITLE = (0.030, 0.095, 0.130), (0.045, 0.150, 0.200)
ERROR = (1.0, 0.55, 0.42)
DISCARD = "Throw it away"
THREADS = 2  # for work in the background


class Task(NamedTuple):
    """Work in progress in another thread."""

    future: Future[Any]
    done: Callable[[Any], object]  # takes the result
    failed: Callable[[], object]
    label: str  # what is being done, in a few words; "" to show nothing

    def finish(self) -> None:
        """Hand the result over; raise what the work raised."""
        if self.future.exception() is not None:
            self.failed()
        self.done(self.future.result())


class Tool(Protocol):
    """The interface of a tool to its window."""

    @property
    def history(self) -> History[Any]:
        """Undo history, which knows what is saved."""

    def draw(self, elapsed_s: float) -> float:
        """Draw everything, `elapsed_s` after the last frame.

        Return the seconds until it changes by itself: 0 while it moves, inf if never.
        """

    def draw_menu(self) -> None:
        """Add entries to the menu bar by ``imgui.menu_item``."""

    def save(self) -> bool:
        """Save; return whether that succeeded. The window shows a UserError."""

    def undo(self) -> None:
        """Go back by one edit."""

    def redo(self) -> None:
        """Go forward by one edit."""

    def close(self) -> None:
        """Release all resources; the OpenGL context is still current."""


class ToolWindow:
    """A window with a tool."""

    def __init__(
        self,
        title: str,
        make: Callable[["ToolWindow"], Tool],
        size: tuple[int, int] = SIZE,
        without: str = "there is nothing to see",
    ) -> None:
        """Open the window, then make the tool, which may take long.

        UserError without a display, with a hint what works `without` one. On any failure
        everything that was opened is closed.
        """
        self.title = title
        self.hint = ""  # shown in the status line while there is no message
        self.area: Rect = (0.0, 0.0, 1.0, 1.0)  # the place for panels
        self.open = True
        self.message = ""  # the last one
        self.idle_s = 0.0  # since the last input
        self._message_age_s, self._is_error = math.inf, False
        self._question: Question | None = None
        self._due_s = 0.0  # until the next frame, if there is no input
        self._awake_s = AWAKE_S
        self._shown_title = ""
        self._woken = False
        self._heard = 0  # input events until the last frame
        self._deferred: list[Callable[[], object]] = []
        self._tasks: list[Task] = []
        with ExitStack() as undo:
            opening = open_windows("mono", size, title=title, without=without)
            undo.callback(opening.close)
            self.window_set, self.gui = opening.window_set, opening.gui
            self.window: GlWindow = self.window_set.front
            self.context = self.window_set.context
            self.gui.open = True  # all input is for panels
            style, names = imgui.get_style(), imgui.Col_
            for name, rgb in (
                (names.window_bg, PANEL),
                (names.popup_bg, TITLE),
                (names.title_bg, TITLE),
                (names.title_bg_active, TITLE),
                (names.menu_bar_bg, PANEL),
            ):
                style.set_color_(name.value, (*rgb, 1.0))
            self._pool = ThreadPoolExecutor(THREADS, "background")
            # Cancel what has not begun; do not wait for the rest.
            undo.callback(self._pool.shutdown, wait=False, cancel_futures=True)
            glfw.set_window_refresh_callback(self.window.handle, lambda handle: self.wake())
            self.tool = make(self)
            undo.callback(self.tool.close)
            self._undo = undo.pop_all()

    @property
    def busy(self) -> bool:
        """True if there is work in the background."""
        return bool(self._tasks)

    @property
    def doing(self) -> str:
        """The label of the first work in the background that has one."""
        return next((task.label for task in self._tasks if task.label), "")

    @property
    def asking(self) -> bool:
        """True if a question is open."""
        return self._question is not None

    @property
    def text_height(self) -> float:
        """The height of text, in pointer units; within a frame."""
        return float(imgui.get_font_size())

    def wake(self) -> None:
        """Draw a frame soon; may be called from another thread."""
        self._woken = True
        glfw.post_empty_event()

    def show_message(self, text: str, error: bool = False) -> None:
        """Show a line in the status line and on the terminal."""
        if text != self.message or self._message_age_s > MESSAGE_S:
            say(text)
        self.message, self._message_age_s, self._is_error = text, 0.0, error

    def ask(self, text: str, answers: Answers) -> None:
        """Open a modal question; the answer's function is called after the frame."""
        self._question = Question(text, answers)

    def defer(self, act: Callable[[], object]) -> None:
        """Call `act` when the present frame has ended; its error is shown."""
        self._deferred.append(act)

    def run_in_background(
        self,
        work: Callable[[], T],
        done: Callable[[T], object],
        label: str = "",
        failed: Callable[[], object] = lambda: None,
    ) -> None:
        """Run `work` in another thread, then `done` with its result in this one.

        If `work` raises, `failed` is called and the error shown. Meanwhile the status line shows
        the `label`.
        """
        future = self._pool.submit(work)
        self._tasks.append(Task(future, done, failed, label))
        future.add_done_callback(lambda _: self.wake())

    @contextmanager
    def panel(self, name: str, rect: Rect, titled: bool = True) -> Iterator[None]:
        """A panel at a fixed place, less a gap; an error while it is drawn is shown."""
        left, top, width, height = rect
        gap = 0.5 * GAP * self.text_height
        imgui.set_next_window_pos((left + gap, top + gap))
        imgui.set_next_window_size((max(width - 2 * gap, 1.0), max(height - 2 * gap, 1.0)))
        imgui.begin(name, None, FIXED if titled else UNTITLED)
        with self._errors_shown(), recovering_errors():
            yield
        imgui.end()

    def save(self) -> bool:
        """Have the tool save; return whether it has."""
        with self._errors_shown():
            return self.tool.save()
        return False

    def request_close(self) -> None:
        """Close the window, after a question if there is unsaved work."""
        self.leave_work(self._close)

    def leave_work(self, act: Callable[[], object]) -> None:
        """Call `act`, which gives up the present work; if that is unsaved, after a question."""
        if self.tool.history.unsaved:
            answers = {"Save": lambda: self.save() and act(), DISCARD: act, "Go on": None}
            self.ask("There is unsaved work.", answers)
        else:
            act()

    def interrupted(self) -> bool:
        """Handle Ctrl-C; return True if it ends the program: at once, or the second time."""
        asked = self._question is not None and DISCARD in self._question.answers
        if asked or not self.tool.history.unsaved:
            return True
        self.request_close()
        self.show_message("there is unsaved work: Ctrl-C once more throws it away", error=True)
        return False

    def run(self) -> None:
        """Draw frames until the window is closed, or Ctrl-C raises KeyboardInterrupt."""
        with deferred_interrupts() as check:
            last = time.perf_counter()
            while self.open:
                try:
                    check()
                except KeyboardInterrupt:
                    if self.interrupted():
                        raise
                if not self._wait():
                    continue
                now = time.perf_counter()
                self.frame(now - last)
                last = now

    def frame(self, elapsed_s: float) -> None:
        """Handle events, draw and present, `elapsed_s` after the last frame."""
        if "leave" in self.window_set.poll():
            self.request_close()
        if not self.window.open:  # its close button
            glfw.set_window_should_close(self.window.handle, False)
            self.request_close()
        ended = [task for task in self._tasks if task.future.done()]
        self._tasks = [task for task in self._tasks if task not in ended]
        for task in ended:
            with self._errors_shown():
                task.finish()
        self._message_age_s += elapsed_s
        stirred, self._woken, self._heard = self.gui.heard != self._heard, False, self.gui.heard
        self._awake_s = AWAKE_S if stirred else max(self._awake_s - elapsed_s, 0.0)
        self.idle_s = 0.0 if stirred else self.idle_s + elapsed_s
        window = self.window
        self.gui.begin(window.points, window.size, self._text_scale())
        self._draw_menu_bar()
        self._draw_status()
        due_s = math.inf
        with self._errors_shown(), recovering_errors():
            due_s = self.tool.draw(elapsed_s)
        self._due_s = 0.0 if self._awake_s or self._question else due_s
        if self.doing:
            self._due_s = min(self._due_s, POLL_S)
        if self._message_age_s < MESSAGE_S:
            self._due_s = min(self._due_s, MESSAGE_S - self._message_age_s + POLL_S)
        if self._question is not None and (answer := self._question.draw()) is not None:
            act, self._question = self._question.answers[answer], None
            if act is not None:
                self.defer(act)
        self.context.screen.use()
        self.context.viewport = (0, 0, *window.size)
        self.context.clear(*BACKGROUND)
        self.gui.end()
        self.window_set.present()
        acts, self._deferred = self._deferred, []
        for act in acts:
            with self._errors_shown():
                act()
        self._due_s = 0.0 if acts else self._due_s

    def close(self) -> None:
        """Close everything in reverse order."""
        self._undo.close()

    def _wait(self) -> bool:
        """Wait for something to draw, at most `POLL_S`; return whether there is."""
        if self._due_s > 0.0 and not self._woken:
            heard, begun = self.gui.heard, time.perf_counter()
            glfw.wait_events_timeout(min(self._due_s, POLL_S))
            self._due_s -= time.perf_counter() - begun
            self._woken |= self.gui.heard != heard
        return self._due_s <= 0.0 or self._woken or not self.window.open

    def _text_scale(self) -> float:
        """The desktop's scale of text, less in a small window."""
        usual = self.window.text_scale
        room = min(*(n / m for n, m in zip(self.window.points, LEAST_LINES, strict=True))) / TEXT_PT
        return min(usual, max(room, LEAST_TEXT * usual))

    def _draw_menu_bar(self) -> None:
        tool, keys = self.tool, not imgui.get_io().want_text_input and self._question is None
        ctrl, shift = imgui.Key.mod_ctrl.value, imgui.Key.mod_shift.value
        top = 0.0
        if imgui.begin_main_menu_bar():
            top = imgui.get_window_size().y
            for label, letter, chords, enabled, act in (
                ("Save", "S", (ctrl | imgui.Key.s.value,), True, self.save),
                ("Undo", "Z", (ctrl | imgui.Key.z.value,), tool.history.may_undo, tool.undo),
                (
                    "Redo", "Y", (ctrl | imgui.Key.y.value, ctrl | shift | imgui.Key.z.value),
                    tool.history.may_redo, tool.redo,
                ),
            ):  # fmt: skip
                clicked = imgui.menu_item(label, "", False, enabled)[0]
                imgui.set_item_tooltip(f"Ctrl+{letter}")
                if enabled and (clicked or (keys and any(map(imgui.is_key_chord_pressed, chords)))):
                    self.defer(act)
            imgui.separator()
            with self._errors_shown(), recovering_errors():
                tool.draw_menu()
            title = f"{self.title} ·  not saved" if tool.history.unsaved else self.title
            room = imgui.get_content_region_avail().x - imgui.calc_text_size(title).x
            if (gap := room - self.text_height) > 0.0:
                imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + gap)
                imgui.text_colored((*QUIET, 1.0), title)
            imgui.end_main_menu_bar()
        title = f"* {self.title}" if tool.history.unsaved else self.title
        if title != self._shown_title:
            self._shown_title = title
            glfw.set_window_title(self.window.handle, title)
        size, gap = imgui.get_io().display_size, 0.5 * GAP * self.text_height
        bottom = STATUS_HEIGHT * self.text_height + gap
        self.area = (gap, top + gap, max(size.x - 2 * gap, 1.0), max(size.y - top - bottom, 1.0))

    def _draw_status(self) -> None:
        """Draw the last message while it is fresh, else the hint; and the background work."""
        line, size = self.text_height, imgui.get_io().display_size
        canvas = imgui.get_background_draw_list()
        height = STATUS_HEIGHT * line
        place = 0.8 * line, size.y - height + (height - line) / 2 - 0.15 * line
        if label := self.doing:
            dots = "." * (1 + int(time.perf_counter() / POLL_S) % 3)
            canvas.add_text((size.x - 16.0 * line, place[1]), colour(MARK), f"{label} {dots}")
        fresh = self._message_age_s < MESSAGE_S
        ink = (ERROR if self._is_error else MARK) if fresh else QUIET
        canvas.add_text(place, colour(ink), self.message if fresh else self.hint)

    def _close(self) -> None:
        self.open = False

    @contextmanager
    def _errors_shown(self) -> Iterator[None]:
        """Show an error as a message: the window and the work stay."""
        try:
            yield
        except UserError as fault:
            self.show_message(str(fault), error=True)
        except Exception as fault:
            text = f"that failed: {type(fault).__name__}: {fault}"
            if text != self.message:  # once, not in every frame
                warnings.warn(traceback.format_exc(), RuntimeWarning, stacklevel=3)
            self.show_message(text, error=True)


def run_tool(title: str, make: Callable[[ToolWindow], Tool], without: str) -> int:
    """Open a window with a tool and run it until it is closed; exit code 0.

    Ctrl-C waits until the tool is made: half of one would outlive its OpenGL context.
    """
    with (
        deferred_interrupts() as check,
        closing(ToolWindow(title, make, without=without)) as window,
    ):
        check()
        window.run()
    return 0
