"""The open water behind everything, and the surface seen from below."""

from math import tan
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array
from subsea.frame.packet import RenderScene
from subsea.rendering.gl.context import GpuOwner
from subsea.rendering.gl.id_buffer import SURFACE
from subsea.rendering.gl.programs import ProgramVariants
from subsea.rendering.gl.shaders import TEXTURE_UNITS
from subsea.rendering.gl.textures import Texels, in_bytes, next_mipmap, repeating_levels, ripples
from subsea.rendering.output.quality import Quality
from subsea.view.camera import FAR_CM, View
from subsea.view.display_rigs import VERTICAL_FOV

COARSE, FINE = (64, 36), (160, 90)  # cells of the background on a plain 16:9 display
HALF_TANGENTS = (16 / 9 * tan(VERTICAL_FOV / 2), tan(VERTICAL_FOV / 2))  # of that display
STEPS = (8, 9)  # narrower views have fewer cells, rounded to these numbers of steps
FINE_FROM = 8  # samples of a light shaft from which the grid is fine
RINGS, SECTORS = 16, 48  # of the surface, a disc
MOST_SLOPE = 4.0  # of the bytes of waves, as `surface.frag` has it; also their greatest variance


class WaterRenderer(GpuOwner):
    """Draws the background on a grid, and the surface on a disc."""

    def __init__(self, context: Any, scene: RenderScene, quality: Quality) -> None:
        super().__init__()
        self._context = context
        self._background = self.own(ProgramVariants(context, "water", None, quality.defines))
        self._grids: dict[tuple[int, int], Any] = {}  # arrays by numbers of cells
        self.adapt(quality)
        self._surface = self.own(ProgramVariants(context, "surface", SURFACE, quality.defines))
        self._floor = float(np.mean(scene.terrain))
        self._waves = self.own(repeating_levels(context, wave_levels, 3))
        places, triangles = self.own_buffers(context, *disc(RINGS, SECTORS))
        self._disc = self._surface.array([(places, "2f4", "a_place")], triangles)

    def adapt(self, quality: Quality) -> None:
        """Use a grid as fine as the light shafts of this quality."""
        self._cells = FINE if quality.shafts >= FINE_FROM else COARSE

    def draw(self, view: View, uniforms: dict[str, Any]) -> int:
        """Fill the pixels that nothing covers; returns the number of triangles."""
        cells = cells_for(view, self._cells)
        if cells not in self._grids:
            triangles = self.own_buffers(self._context, grid(*cells))
            self._grids[cells] = self._background.array([], *triangles)
        background = self._background.ready(self._grids[cells], False, **uniforms, u_cells=cells)
        background.render(moderngl.TRIANGLES)
        self._context.enable(moderngl.BLEND)
        return background.vertices // 3 + self.draw_surface(view, uniforms)

    def draw_surface(self, view: View, uniforms: dict[str, Any], as_ids: bool = False) -> int:
        """Draw the surface or its object id if in view; returns the number of triangles."""
        if highest(view) < 0.0:
            return 0
        self._waves.use(TEXTURE_UNITS["u_waves"])
        ready = self._surface.ready(self._disc, as_ids, **uniforms, u_floor=self._floor)
        ready.render(moderngl.TRIANGLES)
        return int(self._disc.vertices) // 3


def wave_levels(seed: int) -> list[Texels]:
    """The mipmaps of the surface, largest first: slopes along x and y, and their variance.

    The variance of what a level averages out makes the surface rough where its waves are too small
    to be seen. A software renderer reads bytes faster than half floats.
    """
    x: Array
    y: Array
    x, y = ripples(seed)
    square: Array = x**2 + y**2
    levels = []
    low, high = np.array([-MOST_SLOPE, -MOST_SLOPE, 0.0, 0.0]), np.full(4, MOST_SLOPE)
    while True:
        lost = np.maximum(square - x**2 - y**2, 0.0)
        levels.append(in_bytes([x, y, lost, 0.0 * x], low, high))
        if len(x) == 1:
            return levels
        x, y, square = (next_mipmap(layer) for layer in (x, y, square))


def grid(across: int, down: int) -> NDArray[np.int32]:
    """Triangles (n, 3) over a grid of (down + 1)·(across + 1) vertices, row by row."""
    corner = np.arange((across + 1) * (down + 1), dtype=np.int32).reshape(down + 1, across + 1)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, :-1], corner[1:, 1:]
    return np.stack([a, b, c, c, b, d], axis=2).reshape(-1, 3)


def cells_for(view: View, plain: tuple[int, int]) -> tuple[int, int]:
    """Cells across and down, each about as wide an angle as `plain` ones on a plain display."""
    scales = float(view.projection[0, 0]), float(view.projection[1, 1])
    across, down = (
        plain[k]
        // STEPS[k]
        * min(max(round(STEPS[k] / (scales[k] * HALF_TANGENTS[k])), 1), STEPS[k])
        for k in range(2)
    )
    return across, down


def highest(view: View) -> float:
    """Height of the highest corner of a view, cm above the surface."""
    up, across = view.view[:3, 2].tolist(), view.projection.tolist()
    x, y = (
        max(up[k] * (side + across[k][2]) / across[k][k] for side in (-1.0, 1.0)) for k in range(2)
    )
    return float(view.eye[2]) + FAR_CM * (x + y - up[2])


def disc(rings: int, sectors: int) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Vertices (n, 2) of the unit disc, denser toward the middle, and triangles (m, 3)."""
    radius = np.linspace(0.0, 1.0, rings + 1) ** 2
    angle = np.linspace(0.0, 2 * np.pi, sectors + 1)
    places = radius[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    at = np.arange(places.shape[0] * places.shape[1], dtype=np.int32).reshape(places.shape[:2])
    a, b, c, d = at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]
    triangles = np.stack([a, c, b, b, c, d], axis=2).reshape(-1, 3)
    return places.reshape(-1, 2).astype(np.float32), triangles
