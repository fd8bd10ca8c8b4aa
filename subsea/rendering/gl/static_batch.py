"""Static geometry in one vertex buffer: each view draws the visible items in one call."""

from collections.abc import Callable, Sequence
from itertools import accumulate, pairwise
from typing import Any, NamedTuple

import moderngl
import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.kernels import kernel
from subsea.rendering.gl.level_fades import (
    OUT_OF_SIGHT,
    LevelState,
    empty_levels,
    fade_groups,
    next_levels,
    under_way,
)
from subsea.rendering.gl.owner import GpuOwner, replace_data
from subsea.rendering.gl.programs import ProgramVariants, variant_array
from subsea.view.camera import View
from subsea.view.culling import ViewArrays, eye_distance, in_frustum, view_arrays

NEAR_PX, MIDDLE_PX = 360.0, 130.0  # default diameters from which the levels are used
LEAST_PX = 3.0  # smaller items are not drawn
HYSTERESIS = 0.12  # share by which a threshold is overstepped before the level changes
INDIRECT = "GL_ARB_multi_draw_indirect"  # of OpenGL 4.3, and of many drivers of 3.3
COMMAND_BYTES = 20
FADING = ("FADING",)  # variant of a program that draws a share of the pixels


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
    """The vertices and triangles of all items, and a command for each item that is drawn now.

    Drivers without `INDIRECT` receive the indices of all triangles that are drawn now instead.
    """

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
        self._programs = self.own(programs)
        self._reach = reach_cm
        self._thresholds = np.asarray(thresholds_px, np.float64)
        # A mesh used for two levels is held once; meshes that differ only in their vertices share
        # their triangles.
        flat = list({id(mesh): mesh for levels in items for mesh in levels}.values())
        lists = list({id(mesh.triangles): mesh.triangles for mesh in flat}.values())
        self._triangles = np.concatenate([np.zeros((0, 3), np.int32), *lists]).astype("i4")
        self._ranges = _ranges(items, len(thresholds_px) + 1, flat, lists)
        spheres = bounding_spheres(items) if spheres is None else spheres
        self._centres, self._radii = spheres[:, :3].copy(), spheres[:, 3].copy()
        self._state = empty_levels(len(items))
        self._seen = np.zeros((0, len(items)), np.bool_)
        # Calls of each view: first command, or triangle; their number; triangles; share to draw.
        self._calls: list[list[tuple[int, int, int, float]]] = []
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
        self._indirect = INDIRECT in programs.context.extensions
        if self._indirect:
            self._indices = self.own(programs.context.buffer(self._triangles))
            self._commands = self.own(programs.context.buffer(reserve=COMMAND_BYTES))
        else:
            self._indices = self.own(programs.context.buffer(reserve=12))
        self._content = self._vertices, layout, *attributes.split()
        self._array = programs.array([self._content], self._indices)

    def choose(
        self,
        views: Sequence[View],
        time_s: float = 0.0,
        detail: float = 1.0,
        shown: Bools | None = None,
    ) -> None:
        """Choose the items that each view draws, and a level for each that all views share.

        Changes of level fade from picture to picture, which are at `time_s` of the world. `detail`
        is a factor on the pixels that an item covers; infinite draws every item at its finest
        level. `shown` (k,) leaves items out.
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
        same = np.array_equal(state.level, before.level) and np.array_equal(seen, self._seen)
        if same and not fades:
            return
        self._seen = seen
        # Near items first, so that hidden pixels are not lit; sorted only when the choice changes.
        groups = []
        for row, view in zip(seen, views, strict=True):
            own = np.flatnonzero(row)
            away = self._centres[own] - view.eye
            near = np.sqrt(np.einsum("ij,ij->i", away, away)) - self._radii[own]
            groups.append(fade_groups(own[np.argsort(near)], state))
        every = [group for those in groups for group in those]
        items, chosen = (np.concatenate([group[k] for group in every]) for k in (0, 1))
        if self._waiting:
            self._make(items, chosen)
        ranges = self._ranges[items, chosen]
        ends = np.append(0, np.cumsum(ranges[:, 1] - ranges[:, 0]))
        if len(ranges) and self._indirect:
            replace_data(self._commands, commands(ranges))
        elif ends[-1]:
            replace_data(self._indices, gather(self._triangles, ranges))
        bounds = [0, *accumulate(len(group.items) for group in every)]
        calls = []
        for first, end, group in zip(bounds[:-1], bounds[1:], every, strict=True):
            triangles = int(ends[end] - ends[first])
            drawn = (first, end - first) if self._indirect else (int(ends[first]), triangles)
            calls.append((*drawn, triangles, group.share))
        split = [0, *accumulate(map(len, groups))]
        self._calls = [calls[i:k] for i, k in pairwise(split)]

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
        triangles = gather(self._triangles, np.ascontiguousarray(self._ranges[:, level]))
        if not len(triangles):
            return
        indices = compiled.ctx.buffer(triangles)
        array = variant_array(compiled.ctx, compiled, [self._content], indices)
        array.render(moderngl.TRIANGLES)
        array.release()
        indices.release()

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

    def draw(
        self,
        number: int,
        uniforms: dict[str, Any],
        as_ids: bool = False,
        wants: tuple[str, ...] = (),
    ) -> int:
        """Draw the items in view `number`, or their object ids; returns the number of triangles.

        `wants` are defines of the program. Items at rest take one call, those that fade two for
        each moment at which a fade began.
        """
        if self._array is None:
            return 0
        total = 0
        for first, count, triangles, share in self._calls[number]:
            if not triangles:
                continue
            fading = FADING if share else ()
            array = self._programs.ready(
                self._array, as_ids, wants + fading, **uniforms, u_fade=share
            )
            if self._indirect:
                array.render_indirect(self._commands, moderngl.TRIANGLES, count, first)
            else:
                array.render(moderngl.TRIANGLES, vertices=3 * count, first=3 * first)
            total += triangles
        return total


def box_around(batches: Sequence[StaticBatch]) -> Array:
    """Lowest and highest corner (2, 3) of all items of batches; zeros without items."""
    spheres = [np.column_stack(batch.spheres) for batch in batches]
    found = np.concatenate([np.zeros((0, 4)), *spheres])
    found = found[np.isfinite(found).all(axis=1)]
    if not len(found):
        return np.zeros((2, 3))
    low, high = found[:, :3] - found[:, 3:], found[:, :3] + found[:, 3:]
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
    kept until a threshold is overstepped by HYSTERESIS.
    """
    centres, radii = spheres
    seen = np.ones((len(views), len(centres)), np.bool_)
    if np.isinf(detail):
        return np.zeros(len(centres), np.int64), seen
    arrays = view_arrays(views)
    arrays = arrays._replace(scales=detail * arrays.scales)
    level = _levels(centres, radii, arrays, reach_cm, thresholds_px, before, seen)
    return np.asarray(level), seen


@kernel
def _levels(
    centres: Array,
    radii: Array,
    views: ViewArrays,
    reach: float,
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


def commands(ranges: Ints) -> Ints:
    """Commands (k, 5) uint32 that draw each of the `ranges` (k, 3): glDrawElementsIndirect."""
    out = np.empty((len(ranges), 5), np.uint32)
    out[:, 0], out[:, 1] = 3 * (ranges[:, 1] - ranges[:, 0]), 1  # indices, instances
    out[:, 2], out[:, 3], out[:, 4] = 3 * ranges[:, 0], ranges[:, 2], 0  # first index, first vertex
    return out


@kernel
def gather(triangles: Ints, ranges: Ints) -> Ints:
    """The triangles (m, 3) of all `ranges` (k, 3), one after another."""
    out = np.empty(((ranges[:, 1] - ranges[:, 0]).sum(), 3), np.int32)
    place = 0
    for k in range(len(ranges)):
        for i in range(ranges[k, 0], ranges[k, 1]):
            for corner in range(3):
                out[place, corner] = triangles[i, corner] + ranges[k, 2]
            place += 1
    return out


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
