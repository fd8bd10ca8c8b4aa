"""The display, its monitors, and the placement of windows on them."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import glfw

from subsea.base.errors import TransientError
from subsea.sound.space import Layout
from subsea.view.rig import CameraRig

FILM = "`subsea film dive.mp4` makes a film"  # the alternative without a display
PLATFORMS = {
    glfw.PLATFORM_X11: "X11",
    glfw.PLATFORM_WAYLAND: "Wayland",
    glfw.PLATFORM_COCOA: "macOS",
    glfw.PLATFORM_WIN32: "Windows",
}


class Screen(NamedTuple):
    """Placement of a window: a monitor to fill, else a position, else by the desktop."""

    name: str
    size: tuple[int, int]  # pixels
    position: tuple[int, int] | None = None  # upper left corner, pixels of the desktop
    monitor: str | int | None = None  # by its name, or its number from 1

    @property
    def fixed(self) -> bool:
        """True if its place is given: then it has no border, and stays there."""
        return self.position is not None or self.monitor is not None


class Installation(NamedTuple):
    """A fixed rig, with one window for each of its outputs."""

    rig: CameraRig
    screens: Sequence[Screen]
    source: str = ""  # the file that defines them
    loudspeakers: Layout | None = None  # instead of those of the settings
    in_front: bool = True  # False: other computers show what is ahead of the audience


class Monitor(NamedTuple):
    """A connected monitor."""

    number: int  # from 1, the primary one
    name: str
    position: tuple[int, int]  # of its upper left corner on the desktop
    size: tuple[int, int]  # pixels
    rate: int  # Hz, 0 if unknown
    handle: Any = None

    def __str__(self) -> str:
        """Number, name and size, as in a theatre file."""
        return f"{self.number} {self.name!r} {self.size[0]}x{self.size[1]}"


class DesktopDisplay(NamedTuple):
    """The display that windows open on."""

    platform: str  # "X11", "Wayland", …
    monitors: list[Monitor]


@contextmanager
def on_display(without: str = FILM) -> Iterator[DesktopDisplay]:
    """Start the window library, and stop it in the end.

    A TransientError without a display, with the alternative `without` one.
    """
    glfw.ERROR_REPORTING = "exception"
    try:
        if not glfw.init():
            raise glfw.GLFWError("the window library cannot start")
    except glfw.GLFWError as fault:
        raise TransientError(
            f"no display to open a window on ({reason(fault)}); without one, {without}"
        ) from fault
    try:
        yield DesktopDisplay(PLATFORMS.get(glfw.get_platform(), "unknown"), monitors())
    finally:
        glfw.terminate()


def prefer_x11() -> None:
    """Open windows by X11 from now on: OpenXR has no binding for the contexts of Wayland."""
    glfw.init_hint(glfw.PLATFORM, glfw.PLATFORM_X11)


def monitors() -> list[Monitor]:
    """The monitors of the open display."""
    connected = []
    for number, handle in enumerate(glfw.get_monitors(), start=1):
        mode = glfw.get_video_mode(handle)
        name = monitor_name(handle)
        size = mode.size.width, mode.size.height
        left, top = glfw.get_monitor_pos(handle)
        connected.append(Monitor(number, name, (left, top), size, mode.refresh_rate, handle))
    return connected


def monitor_name(handle: Any) -> str:
    """The name of a monitor."""
    name: Any = glfw.get_monitor_name(handle)
    return name.decode("utf-8", "replace") if isinstance(name, bytes) else str(name)


def placed(
    screens: Sequence[Screen],
    connected: Sequence[Monitor],
    source: str = "",
    warn: Callable[[str], None] = lambda message: None,
) -> list[tuple[int, Monitor | None]]:
    """Indices of the screens that can be shown, with the monitors that they ask for.

    Screens whose monitor is missing or taken are reported and left out; a TransientError if none is
    left.
    """
    found: list[tuple[int, Monitor | None]] = []
    faults = []
    taken: dict[int, str] = {}  # windows by the numbers of their monitors
    for number, screen in enumerate(screens):
        if screen.monitor is None:
            found.append((number, None))
            continue
        fits = [m for m in connected if screen.monitor in (m.number, m.name)]
        window = f"{source}: window '{screen.name}'" if source else f"window '{screen.name}'"
        if len(fits) == 1 and fits[0].number in taken:
            faults.append(f"{window}: monitor {fits[0]} has window '{taken[fits[0].number]}'")
        elif len(fits) == 1:
            taken[fits[0].number] = screen.name
            found.append((number, fits[0]))
            if fits[0].size != tuple(screen.size):
                width, height = screen.size
                warn(f"{window}: its {width}x{height} pixels are stretched over monitor {fits[0]}")
        elif fits:
            number_one = f"{len(fits)} monitors are called {screen.monitor!r}, take a number"
            faults.append(f"{window}: {number_one}; there are: {_list(connected)}")
        else:
            faults.append(f"{window}: no monitor {screen.monitor!r}; there are: {_list(connected)}")
    if not found:
        raise TransientError(faults[0])
    for fault in faults:
        warn(f"{fault}; this window is left out")
    return found


def reason(fault: Exception) -> str:
    """The window library's error text, without its number, quotes and final stop."""
    text = str(fault)
    words = text.partition(") ")[2] or text
    return words.removeprefix("b").strip("'\"").rstrip(".")


def _list(connected: Sequence[Monitor]) -> str:
    return ", ".join(map(str, connected)) or "none"
