"""The makers' bench: a window for one tool, in which something is made and saved.

A tool is a `Craft`: it draws its panels and says what is saved, undone and redone. The bench has
the rest: the window and its OpenGL context, a bar on top with Save, Undo and Redo (Ctrl+S, Ctrl+Z,
Ctrl+Y), a line at the foot for what is to be told, questions, work in the background, and the end:
who closes the window or presses Ctrl-C in the terminal is asked once about what is not saved.

    def build(name):                        # what the command line calls
        return work("build", lambda bench: Builder(bench, name), without="...")

    class Builder:                          # a Craft
        def __init__(self, bench, name):
            self.bench, self.history = bench, History(load(name))     # core/undo.py
            self.side = Canvas((-1.0, -5.0, 21.0, 5.0), up=True)      # ui/viewport2d.py
        def draw(self, elapsed_s):
            left, top, width, height = self.bench.room
            with self.bench.pane("Side view", left, top, 0.7 * width, height):
                with self.side.drawn("side", imgui.get_content_region_avail()): ...
            return math.inf                 # nothing moves by itself; 0.0: the next frame at once

The bench draws only when hands do something, when the craft said that something moves, or when
`wake` is called: an idle tool takes no processor time. Pictures are shown by `ImageTexture`,
made with `bench.context`; views that draw themselves with the same context.
"""

import math
import time
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, closing, contextmanager
from typing import Any, Protocol, TypeVar

import glfw
from imgui_bundle import imgui

from subsea.core.console import say
from subsea.core.errors import UserError
from subsea.core.interrupts import deferred_interrupts
from subsea.ui.gui import MARK, QUIET, TEXT_PT, colour, recovering_errors
from subsea.ui.open_windows import open_windows
from subsea.ui.window import GlWindow

T = TypeVar("T")

SIZE = 1280, 800  # of the window when it opens
WAKEFUL_S = 0.6  # so long frames are drawn after hands did something: tips come late
LOOK_S = 0.25  # between two looks for Ctrl-C, where nothing moves
TOLD_S = 15.0  # a line at the foot stays for so long
LETTERS = 62.0, 40.0  # as many heights of letters a window should be wide and high, ...
LEAST_TEXT = 0.7  # ... if these are no smaller than this, of the usual
FOOT = 1.7  # height of that line, in heights of letters
GAP = 0.4  # between panes, in the same
FIXED = (
    imgui.WindowFlags_.no_move.value
    | imgui.WindowFlags_.no_resize.value
    | imgui.WindowFlags_.no_collapse.value
    | imgui.WindowFlags_.no_bring_to_front_on_focus.value
    | imgui.WindowFlags_.no_nav.value
)
BARE = FIXED | imgui.WindowFlags_.no_title_bar.value | imgui.WindowFlags_.no_scrollbar.value
BACK = 0.012, 0.040, 0.058  # behind panes, ...
PANE, TITLE = (0.030, 0.095, 0.130), (0.045, 0.150, 0.200)  # ... and what these are made of
ASKED = imgui.WindowFlags_.no_title_bar.value | imgui.WindowFlags_.always_auto_resize.value
TROUBLE = (1.0, 0.55, 0.42)


class Craft(Protocol):
    """A tool at the bench."""

    @property
    def unsaved(self) -> bool:
        """Whether something would be lost if the window closed now."""

    @property
    def may_undo(self) -> bool:
        """Whether there is something to undo."""

    @property
    def may_redo(self) -> bool:
        """Whether something was undone."""

    def draw(self, elapsed_s: float) -> float:
        """Draw everything in the present frame, `elapsed_s` after the last one.

        The seconds until it will look different by itself: 0 while something moves, inf if not.
        """

    def bar(self) -> None:
        """More entries of the bar on top: ``imgui.menu_item``."""

    def save(self) -> bool:
        """Write what was made; whether that is done. A UserError is told."""

    def undo(self) -> None:
        """Go back by one act."""

    def redo(self) -> None:
        """Go forth by one act."""

    def close(self) -> None:
        """Release what it holds; the OpenGL context is still current."""


class Question:
    """Something that is asked in the midst of the window, with answers that do something."""

    def __init__(self, text: str, answers: Mapping[str, Callable[[], object] | None]) -> None:
        """None does nothing; the last answer is that of Esc."""
        self.text, self.answers = text, answers
        self.shown = False


