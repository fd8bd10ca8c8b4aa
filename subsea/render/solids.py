"""Pillars and rocks: weathered stone in three levels of detail, and their shadows on the sand."""

from typing import Any, NamedTuple

import moderngl
import numpy as np
from numpy.typing import NDArray

from subsea.frame import LEVELS, Packet, Scene
from subsea.render.seabed import drawn_height, thinned
from subsea.render.shaders import program, set_uniforms
from subsea.render.stone import Shape, pillar_shape, rock_shape, shadow
from subsea.render.textures import relief, upload
from subsea.view.camera import View
from subsea.view.culling import HIDDEN, IN_SIGHT, classify

Array = NDArray[np.floating[Any]]

RELIEF_UNIT = 4  # texture unit
# Levels of detail are meant for fishes: a solid counts as so many of its radii long.
LIKE_A_FISH = 1.2


class Solids:
    """Holds the shapes of all solids, level after level, and all shadows."""

    def __init__(self, context: Any, scene: Scene) -> None:
        """Shape them once; `scene` says where they stand."""
        self._context = context
        width = scene.terrain_half_width_cm
        heights = thinned(scene.terrain, width)
        self._reach = IN_SIGHT * scene.water.visibility_cm
        self._number = len(scene.pillars) + len(scene.rocks)
        self._held: list[Any] = []
        if not self._number:
            return

        def floor(x: Array, y: Array) -> Array:
            return drawn_height(heights, width, x, y)

        shapes: list[Shape] = []
        for level in range(len(LEVELS)):
            shapes += [pillar_shape(row, floor, level) for row in scene.pillars]
            shapes += [rock_shape(row, floor, level) for row in scene.rocks]
        shadows = [shadow(row[None], scene.rocks[:0], floor) for row in scene.pillars]
        shadows += [shadow(scene.pillars[:0], row[None], floor) for row in scene.rocks]
        self._relief = upload(context, relief(5))
        self._solids = self._buffered(
            program(context, "solid"),
            shapes,
            "3f4 3f4 4f4 1f4",
            "a_position a_normal a_cover a_above",
        )
        self._shadows = self._buffered(
            program(context, "shadow"), shadows, "3f4 1f4", "a_position a_dark"
        )
        self._held.append(self._relief)

    def _buffered(
        self, compiled: Any, shapes: list[Shape], layout: str, attributes: str
    ) -> "_Shapes":
        """All shapes in one pair of buffers, one after another."""
        starts = np.cumsum([0] + [len(shape.vertices) for shape in shapes])
        triangles = np.concatenate(
            [shape.triangles + start for shape, start in zip(shapes, starts, strict=False)]
        )
        vertices = np.concatenate([shape.vertices for shape in shapes])
        buffers = [
            self._context.buffer(part.tobytes())
            for part in (vertices.astype("f4"), triangles.astype("i4"))
        ]
        array = self._context.vertex_array(
            compiled, [(buffers[0], layout, *attributes.split())], buffers[1]
        )
        self._held += [array, *buffers, compiled]
        places = [shape.vertices[:, :3].astype(np.float64) for shape in shapes[: self._number]]
        centres = np.array([(at.min(axis=0) + at.max(axis=0)) / 2 for at in places])
        radii = [
            float(np.linalg.norm(at - centre, axis=1).max())
            for at, centre in zip(places, centres, strict=True)
        ]
        first = np.cumsum([0] + [shape.triangles.size for shape in shapes])
        return _Shapes(compiled, array, first, centres, np.array(radii))

    def draw(self, packet: Packet, view: View, uniforms: dict[str, Any]) -> int:
        """Draw the solids in sight; the number of triangles."""
        if not self._number:
            return 0
        self._relief.use(RELIEF_UNIT)
        set_uniforms(self._solids.program, u_relief=RELIEF_UNIT)
        self._context.enable(moderngl.CULL_FACE)
        total = self._draw(self._solids, view, uniforms)
        self._context.disable(moderngl.CULL_FACE)
        return total

    def draw_shadows(self, packet: Packet, view: View, uniforms: dict[str, Any]) -> int:
        """Darken the sand that has been drawn, blended; the number of triangles."""
        return self._draw(self._shadows, view, uniforms) if self._number else 0

    def _draw(self, shapes: "_Shapes", view: View, uniforms: dict[str, Any]) -> int:
        """Those of the shapes that are in the frustum and that the water does not hide."""
        set_uniforms(shapes.program, **uniforms)
        size = LIKE_A_FISH * shapes.radii
        level = classify(shapes.centres, shapes.radii, size, [view], True, True)
        far = np.linalg.norm(shapes.centres - view.eye, axis=1) - shapes.radii > self._reach
        total = 0
        for k in np.flatnonzero((level != HIDDEN) & ~far):
            # Shadows have but one level.
            shape = (int(level[k]) * self._number + int(k)) % (len(shapes.first) - 1)
            first, end = int(shapes.first[shape]), int(shapes.first[shape + 1])
            shapes.array.render(moderngl.TRIANGLES, vertices=end - first, first=first)
            total += (end - first) // 3
        return total

    def release(self) -> None:
        """Free every OpenGL object."""
        for held in self._held:
            held.release()


class _Shapes(NamedTuple):
    """Shapes in one buffer: those of all solids at the finest level, then coarser ones."""

    program: Any
    array: Any
    first: NDArray[np.integer[Any]]  # where the indices of each begin, with the end of the last
    centres: Array  # (k, 3) cm, of the spheres about the finest ones
    radii: Array  # (k,) cm
