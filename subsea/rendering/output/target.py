"""The canvas in linear light, the pass that resolves it to eight bits, and further windows."""

import ctypes
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from itertools import product
from typing import Any

import moderngl
import numpy as np

from subsea.base.arrays import Array
from subsea.rendering.gl.context import GpuOwner, gl_function
from subsea.rendering.gl.shaders import TEXTURE_UNITS, program, set_uniforms, source
from subsea.rendering.gl.textures import upload
from subsea.rendering.output.quality import PRESETS, Quality
from subsea.scenario.schema import UNGRADED, Grade
from subsea.view.adjustment import MOST_EDGES
from subsea.view.meshes import fine_mesh, lit_places, shown_size
from subsea.view.rig import CUBES, TONE, DisplayPatch, Projection, Rect, Rgb, Warp, Weave
from subsea.view.surround import ROWS, half_tangent

BLOOM_ROWS = 200  # most rows of the blurred picture: the blur is a share of the height


class Bloom(GpuOwner):
    """Draws the bloom of a part of a canvas, small and blurred."""

    def __init__(self, context: Any) -> None:
        """Compile its passes."""
        super().__init__()
        self._context = context
        self._bright, self._smaller, self._blur = (
            self._pass(BRIGHT=bright, BLUR=blur) for bright, blur in ((1, 0), (0, 0), (0, 1))
        )
        self._held = self.own(GpuOwner())  # of the size below
        self._size = (0, 0)
        self._levels: list[tuple[Any, Any]] = []  # textures and their framebuffers

    def draw(self, canvas: Any, part: Rect) -> Any:
        """The bloom of a part of the canvas, in pixels: a texture, valid until the next."""
        if self._size != part[2:]:
            self._make(part[2:])
        context = self._context
        context.disable(context.DEPTH_TEST | context.BLEND | context.CULL_FACE)
        canvas.filter = context.LINEAR, context.LINEAR
        wide, high = canvas.size
        x, y, width, height = part
        before, shares = canvas, (x / wide, y / high, width / wide, height / high)
        passed = self._bright
        *levels, spare = self._levels
        for level in levels:
            # Between the first two texels of four and between the last two.
            step = 1.0 / before.size[0], 1.0 / before.size[1]
            before = self._draw(passed, before, level, shares, step)
            passed, shares = self._smaller, (0.0, 0.0, 1.0, 1.0)
        small = levels[-1]
        across, down = 1.0 / before.size[0], 1.0 / before.size[1]
        self._draw(self._blur, before, spare, shares, (across, 0.0))
        return self._draw(self._blur, spare[0], small, shares, (0.0, down))

    def _make(self, size: tuple[int, int]) -> None:
        """Textures of a quarter of the size before, down to few rows, and another of the last."""
        self._held.release()
        self._size, self._levels = size, []
        width, height = size
        while not self._levels or height > BLOOM_ROWS:
            width, height = max(width // 4, 1), max(height // 4, 1)
            self._levels.append(self._level((width, height)))
        self._levels.append(self._level((width, height)))

    def _level(self, size: tuple[int, int]) -> tuple[Any, Any]:
        texture = self._held.own(self._context.texture(size, 4, dtype="f2"))
        texture.repeat_x = texture.repeat_y = False
        return texture, self._held.own(self._context.framebuffer([texture]))

    def _pass(self, **constants: int) -> tuple[Any, Any]:
        compiled = self._context.program(
            vertex_shader=source("present.vert"),
            fragment_shader=source("bloom.frag", **constants),
        )
        return self.own(compiled), self.own(self._context.vertex_array(compiled, []))

    def _draw(
        self,
        passed: tuple[Any, Any],
        before: Any,
        into: tuple[Any, Any],
        shares: tuple[float, float, float, float],
        step: tuple[float, float],
    ) -> Any:
        compiled, triangle = passed
        texture, framebuffer = into
        framebuffer.use()
        self._context.viewport = (0, 0, *texture.size)
        set_uniforms(compiled, u_source=shares, u_step=step)
        before.use(0)
        triangle.render(vertices=3)
        return texture


AMBER = np.array([1.0, 0.0, -1.0])  # logarithms of the factors on red, green and blue
WARMEST = 0.35  # of these, by the greatest warmth

Into = Mapping[int, Any]  # framebuffers by output
OWN: Into = {}  # all outputs are drawn into the renderer's own pictures

LINEAR = moderngl.LINEAR, moderngl.LINEAR
NEAREST = moderngl.NEAREST, moderngl.NEAREST  # faster where texels match pixels
# Vertices, where they are lit, triangles, and arrays by constants.
_Mesh = tuple[Any, Any, Any, dict[tuple[int, ...], Any]]
FULL = (1.0, 1.0, 1.0)  # factors on light that change nothing


@lru_cache(maxsize=8)
def gain(grade: Grade) -> tuple[float, float, float]:
    """The factors of a grade on red, green and blue light, before contrast and saturation."""
    red, green, blue = 2.0**grade.exposure_ev * np.exp(WARMEST * grade.warmth * AMBER)
    return float(red), float(green), float(blue)


DEPTH = 0x0100  # OpenGL's bit of the depth buffer
MOST_LIGHT = 8.0  # that a canvas of integers holds: the filmic curve shows more of it as white


class RenderTarget(GpuOwner):
    """A canvas with depth, optionally multisampled, and the pictures made of it.

    It holds half floats or, if of integers, 16 bits from no light to MOST_LIGHT, which a software
    renderer blends and reads for less. `unit` is what the canvas holds for a light of 1.
    """

    def __init__(
        self,
        context: Any,
        size: tuple[int, int],
        samples: int,
        outputs: Sequence[tuple[int, int]],
        pages: int = 1,
        quality: Quality = PRESETS["medium"],
    ) -> None:
        """Make it, with a picture for each page of each output; moderngl.Error leaves nothing.

        It is of integers, and its pictures are deep, as the `quality` says.
        """
        super().__init__()
        # Textures of 8 or 16 bits by output and page, and their framebuffers.
        self.pictures: dict[tuple[int, int], Any] = {}
        self.framebuffers: dict[tuple[int, int], Any] = {}
        self.size = size
        self._context = context
        self._clear = gl_function(context, "glClear", ctypes.c_uint)
        self.samples = samples
        self.unit = 1.0 / MOST_LIGHT if quality.integers else 1.0
        kind = "nu2" if quality.integers else "f2"
        self.deep = quality.deep
        shown = "nu2" if quality.deep else "f1"
        try:
            self.canvas = self.own(context.texture(size, 4, dtype=kind))
            self.canvas.repeat_x = self.canvas.repeat_y = False
            self.flat = self.own(context.framebuffer([self.canvas]))
            colour = self.canvas
            if samples:
                colour = self.own(context.renderbuffer(size, 4, samples=samples, dtype=kind))
            depth = self.own(context.depth_renderbuffer(size, samples=samples))
            self.framebuffer = self.own(context.framebuffer([colour], depth))
            for key in product(range(len(outputs)), range(pages)):
                self.pictures[key] = self.own(context.texture(outputs[key[0]], 4, dtype=shown))
                self.framebuffers[key] = self.own(context.framebuffer([self.pictures[key]]))
        except moderngl.Error:
            self.release()
            raise

    def release(self) -> None:
        """Free every OpenGL object."""
        # moderngl binds the last framebuffer again when it makes one, which must not be freed.
        self._context.detect_framebuffer(0).use()
        super().release()

    def begin(self, whole: bool) -> None:
        """Use the canvas and clear it; of one whose `whole` surface is drawn, the depth alone.

        A software renderer clears colours in a thirtieth of the time of a picture.
        """
        self.framebuffer.use()
        if whole:
            self._clear(DEPTH)
        else:
            self.framebuffer.clear()

    def resolved(self) -> Any:
        """The canvas as a texture, with samples resolved."""
        if self.samples:
            self._context.copy_framebuffer(self.flat, self.framebuffer)
        return self.canvas

    def picture(self, output: int, page: int) -> Any:
        """Read a finished picture (h, w, 3) of 8 or 16 bits, top row first."""
        framebuffer = self.framebuffers[output, page]
        width, height = framebuffer.size
        data = framebuffer.read(components=3, alignment=1, dtype="nu2" if self.deep else "f1")
        kind = np.uint16 if self.deep else np.uint8
        return np.frombuffer(data, kind).reshape(height, width, 3)[::-1]

    def light(self, part: Rect) -> Array:
        """Read the light (h, w, 3) of a part of the canvas that was resolved last, float32."""
        kind, width, height = self.canvas.dtype, *part[2:]
        data = self.flat.read(part, components=3, alignment=1, dtype=kind)
        texels = np.frombuffer(data, np.float16 if kind == "f2" else np.uint16)
        light = texels.reshape(height, width, 3)[::-1].astype(np.float32)
        return np.asarray(light / self.unit / (1.0 if kind == "f2" else 65535.0))


class ResolvePass(GpuOwner):
    """Draws the patches of a rig from a linear canvas to eight-bit outputs."""

    def __init__(
        self,
        context: Any,
        patches: Sequence[DisplayPatch],
        smooth: bool = False,
        grade: Grade = UNGRADED,
    ) -> None:
        """`smooth` smooths edges where a patch shows one eye; light is developed by `grade`."""
        super().__init__()
        self.grade = grade
        self._context = context
        self._programs: dict[tuple[int, ...], Any] = {}  # by constants
        self._plain: dict[tuple[int, ...], Any] = {}  # arrays without vertices
        self._held = self.own(GpuOwner())  # of these patches
        self.smooth, self._deep = smooth, False
        self.patches: tuple[DisplayPatch, ...] = ()
        self._fine: list[Warp | None] = []  # the meshes of the patches
        self._bloom: Bloom | None = None
        self.arrange(patches)

    def adapt(self, quality: Quality) -> None:
        """Smooth edges, and let what is bright spread, as this quality says."""
        self.smooth, self._deep = quality.smooth, quality.deep
        if quality.bloom and self._bloom is None:
            self._bloom = self.own(Bloom(self._context))
        elif not quality.bloom and self._bloom is not None:
            self._bloom.release()
            self._bloom = None

    def arrange(self, patches: Sequence[DisplayPatch]) -> None:
        """Replace the patches."""
        self._held.release()
        fine = zip(self.patches, self._fine, strict=True)
        self.patches = tuple(patches)
        self._fine = self._cut(fine)
        # Of warps: vertices, triangles, and arrays by constants.
        self._meshes = [
            None if mesh is None else self._mesh(patch, mesh)
            for patch, mesh in zip(self.patches, self._fine, strict=True)
        ]
        self._masks: list[Any] = [
            None if p.mask is None else self._mask(p.mask) for p in self.patches
        ]
        # 0 without a mask, 1 with one, 2 if it adds light.
        self._masked = [
            0 if p.mask is None else 1 + bool(np.any(p.mask[..., 3])) for p in self.patches
        ]
        for number, patch in enumerate(self.patches):
            self._array(number, True, exact=self._exact(number, patch.left))

    def draw(
        self,
        canvas: Any,
        into: Any,
        size: tuple[int, int],
        number: int,
        scale: float = 1.0,
        unit: float | None = 1.0,
    ) -> None:
        """Draw patch `number` into `into`, a framebuffer of `size` pixels.

        The canvas is `scale` times the size of the rig's. It holds linear light, `unit` for a light
        of 1. None means that it holds final colours.
        """
        context, patch, linear = self._context, self.patches[number], unit is not None
        bloom = self._bloom if linear and self._may_bloom(patch) else None
        if bloom is not None:
            bloom.draw(canvas, scaled(patch.left, scale)).use(TEXTURE_UNITS["u_bloom"])
        into.use()
        context.viewport = patch.place
        context.disable(context.DEPTH_TEST | context.BLEND)
        left, right = scaled(patch.left, scale), scaled(patch.right, scale)
        gammas = _gammas(patch)
        exact = self._exact(number, left, linear)
        compiled, array = self._array(number, linear, bloom is not None, exact)
        set_uniforms(
            compiled,
            u_size=size,
            u_left=left,
            u_right=right,
            u_wide=patch.wide,
            u_gamma=gammas,
            u_tone=tuple(TONE / gamma for gamma in gammas),
            u_apart=patch.apart,
            u_shown=self._shown(number),
            u_margin=half_tangent(left[3] // ROWS) if patch.shape in CUBES else 1.0,
            u_gain=gain(self.grade),
            u_contrast=self.grade.contrast,
            u_saturation=self.grade.saturation,
            u_whole=1.0 / (unit or 1.0),
            u_shift=(left[0] - patch.place[0], left[1] - patch.place[1]),
            **_adjusted(patch),
        )
        canvas.filter = NEAREST if exact else LINEAR
        canvas.use(0)
        if self._masks[number] is not None:
            self._masks[number].use(TEXTURE_UNITS["u_mask"])
        array.render(vertices=3 if self._meshes[number] is None else -1)

    def _may_bloom(self, patch: DisplayPatch) -> bool:
        """True for the only picture of one eye: others would not match at their edges."""
        plain = patch.weave == Weave.PLAIN and patch.shape == Projection.FLAT
        return plain and patch.mask is None and len(self.patches) == 1

    def _exact(self, number: int, left: Rect, linear: bool = True) -> bool:
        """True if each pixel of a patch is one of its source `left` on the canvas."""
        patch = self.patches[number]
        if patch.shape != Projection.FLAT or self._meshes[number] is not None:
            return False
        return left[2:] == patch.place[2:] and not (self.smooth and linear)

    def _array(
        self, number: int, linear: bool, bloom: bool = False, exact: bool = False
    ) -> tuple[Any, Any]:
        """The program of a patch, compiled when first needed, and its vertex array."""
        patch, held = self.patches[number], self._meshes[number]
        meshed = held is not None and patch.shape == Projection.FLAT
        plain = patch.weave == Weave.PLAIN and patch.shape not in CUBES
        constants = {
            "WEAVE": int(patch.weave),
            "SHAPE": int(Projection.WARPED if meshed else patch.shape),
            "MESH": int(held is not None),
            "SMOOTH": int(self.smooth and linear and plain),
            "MASKED": self._masked[number],
            "LINEAR": int(linear),
            "GRADED": int(linear and self.grade != UNGRADED),
            "BLOOM": int(bloom),
            "EXACT": int(exact),
            "DEEP": int(self._deep),
            "TONED": int(isinstance(patch.gamma, tuple)),
            "ADJUSTED": int(_is_weakened(patch)),
        }
        key = tuple(constants.values())
        if key not in self._programs:
            self._programs[key] = self.own(program(self._context, "resolve", **constants))
            if held is None:
                self._plain[key] = self.own(self._context.vertex_array(self._programs[key], []))
        compiled = self._programs[key]
        if held is None:
            return compiled, self._plain[key]
        vertices, lit, triangles, arrays = held
        if key not in arrays:
            # A shader without a mask may have no use for the place.
            used = "in_place" in compiled
            names = ("2f 4f", "in_place", "in_seen") if used else ("2x4 4f", "in_seen")
            content = [(vertices, *names), (lit, "3f", "in_lit")]
            array = self._context.vertex_array(compiled, content, triangles)
            arrays[key] = self._held.own(array)
        return compiled, arrays[key]

    def _cut(self, before: Iterable[tuple[DisplayPatch, Warp | None]]) -> list[Warp | None]:
        """Cut the meshes of the patches; those of `before` that would be the same are kept."""
        kept = {(id(patch.warp), _cuts(patch)): mesh for patch, mesh in before}
        return [
            kept.get((id(patch.warp), _cuts(patch))) or fine_mesh(patch) for patch in self.patches
        ]

    def _mesh(self, patch: DisplayPatch, mesh: Warp) -> _Mesh:
        parts = mesh.vertices.astype("f4"), lit_places(patch, mesh).astype("f4")
        triangles = mesh.triangles.astype("i4")
        return *self._held.own_buffers(self._context, *parts, triangles), {}

    def _shown(self, number: int) -> tuple[float, float]:
        """Width and height that a patch shows unsqueezed; a dome in a mesh is a square."""
        patch = self.patches[number]
        if self._meshes[number] is not None and patch.shape == Projection.DOME:
            return 1.0, 1.0
        return shown_size(patch)

    def _mask(self, mask: Array) -> Any:
        return self._held.own(upload(self._context, mask[::-1].astype("f2")))


def _cuts(patch: DisplayPatch) -> tuple[object, ...]:
    """Return all that the fine mesh of a patch depends on, beside its warp."""
    adjustment = patch.adjustment
    points = None if adjustment is None or adjustment.points is None else adjustment.points.shape
    moves = adjustment is not None and adjustment.moves
    return points, moves, patch.shape, shown_size(patch)


def _gammas(patch: DisplayPatch) -> Rgb:
    """The gamma of a projector for red, green and blue."""
    return patch.gamma if isinstance(patch.gamma, tuple) else (patch.gamma,) * 3


def _is_weakened(patch: DisplayPatch) -> bool:
    """True if a patch has weaker colours or an edge mask."""
    adjustment = patch.adjustment
    return adjustment is not None and (adjustment.edge is not None or adjustment.gain != FULL)


def _adjusted(patch: DisplayPatch) -> dict[str, Any]:
    """Return the uniforms of a patch with weaker colours or an edge mask."""
    adjustment = patch.adjustment
    if adjustment is None or not _is_weakened(patch):
        return {}
    edge = np.zeros((MOST_EDGES, 2), np.float32)
    count = 0 if adjustment.edge is None else len(adjustment.edge)
    if adjustment.edge is not None:
        edge[:count] = patch.place[:2] + adjustment.edge * np.array(patch.place[2:])
    return {
        "u_weaker": tuple(
            share ** (1.0 / gamma)
            for share, gamma in zip(adjustment.gain, _gammas(patch), strict=True)
        ),
        "u_edge": edge.tobytes(),
        "u_edges": count,
        "u_soft": adjustment.edge_soft_px,
    }


def scaled(rect: Rect, scale: float) -> Rect:
    """A rectangle on a canvas `scale` times as large; adjacent ones stay adjacent."""
    x, y, width, height = rect
    left, bottom = round(scale * x), round(scale * y)
    right, top = round(scale * (x + width)), round(scale * (y + height))
    return left, bottom, max(right - left, 1), max(top - bottom, 1)


class Presenter(GpuOwner):
    """Draws textures of one context over the window of another that shares its objects.

    Vertex arrays and state belong to one context, so each window needs a presenter of its own,
    made and used while that window is current.
    """

    def __init__(
        self, context: Any, page: Callable[[int], object] = lambda number: None, pages: int = 1
    ) -> None:
        """Use the context of the window; `page` selects one of its `pages` buffers."""
        super().__init__()
        self._context = context
        self._page, self._pages = page, pages
        compiled = self.own(program(context, "present"))
        self._triangle = self.own(context.vertex_array(compiled, []))
        self._shade = self.own(program(context, "shade"))
        self._shaded = self.own(context.vertex_array(self._shade, []))

    def show(self, pages: Sequence[Any], size: tuple[int, int]) -> None:
        """Fill the window of `size` pixels with a finished texture, or one for each eye."""
        context = self._context
        context.screen.use()
        context.viewport = (0, 0, *size)
        context.disable(context.DEPTH_TEST | context.BLEND | context.CULL_FACE)
        for number, picture in enumerate(pages):
            self._page(number)
            seen = context.external_texture(picture.glo, picture.size, 4, 0, "f1")
            filtered = context.NEAREST if picture.size == size else context.LINEAR
            seen.filter = filtered, filtered
            seen.repeat_x = seen.repeat_y = False
            seen.use(0)
            self._triangle.render(vertices=3)

    def darken(self, shade: tuple[float, float, float, float], size: tuple[int, int]) -> None:
        """Blend a colour with opacity over all buffers of the window of `size` pixels."""
        context = self._context
        context.screen.use()
        context.viewport = (0, 0, *size)
        context.disable(context.DEPTH_TEST | context.CULL_FACE)
        context.enable(context.BLEND)
        context.blend_func = context.SRC_ALPHA, context.ONE_MINUS_SRC_ALPHA
        set_uniforms(self._shade, u_shade=shade)
        for number in range(self._pages):
            self._page(number)
            self._shaded.render(vertices=3)
        context.disable(context.BLEND)
