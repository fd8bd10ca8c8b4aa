"""Instruments and signs over the picture.

Compass, depth and speed at its foot fade while unchanged. At the edge of the sea a sign shows the
way back. A horizon while pitched, and a vignette in fast turns, reduce motion sickness.
"""

import math
from itertools import pairwise
from typing import Any, Literal, NamedTuple

import numpy as np
from imgui_bundle import imgui

from subsea.base.arrays import Array
from subsea.base.language import marked, translated
from subsea.scenario.schema import Bounds
from subsea.state import Submarine
from subsea.submarine.vessel import (
    ACCELERATION_CM_S2,
    AHEAD_CM_S,
    ASTERN_CM_S,
    CLEARANCE_CM,
    YAW_RAD_S,
    hull_axes,
)
from subsea.ui.gui import (
    INK,
    MARK,
    QUIET,
    SHADE,
    colour,
    draw_backing,
    draw_shadowed_text,
    ground,
    look,
    stroke,
)
from subsea.view.front_screen import FrontView

STILL_S = 6.0  # they fade after this time without change
HUD_FADE_S, SHOW_S = 1.5, 0.3
TAPE = 15.0  # width of the compass, in heights of letters
SPAN_DEG = 60.0  # range of the compass to either side
BAR = 5.5  # length of the speed bar
HIGH = 4.4  # height of all instruments
BESIDE = 9.7  # width of the instrument at either side of the compass
GAP = 1.6  # between the compass and the instruments at its sides
POINTS = {0: marked("N"), 90: marked("E"), 180: marked("S"), 270: marked("W")}

Mode = Literal["as needed", "always", "never"]
MODES: tuple[Mode, ...] = (marked("as needed"), marked("always"), marked("never"))


class Reading(NamedTuple):
    """Values of the instruments."""

    depth_m: float
    heading_deg: float  # by the compass: clockwise from the x axis of the world, [0, 360)
    ahead_m_s: float
    set_share: float  # speed set by the wheel, share of full thrust
    stopping: bool

    def differs(self, other: "Reading") -> bool:
        """True if the difference is visible."""
        turned = abs(math.remainder(self.heading_deg - other.heading_deg, 360.0))
        return (
            abs(self.depth_m - other.depth_m) > 0.15
            or turned > 3.0
            or abs(self.ahead_m_s - other.ahead_m_s) > 0.08
            or (self.set_share, self.stopping) != (other.set_share, other.stopping)
        )


def instrument_reading(submarine: Submarine, throttle: float, stopping: bool) -> Reading:
    """The instruments of a submarine with the speed `throttle` set by the wheel."""
    heading, pitch = submarine.angles
    ahead = float(submarine.velocity @ hull_axes(heading, pitch)[0])
    compass = -math.degrees(heading) % 360.0
    return Reading(-submarine.position[2] / 100.0, compass, ahead / 100.0, throttle, stopping)


class Hud:
    """Draws the instruments, and fades them in and out."""

    def __init__(self) -> None:
        self.mode: Mode = "as needed"
        self.opacity = 1.0
        self._noted: Reading | None = None
        self._still_s = 0.0

    def cycle(self) -> Mode:
        """Set the next of `MODES`, cyclically."""
        self.mode = MODES[(MODES.index(self.mode) + 1) % len(MODES)]
        self._still_s = 0.0
        return self.mode

    def update(self, now: Reading, dt: float, wanted: bool = True) -> None:
        """Fade in or out, `dt` seconds after the last call; hide unless `wanted`."""
        self._still_s += dt
        if self._noted is None or now.differs(self._noted):
            self._noted, self._still_s = now, 0.0
        needed = self.mode == "always" or self._still_s < STILL_S
        shown = wanted and needed and self.mode != "never"
        step = dt / SHOW_S if shown else -dt / HUD_FADE_S
        self.opacity = min(max(self.opacity + step, 0.0), 1.0)

    def draw(self, now: Reading) -> None:
        """Draw them in the current frame of the gui."""
        if self.opacity == 0.0:
            return
        size, line, wide = imgui.get_io().display_size, imgui.get_font_size(), _tape()
        canvas = imgui.get_background_draw_list()
        middle, foot = size.x / 2, size.y - 1.1 * line
        _backing(canvas, middle, wide, size, self.opacity)
        _compass(canvas, middle, foot, wide, now.heading_deg, self.opacity)
        gap = wide / 2 + GAP * line
        _depth(canvas, middle - gap, foot, now.depth_m, self.opacity)
        _speed(canvas, middle + gap, foot, now, self.opacity)


