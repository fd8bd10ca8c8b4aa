"""Motion blur and depth of field: a frame of a film as the mean of several pictures.

The pictures are taken while the shutter is open, through points spread over the lens. Each is what
a pinhole sees, so everything is blurred as it should be: what moves, and what lies before or behind
the plane in focus.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from subsea.view.camera import View

NEAREST_CM = 10.0  # in focus
EVENLY = 0.7548776662466927, 0.5698402909980532
"""Steps that spread points evenly over a square, in no order of time (Roberts' R2 sequence)."""


class Exposure(NamedTuple):
    """The exposure of the frames of a film."""

    samples: int = 1  # pictures of a frame
    shutter: float = 0.5  # share of the time between two frames for which it is open
    aperture_cm: float = 0.0  # diameter of the lens; 0: everything is sharp
    # Distance of the plane in focus from the eye, along the view; 0: that of the followed fish.
    focus_cm: float = 300.0

    def instants(self, instant: float, interval_s: float) -> list[float]:
        """The times of the pictures of a frame at `instant`, s."""
        step = self.shutter * interval_s / self.samples
        return [instant + k * step for k in range(self.samples)]

    def focused(self, away_cm: float) -> "Exposure":
        """Return the exposure whose focus is on the followed fish, `away_cm` along the view."""
        return self._replace(focus_cm=max(away_cm, NEAREST_CM)) if self.focus_cm == 0.0 else self

    def through_lens(self, views: tuple[View, ...], sample: int) -> tuple[View, ...]:
        """The views of a picture, each from its point of the lens; those in focus do not move."""
        if self.aperture_cm == 0.0:
            return views
        share, turn = ((sample + 0.5) * step % 1.0 for step in EVENLY)
        away = 0.5 * self.aperture_cm * np.sqrt(share)
        aside, above = away * np.cos(2.0 * np.pi * turn), away * np.sin(2.0 * np.pi * turn)
        return tuple(_shifted(view, aside, above, self.focus_cm) for view in views)


def _shifted(view: View, aside: float, above: float, focus_cm: float) -> View:
    """A view from an eye moved to its right and up, cm, in which the plane in focus stays."""
    moved, projection = view.view.copy(), view.projection.copy()
    moved[:2, 3] -= aside, above
    projection[0, 2] -= projection[0, 0] * aside / focus_cm
    projection[1, 2] -= projection[1, 1] * above / focus_cm
    eye = view.eye + aside * view.view[0, :3] + above * view.view[1, :3]
    return replace(view, view=moved, projection=projection, eye=eye)


PINHOLE = Exposure()  # one sharp picture
