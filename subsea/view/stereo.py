"""Displays: what a mode draws, and how it becomes the picture, for two eyes or all round.

Where a display shows both pictures at once, in colours, rows or pixels, the renderer draws one
above the other on a *canvas* and weaves them into the picture in the end.
"""

from enum import IntEnum
from typing import NamedTuple

from subsea.view.surround import ALL_ROUND, COLUMNS, ROWS, Surround, face_size

EYE_SEPARATION_CM = 6.4
SCREEN_DISTANCE_CM = 120.0


class Stereo(NamedTuple):
    """The eyes of a stereo display, in cm of the sea unless said otherwise."""

    separation_cm: float = EYE_SEPARATION_CM
    screen_cm: float = SCREEN_DISTANCE_CM  # where both eyes' pictures coincide
    screen_width_cm: float | None = None  # of the real screen, in real centimetres
    swapped: bool = False  # the left eye gets the right one's picture

    def eyes(self, window_cm: float) -> float:
        """How far apart the eyes are, if the screen shows `window_cm` of the sea at its distance.

        What is infinitely far lies on the screen as far apart for the two eyes as they are
        themselves. On a screen so wide that this is more than a person's eyes are apart, they
        would have to turn outwards, which they cannot: then they are brought nearer together.
        """
        if self.screen_width_cm is None:
            return self.separation_cm
        return min(self.separation_cm, EYE_SEPARATION_CM * window_cm / self.screen_width_cm)


EYES = Stereo()


class Weave(IntEnum):
    """How a pixel comes from the canvas; the numbers are those of `shaders/resolve.frag`."""

    PLAIN = 0
    LEFT = 1  # the upper half alone ...
    RIGHT = 2  # ... and the lower
    ROWS = 3  # left and right in turn, the topmost row is left
    CHECKERS = 4  # the same within each row, the upper left pixel is left
    RED_CYAN = 5  # red from the left eye, green and blue from the right
    DUBOIS = 6  # the same with colours mixed so that both eyes see about the same brightness
    EQUIRECTANGULAR = 7  # from the faces of a cube, as the next two
    DOME = 8
    PANORAMA = 9


class Layout(NamedTuple):
    """What a display mode draws, and how that becomes the picture."""

    eyes: str  # "one", "beside" (left eye left), "above" (left eye above), or "cube"
    tall: bool  # the canvas is twice as high as the picture: each eye in full
    weaves: tuple[Weave, ...]  # one for each buffer of the window


LAYOUTS = {
    "mono": Layout("one", False, (Weave.PLAIN,)),
    "stereo": Layout("above", True, (Weave.LEFT, Weave.RIGHT)),
    "side-by-side": Layout("beside", False, (Weave.PLAIN,)),
    "top-bottom": Layout("above", False, (Weave.PLAIN,)),
    "anaglyph": Layout("above", True, (Weave.RED_CYAN,)),
    "anaglyph-comfort": Layout("above", True, (Weave.DUBOIS,)),
    "interlaced": Layout("above", False, (Weave.ROWS,)),
    "checkerboard": Layout("above", True, (Weave.CHECKERS,)),
    "panorama": Layout("cube", False, (Weave.PANORAMA,)),
    "dome": Layout("cube", False, (Weave.DOME,)),
    "equirectangular": Layout("cube", False, (Weave.EQUIRECTANGULAR,)),
}
DISPLAYS = tuple(LAYOUTS)
PAGED = "stereo"  # needs a window with a buffer for each eye
OTHER_STEREO = "side-by-side, top-bottom, anaglyph, interlaced or checkerboard"


def canvas_size(
    display: str, size: tuple[int, int], surround: Surround = ALL_ROUND
) -> tuple[int, int]:
    """Pixels of the canvas for a picture of `size` (width, height)."""
    if LAYOUTS[display].eyes == "cube":
        face = face_size(display, size, surround)
        return COLUMNS * face, ROWS * face
    return size[0], 2 * size[1] if LAYOUTS[display].tall else size[1]
