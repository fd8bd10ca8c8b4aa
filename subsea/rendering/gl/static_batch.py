"""Static geometry in one vertex buffer: each view draws the visible items in one call."""

import ctypes
from collections.abc import Callable, Sequence
from itertools import accumulate, pairwise
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.frame.packet import BITE_CM
from subsea.kernels import kernel
from subsea.rendering.gl.context import GpuOwner, gl_function
from subsea.rendering.gl.programs import ProgramVariants, variant_array
from subsea.rendering.gl.shaders import TEXTURE_UNITS
from subsea.view.camera import View
from subsea.view.culling import ViewArrays, eye_distance, in_frustum, view_arrays
from subsea.view.levels import FADE_S

OUT_OF_SIGHT = -1  # instead of a level


class LevelState(NamedTuple):
    """The levels of k items in the last picture."""

    level: Ints  # (k,), or OUT_OF_SIGHT
    former: Ints  # (k,), the level before
    since: Array  # (k,) s, time of the change; -inf: no fade
    time_s: float  # of the picture


def empty_levels(k: int) -> LevelState:
    """The state before the first picture of k items."""
    return LevelState(
        np.full(k, OUT_OF_SIGHT), np.full(k, OUT_OF_SIGHT), np.full(k, -np.inf), -np.inf
    )


def next_levels(level: Ints, before: LevelState, time_s: float) -> LevelState:
    """The state after a picture that wants these levels (k,) at `time_s`.

    Only a step to the next level fades, in a picture that follows the last: items that come into
    sight, and all items after a jump in time or while it stands still, have their levels at once.
    No change begins during another.
    """
    if not 0.0 < time_s - before.time_s < FADE_S:
        return empty_levels(len(level))._replace(level=level, time_s=time_s)
    seen = (level != OUT_OF_SIGHT) & (before.level != OUT_OF_SIGHT)
    under_way = seen & (time_s - before.since < FADE_S)
    begins = seen & ~under_way & (np.abs(level - before.level) == 1)
    return LevelState(
        np.where(under_way, before.level, level),
        np.where(begins, before.level, before.former),
        np.where(begins, time_s, np.where(under_way, before.since, -np.inf)),
        time_s,
    )


class FadeGroup(NamedTuple):
    """Items that one call draws with one share of their pixels."""

    items: Ints  # (n,), in the order of drawing
    level: Ints  # (n,)
    share: float  # as `fades.glsl` takes it; 0 draws all pixels
    bitten: bool = False  # drawn with the traces of feeding on them

    def parted(self, bitten: Bools) -> "list[FadeGroup]":
        """Return the group without the `bitten` ones of all items (k,), and these as another."""
        mine = bitten[self.items]
        if not mine.any():
            return [self]
        both = ((~mine, False), (mine, True))
        return [
            FadeGroup(self.items[part], self.level[part], self.share, own) for part, own in both
        ]


def fade_groups(items: Ints, state: LevelState) -> list[FadeGroup]:
    """Groups of `items` in sight: those at rest, then both levels of each change under way."""
    since = state.since[items]
    steady = items[since == -np.inf]
    groups = [FadeGroup(steady, state.level[steady], 0.0)]
    if len(steady) == len(items):
        return groups
    for start in np.unique(since[since > -np.inf]).tolist():
        fading = items[since == start]
        done = min(max((state.time_s - start) / FADE_S, 0.01), 0.99)
        groups.append(FadeGroup(fading, state.level[fading], done))
        groups.append(FadeGroup(fading, state.former[fading], done - 1.0))
    return groups


def under_way(state: LevelState) -> Bools:
    """True for each item (k,) that is drawn at two levels."""
    return np.asarray(state.since > -np.inf)


