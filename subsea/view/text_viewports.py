"""Viewports for text: on the front screen of a rig, one for each eye."""

from collections.abc import Callable
from typing import NamedTuple

from subsea.view.rig import CameraRig, DisplayPatch, Projection, Rect, front, seen_part

# Text on a dome, in radii: half its width, its height, and how far its foot is below the middle.
# Its lower corners lie on the rim, in front of the audience.
DOME_HALF, DOME_HIGH, DOME_FOOT = 0.64, 0.96, 0.768


def one_page(number: int) -> None:
    """Select nothing: the window has one buffer."""


class TextViewport(NamedTuple):
    """A part of the window, in shares of it from the upper left corner.

    Where two eyes share a screen, each has a viewport into which the whole screen is squeezed;
    `screen` is the width and height of the screen, in the same shares.
    """

    x: float = 0.0
    y: float = 0.0
    width: float = 1.0
    height: float = 1.0
    screen: tuple[float, float] = (1.0, 1.0)
    number: int = 0
    page: Callable[[int], None] = one_page

    @property
    def squeezed(self) -> bool:
        """True if thin strokes would get lost."""
        return self.screen[0] > 1.4 * self.width or self.screen[1] > 1.4 * self.height


WHOLE = TextViewport()


def text_viewports(
    rig: CameraRig, page: Callable[[int], None] = one_page
) -> tuple[TextViewport, ...]:
    """The text viewports of a rig, one for each eye on the front screen."""
    ahead = front(rig)
    width, height = rig.outputs[ahead.output]
    parts = [
        patch
        for patch in rig.patches
        if (patch.output, patch.channel) == (ahead.output, ahead.channel)
    ]
    low, high = (
        [choose(p.place[axis] + far * p.place[axis + 2] for p in parts) for axis in (0, 1)]
        for choose, far in ((min, 0), (max, 1))
    )
    # Limited to the visible share of each part.
    seen, place = text_part(ahead), ahead.place
    screen = (
        (high[0] - low[0]) / width * seen[2] / place[2],
        (high[1] - low[1]) / height * seen[3] / place[3],
    )
    found = []
    for patch in parts:
        x, y, across, up = text_part(patch)
        top = height - y - up
        share = x / width, top / height, across / width, up / height
        if min(*share[2:], *screen) > 0.0:  # an eye may have no part of one pixel
            found.append(TextViewport(*share, screen, patch.page, page))
    return tuple(found) or (WHOLE,)


def text_part(patch: DisplayPatch) -> Rect:
    """The rectangle for text in a patch, in pixels of the output; on a dome it lies in front."""
    if patch.shape != Projection.DOME or patch.warp is not None:
        return seen_part(patch)
    x, y, width, height = patch.place
    radius = 0.5 * min(width * patch.squeezed[0], height * patch.squeezed[1])
    across, up = (radius / by for by in patch.squeezed)
    left, foot = x + 0.5 * width - DOME_HALF * across, y + 0.5 * height - DOME_FOOT * up
    return round(left), round(foot), int(2.0 * DOME_HALF * across), int(DOME_HIGH * up)
