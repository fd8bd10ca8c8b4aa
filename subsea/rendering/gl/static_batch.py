"""Static geometry in one vertex buffer: each view draws the visible items in one call."""

import ctypes
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.rendering.gl.context import GpuOwner, gl_function
from subsea.rendering.gl.item_levels import (
    Drawn,
    LevelState,
    advance,
    empty_levels,
    levels_in_sight,
    list_calls,
    nearness,
)
from subsea.rendering.gl.programs import ProgramVariants, variant_array
from subsea.rendering.gl.shaders import TEXTURE_UNITS
from subsea.view.camera import View
from subsea.view.culling import view_arrays

NEAR_PX, MIDDLE_PX = 360.0, 130.0  # default diameters from which the levels are used
TRIANGLES, UNSIGNED_INT = 0x0004, 0x1405  # OpenGL enums
FADING = ("FADING",)  # variant of a program that draws a share of the pixels
BITTEN = ("BITTEN",)  # variant that shows traces of feeding, `bites.glsl`
NO_BITES = np.zeros((0, 4), np.float32)


class StaticMesh(NamedTuple):
    """One item at one level of detail, in world coordinates."""

    vertices: Array  # (n, c) float32; the first three columns are the position, cm
    triangles: Ints  # (m, 3), counter-clockwise from outside

    @property
    def number(self) -> int:
        """The number of vertices."""
        return len(self.vertices)


class LazyMesh(NamedTuple):
    """A static mesh whose vertices are computed whenever they are read."""

    make: Callable[[], Array]
    number: int  # of vertices
    triangles: Ints

    @property
    def vertices(self) -> Array:
        """As those of a StaticMesh."""
        return self.make()


