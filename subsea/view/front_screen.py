"""The front screen of a rig: viewports for its text, and projection to the sea and back."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.view.camera import View
from subsea.view.rig import CameraRig, DisplayPatch, Projection, Rect, front, seen_by, seen_part

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
    viewports = []
    for patch in parts:
        x, y, across, up = text_part(patch)
        top = height - y - up
        share = x / width, top / height, across / width, up / height
        if min(*share[2:], *screen) > 0.0:  # an eye may have no part of one pixel
            viewports.append(TextViewport(*share, screen, patch.page, page))
    return tuple(viewports) or (WHOLE,)


def text_part(patch: DisplayPatch) -> Rect:
    """The rectangle for text in a patch, in pixels of the output; on a dome it lies in front."""
    if patch.shape != Projection.DOME or patch.warp is not None:
        return seen_part(patch)
    x, y, width, height = patch.place
    radius = 0.5 * min(width * patch.squeezed[0], height * patch.squeezed[1])
    across, up = (radius / by for by in patch.squeezed)
    left, foot = x + 0.5 * width - DOME_HALF * across, y + 0.5 * height - DOME_FOOT * up
    return round(left), round(foot), int(2.0 * DOME_HALF * across), int(DOME_HIGH * up)


CLIP_CM = 4.0  # lines are clipped at this distance from the eye


class FrontView(NamedTuple):
    """A view and the part of it on the front screen.

    Screen points are shares of the screen from its upper left corner. `low` and `high` are its
    lower left and upper right corner in the view, in [-1, 1].
    """

    view: View
    low: tuple[float, float]
    high: tuple[float, float]

    def ray(self, x: float, y: float) -> tuple[Array, Array]:
        """The eye, cm, and the unit vector through a screen point."""
        across = self.low[0] + x * (self.high[0] - self.low[0])
        up = self.high[1] - y * (self.high[1] - self.low[1])
        p = self.view.projection.astype(np.float64)
        way = np.array([(across + p[0, 2]) / p[0, 0], (up + p[1, 2]) / p[1, 1], -1.0])
        way = way @ self.view.view[:3, :3].astype(np.float64)
        return np.asarray(self.view.eye, np.float64), way / np.linalg.norm(way)

    def places(self, points: Array) -> Array:
        """Screen points (n, 2) of points (n, 3), cm; NaN behind the eye."""
        p = self.view.projection.astype(np.float64)
        away = np.asarray(points, np.float64) - np.asarray(self.view.eye, np.float64)
        seen = away @ self.view.view[:3, :3].astype(np.float64).T
        ahead = np.where(seen[:, 2] < -1e-6, -seen[:, 2], np.nan)
        across = p[0, 0] * seen[:, 0] / ahead - p[0, 2]
        up = p[1, 1] * seen[:, 1] / ahead - p[1, 2]
        return np.stack(
            [
                (across - self.low[0]) / (self.high[0] - self.low[0]),
                (self.high[1] - up) / (self.high[1] - self.low[1]),
            ],
            axis=1,
        )

    def lines(self, segments: Array) -> Array:
        """Screen lines (k, 2, 2) of lines (n, 2, 3), cm, clipped to those in front of the eye."""
        ends = np.asarray(segments, np.float64)
        ahead = -(ends - np.asarray(self.view.eye, np.float64)) @ self.view.view[2, :3]
        share = (CLIP_CM - ahead) / np.where(ahead[:, ::-1] == ahead, 1.0, ahead[:, ::-1] - ahead)
        share = np.where(ahead < CLIP_CM, share, 0.0)[..., None]
        cut = (ends + share * (ends[:, ::-1] - ends))[(ahead > CLIP_CM).any(axis=1)]
        return self.places(cut.reshape(-1, 3)).reshape(-1, 2, 2)


def front_screen(rig: CameraRig, views: Sequence[View]) -> FrontView | None:
    """The left eye's view through the front screen, from those of a rig; None if it is not flat."""
    ahead = front(rig)
    if ahead.shape != Projection.FLAT:
        return None
    number = front_view(rig)
    place, source, viewport = ahead.place, ahead.left, rig.eyes[number].viewport
    low, high = [], []
    for axis in (0, 1):  # a patch may show less than the view
        begin, size = seen_part(ahead)[axis], seen_part(ahead)[axis + 2]
        shares = (np.array([begin, begin + size]) - place[axis]) / place[axis + 2]
        pixels = source[axis] + shares * source[axis + 2] - viewport[axis]
        ends = 2.0 * pixels / viewport[axis + 2] - 1.0
        low.append(float(ends[0]))
        high.append(float(ends[1]))
    return FrontView(views[number], (low[0], low[1]), (high[0], high[1]))


def front_view(rig: CameraRig) -> int:
    """Index of the view on the front screen."""
    return next(k for k, eye in enumerate(rig.eyes) if eye is seen_by(rig, front(rig))[0])
