"""Test patterns on all channels, to line up projectors."""

import numpy as np

from subsea.base.arrays import Bytes
from subsea.stage.theatre.test_pattern import pattern
from subsea.view.rig import CUBES, CameraRig, Rect
from subsea.view.surround import COLUMNS, FACES, ROWS, inner

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