class StaticBatch(GpuOwner):
    """Holds the vertices and triangles of all items; one call draws the chosen items."""

    def __init__(
        self,
        programs: ProgramVariants,
        layout: str,
        attributes: str,
        items: Sequence[Sequence[StaticMesh | LazyMesh]],
        reach_cm: float,
        thresholds_px: Sequence[float] = (NEAR_PX, MIDDLE_PX),
        spheres: Array | None = None,
    ) -> None:
        """Reserve space for `items`: the levels of each, finest first; the last is used beyond.

        `layout` and `attributes` are moderngl's, `reach_cm` is how far one sees. Level k is used
        from `thresholds_px[k]` pixels on. `spheres` (k, 4) are the bounding spheres of the items,
        computed if None. The batch releases `programs`.
        """
        super().__init__()
        self.textures: dict[str, Any] = {}  # by the names of their samplers
        self.uniforms: dict[str, Any] = {}  # beside those of a view
        self._programs = self.own(programs)
        self._reach = reach_cm
        self._thresholds = np.asarray(thresholds_px, np.float64)
        # A mesh used for two levels is held once; meshes that differ only in their vertices share
        # their triangles.
        flat = list({id(mesh): mesh for levels in items for mesh in levels}.values())
        lists = list({id(mesh.triangles): mesh.triangles for mesh in flat}.values())
        triangles = np.concatenate([np.zeros((0, 3), np.int32), *lists]).astype("i4")
        self._ranges = _ranges(items, len(thresholds_px) + 1, flat, lists)
        spheres = bounding_spheres(items) if spheres is None else spheres
        self._centres, self._radii = spheres[:, :3].copy(), spheres[:, 3].copy()
        self._state = empty_levels(len(items))
        self._drawn = _nothing_drawn(0, len(items))
        self._all = np.ones(len(items), np.bool_)
        # Boxes about the items, whose sides a part may know better.
        self._low = self._centres - self._radii[:, None]
        self._high = self._centres + self._radii[:, None]
        self._draw_many = _multi_draw(programs.context)
        self._chosen = _DrawnRanges(*(np.zeros(0, kind) for kind in ("i4", "i8", "i4")))
        # Calls of each view: first and end among the chosen; triangles; share to draw; variant.
        self._calls: list[list[tuple[int, int, int, float, tuple[str, ...]]]] = []
        item = {id(mesh): k for k, levels in enumerate(items) for mesh in levels}
        self._owners = [item[id(mesh)] for mesh in flat], [mesh.number for mesh in flat]
        self._array: Any = None
        if not flat:
            return
        # Most meshes are never drawn at their finest: each is uploaded when first drawn.
        first = np.cumsum([0, *self._owners[1]]).tolist()
        self._waiting = {at: mesh for at, mesh in zip(first, flat, strict=False) if mesh.number}
        self._absent = np.isin(self._ranges[..., 2], [*self._waiting])  # (k, levels)
        self._stride = sum(int(part[0]) * int(part[2]) for part in layout.split())
        self._vertices = self.own(programs.context.buffer(reserve=self._stride * first[-1]))
        self._indices = self.own(programs.context.buffer(triangles))
        self._content = self._vertices, layout, *attributes.split()
        self._array = programs.array([self._content], self._indices)

    def choose(
        self,
        views: Sequence[View],
        time_s: float = 0.0,
        detail: float = 1.0,
        shown: Bools | None = None,
        bites: Array | None = None,
    ) -> None:
        """Choose the items that each view draws, and a level for each that all views share.

        Changes of level fade from picture to picture, which are at `time_s` of the world. `detail`
        is a factor on the pixels that an item covers; infinite draws every item at its finest
        level. `shown` (k,) leaves items out, `bites` are those of a packet.
        """
        if self._array is None:
            return
        level, seen = levels_in_sight(
            (self._centres, self._radii), views, self._reach, detail, self._thresholds,
            self._state.level,
        )  # fmt: skip
        new = len(self._drawn.seen) != len(views)
        if new:
            self._drawn = _nothing_drawn(len(views), len(level))
        shown = self._all if shown is None else shown
        bites = NO_BITES if bites is None else bites
        boxes = self._low, self._high
        drawn = self._drawn
        changed = advance(level, shown, seen, time_s, boxes, bites, self._state, drawn)
        if not changed and not new:
            return
        # Near items first, so that hidden pixels are not lit; sorted only when the choice changes.
        near = nearness(self._centres, self._radii, view_arrays(views).eyes, drawn.seen)
        calls, *chosen, missing = list_calls(
            np.argsort(near), self._state, drawn, self._ranges, self._absent
        )
        self._make({*missing.tolist()})
        self._chosen = _DrawnRanges(*chosen)
        self._calls = [[] for _ in views]
        for view, first, end, triangles, share, bitten in calls.tolist():
            wants = (FADING if share else ()) + (BITTEN if bitten else ())
            self._calls[int(view)].append((int(first), int(end), int(triangles), share, wants))

    def _make(self, missing: set[int]) -> None:
        """Upload the meshes with these first vertices, which are drawn for the first time."""
        for first in missing:
            vertices = np.ascontiguousarray(self._waiting.pop(first).vertices, "f4")
            self._vertices.write(vertices, self._stride * first)
            self._absent &= self._ranges[..., 2] != first

    def cast(self, compiled: Any, level: int) -> None:
        """Draw every item at a level with a program that reads positions alone."""
        if self._array is None:
            return
        ranges = self._ranges[:, level]
        self._make({*ranges[self._absent[:, level], 2].tolist()})
        array = variant_array(compiled.ctx, compiled, [self._content], self._indices)
        counts, offsets = 3 * (ranges[:, 1] - ranges[:, 0]), 12 * ranges[:, 0]
        all_items = _DrawnRanges(counts.astype("i4"), offsets, ranges[:, 2].astype("i4"))
        self._draw_many(array, all_items, 0, len(ranges))
        array.release()

    def recall(self, state: LevelState | None = None) -> LevelState:
        """Set the levels that the next choice starts from, None: no item; returns the old."""
        before = self._state
        self._state = empty_levels(len(before.level)) if state is None else state
        self._drawn = _nothing_drawn(0, len(before.level))  # forces new calls
        return before

    @property
    def spheres(self) -> tuple[Array, Array]:
        """Centres (k, 3) and radii (k,) of the items, cm."""
        return self._centres, self._radii

    @property
    def owners(self) -> Ints:
        """The item that each vertex (n,) belongs to."""
        return np.repeat(*self._owners)

    def draw(self, number: int, uniforms: dict[str, Any], as_ids: bool = False) -> int:
        """Draw the items in view `number`, or their object ids; returns the number of triangles.

        Items at rest take one call, those that fade two for each moment at which a fade began; each
        of these is two where some items are bitten.
        """
        if self._array is None:
            return 0
        for name, texture in self.textures.items():
            texture.use(TEXTURE_UNITS[name])
        uniforms = uniforms | self.uniforms
        total = 0
        for first, end, triangles, share, wants in self._calls[number]:
            if as_ids:  # without traces
                wants = FADING if share else ()
            array = self._programs.ready(self._array, as_ids, wants, **uniforms, u_fade=share)
            self._draw_many(array, self._chosen, first, end)
            total += triangles
        return total


