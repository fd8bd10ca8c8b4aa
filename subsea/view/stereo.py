"""Stereo displays: eye separation, and the parts of canvas and picture for each eye."""

from typing import NamedTuple

import numpy as np

from subsea.view.rig import DisplayPatch, Rect, Weave

EYE_SEPARATION_CM = 6.4
SCREEN_DISTANCE_CM = 120.0


class Stereo(NamedTuple):
    """The eyes of a stereo display, in cm of the sea unless said otherwise."""

    separation_cm: float | None = None  # None: EYE_SEPARATION_CM, or that of the theatre
    screen_cm: float = SCREEN_DISTANCE_CM  # distance of zero parallax
    screen_width_cm: float | None = None  # of the real screen, in real centimetres
    swapped: bool = False  # the left eye gets the right one's picture
    comfort_deg: float | None = None  # largest vergence between screen and infinity

    def eyes(self, window_cm: float) -> float:
        """Eye separation, cm, if the screen shows `window_cm` of the sea at its distance.

        The parallax of infinity on the screen equals the eye separation. It is limited to that of
        a person on a real screen of known width, because eyes cannot diverge.

        Vergence changes by separation over distance from the screen to infinity, while focus stays
        on the screen, which is tiring. `comfort_deg` limits that angle.
        """
        apart = EYE_SEPARATION_CM if self.separation_cm is None else self.separation_cm
        if self.screen_width_cm is not None:
            apart = min(apart, EYE_SEPARATION_CM * window_cm / self.screen_width_cm)
        if self.comfort_deg is not None:
            apart = min(apart, float(np.radians(self.comfort_deg)) * self.screen_cm)
        return apart


EYES = Stereo()


class StereoLayout(NamedTuple):
    """Division of canvas and picture between the eyes in a stereo mode."""

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
    """Split a rectangle for two eyes; an odd row goes to the upper, a column to the right one."""
    x, y, width, height = rect
    if beside:
        return (x, y, width // 2, height), (x + width // 2, y, width - width // 2, height)
    return (x, y + height // 2, width, height - height // 2), (x, y, width, height // 2)


def canvas_of(layout: StereoLayout, size: tuple[int, int]) -> tuple[int, int]:
    """Size of the canvas for a picture of `size`."""
    return size[0], 2 * size[1] if layout.tall else size[1]


def patches_of(layout: StereoLayout, both: DisplayPatch) -> tuple[DisplayPatch, ...]:
    """The patches of a stereo mode: one for both eyes, or one each."""
    if layout.weave != Weave.PLAIN:
        return (both._replace(weave=layout.weave),)
    left = both._replace(right=both.left)
    right = both._replace(left=both.right, apart=-both.apart)
    if both.warp is not None:  # each half shows the columns of its own eye
        vertices = both.warp.vertices
        left = left._replace(warp=both.warp._replace(vertices=vertices[:, [0, 1, 2, 3, 2, 3]]))
        right = right._replace(warp=both.warp._replace(vertices=vertices[:, [0, 1, 4, 5, 4, 5]]))
    if layout.paged:
        return left, right._replace(page=1)
    here, there = halves(both.place, layout.beside)
    squeezed = (2.0, 1.0) if layout.beside else (1.0, 2.0)
    return (
        left._replace(place=here, squeezed=squeezed),
        right._replace(place=there, squeezed=squeezed),
    )
