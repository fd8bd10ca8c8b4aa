"""Two eyes: how far apart they are, and which parts of canvas and picture are theirs."""

from typing import NamedTuple

import numpy as np

from subsea.view.rig import DisplayPatch, Rect, Weave

EYE_SEPARATION_CM = 6.4
SCREEN_DISTANCE_CM = 120.0


class Stereo(NamedTuple):
    """The eyes of a stereo display, in cm of the sea unless said otherwise."""

    separation_cm: float | None = None  # None: a person's, or what the theatre says
    screen_cm: float = SCREEN_DISTANCE_CM  # where both eyes' pictures coincide
    screen_width_cm: float | None = None  # of the real screen, in real centimetres
    swapped: bool = False  # the left eye gets the right one's picture
    comfort_deg: float | None = None  # most that eyes turn between screen and infinity

    def eyes(self, window_cm: float) -> float:
        """How far apart the eyes are, if the screen shows `window_cm` of the sea at its distance.

        What is infinitely far lies on the screen as far apart for the two eyes as they are
        themselves. On a screen so wide that this is more than a person's eyes are apart, they
        would have to turn outwards, which they cannot: then they are brought nearer together.

        Between the screen and infinity the eyes turn by separation over distance, and by as much
        again to what is at half the screen's distance, while they keep focusing on the screen:
        what tires. `comfort_deg` limits that angle.
        """
        apart = EYE_SEPARATION_CM if self.separation_cm is None else self.separation_cm
        if self.screen_width_cm is not None:
            apart = min(apart, EYE_SEPARATION_CM * window_cm / self.screen_width_cm)
        if self.comfort_deg is not None:
            apart = min(apart, float(np.radians(self.comfort_deg)) * self.screen_cm)
        return apart


EYES = Stereo()


class StereoLayout(NamedTuple):
    """How a stereo mode divides the canvas and the picture between the eyes."""

    beside: bool = False  # each eye has half of the canvas' width, else half of its height
    tall: bool = False  # the canvas is twice as high as the picture: each eye in full
    weave: Weave = Weave.PLAIN
    paged: bool = False  # each eye has a buffer of its own


LAYOUTS = {
    "stereo": StereoLayout(tall=True, paged=True),
    "side-by-side": StereoLayout(beside=True),
    "top-bottom": StereoLayout(),
    "anaglyph": StereoLayout(tall=True, weave=Weave.RED_CYAN),
    "anaglyph-comfort": StereoLayout(tall=True, weave=Weave.DUBOIS),
    "interlaced": StereoLayout(weave=Weave.ROWS),
    "checkerboard": StereoLayout(tall=True, weave=Weave.CHECKERS),
}
PAGED = "stereo"  # needs a window with a buffer for each eye
OTHER_STEREO = "side-by-side, top-bottom, anaglyph, interlaced or checkerboard"


def halves(rect: Rect, beside: bool) -> tuple[Rect, Rect]:
    """The left eye's and the right eye's part of a rectangle: left and right, or upper and lower.

    Of an odd number of rows the upper half has one more, of an odd number of columns the right.
    """
    x, y, width, height = rect
    if beside:
        return (x, y, width // 2, height), (x + width // 2, y, width - width // 2, height)
    return (x, y + height // 2, width, height - height // 2), (x, y, width, height // 2)


def canvas_of(layout: StereoLayout, size: tuple[int, int]) -> tuple[int, int]:
    """Pixels of the canvas that two eyes need for a picture of `size`."""
    return size[0], 2 * size[1] if layout.tall else size[1]


def patches_of(layout: StereoLayout, both: DisplayPatch) -> tuple[DisplayPatch, ...]:
    """How two eyes come to their place in the way of a mode: one patch for both, or one each."""
    if layout.weave != Weave.PLAIN:
        return (both._replace(weave=layout.weave),)
    one = both._replace(right=both.left)
    other = both._replace(left=both.right, apart=-both.apart)
    if both.warp is not None:  # of which each shows its own eye's columns
        vertices = both.warp.vertices
        one = one._replace(warp=both.warp._replace(vertices=vertices[:, [0, 1, 2, 3, 2, 3]]))
        other = other._replace(warp=both.warp._replace(vertices=vertices[:, [0, 1, 4, 5, 4, 5]]))
    if layout.paged:
        return one, other._replace(page=1)
    here, there = halves(both.place, layout.beside)
    squeezed = (2.0, 1.0) if layout.beside else (1.0, 2.0)
    return (
        one._replace(place=here, squeezed=squeezed),
        other._replace(place=there, squeezed=squeezed),
    )