def instruments_area() -> tuple[float, float, float, float]:
    """Left, top, width and height of all instruments in the current frame."""
    size, line = imgui.get_io().display_size, imgui.get_font_size()
    wide = _tape() + 2.0 * (GAP + BESIDE) * line
    return (size.x - wide) / 2, size.y - (1.1 + HIGH) * line, wide, HIGH * line


def _tape() -> float:
    """The width of the compass."""
    return min(TAPE * imgui.get_font_size(), 0.42 * float(imgui.get_io().display_size.x))


def _backing(canvas: Any, middle: float, wide: float, size: Any, opacity: float) -> None:
    """Draw a soft shade under the instruments, darkest at the foot of the middle."""
    line = imgui.get_font_size()
    if look().contrast:
        reach = wide / 2 + (BAR + 4.5) * line
        low, high = (middle - reach, size.y - HIGH * line), (middle + reach, size.y)
        canvas.add_rect_filled(low, high, colour(SHADE, opacity), 0.35 * line)
        return
    clear, shade = colour(SHADE, 0.0), colour(SHADE, 0.6 * opacity)
    top, reach = size.y - 1.5 * HIGH * line, wide / 2 + (BAR + 9.0) * line
    white = imgui.get_font_tex_uv_white_pixel()
    foot = middle, size.y
    arc = [
        (
            middle - reach * math.cos(k * math.pi / 24),
            size.y - (size.y - top) * math.sin(k * math.pi / 24),
        )
        for k in range(25)
    ]
    canvas.prim_reserve(72, 72)
    for begin, end in pairwise(arc):
        for place, tint in ((foot, shade), (begin, clear), (end, clear)):
            canvas.prim_vtx(place, white, tint)


def _compass(
    canvas: Any, x: float, foot: float, wide: float, heading: float, opacity: float
) -> None:
    """Draw a tape of headings that moves under a mark."""
    line = imgui.get_font_size()
    high = foot - 1.25 * line
    first = math.ceil((heading - SPAN_DEG) / 10.0) * 10
    for mark in range(first, first + int(2 * SPAN_DEG), 10):
        off = (mark - heading) / SPAN_DEG
        if abs(off) > 1.0:
            continue
        shown = opacity * (1.0 - off**4)
        at, large = x + off * wide / 2, mark % 30 == 0
        top = high - (0.55 if large else 0.3) * line
        canvas.add_line((at + 1, top + 1), (at + 1, high + 1), colour(SHADE, shown), 2.0)
        tint = colour(INK, (1.0 if large else ground(0.7)) * shown)
        canvas.add_line((at, top), (at, high), tint, stroke(max(0.09 * line, 1.0)))
        if large:
            name = POINTS.get(mark % 360)
            rgb = MARK if name == "N" else INK
            text = translated(name) if name else f"{mark % 360}"
            draw_shadowed_text((at, high + 0.15 * line), text, 0.85 * line, rgb, shown, 0.5)
    tip = high - 0.75 * line
    points = (x - 0.32 * line, tip - 0.42 * line), (x + 0.32 * line, tip - 0.42 * line), (x, tip)
    canvas.add_triangle_filled(*points, colour(MARK, opacity))
    number = f"{round(heading) % 360:03d}°"
    draw_shadowed_text((x, tip - 1.65 * line), number, 1.15 * line, INK, opacity, 0.5)


def _depth(canvas: Any, right: float, foot: float, depth_m: float, opacity: float) -> None:
    line = imgui.get_font_size()
    draw_shadowed_text(
        (right, foot - 2.35 * line), f"{depth_m:.1f} m", 1.45 * line, INK, opacity, 1.0
    )
    draw_shadowed_text(
        (right, foot - 0.75 * line), translated("depth"), 0.85 * line, INK, opacity, 1.0
    )


