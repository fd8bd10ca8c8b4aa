"""Captions in a window, drawn for each eye on the screen ahead."""

import math

from imgui_bundle import imgui

from subsea.dive.captions import (
    FOOT,
    INK,
    LEADING,
    ROOM,
    SHADE,
    Caption,
    letters_of,
    lines_of,
    room_of,
)
from subsea.ui.gui import colour, draw_backing
from subsea.view.rig import CameraRig

CLEAR = 7.4  # distance of captions from the lower edge, in heights of letters: above notes
SOFT = tuple(
    (reach * math.cos(k * math.tau / 12), reach * math.sin(k * math.tau / 12), alpha)
    for reach, alpha in ((0.16, 0.05), (0.1, 0.09), (0.05, 0.22))
    for k in range(12)
)  # offsets in heights of letters, and opacities, of a soft shadow


def draw(caption: Caption, rig: CameraRig | None) -> None:
    """Draw a caption near the foot of the picture of a rig; None: of all of the gui's screen."""
    if caption.opacity == 0.0 or not caption.words:
        return
    size = imgui.get_io().display_size
    left, top, across, down = (0.0, 0.0, 1.0, 1.0) if rig is None else room_of(rig)
    left, top, width, height = left * size.x, top * size.y, across * size.x, down * size.y
    tall = letters_of(width, height)
    foot = min(top + FOOT * height, size.y - CLEAR * imgui.get_font_size())
    canvas = imgui.get_background_draw_list()
    imgui.push_font(None, tall)
    lines = lines_of(caption.words, ROOM * width, lambda line: imgui.calc_text_size(line).x)
    box = imgui.calc_text_size("x").y
    wide = max((imgui.calc_text_size(line).x for line in lines), default=0.0)
    begin, top = left + (width - wide) / 2, foot - (len(lines) - 1) * LEADING * tall - box
    draw_backing((begin, top), (begin + wide, foot), tall, caption.opacity)
    for k, line in enumerate(reversed(lines)):
        x = left + (width - imgui.calc_text_size(line).x) / 2
        y = foot - k * LEADING * tall - box
        for aside, below, alpha in SOFT:
            shade = colour(SHADE, alpha * caption.opacity)
            canvas.add_text((x + aside * tall, y + below * tall), shade, line)
        canvas.add_text((x, y), colour(INK, caption.opacity), line)
    imgui.pop_font()
