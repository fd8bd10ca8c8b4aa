"""The open water behind everything, and its surface seen from below."""

from itertools import chain
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from subsea.frame import Scene
from subsea.render.marks import SURFACE, Twin
from subsea.render.quality import Quality
from subsea.render.shaders import program, set_uniforms
from subsea.render.textures import ripples, upload

COARSE, FINE = (64, 36), (160, 90)  # cells of the background's grid
FINE_FROM = 8  # samples of a shaft: these are worth a fine grid
RINGS, SECTORS = 16, 48  # of the disc that is the surface
RIPPLES_UNIT = 7  # texture unit


class Water:
    """Holds the grid of the background and the disc of the surface."""

    def __init__(self, context: Any, scene: Scene) -> None:
        """Compile the shaders; of `scene` the surface mirrors the sand."""
        self._context = context
        self._background = program(context, "water")
        self._grids = {}
        for cells in (COARSE, FINE):
            triangles = context.buffer(grid(*cells).tobytes())
            self._grids[cells] = context.vertex_array(self._background, [], triangles), triangles
        self._cells = COARSE
        self._surface = Twin(context, "surface", SURFACE)
        self._floor = float(np.mean(scene.terrain))
        self._ripples = upload_ripples(context)
        places = disc(RINGS, SECTORS)
        self._places = context.buffer(places.tobytes())
        self._disc = self._surface.array([(self._places, "2f4", "a_place")])

    def adapt(self, quality: Quality) -> None:
        """Draw shafts as finely as they are computed from now on."""
        self._cells = FINE if quality.shafts >= FINE_FROM else COARSE

    def draw(self, uniforms: dict[str, Any]) -> int:
        """Fill what nothing covers; the number of triangles."""
        set_uniforms(self._background, **uniforms, u_cells=self._cells)
        background, _ = self._grids[self._cells]
        background.render(moderngl.TRIANGLES)
        self._context.enable(moderngl.BLEND)
        return background.vertices // 3 + self.draw_surface(uniforms)

    def draw_surface(self, uniforms: dict[str, Any], marked: bool = False) -> int:
        """The surface alone, or its mark; the number of triangles."""
        self._ripples.use(RIPPLES_UNIT)
        own = {"u_ripples": RIPPLES_UNIT, "u_floor": self._floor}
        self._surface.ready(self._disc, marked, **uniforms, **own).render(moderngl.TRIANGLES)
        return int(self._disc.vertices) // 3

    def release(self) -> None:
        """Free every OpenGL object."""
        for held in (
            *chain(*self._grids.values()), self._background,
            self._surface, self._places, self._ripples,
        ):  # fmt: skip
            held.release()


def upload_ripples(context: Any) -> Any:
    """The slopes of the surface and the square of them, of which mipmaps keep the mean.

    Where a mipmap has smoothed the slopes away, their square still tells how rough it is.
    """
    x, y = ripples(3)
    return upload(context, [x, y, x**2 + y**2])


def grid(across: int, down: int) -> NDArray[np.int32]:
    """Triangles (n, 3) over (down + 1)·(across + 1) vertices, row after row."""
    corner = np.arange((across + 1) * (down + 1), dtype=np.int32).reshape(down + 1, across + 1)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, :-1], corner[1:, 1:]
    return np.stack([a, b, c, c, b, d], axis=2).reshape(-1, 3)


def disc(rings: int, sectors: int) -> NDArray[np.float32]:
    """Triangles (n, 3, 2) of the unit disc; its rings crowd toward the middle."""
    radius = np.linspace(0.0, 1.0, rings + 1) ** 2
    angle = np.linspace(0.0, 2 * np.pi, sectors + 1)
    places = radius[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    a, b, c, d = places[:-1, :-1], places[:-1, 1:], places[1:, :-1], places[1:, 1:]
    return np.stack([a, c, b, b, c, d], axis=2).reshape(-1, 3, 2).astype(np.float32)
