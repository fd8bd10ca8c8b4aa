"""Captions of directions at the foot of the picture, and the last fault of a dive that went on.

`ui/text_layer.py` draws captions in a window, `draw_caption` on the pictures of a film.
"""

import re
import time
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from subsea.base.errors import printable
from subsea.base.language import CJK, font_of, translated
from subsea.base.progress import say
from subsea.directing.director import latest
from subsea.view.front_screen import text_viewports
from subsea.view.rig import CameraRig, Projection, front
from subsea.world.world import TICK_S, World

Pixels = NDArray[np.uint8]

FADE_S = 0.6
READ_S, LETTER_S = 2.5, 0.06  # default time of a caption: fixed, and for each letter
TALL, NARROW = 0.045, 0.034  # of letters: share of the screen's height; at most of its width
ROOM = 0.8  # longest line, share of the screen's width
FOOT = 0.85  # where the last line ends, share of the screen's height
LEADING = 1.3  # from line to line, in heights of letters
INK, SHADE = (0.97, 0.98, 1.0), (0.0, 0.04, 0.06)
# The part of an equirectangular picture in front of the viewer: left, top, width, height.
BEFORE = 0.35, 0.25, 0.3, 0.42


STOPS = "、。，．！？」』）ー々っゃゅょッャュョ"
PIECE = re.compile(rf"(\s*)([{CJK}][{STOPS}]*|[^\s{CJK}]+)")
"""The blanks before a piece of text, and the piece, which no line break divides."""


class Caption(NamedTuple):
    """A caption to be shown now."""

    words: str = ""
    opacity: float = 0.0  # in [0, 1]: it fades in and out


def shown_s(words: str, for_s: float | None) -> float:
    """Duration of a caption, s: as its direction says, else the time to read it."""
    return READ_S + LETTER_S * len(words) if for_s is None else for_s


def faded(words: str, since_s: float, left_s: float) -> Caption:
    """Fade a caption in and out; nothing is left of one that is over."""
    share = min(max(min(since_s, left_s) / FADE_S, 0.0), 1.0)
    return Caption(words, share * share * (3.0 - 2.0 * share)) if left_s > 0.0 else Caption()


def caption_of(world: World, alpha: float) -> Caption:
    """The caption of a world at `alpha` between its last two ticks."""
    cue = latest(world.scenario, world.state, "caption")
    if cue is None:
        return Caption()
    one = world.scenario.direction[cue]
    words = one.caption or ""
    since_s = (world.state.tick - 1 + alpha - int(world.state.directions.began[cue])) * TICK_S
    return faded(translated(words), since_s, shown_s(words, one.for_s) - since_s)


def room_of(rig: CameraRig) -> tuple[float, float, float, float]:
    """Left, top, width and height of the part ahead of the viewer, shares of the screen."""
    return BEFORE if front(rig).shape == Projection.EQUIRECTANGULAR else (0.0, 0.0, 1.0, 1.0)


def letters_of(width: float, height: float) -> float:
    """The height of a caption's letters in a room of that size."""
    return min(TALL * height, NARROW * width)


def lines_of(words: str, room: float, width_of: Callable[[str], float]) -> list[str]:
    """Wrap words into the fewest lines, of about equal length.

    Lines break at blanks, and between letters of Japanese but not before a stop.
    """

    def broken(room: float) -> list[str]:
        lines: list[str] = []
        for gap, word in PIECE.findall(words.strip()):
            longer = f"{lines[-1]}{gap and ' '}{word}" if lines else word
            if lines and width_of(longer) <= room:
                lines[-1] = longer
            else:
                lines.append(word)
        return lines

    low, high = 0.0, room
    for _ in range(10):  # find the least width with the same number of lines
        middle = (low + high) / 2
        fits = len(broken(middle)) <= len(broken(room))
        low, high = (low, middle) if fits else (middle, high)
    return broken(high)


def draw_caption(picture: Pixels, rig: CameraRig, output: int, caption: Caption) -> Pixels:
    """Draw a caption on the picture (h, w, 3) of a rig's `output`, for each eye."""
    if output != front(rig).output or caption.opacity == 0.0 or not caption.words:
        return picture
    from PIL import Image

    image = Image.fromarray(picture)
    width, height = rig.outputs[output]
    left, top, across, down = room_of(rig)
    for pane in (one for one in text_viewports(rig) if one.number == 0):
        screen = pane.screen[0] * width * across, pane.screen[1] * height * down
        seen = pane.width * width * across, pane.height * height * down
        sign = _sign(caption.words, (round(screen[0]), round(screen[1])))
        sign = sign.resize((max(round(seen[0]), 1), max(round(seen[1]), 1)))
        faded = sign.getchannel("A").point(lambda value: round(caption.opacity * value))
        place = (pane.x + left * pane.width) * width, (pane.y + top * pane.height) * height
        image.paste(sign, (round(place[0]), round(place[1])), faded)
    return np.asarray(image)


@lru_cache(maxsize=4)
def _sign(words: str, size: tuple[int, int]):  # type: ignore[no-untyped-def]
    """Draw an RGBA picture of that size with the words near its foot, on a soft shade."""
    from PIL import Image, ImageDraw, ImageFilter, ImageFont

    width, height = max(size[0], 1), max(size[1], 1)
    tall = max(letters_of(width, height), 4.0)
    font = ImageFont.truetype(str(font_of(words)), tall)
    lines = lines_of(words, ROOM * width, font.getlength)
    shade, ink = (tuple(round(255 * value) for value in rgb) for rgb in (SHADE, INK))
    sign = Image.new("RGBA", (width, height), (*shade, 0))
    for blur, stroke, rgb in ((0.35, 0.12, shade), (0.0, 0.06, shade), (0.0, 0.0, ink)):
        layer = Image.new("RGBA", (width, height), (*rgb, 0))
        canvas = ImageDraw.Draw(layer)
        for k, line in enumerate(reversed(lines)):
            foot = FOOT * height - k * LEADING * tall
            canvas.text((width / 2, foot), line, (*rgb, 255), font, anchor="ms",
                        stroke_width=round(stroke * tall))  # fmt: skip
        if blur:
            layer = layer.filter(ImageFilter.GaussianBlur(blur * tall))
        sign = Image.alpha_composite(sign, layer)
    return sign


class FaultState(msgspec.Struct, frozen=True):
    """A fault, and how long ago it was."""

    text: str
    ago_s: float


class FaultLog:
    """Remembers the last fault."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """`clock` gives the time, s."""
        self._clock, self._text, self._at_s = clock, "", 0.0

    def add(self, text: str) -> None:
        """Remember a fault that has just happened."""
        self._text, self._at_s = printable(text), self._clock()

    def say(self, text: str) -> None:
        """Report a fault on the terminal, and remember it."""
        say(text)
        self.add(text)

    @property
    def state(self) -> FaultState | None:
        """The last fault; None if there was none."""
        return FaultState(self._text, round(self._clock() - self._at_s, 1)) if self._text else None