NEAR_PX, MIDDLE_PX = 360.0, 130.0  # default diameters from which the levels are used
LEAST_PX = 3.0  # smaller items are not drawn
LARGE_PX = 150.0  # diameter from which a detail below 1 matters less; from twice that not at all
HYSTERESIS = 0.12  # share by which a threshold is overstepped before the level changes
TRIANGLES, UNSIGNED_INT = 0x0004, 0x1405  # OpenGL enums
FADING = ("FADING",)  # variant of a program that draws a share of the pixels
BITTEN = ("BITTEN",)  # variant that shows traces of feeding, `bites.glsl`


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
        self._seen = np.zeros((0, len(items)), np.bool_)
        self._bitten = np.zeros(len(items), np.bool_)
        # Boxes about the items, whose sides a part may know better.
        self._low = self._centres - self._radii[:, None]
        self._high = self._centres + self._radii[:, None]
        self._draw_many = _multi_draw(programs.context)
        self._chosen = np.zeros((0, 3), np.int64)  # rows of `_ranges`, in the order of drawing
        # Calls of each view: first and end among the chosen; triangles; share to draw; bitten.
        self._calls: list[list[tuple[int, int, int, float, bool]]] = []
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
        spheres, before = (self._centres, self._radii), self._state
        level, seen = levels_in_sight(
            spheres, views, self._reach, detail, self._thresholds, before.level
        )
        if shown is not None:
            level[~shown] = OUT_OF_SIGHT
        seen &= level != OUT_OF_SIGHT
        state = self._state = next_levels(level, before, time_s)
        fades = under_way(state).any() or under_way(before).any()
        bitten = self._touched(bites)
        same = np.array_equal(state.level, before.level) and np.array_equal(seen, self._seen)
        if same and not fades and np.array_equal(bitten, self._bitten):
            return
        self._seen, self._bitten = seen, bitten
        # Near items first, so that hidden pixels are not lit; sorted only when the choice changes.
        groups = []
        for row, view in zip(seen, views, strict=True):
            in_view = np.flatnonzero(row)
            away = self._centres[in_view] - view.eye
            near = np.sqrt(np.einsum("ij,ij->i", away, away)) - self._radii[in_view]
            faded = fade_groups(in_view[np.argsort(near)], state)
            groups.append([part for group in faded for part in group.parted(bitten)])
        every = [group for those in groups for group in those]
        items, chosen = (np.concatenate([group[k] for group in every]) for k in (0, 1))
        if self._waiting:
            self._make(items, chosen)
        self._chosen = ranges = self._ranges[items, chosen]
        ends = np.append(0, np.cumsum(ranges[:, 1] - ranges[:, 0])).tolist()
        bounds = [0, *accumulate(len(group.items) for group in every)]
        calls = [
            (first, end, ends[end] - ends[first], group.share, group.bitten)
            for (first, end), group in zip(pairwise(bounds), every, strict=True)
        ]
        split = [0, *accumulate(map(len, groups))]
        self._calls = [calls[i:k] for i, k in pairwise(split)]

    def _touched(self, bites: Array | None) -> Bools:
        """Return True for each item (k,) on which one of these bites (b, 4) may lie."""
        touched = np.zeros(len(self._centres), np.bool_)
        for place in () if bites is None else bites[:, :3]:
            beside = np.maximum(self._low - place, place - self._high)
            touched |= (beside < BITE_CM).all(axis=1)
        return touched

    def _make(self, items: Ints, level: Ints) -> None:
        """Upload the meshes of `items` at these levels that are drawn for the first time."""
        absent = self._absent[items, level]
        for first in {*self._ranges[items[absent], level[absent], 2].tolist()}:
            vertices = np.ascontiguousarray(self._waiting.pop(first).vertices, "f4")
            self._vertices.write(vertices, self._stride * first)
            self._absent &= self._ranges[..., 2] != first

    def cast(self, compiled: Any, level: int) -> None:
        """Draw every item at a level with a program that reads positions alone."""
        if self._array is None:
            return
        if self._waiting:
            items = np.arange(len(self._centres))
            self._make(items, np.full(len(items), level))
        array = variant_array(compiled.ctx, compiled, [self._content], self._indices)
        self._draw_many(array, self._ranges[:, level])
        array.release()

    def recall(self, state: LevelState | None = None) -> LevelState:
        """Set the levels that the next choice starts from, None: no item; returns the old."""
        before = self._state
        self._state = empty_levels(len(before.level)) if state is None else state
        self._seen = np.zeros((0, len(before.level)), np.bool_)  # forces new indices
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
        for first, end, triangles, share, bitten in self._calls[number]:
            if not triangles:
                continue
            wants = (FADING if share else ()) + (BITTEN if bitten and not as_ids else ())
            array = self._programs.ready(self._array, as_ids, wants, **uniforms, u_fade=share)
            self._draw_many(array, self._chosen[first:end])
            total += triangles
        return total


