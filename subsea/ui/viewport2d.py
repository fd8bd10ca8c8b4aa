"""A view on something flat, in a panel: moved, zoomed, drawn on, and touched by the pointer."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
from imgui_bundle import imgui
from numpy.typing import ArrayLike

from subsea.core.arrays import Array
from subsea.ui.gui import GLASS, INK, QUIET, colour

Ink = tuple[float, float, float]
Box = tuple[float, float, float, float]  # left, low, right, high in the view's own coordinates

ZOOM = 1.15  # of a step of the wheel
CLOSEST, FARTHEST = 200.0, 0.1  # how much larger and smaller than fitted a view may be
EDGE = 0.04  # left free about what is fitted, share of the room
REACH = 0.6  # so near to a point the pointer is on it, in heights of letters
NOWHERE = (math.nan, math.nan)


class Touch(NamedTuple):
    """What the pointer does to points that can be taken hold of, in this frame."""

    over: int | None = None  # the point that it is on, or holds
    held: int | None = None  # the point that is dragged
    began: bool = False  # it was taken hold of just now ...
    ended: bool = False  # ... or let go of just now: `held` still tells which
    to: tuple[float, float] = NOWHERE  # where it is dragged to: not by a jump to the pointer


class Canvas:
    """A flat view with coordinates of its own: of pixels (y down), or of anything (`up`: y up).

    The wheel zooms about the pointer; the right or the middle button moves the view, and so does
    the left one where what is drawn does not take hold of something. A double click in the empty
    fits all in again.

    In a panel, once a frame::

        with canvas.drawn("side", (width, height)):     # pointer units
            canvas.picture(shown.glo, (0, 0, 800, 600))
            canvas.line(points, MARK)                   # (n, 2) in own coordinates
            touch = canvas.touch("border", points)
            if touch.held is not None:
                points[touch.held] = touch.to
    """

    def __init__(self, box: Box, up: bool = False) -> None:
        """What is between these borders is seen whole at first."""
        self.box, self.up = box, up
        self.scale = 1.0  # pointer units for one of its own
        self.place: tuple[float, float] = 0.0, 0.0  # of the view on the screen, upper left
        self.size: tuple[float, float] = 1.0, 1.0
        self.mouse: tuple[float, float] = NOWHERE  # where the pointer is, in own coordinates
        self.hovered = False  # whether the pointer is on the view and nothing else
        self.clicked = False  # the left button went down in it, and took hold of no point so far
        self._middle = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2
        self._fits = True  # whether it stays fitted whatever its size
        self._held: tuple[str, int] | None = None
        self._off = 0.0, 0.0  # from the pointer to the point that it holds
        self._moves = False

    def fit(self, box: Box | None = None) -> None:
        """Show all that lies between these borders, or those of the beginning."""
        self.box = box or self.box
        self._fits = True

    def follow(self, other: "Canvas") -> None:
        """Be as large as another view, and show the same places across; call it before `drawn`."""
        self.scale, self._middle = other.scale, (other._middle[0], self._middle[1])
        self._fits = False

    @contextmanager
    def drawn(self, name: str, size: tuple[float, float]) -> Iterator["Canvas"]:
        """The view of that size at the present place of a panel; what is drawn stays within."""
        size = max(size[0], 1.0), max(size[1], 1.0)
        corner = imgui.get_cursor_screen_pos()
        self.place, self.size = (corner.x, corner.y), size
        imgui.invisible_button(name, size)
        self.hovered = imgui.is_item_hovered()
        # The wheel is the view's, not that of the panel which it is in.
        if self.hovered:
            imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
        self._look()
        canvas = imgui.get_window_draw_list()
        end = corner.x + size[0], corner.y + size[1]
        canvas.push_clip_rect(corner, end, True)
        canvas.add_rect_filled(corner, end, colour(GLASS, 0.9), 4.0)
        try:
            yield self
        finally:
            self._drag()
            canvas.pop_clip_rect()

    def on_screen(self, points: ArrayLike) -> Array:
        """Where points (..., 2) lie on the screen."""
        middle, sign = np.array(self._middle), np.array([1.0, -1.0 if self.up else 1.0])
        centre = np.array(self.place) + np.array(self.size) / 2
        return np.asarray((np.asarray(points, float) - middle) * (self.scale * sign) + centre)

    def own(self, x: float, y: float) -> tuple[float, float]:
        """The own coordinates of a place on the screen."""
        sign = -1.0 if self.up else 1.0
        return (
            self._middle[0] + (x - self.place[0] - self.size[0] / 2) / self.scale,
            self._middle[1] + sign * (y - self.place[1] - self.size[1] / 2) / self.scale,
        )

    def touch(
        self, name: str, points: ArrayLike, reach: float = REACH, seize: bool = False
    ) -> Touch:
        """Whether the pointer is on one of the points (n, 2) called `name`, and drags it.

        The nearest counts, within `reach` heights of letters, or wherever it is to `seize` one.
        Of several sets that lie close to one another the first to ask is served.
        """
        points = np.asarray(points, float).reshape(-1, 2)
        if self._held is not None:
            who, which = self._held
            if who != name or which >= len(points):
                return Touch()
            to = self.mouse[0] + self._off[0], self.mouse[1] + self._off[1]
            ended = not imgui.is_mouse_down(0)
            if ended:
                self._held = None
            return Touch(which, which, False, ended, to)
        if not self.hovered or not len(points):
            return Touch()
        pointer = imgui.get_mouse_pos()
        far = np.hypot(*(self.on_screen(points) - (pointer.x, pointer.y)).T)
        far = np.where(np.isfinite(far), far, np.inf)
        nearest = int(far.argmin())
        if far[nearest] > reach * imgui.get_font_size() and not seize:
            return Touch()
        if not self.clicked:
            return Touch(nearest)
        self.clicked = False
        x, y = (float(c) for c in points[nearest])
        self._held, self._off = (name, nearest), (x - self.mouse[0], y - self.mouse[1])
        return Touch(nearest, nearest, True, False, (x, y))

    def picture(self, glo: int, box: Box, alpha: float = 1.0) -> None:
        """A texture, its first row at the top of the box on the screen."""
        (left, low), (right, high) = self.on_screen([box[:2], box[2:]]).tolist()
        top, bottom = min(low, high), max(low, high)
        imgui.get_window_draw_list().add_image(
            imgui.ImTextureRef(glo), (left, top), (right, bottom), (0.0, 0.0), (1.0, 1.0),
            colour((1.0, 1.0, 1.0), alpha),
        )  # fmt: skip

    def line(
        self, points: ArrayLike, ink: Ink, wide: float = 1.5, alpha: float = 1.0,
        closed: bool = False,
    ) -> None:  # fmt: skip
        """A line through points (n, 2); `wide` in pointer units."""
        places: list[Any] = [imgui.ImVec2(x, y) for x, y in self.on_screen(points).tolist()]
        if closed:
            places += places[:1]
        imgui.get_window_draw_list().add_polyline(places, colour(ink, alpha), wide, 0)

    def area(self, points: ArrayLike, ink: Ink, alpha: float = 1.0) -> None:
        """What lies within an outline (n, 2), which may be hollow but not cross itself."""
        places: list[Any] = [imgui.ImVec2(x, y) for x, y in self.on_screen(points).tolist()]
        imgui.get_window_draw_list().add_concave_poly_filled(places, colour(ink, alpha))

    def dots(
        self, points: ArrayLike, ink: Ink, radius: float = 3.0, alpha: float = 1.0,
        ring: bool = False,
    ) -> None:  # fmt: skip
        """Points (n, 2), `radius` in pointer units; with `ring` hollow ones."""
        canvas, tint = imgui.get_window_draw_list(), colour(ink, alpha)
        for place in self.on_screen(np.asarray(points, float).reshape(-1, 2)).tolist():
            if ring:
                canvas.add_circle(place, radius, tint, 0, max(0.4 * radius, 1.2))
            else:
                canvas.add_circle_filled(place, radius, tint)

    def text(
        self, place: ArrayLike, words: str, ink: Ink = QUIET, share: tuple[float, float] = (0, 0)
    ) -> None:
        """Words at a place; `share` of their width and height lies left of and above it."""
        (x, y), box = self.on_screen(place).tolist(), imgui.calc_text_size(words)
        at = x - share[0] * box.x, y - share[1] * box.y
        canvas = imgui.get_window_draw_list()
        canvas.add_text((at[0] + 1.0, at[1] + 1.0), colour(GLASS, 0.9), words)
        canvas.add_text(at, colour(ink), words)

    def caption(self, words: str, ink: Ink = INK) -> None:
        """Words in the view's upper left corner."""
        gap = 0.4 * imgui.get_font_size()
        self.text(self.own(self.place[0] + gap, self.place[1] + gap), words, ink)

    def grid(self, ink: Ink = QUIET, alpha: float = 0.14) -> None:
        """Lines at round numbers of its own units, about as far apart as five letters are high."""
        step = 5.0 * imgui.get_font_size() / self.scale
        step = next(
            round_step
            for power in (10.0 ** math.floor(math.log10(step)),)
            for round_step in (power, 2.0 * power, 5.0 * power, 10.0 * power)
            if round_step >= step
        )
        (x0, y0), (x1, y1) = (
            self.own(*self.place),
            self.own(self.place[0] + self.size[0], self.place[1] + self.size[1]),
        )
        low, high = min(y0, y1), max(y0, y1)
        for x in np.arange(math.ceil(x0 / step), math.floor(x1 / step) + 1) * step:
            self.line([(x, low), (x, high)], ink, 1.0, alpha)
        for y in np.arange(math.ceil(low / step), math.floor(high / step) + 1) * step:
            self.line([(x0, y), (x1, y)], ink, 1.0, alpha)

    def _look(self) -> None:
        """Fit, zoom, and where the pointer is then."""
        left, low, right, high = self.box
        room = [(1.0 - 2.0 * EDGE) * length for length in self.size]
        fitted = max(min(room[0] / max(right - left, 1e-9), room[1] / max(high - low, 1e-9)), 1e-9)
        if self._fits:
            self.scale, self._middle = fitted, ((left + right) / 2, (low + high) / 2)
        io, pointer = imgui.get_io(), imgui.get_mouse_pos()
        if self.hovered and io.mouse_wheel:
            before = self.own(pointer.x, pointer.y)
            zoomed = self.scale * ZOOM**io.mouse_wheel
            self.scale = min(max(zoomed, FARTHEST * fitted), CLOSEST * fitted)
            after = self.own(pointer.x, pointer.y)
            self._middle = tuple(  # type: ignore[assignment]
                m + b - a for m, b, a in zip(self._middle, before, after, strict=True)
            )
            self._fits = False
        there = imgui.is_mouse_pos_valid()
        self.mouse = self.own(pointer.x, pointer.y) if there else self.mouse
        self.clicked = self.hovered and imgui.is_mouse_clicked(0)

    def _drag(self) -> None:
        """The hand that holds nothing moves the view."""
        if self.hovered and (
            imgui.is_mouse_clicked(1) or imgui.is_mouse_clicked(2) or self.clicked
        ):
            self._moves = True
            if self.clicked and imgui.is_mouse_double_clicked(0):
                self.fit()
        down = any(imgui.is_mouse_down(button) for button in range(3))
        self._moves = self._moves and down and self._held is None
        moved = imgui.get_io().mouse_delta
        if self._moves and (moved.x or moved.y):
            sign = -1.0 if self.up else 1.0
            self._middle = (
                self._middle[0] - moved.x / self.scale,
                self._middle[1] - sign * moved.y / self.scale,
            )
            self._fits = False
        if self._held is not None and not imgui.is_mouse_down(0):
            self._held = None  # whose points were not asked for
