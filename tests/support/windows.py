"""A display to open windows on, and real input for them by xdotool."""

import ctypes
import os
import re
import shlex
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, Self

import glfw
import msgspec
import numpy as np
import pytest
from imgui_bundle import imgui
from PIL import ImageGrab

from subsea.base.system import resource_path
from subsea.dive.options import DisplayOptions, DiveOptions
from subsea.dive.part import DivePart, planned
from subsea.dive.settings import DisplaySettings, PictureSettings, Settings
from subsea.dive.start import headless
from subsea.dive.tick_source import LocalTicks
from subsea.lab import benchmark
from subsea.media import eye_frames, film
from subsea.rendering.fish import atlas
from subsea.rendering.gl import textures
from subsea.rendering.output.quality import PRESETS
from tools.monkey import virtual_display

# Neither notes of the logbook, which would hide others, nor a tour at the beginning.
QUIET = Settings(
    pictures=PictureSettings(logbook=False), display=DisplaySettings(introduction="off")
)
FRAME_S = 0.1  # three ticks a picture: tests of windows are not about smoothness


def dive_options(
    scenario: object, size: tuple[int, int], quality: str = "auto", introduction: str = "off",
    **rest: Any,
) -> DiveOptions:  # fmt: skip
    """The planned options of a dive in one small window, the same every time."""
    display = DisplayOptions(size=size, quality=quality)
    usual = {"scenario": str(scenario), "seed": 1, "display": display, "settings": QUIET} | rest
    shown = msgspec.structs.replace(usual["settings"].display, introduction=introduction)
    usual["settings"] = msgspec.structs.replace(usual["settings"], display=shown)
    return planned(DiveOptions(**usual))


class ShownOn(DivePart):
    """A part that shows the dive in the windows of an installation."""

    def __init__(self, installation: Any, make_ticks: Any = LocalTicks) -> None:
        self._shown = installation, make_ticks

    def installation(self, options: DiveOptions) -> Any:
        """The windows and the source of ticks."""
        return self._shown


@pytest.fixture(scope="session")
def x_server() -> Iterator[str]:
    """The virtual display of this process, of 800x600.

    One for all modules: a process that makes a window on a second display, when the first has
    ended, is ended by Xlib, as libGLX tells the second one about a context of the first.
    """
    for tool in ("Xvfb", "xdotool"):
        if shutil.which(tool) is None:
            pytest.fail(f"{tool} is missing; `make test` installs it, or prints how")
    with virtual_display() as name, InputDevices(name) as devices:
        User.devices = devices
        yield name


