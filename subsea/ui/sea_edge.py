"""A sign at the edge of the sea, where the submarine comes to rest: the way back."""

import math
from typing import NamedTuple

from imgui_bundle import imgui

from subsea.base.language import translated
from subsea.scenario.schema import Bounds
from subsea.state import Submarine
from subsea.submarine.vessel import CLEARANCE_CM
from subsea.ui.gui import INK, MARK, colour, draw_backing, draw_shadowed_text

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
    half = 0.5 * large / line * max(imgui.calc_text_size(one).x for one in (text, way)) + 0.3 * line
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
