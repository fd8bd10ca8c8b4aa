"""Places of panels: those they were dragged to, else those that cover least.

A swimming fish in a panel, turned by the mouse.
"""

import itertools
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
from imgui_bundle import imgui
from msgspec import Meta
from numpy.typing import NDArray

from subsea.base.errors import UserError
from subsea.base.files import replacing
from subsea.dive.ride import ASPECT, EDGE, WIDE
from subsea.dive.settings import settings_path
from subsea.fish.species import Species
from subsea.fish.swimmer import Swimmer
from subsea.rendering.fish.preview import FishPreview, Orbit

Area = tuple[float, float, float, float]  # left, top, width, height
Share = Annotated[float, Meta(ge=0.0, le=1.0)]
Places = dict[str, tuple[Share, Share]]  # upper left corners, in shares of the screen

TITLE = 1.6  # height of a panel's title, in heights of letters
TITLE_WEIGHT = 8.0  # of covering a title against covering the rest of a panel
LONGEST = 1 << 16  # bytes of a file of places
# Expected sizes with all their contents, in heights of letters.
SIZES = {
    "Initialisation": (36.6, 26.7),
    "Placement": (21.5, 26.0),
    "Physics": (25.3, 26.9),
    "Behavior": (25.4, 33.2),
    "Habits": (26.5, 14.8),
    "Control": (23.8, 22.2),
    "Fish view": (25.3, 20.3),
    "Time": (28.2, 7.2),
}
OTHER_SIZE = 26.0, 20.0


def best_place(size: tuple[float, float], room: Area, taken: Sequence[Area], line: float) -> Area:
    """The area in the `room` for a panel that covers least of the `taken` ones.

    It lies at the sides of the room if possible, so that the middle stays free, and titles of
    covered panels stay visible. `line` is the height of letters.
    """
    left, top, width, height = room
    wide, high = min(size[0], width), min(size[1], height)
    columns = {left, left + width - wide}
    rows = {top, top + height - high}
    gap = 0.5 * line
    for x, y, across, down in taken:
        columns |= {x + across + gap, x - gap - wide}
        rows |= {y + down + gap, y - gap - high, y + TITLE * line}
    best, least = (left, top, wide, high), (float("inf"), 0.0, 0.0, 0.0)
    for x, y in itertools.product(columns, rows):
        here = x, y, wide, high
        if not (left <= x <= left + width - wide and top <= y <= top + height - high):
            continue
        covered = sum(
            common(here, one) + TITLE_WEIGHT * common(here, (*one[:3], TITLE * line))
            for one in taken
        )
        cost = covered, min(x - left, left + width - wide - x), y, x
        if cost < least:
            best, least = here, cost
    return best


def common(one: Area, other: Area) -> float:
    """The area that two panels share."""
    (x, y, width, height), (left, top, across, down) = one, other
    shared_x = min(x + width, left + across) - max(x, left)
    shared_y = min(y + height, top + down) - max(y, top)
    return max(shared_x, 0.0) * max(shared_y, 0.0)


def covers(over: Iterable[Area], area: Area) -> bool:
    """True if any of the areas `over` another hides a part of it."""
    return any(common(one, area) > 0.0 for one in over)


def eye_areas(width: float, height: float) -> tuple[Area, Area]:
    """The places of the pictures of both eyes of a ridden fish, on a screen of this size."""
    edge, wide = EDGE * width, WIDE * width
    high = min(wide / ASPECT, height)
    return (edge, edge, wide, high), (width - edge - wide, edge, wide, high)


def places_path() -> Path:
    """The file of the places to which panels were dragged."""
    return settings_path().with_name("panels.json")


def read_places() -> Places:
    """Read the places; none if the file is missing or damaged."""
    with suppress(OSError, msgspec.MsgspecError, UnicodeDecodeError), places_path().open("rb") as f:
        return msgspec.json.decode(f.read(LONGEST), type=Places)
    return {}


def write_places(places: Places) -> None:
    """Write the places; without a writable folder they are forgotten."""
    with suppress(UserError), replacing(places_path()) as part:
        part.write_bytes(msgspec.json.encode(places))


TURN = 0.008  # rad per pointer unit
ZOOM = 1.12  # per step of the wheel
FIRST_ORBIT = Orbit(turn=0.35, tilt=0.12)


class PreviewPanel:
    """A species, its sheet, and how it swims."""

    def __init__(self, context: Any, species: Species, sheet: NDArray[np.uint8]) -> None:
        """Show a species with a sheet, bottom row first."""
        self.orbit = FIRST_ORBIT
        self.swimmer = Swimmer(species)
        self._fish = FishPreview(context, species, sheet)

    def reshape(self, species: Species) -> None:
        """Change the shape, and keep swimming."""
        self.swimmer.reshape(species)
        self._fish.update(species)

    def set_sheet(self, species: Species, sheet: NDArray[np.uint8]) -> None:
        """Show another sheet."""
        self._fish.update(species, sheet)

    def draw(self, size: tuple[float, float], scale: float, elapsed_s: float) -> None:
        """Draw it, `size` in pointer units of `scale` pixels.

        The left button turns the fish, the wheel zooms, a double click resets both.
        """
        size = max(size[0], 1.0), max(size[1], 1.0)
        corner = imgui.get_cursor_screen_pos()
        imgui.invisible_button("preview", size)
        if imgui.is_item_hovered():
            imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
            self.orbit = self.orbit.zoomed(ZOOM ** imgui.get_io().mouse_wheel)
            if imgui.is_mouse_double_clicked(0):
                self.orbit = FIRST_ORBIT
        if imgui.is_item_active():
            moved = imgui.get_io().mouse_delta
            self.orbit = self.orbit.moved(-TURN * moved.x, TURN * moved.y)
        points = self.swimmer.advance(elapsed_s)
        pixels = max(round(size[0] * scale), 1), max(round(size[1] * scale), 1)
        texture = self._fish.draw(points, self.orbit, pixels)
        imgui.get_window_draw_list().add_image_rounded(
            imgui.ImTextureRef(texture.glo), corner, (corner.x + size[0], corner.y + size[1]),
            (0.0, 1.0), (1.0, 0.0), imgui.get_color_u32((1.0, 1.0, 1.0, 1.0)), 4.0,
        )  # fmt: skip

    def release(self) -> None:
        """Free every OpenGL object."""
        self._fish.release()
