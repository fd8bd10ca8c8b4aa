"""A display to open windows on, and hands to use them: real events by xdotool."""

import os
import re
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from imgui_bundle import imgui
from PIL import ImageGrab

from subsea.core.resources import resource_path
from subsea.dive.options import DisplayOptions, DiveOptions
from subsea.dive.start import headless
from subsea.media import eye_frames, film
from subsea.profiling import benchmark
from subsea.render.output.quality import PRESETS

FRAME_S = 0.1  # three ticks a picture: tests of windows are not about smoothness


def dive_options(
    scenario: object, size: tuple[int, int], quality: str = "auto", **rest: Any
) -> DiveOptions:
    """The options of a dive in one small window, the same every time."""
    display = DisplayOptions(size=size, quality=quality)
    return DiveOptions(**{"scenario": str(scenario), "seed": 1, "display": display, **rest})


@pytest.fixture(scope="module")
def display() -> Iterator[str]:
    """A virtual display of 800x600, named in DISPLAY as long as the tests of a module run."""
    for tool in ("Xvfb", "xdotool"):
        if shutil.which(tool) is None:
            pytest.fail(f"{tool} is missing; `make test` installs it, or prints how")
    read, write = os.pipe()
    # The server chooses a free number itself and tells it once it listens. Left to itself it
    # would begin anew whenever the last window closes, and refuse the next one meanwhile.
    command = ["Xvfb", "-displayfd", str(write), "-screen", "0", "800x600x24"]
    command += ["-nolisten", "tcp", "-noreset"]
    server = subprocess.Popen(
        command, pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    os.close(write)
    with os.fdopen(read) as pipe:
        name = ":" + pipe.readline().strip()
    before = {key: os.environ.pop(key, None) for key in ("DISPLAY", "WAYLAND_DISPLAY")}
    os.environ["DISPLAY"] = name
    try:
        yield name
    finally:
        os.environ.pop("DISPLAY")
        os.environ.update({key: value for key, value in before.items() if value is not None})
        server.terminate()
        server.wait()


class Hands:
    """What moves the mouse and presses keys, and the dive's frames meanwhile."""

    @staticmethod
    def do(*words: object) -> None:
        """Let xdotool do it; returns when the display has taken it."""
        subprocess.run(["xdotool", *map(str, words)], check=True, timeout=60)

    @staticmethod
    def glide(running: Any, seconds: float) -> None:
        """Frames of the dive for `seconds` of its own time, however slow this machine draws."""
        for _ in range(round(seconds / FRAME_S)):
            running.frame(FRAME_S)

    @staticmethod
    def until(running: Any, true: Callable[[], object], seconds: float = 60.0) -> None:
        """Frames until the display has brought what hands did; it may take its time."""
        end = time.monotonic() + seconds
        while not true() and time.monotonic() < end:
            running.frame(FRAME_S)
            time.sleep(0.01)
        assert true()

    @staticmethod
    def double_click(running: Any) -> None:
        """Click twice; imgui measures the pause in seconds, and frames are slow here."""
        io = imgui.get_io()
        usual = io.mouse_double_click_time, io.mouse_single_click_delay
        io.mouse_double_click_time, io.mouse_single_click_delay = 5.0, 6.0
        Hands.do("click", "--repeat", 2, "--delay", 60, 1)
        Hands.glide(running, 1.0)
        io.mouse_double_click_time, io.mouse_single_click_delay = usual

    def point(self, running: Any, x: float, y: float) -> None:
        """Move the pointer, in two steps, to a place given in [-1, 1] from the middle."""
        (left, top), (width, height) = running.window.position, running.window.points
        for share in (0.8, 1.0):
            across, down = left + (1 + share * x) / 2 * width, top + (1 - share * y) / 2 * height
            self.do("mousemove", int(across), int(down))
            self.glide(running, FRAME_S)

    @staticmethod
    def screen(running: Any) -> Any:
        """The window as the display shows it, (h, w, 3)."""
        left, top = running.window.position
        picture = ImageGrab.grab(xdisplay=os.environ["DISPLAY"])
        width, height = running.window.size
        return np.asarray(picture)[top : top + height, left : left + width, :3].astype(int)


@pytest.fixture(scope="module")
def one_context() -> Iterator[None]:
    """What a module draws without a window is drawn in one context: each new one costs 0.5 s."""
    with headless() as context, pytest.MonkeyPatch.context() as patch:
        for module in (benchmark, eye_frames, film):
            patch.setattr(module, "headless", lambda: context)
        yield


@pytest.fixture(scope="module")
def coarse() -> Iterator[str]:
    """A quality for windows whose sea is not looked at: "low" on a sixteenth of the pixels."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(PRESETS, "coarse", replace(PRESETS["low"], scale=0.25))
        yield "coarse"


@pytest.fixture(scope="session")
def quiet(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The sea of the first dive with few fishes, so that software draws it fast: its file."""
    text = (resource_path("assets/scenarios") / "peaceful.toml").read_text()
    path = tmp_path_factory.mktemp("sea") / "quiet.toml"
    path.write_text(re.sub(r"^number = \d+", "number = 2", text, flags=re.MULTILINE))
    return str(path)


@pytest.fixture(scope="session")
def hands() -> Hands:
    """Real events by xdotool, on the display of the module."""
    return Hands()


class Spots(dict[str, tuple[float, float, float, float]]):
    """Where each widget of a panel was drawn last, by its label: left, top, right, bottom."""

    WIDGETS = (
        "arrow_button", "button", "checkbox", "collapsing_header", "input_double", "input_int",
        "menu_item", "radio_button", "slider_float", "input_text_with_hint", "selectable",
        "drag_float", "invisible_button", "input_text", "color_edit3",
    )  # fmt: skip

    def watch(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Note widgets from now on."""
        for name in self.WIDGETS:
            monkeypatch.setattr(imgui, name, self._noting(getattr(imgui, name)))

    def _noting(self, widget: Callable[..., Any]) -> Callable[..., Any]:
        def drawn(label: str, *rest: Any, **named: Any) -> Any:
            out = widget(label, *rest, **named)
            low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
            self[label] = (low.x, low.y, high.x, high.y)
            return out

        return drawn

    def place(self, running: Any, label: str, share: float = 0.5) -> tuple[int, int]:
        """Where on the display a widget is: the middle of its height, a share of its width."""
        left, top, right, bottom = self[label]
        x, y = running.window.position
        return round(x + left + share * (right - left)), round(y + (top + bottom) / 2)

    def click(self, running: Any, label: str, share: float = 0.5) -> None:
        """Press the left button on a widget, and let it go."""
        Hands.do("mousemove", *self.place(running, label, share))
        Hands.glide(running, 2 * FRAME_S)
        for word in ("mousedown", "mouseup"):
            Hands.do(word, 1)
            Hands.glide(running, 2 * FRAME_S)

    def drag(self, running: Any, label: str, begin: float, end: float) -> None:
        """Drag from one share of a widget's width to another."""
        Hands.do("mousemove", *self.place(running, label, begin))
        Hands.glide(running, 2 * FRAME_S)
        Hands.do("mousedown", 1)
        Hands.glide(running, 2 * FRAME_S)
        Hands.do("mousemove", *self.place(running, label, end))
        Hands.glide(running, 2 * FRAME_S)
        Hands.do("mouseup", 1)
        Hands.glide(running, 2 * FRAME_S)

    def type(self, running: Any, label: str, text: str) -> None:
        """Enter something into a field, in place of what is there."""
        Hands.glide(running, FRAME_S)
        self.click(running, label, 0.1)
        Hands.do("key", "ctrl+a")
        Hands.glide(running, FRAME_S)
        Hands.do("type", "--delay", 12, text)
        Hands.do("key", "Return")
        for _ in range(2 * len(text) + 6):  # a frame takes one thing at a time from a hand
            running.frame(0.0)


@pytest.fixture
def spots(monkeypatch: pytest.MonkeyPatch) -> Spots:
    """Where widgets are drawn, to click on them."""
    found = Spots()
    found.watch(monkeypatch)
    return found