class Bench:
    """A window with a craft."""

    def __init__(
        self,
        title: str,
        make: Callable[["Bench"], Craft],
        size: tuple[int, int] = SIZE,
        without: str = "there is nothing to see",
    ) -> None:
        """Open the window, then make the craft: somebody sees at once that something happens.

        No display is a UserError that tells what can be done `without` one. Whatever fails, all
        that was opened is closed again.
        """
        self.title = title
        self.hint = ""  # what hands may do now: at the foot, while nothing is told
        self.room = 0.0, 0.0, 1.0, 1.0  # left, top, width and height of the place for panes
        self.told = ""  # what was told last
        self._told_for_s, self._trouble = math.inf, False
        self._question: Question | None = None
        self._due = 0.0  # the next frame is due in so many seconds, unless hands do something
        self._awake_s = WAKEFUL_S
        self._named = ""
        self._woken = False
        self._left = False
        self.quiet_s = 0.0  # since hands did something
        self._heard = 0  # events, until the last frame
        self._later: list[Callable[[], object]] = []
        self._works: list[tuple[Future[Any], Callable[[Any], object], str]] = []
        with ExitStack() as undo:
            opening = open_windows("mono", size, title=title, without=without)
            undo.callback(opening.close)
            self.window_set, self.gui = opening.window_set, opening.gui
            self.window: GlWindow = self.window_set.front
            self.context = self.window_set.context
            self.gui.open = True  # all that hands do is for panes
            style, names = imgui.get_style(), imgui.Col_
            for name, rgb in (
                (names.window_bg, PANE),
                (names.popup_bg, TITLE),
                (names.title_bg, TITLE),
                (names.title_bg_active, TITLE),
                (names.menu_bar_bg, PANE),
            ):
                style.set_color_(name.value, (*rgb, 1.0))
            self._pool = ThreadPoolExecutor(2, "bench")
            undo.callback(self._pool.shutdown, wait=False, cancel_futures=True)
            glfw.set_window_refresh_callback(self.window.handle, lambda handle: self.wake())
            self.craft = make(self)
            undo.callback(self.craft.close)
            self._undo = undo.pop_all()

    @property
    def open(self) -> bool:
        """Whether there is no end yet."""
        return not self._left

    @property
    def busy(self) -> bool:
        """Whether work in the background is not done yet."""
        return bool(self._works)

    @property
    def asks(self) -> bool:
        """Whether a question waits for its answer."""
        return self._question is not None

    @property
    def _doing(self) -> str:
        return next((doing for _, _, doing in self._works if doing), "")

    @property
    def line(self) -> float:
        """The height of letters, in pointer units; within a frame."""
        return float(imgui.get_font_size())

    def wake(self) -> None:
        """Draw a frame soon; also from another thread."""
        self._woken = True
        glfw.post_empty_event()

    def tell(self, text: str, trouble: bool = False) -> None:
        """Tell a line at the foot of the window, and on the terminal."""
        if text != self.told or self._told_for_s > TOLD_S:
            say(text)
        self.told, self._told_for_s, self._trouble = text, 0.0, trouble

    def ask(self, text: str, answers: Mapping[str, Callable[[], object] | None]) -> None:
        """Ask something; nothing else can be done until one of the answers is clicked.

        An answer calls its function after the frame, None nothing. The last is that of Esc.
        """
        self._question = Question(text, answers)

    def later(self, act: Callable[[], object]) -> None:
        """Do it when the present frame has ended; what it raises is told."""
        self._later.append(act)

    def behind(
        self,
        work: Callable[[], T],
        then: Callable[[T], object],
        doing: str = "",
        failed: Callable[[], object] = lambda: None,
    ) -> None:
        """Do `work` in another thread, two at a time, and `then` with its result in this one.

        A fault of it is told, and `failed` is called then. Meanwhile the foot tells what is being
        done, in a few words.
        """

        def finish(task: Future[T]) -> None:
            if task.exception() is not None:
                failed()
            then(task.result())

        task = self._pool.submit(work)
        self._works.append((task, finish, doing))
        task.add_done_callback(lambda done: self.wake())

    @contextmanager
    def pane(
        self, name: str, left: float, top: float, width: float, height: float, titled: bool = True
    ) -> Iterator[None]:
        """A panel that stays where it is put; a fault of what is drawn in it is told.

        Its name is above it if it is `titled`. Panes in `room` have a gap between them.
        """
        gap = 0.5 * GAP * self.line
        imgui.set_next_window_pos((left + gap, top + gap))
        imgui.set_next_window_size((max(width - 2 * gap, 1.0), max(height - 2 * gap, 1.0)))
        imgui.begin(name, None, FIXED if titled else BARE)
        with self._contained(), recovering_errors():
            yield
        imgui.end()

    def save(self) -> bool:
        """Have the craft save; whether it has."""
        with self._contained():
            return self.craft.save()
        return False

    def ask_to_close(self) -> None:
        """Close the window, but for what is not saved: that is asked about."""
        if self.craft.unsaved:
            self.ask(
                "There is unsaved work.",
                {"Save": self._save_and_leave, "Throw it away": self._leave, "Go on": None},
            )
        else:
            self._leave()

    def interrupted(self) -> bool:
        """Ctrl-C was pressed; whether that is the end: when it was asked already, it is."""
        asked = self._question is not None and "Throw it away" in self._question.answers
        if asked or not self.craft.unsaved:
            return True
        self.ask_to_close()
        self.tell("there is unsaved work: Ctrl-C once more throws it away", trouble=True)
        return False

    def run(self) -> None:
        """Frames until the window is closed, or Ctrl-C raises KeyboardInterrupt."""
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
        """Events, drawing and presenting, `elapsed_s` after the last frame."""
        if "leave" in self.window_set.poll():
            self.ask_to_close()
        if not self.window.open:  # somebody wants it closed
            glfw.set_window_should_close(self.window.handle, False)
            self.ask_to_close()
        for work in [one for one in self._works if one[0].done()]:
            self._works.remove(work)
            with self._contained():
                work[1](work[0])
        self._told_for_s += elapsed_s
        stirred, self._woken, self._heard = self.gui.heard != self._heard, False, self.gui.heard
        self._awake_s = WAKEFUL_S if stirred else max(self._awake_s - elapsed_s, 0.0)
        self.quiet_s = 0.0 if stirred else self.quiet_s + elapsed_s
        window = self.window
        self.gui.begin(window.points, window.size, self._text_scale())
        self._bar()
        self._foot()
        due = math.inf
        with self._contained(), recovering_errors():
            due = self.craft.draw(elapsed_s)
        self._due = 0.0 if self._awake_s or self._question else due
        if self._doing:
            self._due = min(self._due, LOOK_S)
        if self._told_for_s < TOLD_S:
            self._due = min(self._due, TOLD_S - self._told_for_s + LOOK_S)
        self._ask()
        self.context.screen.use()
        self.context.viewport = (0, 0, *window.size)
        self.context.clear(*BACK)
        self.gui.end()
        self.window_set.present()
        acts, self._later = self._later, []
        for act in acts:
            with self._contained():
                act()
        self._due = 0.0 if acts else self._due

    def picture(self) -> Any:
        """What the window shows: (h, w, 3) uint8, top row first; for those who take pictures."""
        return self.window_set.picture()

    def close(self) -> None:
        """Close everything in the reverse order of its opening."""
        self._undo.close()

    def _wait(self) -> bool:
        """Wait until there is something to draw, at most for a look; whether there is."""
        if self._due > 0.0 and not self._woken:
            heard, begun = self.gui.heard, time.perf_counter()
            glfw.wait_events_timeout(min(self._due, LOOK_S))
            self._due -= time.perf_counter() - begun
            self._woken |= self.gui.heard != heard
        return self._due <= 0.0 or self._woken or not self.window.open

    def _text_scale(self) -> float:
        """How large text is: as the desktop wants it, smaller where it would have no room."""
        usual = self.window.text_scale
        room = min(*(n / m for n, m in zip(self.window.points, LETTERS, strict=True))) / TEXT_PT
        return min(usual, max(room, LEAST_TEXT * usual))

    def _bar(self) -> None:
        """What every tool has: Save, Undo and Redo; then the craft's own entries, and its name."""
        craft, keys = self.craft, not imgui.get_io().want_text_input and self._question is None
        ctrl, shift = imgui.Key.mod_ctrl.value, imgui.Key.mod_shift.value
        top = 0.0
        if imgui.begin_main_menu_bar():
            top = imgui.get_window_size().y
            for words, letter, chords, may, act in (
                ("Save", "S", (ctrl | imgui.Key.s.value,), True, self.save),
                ("Undo", "Z", (ctrl | imgui.Key.z.value,), craft.may_undo, craft.undo),
                (
                    "Redo", "Y", (ctrl | imgui.Key.y.value, ctrl | shift | imgui.Key.z.value),
                    craft.may_redo, craft.redo,
                ),
            ):  # fmt: skip
                clicked = imgui.menu_item(words, "", False, may)[0]
                imgui.set_item_tooltip(f"Ctrl+{letter}")
                if may and (clicked or (keys and any(map(imgui.is_key_chord_pressed, chords)))):
                    self.later(act)
            imgui.separator()
            with self._contained(), recovering_errors():
                craft.bar()
            name = f"{self.title} ·  not saved" if craft.unsaved else self.title
            far = imgui.get_content_region_avail().x - imgui.calc_text_size(name).x - self.line
            if far > 0.0:
                imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + far)
                imgui.text_colored((*QUIET, 1.0), name)
            imgui.end_main_menu_bar()
        name = f"* {self.title}" if craft.unsaved else self.title
        if name != self._named:
            self._named = name
            glfw.set_window_title(self.window.handle, name)
        size, foot, gap = imgui.get_io().display_size, FOOT * self.line, 0.5 * GAP * self.line
        self.room = (
            gap,
            top + gap,
            max(size.x - 2 * gap, 1.0),
            max(size.y - top - foot - gap, 1.0),
        )

    def _foot(self) -> None:
        """What was told last, or what hands may do."""
        size, height = imgui.get_io().display_size, FOOT * self.line
        canvas = imgui.get_background_draw_list()
        place = 0.8 * self.line, size.y - height + (height - self.line) / 2 - 0.15 * self.line
        fresh = self._told_for_s < TOLD_S
        if doing := self._doing:
            dots = "." * (1 + int(time.perf_counter() / LOOK_S) % 3)
            canvas.add_text((size.x - 16.0 * self.line, place[1]), colour(MARK), f"{doing} {dots}")
        ink = (TROUBLE if self._trouble else MARK) if fresh else QUIET
        text = self.told if fresh else self.hint
        canvas.add_text(place, colour(ink), text)

    def _ask(self) -> None:
        """The question in the midst of the window, if there is one."""
        question = self._question
        if question is None:
            return
        if not question.shown:
            imgui.open_popup("##question")
            question.shown = True
        size = imgui.get_io().display_size
        imgui.set_next_window_pos((size.x / 2, size.y / 2), 0, (0.5, 0.5))
        chosen: str | None = None
        if imgui.begin_popup_modal("##question", None, ASKED)[0]:
            imgui.text(question.text)
            imgui.dummy((0.0, 0.3 * self.line))
            for number, words in enumerate(question.answers):
                if number:
                    imgui.same_line()
                if imgui.button(f"{words}##answer"):
                    chosen = words
            if imgui.is_key_pressed(imgui.Key.escape):
                chosen = list(question.answers)[-1]
            if chosen is not None:
                imgui.close_current_popup()
            imgui.end_popup()
        if chosen is not None:
            self._question = None
            if (act := question.answers[chosen]) is not None:
                self.later(act)

    def _save_and_leave(self) -> None:
        if self.save():
            self._leave()

    def _leave(self) -> None:
        self._left = True

    @contextmanager
    def _contained(self) -> Iterator[None]:
        """A fault in it is told, and costs nobody the work."""
        try:
            yield
        except UserError as fault:
            self.tell(str(fault), trouble=True)
        except Exception as fault:
            text = f"that failed: {type(fault).__name__}: {fault}"
            if text != self.told:  # once, not in every frame
                warnings.warn(traceback.format_exc(), RuntimeWarning, stacklevel=3)
            self.tell(text, trouble=True)


def work(
    title: str, make: Callable[[Bench], Craft], without: str, size: tuple[int, int] = SIZE
) -> int:
    """Open a bench with a craft and work at it until it is closed; exit code 0.

    Ctrl-C waits until the craft is made: half of one would outlive its OpenGL context.
    """
    with deferred_interrupts() as check, closing(Bench(title, make, size, without)) as bench:
        check()
        bench.run()
    return 0