class _DrawnRanges:
    """Ranges of triangles as OpenGL reads them."""

    def __init__(self, counts: Ints, offsets: Ints, vertices: Ints) -> None:
        """Take numbers of indices (n,) int32, their first bytes, and first vertices int32."""
        self._held = counts, offsets, vertices
        self.addresses = counts.ctypes.data, offsets.ctypes.data, vertices.ctypes.data


def _nothing_drawn(views: int, k: int) -> Drawn:
    return Drawn(np.zeros((views, k), np.bool_), np.zeros(k, np.bool_))


def box_around(batches: Sequence[StaticBatch]) -> Array:
    """Lowest and highest corner (2, 3) of all items of batches; zeros without items."""
    spheres = [np.column_stack(batch.spheres) for batch in batches]
    finite = np.concatenate([np.zeros((0, 4)), *spheres])
    finite = finite[np.isfinite(finite).all(axis=1)]
    if not len(finite):
        return np.zeros((2, 3))
    low, high = finite[:, :3] - finite[:, 3:], finite[:, :3] + finite[:, 3:]
    return np.stack([low.min(axis=0), high.max(axis=0)])


def _multi_draw(context: Any) -> Callable[[Any, _DrawnRanges, int, int], None]:
    """Return a function that draws ranges, from one to an end, of a vertex array in one call.

    moderngl wraps no call that draws several ranges with OpenGL 3.3.
    """
    kinds = ctypes.c_uint, ctypes.c_void_p, ctypes.c_uint, ctypes.c_void_p, ctypes.c_int
    draw = gl_function(context, "glMultiDrawElementsBaseVertex", *kinds, ctypes.c_void_p)
    use = gl_function(context, "glUseProgram", ctypes.c_uint)
    bind = gl_function(context, "glBindVertexArray", ctypes.c_uint)

    def draw_many(array: Any, ranges: _DrawnRanges, first: int, end: int) -> None:
        counts, offsets, vertices = ranges.addresses
        use(array.program.glo)
        bind(array.glo)
        with context.extra:
            draw(
                TRIANGLES, counts + 4 * first, UNSIGNED_INT, offsets + 8 * first, end - first,
                vertices + 4 * first,
            )  # fmt: skip

    return draw_many


def bounding_spheres(items: Sequence[Sequence[StaticMesh | LazyMesh]]) -> Array:
    """Spheres (k, 4) about items at their finest level: centre (of the bounding box), radius."""
    spheres = np.full((len(items), 4), np.nan)
    for sphere, levels in zip(spheres, items, strict=True):
        places = levels[0].vertices[:, :3].astype(np.float64)
        if len(places):
            sphere[:3] = 0.5 * (places.min(axis=0) + places.max(axis=0))
            sphere[3] = np.sqrt(((places - sphere[:3]) ** 2).sum(axis=1).max())
    return spheres


def _ranges(
    items: Sequence[Sequence[StaticMesh | LazyMesh]],
    levels: int,
    flat: list[StaticMesh | LazyMesh],
    lists: list[Ints],
) -> Ints:
    """First triangle, end and first vertex (k, levels, 3); `flat` and `lists` in buffer order."""
    vertices = np.cumsum([0] + [mesh.number for mesh in flat])
    triangles = np.cumsum([0] + [len(part) for part in lists])
    vertex = dict(zip(map(id, flat), vertices, strict=False))
    first = dict(zip(map(id, lists), triangles, strict=False))
    ranges = np.zeros((len(items), levels, 3), np.int64)
    for item, own in enumerate(items):
        for level, mesh in enumerate(own):
            start = first[id(mesh.triangles)]
            ranges[item, level:] = start, start + len(mesh.triangles), vertex[id(mesh)]
    return ranges
