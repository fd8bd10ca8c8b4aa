"""Labels of diagrams over the picture."""

from collections.abc import Sequence

import numpy as np
from imgui_bundle import imgui

from subsea.frame.labels import Label
from subsea.ui.gui import INK, colour
from subsea.view.unproject import FrontView

SMALL = 0.8  # factor on the size of letters
SHADE = (0.0, 0.05, 0.08)


def draw_labels(labels: Sequence[Label], front_view: FrontView | None) -> None:
    """Draw labels at their places on the screen ahead; none if that is not a flat picture.

    For two eyes: where the left one sees them.
    """
    if front_view is None or not labels:
        return
    size, font = imgui.get_io().display_size, imgui.get_font()
    tall = SMALL * imgui.get_font_size()
    canvas = imgui.get_background_draw_list()
    places = front_view.places(np.array([label.place for label in labels]))
    for (x, y), label in zip(places.tolist(), labels, strict=True):
        if not (0.0 <= x <= 1.0 and 0.0 <= y <= 1.0):  # NaN behind the viewer
            continue
        wide = SMALL * imgui.calc_text_size(label.text).x
        left, top = x * size.x - wide / 2, y * size.y - tall
        for off, ink in ((1.0, colour(SHADE, 0.8)), (0.0, colour(INK, 0.95))):
            canvas.add_text(font, tall, (left + off, top + off), ink, label.text)
