"""A tool window by real events: dragging points, undo, saving."""

import math
import signal
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from subsea.base.errors import UserError
from subsea.rendering.gl.textures import ImageTexture
from subsea.studio.questions import NameDialog
from subsea.studio.tool_window import ToolWindow, run_tool
from subsea.studio.viewport2d import Viewport2D
from subsea.ui.gui import INK, MARK
from subsea.ui.undo import History

SIZE = 640, 480
POINTS = ((0.0, 0.0), (5.0, 2.0), (10.0, 0.0))
RED = np.full((8, 16, 3), (200, 30, 30), np.uint8)


class Line:
    """A tool: a line through three points that can be dragged."""

    def __init__(self, window):
        self.window, self.history = window, History(POINTS)
        self.view = Viewport2D((-1.0, -3.0, 11.0, 3.0), up=True)
        self.shown = ImageTexture(window.context, RED)
        self.trial, self.fault, self.refuses = None, None, False
        self.frames, self.due = 0, math.inf

    @property
    def points(self):
        return self.trial or self.history.present

    def save(self):
        if self.refuses:
            raise UserError("the disk is full")
        self.history.saved()
        return True

    def undo(self):
        self.history.undo()

    def redo(self):
        self.history.redo()

    def draw_menu(self):
        imgui.menu_item("Entry", "", False)

    def close(self):
        self.shown.release()

    def draw(self, elapsed_s):
        self.frames += 1
        self.window.hint = "Drag a point."
        with (
            self.window.panel("View", self.window.area),
            self.view.drawn("view", tuple(imgui.get_content_region_avail())) as view,
        ):
            view.picture(self.shown.glo, (7.0, -2.8, 10.0, -1.3))
            view.grid()
            view.line(self.points, MARK)
            drag = view.drag_points("points", self.points)
            view.dots(self.points, INK)
            if drag.dragged is not None:
                points = list(self.points)
                points[drag.dragged] = drag.to
                self.trial = tuple(points)
                if drag.ended:
                    self.history.do(self.trial)
                    self.trial = None
            if self.fault:
                raise self.fault
        return self.due


def test_without_a_display_it_says_so_in_one_line(monkeypatch):
    # Must be the first test of this module: the window library has one display at a time.
    for key in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(key, raising=False)
    with pytest.raises(UserError, match=r"no display .*; without one, `subsea skin --auto` works"):
        run_tool("line", Line, "`subsea skin --auto` works")


def test_ctrl_c_waits_until_the_tool_is_made(display, monkeypatch):
    closed = []

    class Slow(Line):
        def __init__(self, window):
            signal.raise_signal(signal.SIGINT)
            super().__init__(window)

        def close(self):
            super().close()
            closed.append(self.frames)

    with pytest.raises(KeyboardInterrupt):
        run_tool("slow", Slow, "no")
    assert closed == [0]


@pytest.fixture(scope="module")
def window(display):
    with closing(ToolWindow("line", Line, SIZE)) as window:
        for _ in range(5):
            window.frame(0.1)
        yield window


def at(window, x, y):
    """The position on the display of a place in the view."""
    left, top = window.window.position
    across, down = window.tool.view.on_screen((x, y))
    return round(left + across), round(top + down)


def test_a_point_is_dragged_undone_redone_and_saved(window, user, spots):
    line = window.tool
    user.drag(window, at(window, 5.0, 2.0), at(window, 6.0, -1.0))
    user.until(window, lambda: line.points[1] == pytest.approx((6.0, -1.0), abs=0.05))
    assert (line.points[0], line.points[2]) == (POINTS[0], POINTS[2])
    moved = line.points
    assert line.history.unsaved
    user.do("key", "ctrl+z")
    user.until(window, lambda: line.points == POINTS)
    assert not line.history.unsaved
    user.do("key", "ctrl+y")
    user.until(window, lambda: line.points == moved)
    spots.click(window, "Undo")
    user.until(window, lambda: line.points == POINTS)
    user.do("key", "ctrl+shift+z")
    user.until(window, lambda: line.points == moved)
    user.do("key", "ctrl+s")
    user.until(window, lambda: not line.history.unsaved)
    spots.click(window, "Undo")
    user.until(window, lambda: line.history.unsaved)
    spots.click(window, "Save")
    user.until(window, lambda: not line.history.unsaved)


def test_a_tap_within_a_frame_undoes_even_if_ctrl_is_released_first(window, user):
    line = window.tool
    for tap in (["keydown", "z", "keyup", "ctrl", "keyup", "z"], ["key", "z", "keyup", "ctrl"]):
        line.history.do(((1.0, 1.0), *POINTS[1:]))
        user.do("keydown", "ctrl")
        user.glide(window, 0.3)
        user.do(*tap)  # no frame meanwhile
        user.until(window, lambda: line.points[0] == POINTS[0], 5.0)
    user.glide(window, 0.2)
    line.history.saved()


def test_esc_in_a_list_of_a_dialog_closes_only_the_list(window, user, spots, monkeypatch):
    naming, answers = NameDialog("fusilier"), []
    monkeypatch.setattr(window.tool, "draw", lambda elapsed_s: answers.append(naming.draw()) or 0.0)
    user.glide(window, 0.3)
    popups = imgui.get_current_context().open_popup_stack
    spots.click(window, "built like")
    user.until(window, lambda: popups.size() == 2)
    user.do("key", "Escape")
    user.until(window, lambda: popups.size() == 1)
    assert set(answers) == {None}
    user.do("key", "Escape")
    user.until(window, lambda: False in answers)