def _speed(canvas: Any, left: float, foot: float, now: Reading, opacity: float) -> None:
    """Draw the speed in figures and as a bar from astern to ahead; a mark shows the set speed."""
    line = imgui.get_font_size()
    figures = f"{abs(now.ahead_m_s):.1f} m/s"
    draw_shadowed_text((left, foot - 2.35 * line), figures, 1.45 * line, INK, opacity, 0.0)
    way = 0.0 if abs(now.ahead_m_s) <= 0.05 else now.ahead_m_s
    moving = marked("ahead") if way > 0.0 else marked("astern") if way else marked("speed")
    words = translated(marked("full stop") if now.stopping else moving)
    draw_shadowed_text((left, foot - 0.75 * line), words, 0.85 * line, INK, opacity, 0.0)
    slow, fast = -ASTERN_CM_S / 100.0, AHEAD_CM_S / 100.0
    begin, y = left + 4.2 * line, foot - 0.32 * line

    def at(speed: float) -> float:
        share = (min(max(speed, slow), fast) - slow) / (fast - slow)
        return begin + share * (BAR - 2.2) * line

    thick = max(0.16 * line, 2.0)
    canvas.add_line((at(slow), y), (at(fast), y), colour(QUIET, ground(0.35) * opacity), thick)
    canvas.add_line((at(0.0), y), (at(now.ahead_m_s), y), colour(MARK, opacity), 1.6 * thick)
    zero = at(0.0)
    canvas.add_line(
        (zero, y - 0.25 * line), (zero, y + 0.25 * line), colour(INK, 0.8 * opacity), stroke(1.5)
    )
    if now.set_share:
        mark = at(now.set_share * (fast if now.set_share > 0.0 else -slow))
        tip = y - 0.2 * line
        points = (mark - 0.22 * line, tip - 0.4 * line), (mark + 0.22 * line, tip - 0.4 * line)
        canvas.add_triangle_filled(*points, (mark, tip), colour(INK, opacity))


SIGN_FAR_CM, SIGN_NEAR_CM = 110.0, 50.0  # from where it rests: the sign begins to show; shows fully
TOP = 0.2  # its upper edge, share of the picture's height ...
BELOW = 6.3  # ... and below the lines for a new visitor, in heights of letters


class EdgeReading(NamedTuple):
    """The sign: its opacity, and the way back."""

    opacity: float  # in [0, 1]
    turn: float  # rad in [-pi, pi], from the nose to the middle of the sea; left positive
    compass_deg: float  # by the compass of the instruments, [0, 360)


def edge_reading(submarine: Submarine, bounds: Bounds) -> EdgeReading:
    """The sign for a submarine in the sea of these bounds."""
    x, y = submarine.position[:2]
    left_cm = bounds.radius_cm - CLEARANCE_CM - math.hypot(x, y)
    opacity = min(max((SIGN_FAR_CM - left_cm) / (SIGN_FAR_CM - SIGN_NEAR_CM), 0.0), 1.0)
    back = math.atan2(-y, -x)
    turn = math.remainder(back - submarine.angles[0], math.tau)
    return EdgeReading(opacity, turn, -math.degrees(back) % 360.0)


def draw_sea_edge(edge: EdgeReading) -> None:
    """Draw it in the current frame: an arrow up is ahead, an arrow down behind."""
    if edge.opacity == 0.0:
        return
    size, line = imgui.get_io().display_size, imgui.get_font_size()
    text = translated("The open sea begins here")
    way = translated("back this way: {degrees}°")
    way = way.format(degrees=f"{round(edge.compass_deg) % 360:03d}")
    large, top, middle = 1.2 * line, max(TOP * size.y, BELOW * line), size.x / 2
    half = (
        0.5 * large / line * max(imgui.calc_text_size(words).x for words in (text, way))
        + 0.3 * line
    )
    draw_backing((middle - half, top), (middle + half, top + 4.9 * line), line, edge.opacity)
    draw_shadowed_text((middle, top + 0.1 * line), text, large, INK, edge.opacity, 0.5)
    # The way back on the screen: x right, y down.
    ahead = -math.sin(edge.turn), -math.cos(edge.turn)
    across = ahead[1], -ahead[0]
    hub = middle, top + 2.45 * line
    points = [
        (
            hub[0] + line * (along * ahead[0] + aside * across[0]),
            hub[1] + line * (along * ahead[1] + aside * across[1]),
        )
        for along, aside in ((0.9, 0.0), (-0.6, 0.6), (-0.25, 0.0), (-0.6, -0.6))
    ]
    canvas, tint = imgui.get_background_draw_list(), colour(MARK, edge.opacity)
    canvas.add_triangle_filled(points[0], points[1], points[2], tint)
    canvas.add_triangle_filled(points[0], points[2], points[3], tint)
    draw_shadowed_text((middle, top + 3.7 * line), way, line, INK, edge.opacity, 0.5)