def box_around(batches: Sequence[StaticBatch]) -> Array:
    """Lowest and highest corner (2, 3) of all items of batches; zeros without items."""
    spheres = [np.column_stack(batch.spheres) for batch in batches]
    finite = np.concatenate([np.zeros((0, 4)), *spheres])
    finite = finite[np.isfinite(finite).all(axis=1)]
    if not len(finite):
        return np.zeros((2, 3))
    low, high = finite[:, :3] - finite[:, 3:], finite[:, :3] + finite[:, 3:]
    return np.stack([low.min(axis=0), high.max(axis=0)])


def levels_in_sight(
    spheres: tuple[Array, Array],
    views: Sequence[View],
    reach_cm: float,
    detail: float,
    thresholds_px: Array,
    before: Ints,
) -> tuple[Ints, Bools]:
    """Levels of detail (k,) of `spheres`, and which of them (v, k) each view sees.

    `spheres` are centres (k, 3) and radii (k,), cm. The level follows from the largest diameter in
    pixels; it is OUT_OF_SIGHT for what no view sees or what is too small. The level `before` is
    kept until a threshold is overstepped by HYSTERESIS. A `detail` below 1 spares what is large.
    """
    centres, radii = spheres
    seen = np.ones((len(views), len(centres)), np.bool_)
    if np.isinf(detail):
        return np.zeros(len(centres), np.int64), seen
    arrays = view_arrays(views)
    level = _levels(centres, radii, arrays, reach_cm, detail, thresholds_px, before, seen)
    return np.asarray(level), seen


@kernel
def _levels(
    centres: Array,
    radii: Array,
    views: ViewArrays,
    reach: float,
    detail: float,
    thresholds: Array,
    before: Ints,
    seen: Bools,
) -> Ints:
    planes, _, scales = views
    level = np.empty(len(centres), np.int64)
    for i in range(len(centres)):
        x, y, z = centres[i, 0], centres[i, 1], centres[i, 2]
        pixels = 0.0
        for v in range(len(planes)):
            seen[v, i] = in_frustum(planes, v, x, y, z, radii[i])  # most are not
            if not seen[v, i]:
                continue
            d = eye_distance(views, v, x, y, z)
            seen[v, i] = d - radii[i] < reach
            if seen[v, i]:
                pixels = max(pixels, 2.0 * radii[i] * scales[v] / max(d - radii[i], 1.0))
        # The straight edges of a coarse level would show in large items: these have full detail.
        full = min(max(pixels / LARGE_PX - 1.0, 0.0), 1.0) if detail < 1.0 else 0.0
        pixels *= detail + full * (1.0 - detail)
        new = before[i] == OUT_OF_SIGHT
        if pixels < (LEAST_PX if new else LEAST_PX / (1.0 + HYSTERESIS)):
            level[i] = OUT_OF_SIGHT
            continue
        finest, plain, coarsest = 0, 0, 0
        for threshold in thresholds:
            finest += pixels * (1.0 + HYSTERESIS) < threshold
            plain += pixels < threshold
            coarsest += pixels / (1.0 + HYSTERESIS) < threshold
        level[i] = plain if new else min(max(before[i], finest), coarsest)
    return level


def _multi_draw(context: Any) -> Callable[[Any, Ints], None]:
    """Return a function that draws `ranges` (k, 3) of a vertex array in one call.

    moderngl wraps no call that draws several ranges with OpenGL 3.3.
    """
    kinds = ctypes.c_uint, ctypes.c_void_p, ctypes.c_uint, ctypes.c_void_p, ctypes.c_int
    draw = gl_function(context, "glMultiDrawElementsBaseVertex", *kinds, ctypes.c_void_p)
    use = gl_function(context, "glUseProgram", ctypes.c_uint)
    bind = gl_function(context, "glBindVertexArray", ctypes.c_uint)

    def draw_many(array: Any, ranges: Ints) -> None:
        counts = (3 * (ranges[:, 1] - ranges[:, 0])).astype(np.int32)
        offsets = 12 * np.ascontiguousarray(ranges[:, 0])  # bytes: three indices of four
        vertices = ranges[:, 2].astype(np.int32)
        use(array.program.glo)
        bind(array.glo)
        with context.extra:
            draw(
                TRIANGLES, counts.ctypes.data, UNSIGNED_INT, offsets.ctypes.data, len(ranges),
                vertices.ctypes.data,
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
