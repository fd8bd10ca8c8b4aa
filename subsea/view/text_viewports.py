"""Where text goes in the windows of a rig: on the screen ahead, once for each eye."""

from collections.abc import Callable
from typing import NamedTuple

from subsea.view.rig import CameraRig, front, seen_part


def one_page(number: int) -> None:
    """There is only one buffer to draw into."""


class TextViewport(NamedTuple):
    """A part of the window that shows everything, in shares of it from the upper left corner.

    Where two eyes share a screen each has a pane, into which all is squeezed that would fill the
    screen: `screen` is its width and height, in the same shares.
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
        """Whether thin strokes would be lost."""
        return self.screen[0] > 1.4 * self.width or self.screen[1] > 1.4 * self.height


WHOLE = TextViewport()


def text_viewports(
    rig: CameraRig, page: Callable[[int], None] = one_page
) -> tuple[TextViewport, ...]:
    """Where text goes: in the pilot's window, on the screen ahead, in the part of each eye."""
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
    # As much of it as is seen of each part.
    seen, place = seen_part(ahead), ahead.place
    screen = (
        (high[0] - low[0]) / width * seen[2] / place[2],
        (high[1] - low[1]) / height * seen[3] / place[3],
    )
    found = []
    for patch in parts:
        x, y, across, up = seen_part(patch)
        top = height - y - up
        share = x / width, top / height, across / width, up / height
        if min(*share[2:], *screen) > 0.0:  # of a pixel an eye may have none
            found.append(TextViewport(*share, screen, patch.page, page))
    return tuple(found) or (WHOLE,)