TILTED, STEEP = math.radians(4.0), math.radians(12.0)  # pitch: horizon starts to show; shows fully
SHOWN = 0.55  # its full opacity
FAR_CM = 1e6
ASIDE = math.radians(8.0)  # from straight ahead, where its height is computed
PARTS = ((0.30, 0.44), (0.56, 0.70))  # shares of the width that it covers: the middle stays free
EASE_S = 0.4
FEW, SEGMENTS = 0.35, 48  # share of the fastest turn without darkening; rim segments
DARK = (0.0, 0.03, 0.05)


def draw_horizon(front_view: FrontView, forward: Array) -> None:
    """Draw the water's horizon on the screen ahead, if the observer is pitched.

    `forward` (3,) is the observer's unit direction: the middle of the screen may be above or below.
    """
    pitch = math.asin(float(np.clip(forward[2], -1.0, 1.0)))
    share = (abs(pitch) - TILTED) / (STEEP - TILTED)
    if share <= 0.0:
        return
    eye, way = front_view.ray(0.5, 0.5)
    heading = math.atan2(way[1], way[0])
    turns = heading + np.array([ASIDE, -ASIDE])
    level = np.stack([np.cos(turns), np.sin(turns), np.zeros(2)], axis=1)
    (x0, y0), (x1, y1) = front_view.places(eye + FAR_CM * level)
    if not np.isfinite([x0, y0, x1, y1]).all() or abs(x1 - x0) < 1e-6:
        return
    size, line = imgui.get_io().display_size, imgui.get_font_size()
    canvas, tint = imgui.get_background_draw_list(), colour(INK, SHOWN * min(share, 1.0))
    slope = (y1 - y0) / (x1 - x0)
    thick = stroke(max(0.1 * line, 1.5))
    for begin, end in PARTS:
        ends = [(x * size.x, (y0 + slope * (x - x0)) * size.y) for x in (begin, end)]
        if all(0.0 < y < size.y for _, y in ends):
            canvas.add_line(ends[0], ends[1], tint, thick)
            x, y = ends[1] if begin < 0.5 else ends[0]
            canvas.add_line(
                (x, y), (x, y + 0.5 * line), tint, thick
            )  # the ends point to the seabed


class Vignette:
    """A darker rim while the submarine turns or accelerates fast."""

    def __init__(self, most: float) -> None:
        """`most` in [0, 1] is the largest opacity, from the settings."""
        self.most, self.amount = most, 0.0
        self._velocity = np.zeros(3)

    def update(self, rates: np.ndarray, velocity: np.ndarray, dt: float) -> None:
        """Adapt to rates, rad/s, and velocity (3,), cm/s, of the hull `dt` seconds later."""
        if dt <= 0.0:
            return
        faster = float(np.linalg.norm(velocity - self._velocity)) / dt / ACCELERATION_CM_S2
        self._velocity = np.array(velocity)
        moved = max(float(np.abs(rates).max()) / YAW_RAD_S, faster)
        wanted = min(max(moved - FEW, 0.0) / (1.0 - FEW), 1.0)
        self.amount += (1.0 - math.exp(-dt / EASE_S)) * (wanted - self.amount)

    @property
    def opacity(self) -> float:
        """The opacity of the rim, in [0, 1]."""
        return self.most * self.amount

    def draw(self) -> None:
        """Draw it in the current frame."""
        shown = self.opacity
        if shown < 0.01:
            return
        size = imgui.get_io().display_size
        canvas, white = imgui.get_background_draw_list(), imgui.get_font_tex_uv_white_pixel()
        clear, dark = colour(DARK, 0.0), colour(DARK, min(shown, 1.0))
        angles = np.linspace(0.0, math.tau, SEGMENTS + 1)
        round_ = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        middle = np.array([size.x, size.y]) / 2
        # The inner half stays clear; the corners are beyond the outer rim.
        rims = [(middle + share * middle * round_).tolist() for share in (0.5, 1.15, 2.0)]
        tints = (clear, dark, dark)
        canvas.prim_reserve(12 * SEGMENTS, 12 * SEGMENTS)
        for inner, outer, near, far in zip(rims, rims[1:], tints, tints[1:], strict=False):
            for k in range(SEGMENTS):
                for place, tint in (
                    (inner[k], near), (outer[k], far), (outer[k + 1], far),
                    (inner[k], near), (outer[k + 1], far), (inner[k + 1], near),
                ):  # fmt: skip
                    canvas.prim_vtx(place, white, tint)
