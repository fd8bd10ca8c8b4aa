"""A 2D view in a panel: pan, zoom, draw, drag points."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
from imgui_bundle import imgui
from numpy.typing import ArrayLike

from subsea.base.arrays import Array
from subsea.ui.gui import GLASS, INK, QUIET, Rgb, colour

Box = tuple[float, float, float, float]  # left, low, right, high in the coordinates of the view

ZOOM = 1.15  # per step of the wheel
MOST_ZOOM, LEAST_ZOOM = 200.0, 0.1  # limits, relative to the fitted view
MARGIN = 0.04  # around the fitted box, share of the view
REACH = 0.6  # distance at which the pointer picks a point, text heights
GRID = 0.14  # alpha of the lines of the grid
NOWHERE = (math.nan, math.nan)


class PointDrag(NamedTuple):
    """Actions of the pointer on points in this frame."""

    hovered: int | None = None  # the point under the pointer, or dragged
    dragged: int | None = None  # still set in the frame in which the drag ends
    began: bool = False  # the drag began in this frame
    ended: bool = False
    to: tuple[float, float] = NOWHERE  # the place of the dragged point


class Viewport2D:
    """A view with its own coordinates: y down as in pictures, or up.

    The wheel zooms about the pointer. The right or middle button pans, and so does the left one
    where no point is dragged. A double click beside points fits the view again. Draw within
    `with view.drawn(...)`, once a frame.
    """

    def __init__(self, box: Box, up: bool = False) -> None:
        self.box, self.up = box, up
        self.scale = 1.0  # pointer units per unit of the view
        self.place: tuple[float, float] = 0.0, 0.0  # upper left corner on the screen
        self.size: tuple[float, float] = 1.0, 1.0
        self.mouse: tuple[float, float] = NOWHERE  # the pointer, in coordinates of the view
        self.hovered = False  # the pointer is on the view and nothing else
        self.clicked = False  # the left button was pressed beside all points so far
        self._middle = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2
        self._fits = True  # stays fitted when its size changes
        self._dragged: tuple[str, int] | None = None
        self._offset = 0.0, 0.0  # from the pointer to the dragged point
        self._panning = False

    def fit(self, box: Box | None = None) -> None:
        """Show a box, or the first one, whole."""
        self.box = box or self.box
        self._fits = True

    def follow(self, other: "Viewport2D") -> None:
        """Take over scale and horizontal place of another view; call it before `drawn`."""
        level = (self.box[1] + self.box[3]) / 2 if self._fits else self._middle[1]
        self.scale, self._middle = other.scale, (other._middle[0], level)
        self._fits = False

    @contextmanager
    def drawn(self, name: str, size: tuple[float, float]) -> Iterator["Viewport2D"]:
        """Begin the view at the cursor of the panel; drawing is clipped to it."""
        size = max(size[0], 1.0), max(size[1], 1.0)
        corner = imgui.get_cursor_screen_pos()
        self.place, self.size = (corner.x, corner.y), size
        imgui.invisible_button(name, size)
        self.hovered = imgui.is_item_hovered()
        # The wheel zooms instead of scrolling the panel.
        if self.hovered:
            imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
        self._zoom()
        canvas = imgui.get_window_draw_list()
        end = corner.x + size[0], corner.y + size[1]
        canvas.push_clip_rect(corner, end, True)
        canvas.add_rect_filled(corner, end, colour(GLASS, 0.9), 4.0)
        try:
            yield self
        finally:
            self._pan()
            canvas.pop_clip_rect()

    def on_screen(self, points: ArrayLike) -> Array:
        """Convert points (..., 2) to the screen."""
        middle, sign = np.array(self._middle), np.array([1.0, -1.0 if self.up else 1.0])
        centre = np.array(self.place) + np.array(self.size) / 2
        return np.asarray((np.asarray(points, float) - middle) * (self.scale * sign) + centre)

    def from_screen(self, x: float, y: float) -> tuple[float, float]:
        """Convert a place on the screen to coordinates of the view."""
        sign = -1.0 if self.up else 1.0
        return (
            self._middle[0] + (x - self.place[0] - self.size[0] / 2) / self.scale,
            self._middle[1] + sign * (y - self.place[1] - self.size[1] / 2) / self.scale,
        )

    def drag_points(
        self, name: str, points: ArrayLike, reach: float = REACH, anywhere: bool = False
    ) -> PointDrag:
        """Hover and drag the nearest of the points (n, 2) of the set `name`.

        It must lie within `reach` text heights of the pointer, unless `anywhere`. The first call
        in a frame takes precedence.
        """
        points = np.asarray(points, float).reshape(-1, 2)
        if self._dragged is not None:
            owner, which = self._dragged
            if owner != name or which >= len(points):
                return PointDrag()
            to = self.mouse[0] + self._offset[0], self.mouse[1] + self._offset[1]
            ended = not imgui.is_mouse_down(0)
            if ended:
                self._dragged = None
            return PointDrag(which, which, False, ended, to)
        if not self.hovered or not len(points):
            return PointDrag()
        pointer = imgui.get_mouse_pos()
        far = np.hypot(*(self.on_screen(points) - (pointer.x, pointer.y)).T)
        far = np.where(np.isfinite(far), far, np.inf)
        nearest = int(far.argmin())
        if far[nearest] > reach * imgui.get_font_size() and not anywhere:
            return PointDrag()
        if not self.clicked:
            return PointDrag(nearest)
        self.clicked = False
        x, y = (float(c) for c in points[nearest])
        self._dragged, self._offset = (name, nearest), (x - self.mouse[0], y - self.mouse[1])
        return PointDrag(nearest, nearest, True, False, (x, y))

    def picture(self, glo: int, box: Box, alpha: float = 1.0) -> None:
        """Draw a texture, its first row at the top of the box."""
        (left, low), (right, high) = self.on_screen([box[:2], box[2:]]).tolist()
        top, bottom = min(low, high), max(low, high)
        imgui.get_window_draw_list().add_image(
            imgui.ImTextureRef(glo), (left, top), (right, bottom), (0.0, 0.0), (1.0, 1.0),
            colour((1.0, 1.0, 1.0), alpha),
        )  # fmt: skip

    def line(
        self, points: ArrayLike, ink: Rgb, wide: float = 1.5, alpha: float = 1.0,
        closed: bool = False,
    ) -> None:  # fmt: skip
        """Draw a line through points (n, 2), `wide` pointer units."""
        places: list[Any] = [imgui.ImVec2(x, y) for x, y in self.on_screen(points).tolist()]
        if closed:
            places += places[:1]
        imgui.get_window_draw_list().add_polyline(places, colour(ink, alpha), wide, 0)

    def polygon(self, points: ArrayLike, ink: Rgb, alpha: float = 1.0) -> None:
        """Fill an outline (n, 2), concave or not, that does not cross itself."""
        places: list[Any] = [imgui.ImVec2(x, y) for x, y in self.on_screen(points).tolist()]
        imgui.get_window_draw_list().add_concave_poly_filled(places, colour(ink, alpha))

    def dots(
        self, points: ArrayLike, ink: Rgb, radius: float = 3.0, alpha: float = 1.0,
        ring: bool = False,
    ) -> None:  # fmt: skip
        """Draw points (n, 2) as discs or rings, `radius` in pointer units."""
        canvas, tint = imgui.get_window_draw_list(), colour(ink, alpha)
        for place in self.on_screen(np.asarray(points, float).reshape(-1, 2)).tolist():
            if ring:
                canvas.add_circle(place, radius, tint, 0, max(0.4 * radius, 1.2))
            else:
                canvas.add_circle_filled(place, radius, tint)

    def caption(self, text: str) -> None:
        """Draw text in the upper left corner."""
        gap, canvas = 0.4 * imgui.get_font_size(), imgui.get_window_draw_list()
        x, y = self.place[0] + gap, self.place[1] + gap
        canvas.add_text((x + 1.0, y + 1.0), colour(GLASS, 0.9), text)
        canvas.add_text((x, y), colour(INK), text)

    def grid(self) -> None:
        """Draw lines at round coordinates, about five text heights apart."""
        least = 5.0 * imgui.get_font_size() / self.scale
        power = 10.0 ** math.floor(math.log10(least))
        step = next(times * power for times in (1.0, 2.0, 5.0, 10.0) if times * power >= least)
        x0, y0 = self.from_screen(*self.place)
        x1, y1 = self.from_screen(self.place[0] + self.size[0], self.place[1] + self.size[1])
        low, high = min(y0, y1), max(y0, y1)
        for x in np.arange(math.ceil(x0 / step), math.floor(x1 / step) + 1) * step:
            self.line([(x, low), (x, high)], QUIET, 1.0, GRID)
        for y in np.arange(math.ceil(low / step), math.floor(high / step) + 1) * step:
            self.line([(x0, y), (x1, y)], QUIET, 1.0, GRID)

    def _zoom(self) -> None:
        """Fit or zoom the view, and locate the pointer."""
        left, low, right, high = self.box
        room = [(1.0 - 2.0 * MARGIN) * length for length in self.size]
        fitted = max(min(room[0] / max(right - left, 1e-9), room[1] / max(high - low, 1e-9)), 1e-9)
        if self._fits:
            self.scale, self._middle = fitted, ((left + right) / 2, (low + high) / 2)
        io, pointer = imgui.get_io(), imgui.get_mouse_pos()
        if self.hovered and io.mouse_wheel:
            before = self.from_screen(pointer.x, pointer.y)
            zoomed = self.scale * ZOOM**io.mouse_wheel
            self.scale = min(max(zoomed, LEAST_ZOOM * fitted), MOST_ZOOM * fitted)
            after = self.from_screen(pointer.x, pointer.y)
            self._middle = tuple(  # type: ignore[assignment]
                m + b - a for m, b, a in zip(self._middle, before, after, strict=True)
            )
            self._fits = False
        there = imgui.is_mouse_pos_valid()
        self.mouse = self.from_screen(pointer.x, pointer.y) if there else self.mouse
        self.clicked = self.hovered and imgui.is_mouse_clicked(0)

    def _pan(self) -> None:
        """Pan when no point is dragged; fit after a double click."""
        pressed = imgui.is_mouse_clicked(1) or imgui.is_mouse_clicked(2) or self.clicked
        if self.hovered and pressed:
            self._panning = True
            if self.clicked and imgui.is_mouse_double_clicked(0):
                self.fit()
        down = any(imgui.is_mouse_down(button) for button in range(3))
        self._panning = self._panning and down and self._dragged is None
        moved = imgui.get_io().mouse_delta
        if self._panning and (moved.x or moved.y):
            sign = -1.0 if self.up else 1.0
            self._middle = (
                self._middle[0] - moved.x / self.scale,
                self._middle[1] - sign * moved.y / self.scale,
            )
            self._fits = False
        if self._dragged is not None and not imgui.is_mouse_down(0):
            self._dragged = None  # its points were not drawn in this frame