@pytest.fixture(scope="module")
def display(x_server: str) -> Iterator[str]:
    """The virtual display, named in DISPLAY as long as the tests of a module run."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("DISPLAY", x_server)
        patch.delenv("WAYLAND_DISPLAY", raising=False)
        User.do("mousemove", 400, 300)
        yield x_server


def display_pixels() -> Any:
    """A screenshot of the display, (h, w, 3)."""
    return np.asarray(ImageGrab.grab(xdisplay=os.environ["DISPLAY"]))[..., :3].astype(int)


class ClientMessage(ctypes.Structure):
    """XClientMessageEvent, padded to the size of all events."""

    _fields_ = (
        ("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("sent", ctypes.c_int),
        ("display", ctypes.c_void_p), ("window", ctypes.c_ulong), ("kind", ctypes.c_ulong),
        ("format", ctypes.c_int), ("data", ctypes.c_long * 5), ("room", ctypes.c_long * 12),
    )  # fmt: skip


def press_close_button(*windows: int) -> None:
    """Ask X11 windows to close, as window managers do for a close button or Alt+F4."""
    x = ctypes.CDLL("libX11.so.6")
    x.XOpenDisplay.restype = ctypes.c_void_p
    x.XInternAtom.restype = ctypes.c_ulong
    display = ctypes.c_void_p(x.XOpenDisplay(None))
    kind, close = (
        x.XInternAtom(display, name, False) for name in (b"WM_PROTOCOLS", b"WM_DELETE_WINDOW")
    )
    for number in windows:
        event = ClientMessage(type=33, window=number, kind=kind, format=32)
        event.data[0] = close
        x.XSendEvent(display, ctypes.c_ulong(number), False, 0, ctypes.byref(event))
    x.XCloseDisplay(display)


class InputDevices:
    """Mouse and keyboard of a display: one xdotool, as a new one takes 20 ms."""

    COMMANDS = ("key", "keydown", "keyup", "type", "click", "mousedown", "mouseup", "mousemove",
                "mousemove_relative")  # fmt: skip
    WHERE = "X=", "Y=", "SCREEN=", "WINDOW="  # lines of xdotool about the pointer

    def __init__(self, display: str) -> None:
        self._tool = subprocess.Popen(
            ["stdbuf", "-oL", "xdotool", "-"], env=os.environ | {"DISPLAY": display}, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip

    def do(self, *words: object) -> None:
        """Run a command, and return when the display has taken its events."""
        assert self._tool.stdin and self._tool.stdout
        self._tool.stdin.write(shlex.join(map(str, words)) + "\ngetmouselocation --shell\n")
        self._tool.stdin.flush()
        for start in self.WHERE:
            line = self._tool.stdout.readline()
            assert line.startswith(start), f"xdotool {words}: {line}"

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *fault: object) -> None:
        self._tool.communicate()


class User:
    """Moves the mouse and presses keys, and runs the dive's frames meanwhile."""

    devices: InputDevices

    @classmethod
    def do(cls, *words: object) -> str:
        """Run an xdotool command; returns its output when the display has taken it."""
        if words[0] in InputDevices.COMMANDS:
            cls.devices.do(*words)
            return ""
        command = ["xdotool", *map(str, words)]
        done = subprocess.run(command, check=True, timeout=60, stdout=subprocess.PIPE, text=True)
        return done.stdout

    @staticmethod
    def glide(running: Any, seconds: float) -> None:
        """Draw frames of the dive for `seconds` of its own time."""
        for _ in range(round(seconds / FRAME_S)):
            running.frame(FRAME_S)

    @staticmethod
    def until(running: Any, true: Callable[[], object], seconds: float = 60.0) -> None:
        """Draw frames until the display has delivered the events and `true` holds."""
        end = time.monotonic() + seconds
        while not true() and time.monotonic() < end:
            running.frame(FRAME_S)
            time.sleep(0.003)
        assert true()

    @staticmethod
    def double_click(running: Any) -> None:
        """Click twice. Frames are slow here, and imgui measures the pause in seconds."""
        io = imgui.get_io()
        usual = io.mouse_double_click_time, io.mouse_single_click_delay
        io.mouse_double_click_time, io.mouse_single_click_delay = 5.0, 6.0
        User.do("click", "--repeat", 2, "--delay", 60, 1)
        User.glide(running, 1.0)
        io.mouse_double_click_time, io.mouse_single_click_delay = usual

    def point(self, running: Any, x: float, y: float) -> None:
        """Move the pointer, in two steps, to a place given in [-1, 1] from the middle."""
        (left, top), (width, height) = running.window.position, running.window.points
        for share in (0.8, 1.0):
            across, down = left + (1 + share * x) / 2 * width, top + (1 - share * y) / 2 * height
            self.do("mousemove", int(across), int(down))
            self.glide(running, FRAME_S)

    def drag(
        self, running: Any, *places: tuple[int, int], button: int = 1, drop: bool = True,
        hold_s: float = 3 * FRAME_S,
    ) -> None:  # fmt: skip
        """Press a button at the first place on the display, drag to the others, and release."""
        self.do("mousemove", *places[0])
        self.glide(running, 3 * FRAME_S)
        self.do("mousedown", button)
        self.glide(running, 3 * FRAME_S)
        for place in places[1:]:
            self.do("mousemove", *place)
            self.glide(running, hold_s)
        if drop:
            self.do("mouseup", button)
            self.glide(running, 3 * FRAME_S)

    @staticmethod
    def screen(running: Any) -> Any:
        """The window as the display shows it, (h, w, 3)."""
        left, top = running.window.position
        width, height = running.window.size
        return display_pixels()[top : top + height, left : left + width]


@pytest.fixture(scope="module")
def one_context() -> Iterator[None]:
    """One OpenGL context for all that a module draws without a window: each costs 0.5 s."""
    with headless() as context, pytest.MonkeyPatch.context() as patch:
        for module in (benchmark, eye_frames, film):
            patch.setattr(module, "headless", lambda: context)
        yield