def test_the_wheel_zooms_about_the_pointer_and_a_drag_moves_the_view(window, user):
    view = window.tool.view
    fitted, place = view.scale, at(window, 2.0, -2.0)
    user.do("mousemove", *place)
    user.glide(window, 0.3)
    user.do("click", 4, "click", 4)
    user.until(window, lambda: view.scale > 1.3 * fitted)
    assert at(window, 2.0, -2.0) == pytest.approx(place, abs=1)
    for button in (1, 2, 3):
        before = view.from_screen(100.0, 100.0)
        user.drag(window, place, (place[0] + 40, place[1] - 30), button=button)
        x, y = view.from_screen(100.0, 100.0)
        assert x == pytest.approx(before[0] - 40 / view.scale, abs=1e-6)
        assert y == pytest.approx(before[1] - 30 / view.scale, abs=1e-6)
    assert window.tool.points == window.tool.history.present
    user.glide(window, 0.5)
    user.double_click(window)
    user.until(window, lambda: view.scale == pytest.approx(fitted))


def test_pictures_are_shown_as_they_are(window, user):
    user.glide(window, 0.2)
    left, top = window.window.position
    x, y = at(window, 8.7, -1.7)
    assert np.abs(user.screen(window)[y - top, x - left] - RED[0, 0]).max() < 12
    assert (
        window.window_set.picture()[y - top, x - left] == user.screen(window)[y - top, x - left]
    ).all()


def test_closing_asks_once_about_unsaved_work(window, user, spots):
    import glfw

    line = window.tool
    line.history.do(((0.0, 0.0), (5.0, 1.0), (10.0, 0.0)))
    close = lambda: glfw.set_window_should_close(window.window.handle, True)  # noqa: E731
    close()
    user.glide(window, 0.3)
    assert window.open
    assert window.asking
    spots.click(window, "Go on##answer")
    user.until(window, lambda: not window.asking)
    assert window.open and line.history.unsaved
    line.refuses = True
    close()
    user.glide(window, 0.3)
    spots.click(window, "Save##answer")
    user.glide(window, 0.2)
    assert window.open and line.history.unsaved and window.message == "the disk is full"
    line.refuses = False
    # The first Ctrl-C asks; the second ends.
    assert not window.interrupted()
    user.glide(window, 0.2)
    assert window.interrupted()
    user.do("key", "Escape")
    user.glide(window, 0.3)
    assert not window.interrupted()
    user.glide(window, 0.2)
    spots.click(window, "Save##answer")
    user.until(window, lambda: not window.open)
    assert not line.history.unsaved
    window.open = True


def test_an_error_is_shown_and_costs_no_work(window, user):
    line = window.tool
    line.fault = UserError("fish.toml: no such fish")
    user.glide(window, 0.2)
    assert window.message == "fish.toml: no such fish"
    line.fault = ZeroDivisionError("by zero")
    with pytest.warns(RuntimeWarning, match="ZeroDivisionError"):
        user.glide(window, 0.3)
    assert "by zero" in window.message
    line.fault = None
    frames = line.frames
    user.glide(window, 0.2)
    assert line.frames == frames + 2


def test_background_work_returns_its_result_or_its_error(window, user):
    results = []
    window.run_in_background(lambda: 6 * 7, results.append)
    assert window.busy
    user.until(window, lambda: results == [42])
    assert not window.busy

    def fails():
        raise UserError("too dark")

    window.run_in_background(fails, results.append, "looking", lambda: results.append("failed"))
    user.until(window, lambda: window.message == "too dark")
    assert results == [42, "failed"]


def test_it_draws_in_a_window_of_one_pixel(window, user):
    import glfw

    for size in ((1, 1), (30, 400), (400, 30), SIZE):
        glfw.set_window_size(window.window.handle, *size)
        user.until(window, lambda size=size: window.window.points == size)
        frames = window.tool.frames
        window.wake()
        user.glide(window, 0.3)
        assert window.tool.frames > frames


@pytest.mark.nightly
def test_ctrl_c_in_the_terminal_ends_the_builder(display):
    command = [sys.executable, "-m", "subsea", "build", "fusilier"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        search = ["xdotool", "search", "--sync", "--all", "--pid", str(process.pid)]
        subprocess.run([*search, "--name", "subsea"], check=True, timeout=180, capture_output=True)
        process.send_signal(signal.SIGINT)
        _, told = process.communicate(timeout=60)
    finally:
        process.kill()
        process.wait()
    assert process.returncode == 130
    assert told.splitlines()[-1:] == ["subsea: interrupted"]


@pytest.mark.nightly
def test_an_idle_window_draws_nothing_and_ctrl_c_ends_it(display, tmp_path):
    program = tmp_path / "idle.py"
    program.write_text(
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "from test_tool_window import Line\n"
        "from subsea.studio.tool_window import run_tool\n"
        "from subsea.base.command_line import run_command\n"
        "class Counted(Line):\n"
        "    def draw(self, elapsed_s):\n"
        "        print(self.frames, flush=True)\n"
        "        return super().draw(elapsed_s)\n"
        "sys.exit(run_command('subsea', lambda: run_tool('idle', Counted, 'no')))\n"
    )
    frames = tmp_path / "frames"
    with frames.open("w") as out:
        command = [sys.executable, str(program), str(Path(__file__).parent)]
        process = subprocess.Popen(command, stdout=out)
    try:
        drawn, since, end = "", time.monotonic(), time.monotonic() + 60.0
        while not drawn or time.monotonic() < since + 1.5:  # no drawing for this time
            assert time.monotonic() < end
            time.sleep(0.05)
            if frames.read_text() != drawn:
                drawn, since = frames.read_text(), time.monotonic()
        process.send_signal(signal.SIGINT)
        assert process.wait(20.0) == 130
        assert frames.read_text() == drawn
    finally:
        process.kill()
        process.wait()
