"""A numbered test pattern: grid, border, circle, greys and the channel's number."""

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

CELLS = 8  # of the grid, along the shorter side
GROUND, LINES, INK = (24, 40, 56), (150, 165, 180), (255, 255, 255)
# One for each channel, so that seams show which is which.
TINTS = ((255, 120, 90), (110, 220, 120), (100, 160, 255), (250, 210, 80), (220, 120, 240))


def pattern(size: tuple[int, int], number: int, word: str = "") -> NDArray[np.uint8]:
    """The pattern of a channel: (h, w, 3), top row first; `size` is width, height in pixels.

    Squares are square and the circle round if pixels are. The outermost row and column of pixels
    are white: where they are missing, a picture is cut off.
    """
    width, height = size
    short = min(size)
    picture = Image.new("RGB", size, GROUND)
    draw = ImageDraw.Draw(picture)
    tint = TINTS[(number - 1) % len(TINTS)]
    middle_x, middle_y = (width - 1) / 2, (height - 1) / 2
    cell = short / CELLS
    for k in range(-int(middle_x / cell), int(middle_x / cell) + 1):
        x = round(middle_x + k * cell)
        draw.line((x, 0, x, height), LINES if k else tint)
    for k in range(-int(middle_y / cell), int(middle_y / cell) + 1):
        y = round(middle_y + k * cell)
        draw.line((0, y, width, y), LINES if k else tint)
    r = 0.48 * short
    thick = max(short // 150, 1)
    draw.ellipse((middle_x - r, middle_y - r, middle_x + r, middle_y + r), None, tint, thick)
    for step in range(11):  # greys in steps of a tenth of the code value
        grey = round(25.5 * step)
        left = middle_x + (step - 5.5) * 0.6 * cell
        box = (left, middle_y + 2 * cell, left + 0.6 * cell, middle_y + 2.6 * cell)
        draw.rectangle(box, (grey, grey, grey))
    for dy, text, share in ((-0.3, str(number), 3.0), (1.5, word, 0.8)):
        font = ImageFont.load_default(max(share * cell, 6.0))
        place = middle_x, middle_y + dy * cell
        draw.text(place, text, INK, font, "mm", stroke_width=2 * thick, stroke_fill=GROUND)
    draw.rectangle((0, 0, width - 1, height - 1), None, INK)
    return np.asarray(picture)
