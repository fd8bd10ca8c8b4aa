"""The picture in linear light, and its way to the screen."""

from collections.abc import Sequence
from itertools import chain
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from subsea.render.gl.shaders import program, set_uniforms
from subsea.render.output.quality import Quality
from subsea.view.rig import CUBES, DisplayPatch, Projection, Rect, Warp, Weave
from subsea.view.surround import ROWS, half_tangent

MASK_UNIT = 1  # nothing of the scene is drawn any more

LINEAR = moderngl.LINEAR, moderngl.LINEAR
NEAREST = moderngl.NEAREST, moderngl.NEAREST  # quicker, where each pixel has its own


class RenderTarget:
    """A half-float picture with depth, smoothed by multisampling if asked for."""

    def __init__(self, context: Any, size: tuple[int, int], samples: int) -> None:
        """Whatever of it cannot be made, nothing of it is left behind."""
        self.size = size
        self._context = context
        self._samples = samples
        self._held: list[Any] = []
        try:
            self._picture = self._keep(context.texture(size, 4, dtype="f2"))
            self._picture.repeat_x = self._picture.repeat_y = False  # its neighbours at the edge
            self._flat = self._keep(context.framebuffer([self._picture]))
            colour = self._picture
            if samples:
                colour = self._keep(context.renderbuffer(size, 4, samples=samples, dtype="f2"))
            depth = self._keep(context.depth_renderbuffer(size, samples=samples))
            self.framebuffer = self._keep(context.framebuffer([colour], depth))
        except moderngl.Error:
            self.release()
            raise

    def _keep(self, made: Any) -> Any:
        self._held.insert(0, made)
        return made

    def picture(self) -> Any:
        """The finished picture as a texture."""
        if self._samples:
            self._context.copy_framebuffer(self._flat, self.framebuffer)
        return self._picture

    def release(self) -> None:
        """Free every OpenGL object."""
        for held in self._held:
            held.release()


class ResolvePass:
    """The patches of a rig: from a linear canvas to eight bits, each at its place."""

    def __init__(self, context: Any, patches: Sequence[DisplayPatch], smooth: bool = False) -> None:
        """For these patches; with `smooth` edges are smoothed where a patch shows one eye."""
        self._context = context
        self._made: dict[tuple[int, ...], Any] = {}
        self._plain: dict[tuple[int, ...], Any] = {}  # arrays without vertices
        self._meshes: list[Any] = []  # (vertices, triangles, arrays by program) of warped patches
        self._masks: list[Any] = []
        self._smooth = smooth
        self.arrange(patches)

    def adapt(self, quality: Quality) -> None:
        """Smooth edges, or not, from now on."""
        self._smooth = quality.smooth

    def arrange(self, patches: Sequence[DisplayPatch]) -> None:
        """Other patches from now on."""
        self._release_patches()
        self.patches = tuple(patches)
        for patch in self.patches:
            self._meshes.append(None if patch.warp is None else self._mesh(patch.warp))
            self._masks.append(None if patch.mask is None else self._mask(patch.mask))
        for number in range(len(self.patches)):
            self._array(number, True)

    def draw(
        self,
        canvas: Any,
        into: Any,
        size: tuple[int, int],
        number: int,
        scale: float = 1.0,
        linear: bool = True,
    ) -> None:
        """Show the patch of this `number` in `into`, a framebuffer of `size` pixels.

        The canvas is as large as the rig's times `scale`. It holds light, or, if not `linear`,
        what is to be shown as it is.
        """
        context, patch = self._context, self.patches[number]
        into.use()
        context.viewport = patch.place
        context.disable(context.DEPTH_TEST | context.BLEND)
        compiled, array = self._array(number, linear)
        left, right = scaled(patch.left, scale), scaled(patch.right, scale)
        set_uniforms(
            compiled,
            u_size=size,
            u_left=left,
            u_right=right,
            u_wide=patch.wide,
            u_apart=patch.apart,
            u_shown=_shown(patch),
            u_margin=half_tangent(left[3] // ROWS) if patch.shape in CUBES else 1.0,
            u_mask=MASK_UNIT,
        )
        smooth = self._smooth and linear
        exact = patch.shape == Projection.FLAT and left[2:] == patch.place[2:] and not smooth
        canvas.filter = NEAREST if exact else LINEAR
        canvas.use(0)
        if self._masks[number] is not None:
            self._masks[number].use(MASK_UNIT)
        if patch.warp is None:
            array.render(vertices=3)
        else:
            array.render()

    def release(self) -> None:
        """Free every OpenGL object."""
        self._release_patches()
        for held in chain(self._plain.values(), self._made.values()):
            held.release()

    def _array(self, number: int, linear: bool) -> tuple[Any, Any]:
        """The program of a patch, compiled once, and its vertices."""
        patch = self.patches[number]
        smooth = self._smooth and linear and patch.weave == Weave.PLAIN and patch.shape not in CUBES
        masked = patch.mask is not None
        mesh = patch.warp is not None
        key = tuple(map(int, (patch.weave, patch.shape, mesh, smooth, masked, linear)))
        if key not in self._made:
            names = "WEAVE", "SHAPE", "MESH", "SMOOTH", "MASKED", "LINEAR"
            constants = dict(zip(names, key, strict=True))
            self._made[key] = program(self._context, "resolve", **constants)
            if not mesh:
                self._plain[key] = self._context.vertex_array(self._made[key], [])
        if self._meshes[number] is None:
            return self._made[key], self._plain[key]
        vertices, triangles, arrays = self._meshes[number]
        if key not in arrays:
            arrays[key] = self._context.vertex_array(
                self._made[key], [(vertices, "2f 4f", "in_place", "in_seen")], triangles
            )
        return self._made[key], arrays[key]

    def _mesh(self, warp: Warp) -> tuple[Any, Any, dict[tuple[int, ...], Any]]:
        vertices = self._context.buffer(np.ascontiguousarray(warp.vertices, "f4").tobytes())
        triangles = self._context.buffer(np.ascontiguousarray(warp.triangles, "i4").tobytes())
        return vertices, triangles, {}

    def _mask(self, mask: NDArray[np.floating[Any]]) -> Any:
        height, width = mask.shape[:2]
        data = np.ascontiguousarray(mask[::-1], "f2").tobytes()
        texture = self._context.texture((width, height), 4, data, dtype="f2")
        texture.repeat_x = texture.repeat_y = False
        return texture

    def _release_patches(self) -> None:
        for vertices, triangles, arrays in filter(None, self._meshes):
            for held in (*arrays.values(), triangles, vertices):
                held.release()
        for mask in filter(None, self._masks):
            mask.release()
        self._meshes, self._masks = [], []


def _shown(patch: DisplayPatch) -> tuple[float, float]:
    """Sides of what a patch shows, were it not squeezed; a dome that a mesh bends is a square."""
    if patch.warp is not None and patch.shape == Projection.DOME:
        return 1.0, 1.0
    return patch.place[2] * patch.squeezed[0], patch.place[3] * patch.squeezed[1]


def scaled(rect: Rect, scale: float) -> Rect:
    """A rectangle on a canvas that is `scale` times as large; neighbours still meet."""
    x, y, width, height = rect
    left, bottom = round(scale * x), round(scale * y)
    right, top = round(scale * (x + width)), round(scale * (y + height))
    return left, bottom, max(right - left, 1), max(top - bottom, 1)
