"""Draw labels over their picture, to look at them."""

import colorsys

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from subsea.base.arrays import Array
from subsea.dive.ride import VALUES
from subsea.lab.dataset.keypoints import NAMES, SKELETON
from subsea.lab.dataset.labelling import HIDDEN, VISIBLE, Labels

MASK = 0.35  # share of a mask's colour
DOT_PX = 2.5  # radius of a keypoint
LEAST_PX = 24.0  # side of a box whose keypoints are drawn
FAST_PX = 8.0  # flow of full colour


def overlay(labels: Labels) -> NDArray[np.uint8]:
    """Draw masks, boxes and keypoints over a picture (h, w, 3).

    Boxes of what is visible are solid, those of whole bodies thin. Hidden keypoints are hollow.
    """
    fishes = labels.fishes
    picture = labels.picture.astype(np.float64)
    colours = [_colour(int(number)) for number in fishes.number]
    for number, colour in zip(fishes.number, colours, strict=True):
        mask = labels.identity == VALUES["fish"] + number
        picture[mask] = (1.0 - MASK) * picture[mask] + MASK * np.array(colour)
    drawn = Image.fromarray(np.rint(picture).astype(np.uint8))
    pen = ImageDraw.Draw(drawn)
    for i, colour in enumerate(colours):
        _rectangle(pen, fishes.whole[i], tuple(int(0.6 * part) for part in colour), 1)
        _rectangle(pen, fishes.box[i], colour, 2)
        if np.nanmax(fishes.whole[i, 2:], initial=0.0) > LEAST_PX:
            _keypoints(pen, fishes.keypoints[i], fishes.state[i], colour)
    return np.asarray(drawn)


def flow_colours(flow: Array) -> NDArray[np.uint8]:
    """Colour optical flow (h, w, 2): the hue is its direction; grey is not known."""
    speed = np.linalg.norm(flow, axis=-1)
    hue = np.arctan2(flow[..., 1], flow[..., 0])
    strength = np.clip(speed / FAST_PX, 0.0, 1.0)[..., None]
    wheel = 0.5 + 0.5 * np.cos(hue[..., None] - np.array([0.0, 2.0, 4.0]) * np.pi / 3)
    colour = 1.0 - strength + strength * wheel
    colour = np.where(np.isnan(speed)[..., None], 0.4, colour)
    return np.asarray(np.rint(255.0 * colour), np.uint8)


def _colour(number: int) -> tuple[int, ...]:
    return tuple(int(255 * part) for part in colorsys.hsv_to_rgb(number * 0.618 % 1.0, 0.75, 1.0))


def _rectangle(pen: ImageDraw.ImageDraw, box: Array, colour: tuple[int, ...], width: int) -> None:
    if not np.isnan(box).any():
        x, y, wide, high = box.tolist()
        pen.rectangle((x - 1, y - 1, x + wide, y + high), outline=colour, width=width)


def _keypoints(
    pen: ImageDraw.ImageDraw, places: Array, states: Array, colour: tuple[int, ...]
) -> None:
    named = dict(zip(NAMES, zip(places.tolist(), states.tolist(), strict=True), strict=True))
    for a, b in SKELETON:
        (from_, one), (to, other) = named[a], named[b]
        if min(one, other) == VISIBLE:
            pen.line((*from_, *to), fill=colour, width=1)
    for (x, y), state in named.values():
        if state < HIDDEN:
            continue
        dot = (x - DOT_PX, y - DOT_PX, x + DOT_PX, y + DOT_PX)
        if state == VISIBLE:
            pen.ellipse(dot, fill=(255, 255, 255), outline=colour)
        else:
            pen.ellipse(dot, outline=colour)