@pytest.fixture(scope="module")
def coarse() -> Iterator[str]:
    """Quality for windows whose sea is not examined: far below "low"."""
    make = textures.mipmapped
    least = replace(PRESETS["low"], scale=0.25, detail=0.3, snow=50, shafts=0, shadows=False)

    def largest_only(context: Any, texels: Any, last: int = 0, srgb: bool = False) -> Any:
        return make(context, texels, 0, srgb)

    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(PRESETS, "coarse", least)
        for module in (textures, atlas):  # mipmaps take as long as many pictures
            patch.setattr(module, "mipmapped", largest_only)
        yield "coarse"


@pytest.fixture(scope="session")
def quiet(tmp_path_factory: pytest.TempPathFactory) -> str:
    """File of the peaceful bay with few fishes and bare rocks, which is drawn fast."""
    text = (resource_path("assets/scenarios") / "peaceful.toml").read_text()
    text = re.sub(r"^number = \d+", "number = 2", text, flags=re.MULTILINE)
    text = re.sub(r"^\[\[(reef|seaweed|vent)\]\]\n([^[].*\n|\n)*", "", text, flags=re.MULTILINE)
    path = tmp_path_factory.mktemp("sea") / "quiet.toml"
    path.write_text(text.replace("plankton = 1800", "plankton = 200"))
    return str(path)


@pytest.fixture(scope="session")
def user() -> User:
    """Real events by xdotool, on the display of the module."""
    return User()


class Spots(dict[str, tuple[float, float, float, float]]):
    """The last box of each widget by its label: left, top, right, bottom."""

    WIDGETS = (
        "arrow_button", "button", "checkbox", "collapsing_header", "input_double", "input_int",
        "menu_item", "radio_button", "slider_float", "input_text_with_hint", "selectable",
        "drag_float", "invisible_button", "input_text", "color_edit3", "combo",
    )  # fmt: skip

    def watch(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Record widgets from now on."""
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
        """Point on the display at half the height and a share of the width of a widget."""
        left, top, right, bottom = self[label]
        x, y = running.window.position
        return round(x + left + share * (right - left)), round(y + (top + bottom) / 2)

    def click(self, running: Any, label: str, share: float = 0.5) -> None:
        """Click a widget with the left button."""
        self.drag(running, label, share)

    def drag(self, running: Any, label: str, begin: float, *ends: float) -> None:
        """Drag from one share of a widget's width to others.

        Calls the callbacks of the window as GLFW does, which takes fewer frames than real events.
        The real pointer goes along to the first place: it sends nothing if it does not move.
        """
        User.do("mousemove", *self.place(running, label, begin))
        window, (corner_x, corner_y) = running.window, running.window.position

        def point(share: float) -> None:
            x, y = self.place(running, label, share)
            window._on_pointer(window.handle, x - corner_x, y - corner_y)
            running.frame(FRAME_S)

        point(begin)
        window._on_button(window.handle, glfw.MOUSE_BUTTON_LEFT, glfw.PRESS, 0)
        running.frame(FRAME_S)
        for share in ends:
            point(share)
        window._on_button(window.handle, glfw.MOUSE_BUTTON_LEFT, glfw.RELEASE, 0)
        for _ in range(3):  # a popup has its place in the third
            running.frame(FRAME_S)

    def type(self, running: Any, label: str, text: str) -> None:
        """Replace the text of a field, by the callbacks of the window."""
        User.glide(running, FRAME_S)
        self.click(running, label, 0.1)
        window = running.window

        def key(code: int, *actions: int, modifiers: int = 0) -> None:
            for action in actions or (glfw.PRESS, glfw.RELEASE):
                window._on_key(window.handle, code, 0, action, modifiers)

        key(glfw.KEY_LEFT_CONTROL, glfw.PRESS)
        key(glfw.KEY_A, modifiers=glfw.MOD_CONTROL)
        key(glfw.KEY_LEFT_CONTROL, glfw.RELEASE, modifiers=glfw.MOD_CONTROL)
        for letter in text:
            window._on_character(window.handle, ord(letter))
        key(glfw.KEY_ENTER)
        for _ in range(8):  # a frame handles keys or letters
            running.frame(0.0)


@pytest.fixture
def spots(monkeypatch: pytest.MonkeyPatch) -> Spots:
    """Boxes of the widgets, to click on them."""
    found = Spots()
    found.watch(monkeypatch)
    return found
