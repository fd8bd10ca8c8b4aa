"""The open water behind everything, and its surface seen from below."""

from itertools import chain
from math import tan
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from subsea.frame.packet import Scene
from subsea.render.gl.id_buffer import SURFACE, ProgramVariants
from subsea.render.gl.mipmaps import Texels
from subsea.render.gl.shaders import program, set_uniforms, wanted
from subsea.render.gl.textures import halves, repeating, ripples
from subsea.render.output.quality import Quality
from subsea.view.camera import FAR_CM, View
from subsea.view.display_rigs import VERTICAL_FOV

COARSE, FINE = (64, 36), (160, 90)  # cells of the background's grid on a plain display of 16:9
HALF_TANGENTS = (16 / 9 * tan(VERTICAL_FOV / 2), tan(VERTICAL_FOV / 2))  # which shows so much
STEPS = (8, 9)  # a view that shows less has fewer cells, in so many steps
FINE_FROM = 8  # samples of a shaft: these are worth a fine grid
RINGS, SECTORS = 16, 48  # of the disc that is the surface
RIPPLES_UNIT = 7  # texture unit


class WaterRenderer:
    """Holds the grid of the background and the disc of the surface."""

    def __init__(self, context: Any, scene: Scene) -> None:
        """Compile the shaders; of `scene` the surface mirrors the sand."""
        self._context = context
        # Another one is made when lamps are first on.
        self._programs: dict[tuple[str, ...], Any] = {(): program(context, "water")}
        # By their cells, and what the program is wanted for.
        self._grids: dict[tuple[Any, ...], tuple[Any, Any]] = {}
        self._cells = COARSE
        self._surface = ProgramVariants(context, "surface", SURFACE)
        self._floor = float(np.mean(scene.terrain))
        self._ripples = repeating(context, rippled, 3)
        self._parts = [context.buffer(part.tobytes()) for part in disc(RINGS, SECTORS)]
        self._disc = self._surface.array([(self._parts[0], "2f4", "a_place")], self._parts[1])

    def adapt(self, quality: Quality) -> None:
        """Draw shafts as finely as they are computed from now on."""
        self._cells = FINE if quality.shafts >= FINE_FROM else COARSE

    def draw(self, view: View, uniforms: dict[str, Any]) -> int:
        """Fill what nothing covers; the number of triangles."""
        cells = cells_for(view, self._cells)
        if (wants := wanted(uniforms)) not in self._programs:
            self._programs[wants] = program(self._context, "water", **dict.fromkeys(wants, 1))
        if (cells, wants) not in self._grids:
            triangles = self._context.buffer(grid(*cells).tobytes())
            array = self._context.vertex_array(self._programs[wants], [], triangles)
            self._grids[cells, wants] = array, triangles
        set_uniforms(self._programs[wants], **uniforms, u_cells=cells)
        background, _ = self._grids[cells, wants]
        background.render(moderngl.TRIANGLES)
        self._context.enable(moderngl.BLEND)
        return background.vertices // 3 + self.draw_surface(view, uniforms)

    def draw_surface(self, view: View, uniforms: dict[str, Any], marked: bool = False) -> int:
        """The surface alone, or its mark, if the view shows it; the number of triangles."""
        if highest(view) < 0.0:
            return 0
        self._ripples.use(RIPPLES_UNIT)
        own = {"u_ripples": RIPPLES_UNIT, "u_floor": self._floor}
        self._surface.ready(self._disc, marked, **uniforms, **own).render(moderngl.TRIANGLES)
        return int(self._disc.vertices) // 3

    def release(self) -> None:
        """Free every OpenGL object."""
        for held in (
            *chain(*self._grids.values()), *self._programs.values(),
            self._surface, *self._parts, self._ripples,
        ):  # fmt: skip
            held.release()


def rippled(seed: int) -> Texels:
    """The slopes of the surface and the square of them, of which mipmaps keep the mean.

    Where a mipmap has smoothed the slopes away, their square still tells how rough it is.
    """
    x, y = ripples(seed)
    return halves([x, y, x**2 + y**2])


def grid(across: int, down: int) -> NDArray[np.int32]:
    """Triangles (n, 3) over (down + 1)·(across + 1) vertices, row after row."""
    corner = np.arange((across + 1) * (down + 1), dtype=np.int32).reshape(down + 1, across + 1)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, :-1], corner[1:, 1:]
    return np.stack([a, b, c, c, b, d], axis=2).reshape(-1, 3)


def cells_for(view: View, plain: tuple[int, int]) -> tuple[int, int]:
    """Cells across and down, of about the angle that `plain` ones have on a plain display."""
    found = [
        whole // steps * min(max(round(steps / (scale * tangent)), 1), steps)
        for whole, steps, scale, tangent in zip(
            plain, STEPS, np.diag(view.projection)[:2].tolist(), HALF_TANGENTS, strict=True
        )
    ]
    return found[0], found[1]


def highest(view: View) -> float:
    """How high the corners of a view reach, cm over the water's surface."""
    up, across = view.view[:3, 2], view.projection
    x, y = ((np.array([-1.0, 1.0]) + across[k, 2]) / across[k, k] for k in range(2))
    rise = (up[0] * x).max() + (up[1] * y).max() - up[2]
    return float(view.eye[2] + FAR_CM * rise)


def disc(rings: int, sectors: int) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Places (n, 2) on the unit disc, whose rings crowd toward the middle; triangles (m, 3)."""
    radius = np.linspace(0.0, 1.0, rings + 1) ** 2
    angle = np.linspace(0.0, 2 * np.pi, sectors + 1)
    places = radius[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    at = np.arange(places.shape[0] * places.shape[1], dtype=np.int32).reshape(places.shape[:2])
    a, b, c, d = at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]
    triangles = np.stack([a, c, b, b, c, d], axis=2).reshape(-1, 3)
    return places.reshape(-1, 2).astype(np.float32), triangles
