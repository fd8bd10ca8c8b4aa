"""Numbered test patterns to check place, geometry and focus of all channels of a theatre."""

import colorsys
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from subsea.base.arrays import Bytes
from subsea.view.rig import CUBES, CameraRig, Rect
from subsea.view.surround import COLUMNS, FACES, ROWS, inner

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


Picture = Bytes


def lineup(rig: CameraRig) -> Picture:
    """A canvas (h, w, 3), top row first, with a pattern in the source of each patch.

    Channels are numbered from 1; where the eyes differ L or R is added, and to the faces of a
    cube where they look.
    """
    width, height = rig.canvas
    canvas = np.zeros((height, width, 3), np.uint8)
    for patch in rig.patches:
        eyes = _eyes(rig, patch.channel)
        for source in (patch.left, patch.right):
            eye = "LR"[eyes.index(source)] if len(eyes) == 2 else ""
            if patch.shape in CUBES:
                wide, high = source[2] // COLUMNS, source[3] // ROWS
                for face, word in enumerate(FACES):
                    x, y = source[0] + face % COLUMNS * wide, source[1] + face // COLUMNS * high
                    _paste(canvas, inner((x, y, wide, high)), patch.channel + 1, f"{word} {eye}")
            else:
                _paste(canvas, source, patch.channel + 1, eye)
    return canvas


def _eyes(rig: CameraRig, channel: int) -> list[Rect]:
    """The source rectangles of a channel on the canvas: one, or one for each eye."""
    patches = [patch for patch in rig.patches if patch.channel == channel]
    return list(dict.fromkeys(source for patch in patches for source in (patch.left, patch.right)))


def _paste(canvas: Picture, place: Rect, number: int, word: str) -> None:
    """Draw a pattern into a rectangle whose origin is the lower left corner."""
    x, y, width, height = place
    top = canvas.shape[0] - y - height
    canvas[top : top + height, x : x + width] = pattern((width, height), number, word)
