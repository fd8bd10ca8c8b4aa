"""Reduce motion sickness: a horizon while pitched, and a vignette in fast turns."""

import math

import numpy as np
from imgui_bundle import imgui

from subsea.base.arrays import Array
from subsea.submarine.vessel import ACCELERATION_CM_S2, YAW_RAD_S
from subsea.ui.gui import INK, colour
from subsea.view.unproject import FrontView

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
    thick = max(0.1 * line, 1.5)
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
