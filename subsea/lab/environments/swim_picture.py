"""Pictures of one swimming body, drawn by the renderer without a window."""

import numpy as np

from subsea.base.arrays import Array, Bytes
from subsea.biomechanics.body import build_body
from subsea.fish.coupling import couple, place
from subsea.fish.paint import paint
from subsea.fish.species import Species
from subsea.fish.surface import rest_control_points
from subsea.rendering.fish.preview import FishPreview, Orbit
from subsea.rendering.gl.context import headless_context

SIZE = (640, 360)
ORBIT = Orbit(turn=0.3, tilt=0.6, zoom=0.8)  # from the left and above, with room to turn


class SwimPicture:
    """A species, its skin and a headless context; UserError without OpenGL."""

    def __init__(self, species: Species) -> None:
        """Upload the species."""
        assert species.muscles
        body = build_body(species.muscles.body)
        rest = rest_control_points(species.surface, species.length_cm, body.rest[0, 0])
        self._coupling = couple(species.surface.coupling, body.rest, rest)
        self._context = headless_context()
        self._fish = FishPreview(self._context, species, paint(species))

    def draw(self, x: Array) -> Bytes:
        """The body (360, 640, 3) with nodes (23, 3) in world axes, in the middle of the picture."""
        points = place(self._coupling, x) - 0.5 * (x[5] + x[7])
        self._fish.draw(points, ORBIT, SIZE)
        return np.ascontiguousarray(self._fish.read_pixels())

    def release(self) -> None:
        """Free every OpenGL object."""
        self._fish.release()
        self._context.release()
