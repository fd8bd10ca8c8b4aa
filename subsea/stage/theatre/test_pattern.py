"""A numbered test pattern to check place, geometry and focus of a channel."""

import colorsys
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from subsea.base.arrays import Bytes

WHITE, GREY, BLACK = (255, 255, 255), (130, 130, 130), (0, 0, 0)
GOLDEN = 0.618034  # hue step between channels, in turns, so that all differ
STEPS = 11  # of the grey ramp, with black and white


def pattern(size: tuple[int, int], number: int, word: str = "") -> Bytes:
    """The pattern of a channel: (h, w, 3), top row first; `size` is width, height in pixels.

    The outermost row and column of pixels are white: where they are missing, a picture is cut
    off. Lines lie at each tenth, arrows in the corners; circles are round if pixels are square.
    """
    width, height = size
    colour = colour_of(number)
    dark = tuple(channel // 6 for channel in colour)
    picture = Image.new("RGB", size, dark)
    draw = ImageDraw.Draw(picture)
    unit = min(size) / 100
    fine = max(round(unit / 4), 1)
    for k in range(1, 10):
        line = WHITE if k == 5 else GREY
        x, y = round(k * (width - 1) / 10), round(k * (height - 1) / 10)
        draw.line([(x, 0), (x, height - 1)], line, fine)
        draw.line([(0, y), (width - 1, y)], line, fine)
    middle = np.array([(width - 1) / 2, (height - 1) / 2])
    for radius in (45 * unit, 30 * unit):
        draw.ellipse([*(middle - radius), *(middle + radius)], outline=colour, width=2 * fine)
    _arrows(draw, size, colour, unit)
    _write(draw, str(number), (middle[0], middle[1] - 4 * unit), 34 * unit, colour)
    _write(draw, word, (middle[0], middle[1] + 19 * unit), 8 * unit, WHITE)
    _ramp(draw, size)
    draw.rectangle([0, 0, width - 1, height - 1], outline=WHITE)
    return np.asarray(picture)


def colour_of(number: int) -> tuple[int, int, int]:
    """The bright colour of a channel."""
    bright = colorsys.hsv_to_rgb(number * GOLDEN % 1, 0.75, 1.0)
    red, green, blue = (round(255 * part) for part in bright)
    return red, green, blue


def _arrows(
    draw: ImageDraw.ImageDraw, size: tuple[int, int], colour: tuple[int, int, int], unit: float
) -> None:
    """An arrow into each corner."""
    width, height = size
    for x, y in ((0, 0), (width - 1, 0), (0, height - 1), (width - 1, height - 1)):
        inward = np.array([1 if x == 0 else -1, 1 if y == 0 else -1])
        tip = np.array([x, y]) + 2 * unit * inward
        sides = tip + 7 * unit * inward * [1, 0], tip + 7 * unit * inward * [0, 1]
        tail = tip + 12 * unit * inward
        draw.line([*tip, *tail], colour, max(round(unit), 1))
        draw.polygon([*tip, *sides[0], *sides[1]], colour)


def _ramp(draw: ImageDraw.ImageDraw, size: tuple[int, int]) -> None:
    """Grey from black to white in even steps of code values, above a smooth one."""
    width, height = size
    left, right = 0.2 * width, 0.8 * width
    top, middle, bottom = 0.80 * height, 0.83 * height, 0.86 * height
    for k in range(STEPS):
        begin, end = (left + (right - left) * share / STEPS for share in (k, k + 1))
        code = round(255 * k / (STEPS - 1))
        draw.rectangle([begin, top, max(end - 1, begin), max(middle - 1, top)], fill=(code,) * 3)
    columns = np.arange(round(left), max(round(right), round(left) + 1))
    for column in columns.tolist():
        code = round(255 * (column - columns[0]) / max(len(columns) - 1, 1))
        draw.line([(column, middle), (column, bottom)], (code,) * 3)


def _write(
    draw: ImageDraw.ImageDraw, text: str, at: tuple[Any, Any], tall: float, colour: tuple[int, ...]
) -> None:
    """A line of text in the middle of a place, not wider than the picture, edged in black."""
    text = " ".join(text.split())
    width = draw.im.size[0] * 0.9
    font = ImageFont.load_default(max(tall, 4))
    if (long := draw.textlength(text, font)) > width:
        font = ImageFont.load_default(max(tall * width / long, 4))
    draw.text(
        at, text, colour, font, "mm", stroke_width=max(round(tall / 24), 1), stroke_fill=BLACK
    )
