"""What stands still: all shapes in one buffer, of which a view draws those in sight at once."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import moderngl
import numpy as np

from subsea.core.arrays import Array, Bools, Ints
from subsea.core.kernels import kernel
from subsea.render.gl.id_buffer import double
from subsea.render.gl.shaders import set_uniforms, wanted
from subsea.view.camera import View
from subsea.view.culling import in_frustum, pixels_per_radian

OUT_OF_SIGHT = -1  # in place of a level
NEAR_PX, MIDDLE_PX = 360.0, 130.0  # a level is used while its shape's diameter covers so many
LEAST_PX = 3.0  # what covers fewer is not drawn
HYSTERESIS = 0.12  # share by which a threshold is overstepped before the level changes


class StaticMesh(NamedTuple):
    """One shape at one level of detail, in world coordinates."""

    vertices: Array  # (n, c) float32; the first three columns are the place, cm
    triangles: Ints  # (m, 3), counter-clockwise from outside

    @property
    def number(self) -> int:
        """How many vertices there are."""
        return len(self.vertices)


class LazyMesh(NamedTuple):
    """The same, but its vertices are made whenever they are asked for."""

    make: Callable[[], Array]
    number: int
    triangles: Ints

    @property
    def vertices(self) -> Array:
        """As those of a shape."""
        return self.make()


class StaticBatch:
    """Holds the vertices of all shapes, and the triangles of those that are drawn now."""

    def __init__(
        self,
        context: Any,
        compiled: Any,
        layout: str,
        attributes: str,
        shapes: Sequence[Sequence[StaticMesh | LazyMesh]],
        reach_cm: float,
        thresholds_px: Sequence[float] = (NEAR_PX, MIDDLE_PX),
        spheres: Array | None = None,
    ) -> None:
        """Make room for `shapes`, per item its levels, finest first; the last stands for coarser.

        `compiled` is the program, `layout` and `attributes` are those of moderngl, `reach_cm` is
        how far one sees. Level k is used from `thresholds_px[k]` pixels on. The `spheres` (k, 4)
        about items, centre and radius, need not be given. The program stays the caller's.
        """
        self._reach = reach_cm
        self._thresholds = np.asarray(thresholds_px, np.float64)
        # What stands for two levels is held once; shapes that differ in their vertices alone have
        # their triangles in common.
        flat = list({id(shape): shape for levels in shapes for shape in levels}.values())
        meshes = list({id(shape.triangles): shape.triangles for shape in flat}.values())
        self._triangles = np.concatenate([np.zeros((0, 3), np.int32), *meshes]).astype("i4")
        self._ranges = _ranges(shapes, len(thresholds_px) + 1, flat, meshes)
        spheres = bounding_spheres(shapes) if spheres is None else spheres
        self._centres, self._radii = spheres[:, :3].copy(), spheres[:, 3].copy()
        self._level = np.full(len(shapes), OUT_OF_SIGHT)
        self._seen = np.zeros((0, len(shapes)), np.bool_)
        self._starts = [0]  # of each view's triangles, with the end
        self._held: list[Any] = []
        # What draws it, by what that is wanted for (`shaders.wanted`): array and program.
        self._by: dict[tuple[str, ...], tuple[Any, Any]] = {}
        # Of each shape which item it is, and how many vertices it has.
        item = {id(shape): k for k, levels in enumerate(shapes) for shape in levels}
        self._owners = [item[id(shape)] for shape in flat], [shape.number for shape in flat]
        if not flat:
            return
        self._context = context
        # Most are never seen as finely as they could be: each is uploaded when it is first drawn.
        first = np.cumsum([0, *self._owners[1]]).tolist()
        self._waiting = {at: own for at, own in zip(first, flat, strict=False) if own.number}
        self._absent = np.isin(self._ranges[..., 2], [*self._waiting])  # (k, levels), of the items
        self._stride = sum(int(part[0]) * int(part[2]) for part in layout.split())
        self._vertices = context.buffer(reserve=self._stride * first[-1])
        self._indices = context.buffer(reserve=12)
        self._content = [(self._vertices, layout, *attributes.split())]
        array = context.vertex_array(compiled, self._content, self._indices)
        self._by[()] = array, compiled
        self._held = [array, self._vertices, self._indices]

    def choose(
        self, views: Sequence[View], detail: float = 1.0, shown: Bools | None = None
    ) -> None:
        """Decide what each view draws, and once for all of them how finely.

        `detail` is a factor on the pixels that a shape covers, infinite: all are drawn in full,
        in sight or not; `shown` (k,) leaves items out.
        """
        if not self._held:
            return
        level, seen = levels_in_sight(
            self._centres, self._radii, views, self._reach, detail, self._thresholds, self._level
        )
        if shown is not None:
            level[~shown] = OUT_OF_SIGHT
        seen &= level != OUT_OF_SIGHT
        if np.array_equal(level, self._level) and np.array_equal(seen, self._seen):
            return
        self._level, self._seen = level, seen
        # The near first: what they cover need not be lit. As near as when the choice last changed.
        drawn = [
            own[np.argsort(np.linalg.norm(self._centres[own] - eye, axis=1) - self._radii[own])]
            for own, eye in (
                (np.flatnonzero(row), view.eye) for row, view in zip(seen, views, strict=True)
            )
        ]
        ranges = [self._ranges[own, level[own]] for own in drawn]
        for own, rows in zip(drawn, ranges, strict=True):
            for first in {*rows[self._absent[own, level[own]], 2].tolist()}:
                vertices = np.ascontiguousarray(self._waiting.pop(first).vertices, "f4")
                self._vertices.write(vertices, self._stride * first)
                self._absent &= self._ranges[..., 2] != first
        self._starts = np.cumsum([0, *((own[:, 1] - own[:, 0]).sum() for own in ranges)]).tolist()
        if self._starts[-1]:
            data = _gathered(self._triangles, np.concatenate(ranges))
            self._indices.orphan(data.nbytes)
            self._indices.write(data)

    def recall(self, level: Ints | None = None) -> Ints:
        """Choose next as if `level` (k,) had been chosen last, None: nothing; returns what was."""
        before = self._level
        self._level = np.full_like(before, OUT_OF_SIGHT) if level is None else level
        self._seen = np.zeros((0, len(before)), np.bool_)  # the indices are to be written anew
        return before

    @property
    def owners(self) -> Ints:
        """Which item each vertex (n,) belongs to."""
        return np.repeat(*self._owners)

    def draw_by(self, wants: tuple[str, ...], compiled: Any, marks: Array | None = None) -> None:
        """Draw by another program what is wanted so; `marks` (n,) are its vertices' `a_mark`."""
        if not self._held:
            return
        content = list(self._content)
        if marks is not None:
            buffer = self._context.buffer(marks.astype("f4"))
            content.append((buffer, "1f4", "a_mark"))
            self._held.append(buffer)
        array = double(self._context, compiled, content, self._indices)
        self._by[wants] = array, compiled
        self._held.append(array)

    def draw(self, number: int, uniforms: dict[str, Any], marked: bool = False) -> int:
        """Draw in one call what view `number` sees, or its marks; the number of triangles."""
        if not self._held:
            return 0
        first, end = self._starts[number : number + 2]
        if end > first:
            # Of shadows, which no lamp lights, there is one program.
            array, compiled = self._by.get(wanted(uniforms, marked), self._by[()])
            set_uniforms(compiled, **uniforms)
            array.render(moderngl.TRIANGLES, vertices=3 * (end - first), first=3 * first)
        return end - first

    def release(self) -> None:
        """Free the buffers."""
        for held in self._held:
            held.release()


def levels_in_sight(
    centres: Array,
    radii: Array,
    views: Sequence[View],
    reach_cm: float,
    detail: float,
    thresholds_px: Array,
    before: Ints,
) -> tuple[Ints, Bools]:
    """Levels of detail (k,) of spheres, and which of them (v, k) each view sees.

    A level follows from the pixels that the diameter covers where it covers most; OUT_OF_SIGHT is
    what no view sees, or what is too small. One `before` is kept until a threshold is overstepped
    by HYSTERESIS.
    """
    seen = np.ones((len(views), len(centres)), np.bool_)
    if np.isinf(detail):
        return np.zeros(len(centres), np.int64), seen
    planes = np.stack([view.planes for view in views])
    eyes = np.stack([np.asarray(view.eye, np.float64) for view in views])
    scales = detail * np.array([pixels_per_radian(view) for view in views])
    level = _levels(centres, radii, planes, eyes, scales, reach_cm, thresholds_px, before, seen)
    return np.asarray(level), seen


@kernel
def _levels(
    centres: Array,
    radii: Array,
    planes: Array,
    eyes: Array,
    scales: Array,
    reach: float,
    thresholds: Array,
    before: Ints,
    seen: Bools,
) -> Ints:
    level = np.empty(len(centres), np.int64)
    for i in range(len(centres)):
        x, y, z = centres[i, 0], centres[i, 1], centres[i, 2]
        pixels = 0.0
        for v in range(len(planes)):
            d = np.sqrt((x - eyes[v, 0]) ** 2 + (y - eyes[v, 1]) ** 2 + (z - eyes[v, 2]) ** 2)
            seen[v, i] = d - radii[i] < reach and in_frustum(planes, v, x, y, z, radii[i])
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


@kernel
def _gathered(triangles: Ints, ranges: Ints) -> Ints:
    """The triangles (m, 3) of all `ranges` (k, 3), one after another."""
    out = np.empty(((ranges[:, 1] - ranges[:, 0]).sum(), 3), np.int32)
    place = 0
    for k in range(len(ranges)):
        for i in range(ranges[k, 0], ranges[k, 1]):
            for corner in range(3):
                out[place, corner] = triangles[i, corner] + ranges[k, 2]
            place += 1
    return out


@kernel
def bounding_sphere(vertices: Array) -> tuple[Array, float]:
    """Centre (3,) and radius of a sphere about vertices (n, 3 or more), from their bounding box."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for i in range(len(vertices)):
        for axis in range(3):
            low[axis] = min(low[axis], vertices[i, axis])
            high[axis] = max(high[axis], vertices[i, axis])
    centre = 0.5 * (low + high)
    square = 0.0
    for i in range(len(vertices)):
        x, y, z = (
            vertices[i, 0] - centre[0], vertices[i, 1] - centre[1], vertices[i, 2] - centre[2],
        )  # fmt: skip
        square = max(square, x * x + y * y + z * z)
    return centre, np.sqrt(square)


def bounding_spheres(shapes: Sequence[Sequence[StaticMesh | LazyMesh]]) -> Array:
    """The centres and radii (k, 4) of spheres about items at their finest level."""
    spheres = np.zeros((len(shapes), 4))
    for k, levels in enumerate(shapes):
        spheres[k, :3], spheres[k, 3] = bounding_sphere(levels[0].vertices)
    return spheres


def _ranges(
    shapes: Sequence[Sequence[StaticMesh | LazyMesh]],
    levels: int,
    flat: list[StaticMesh | LazyMesh],
    meshes: list[Ints],
) -> Ints:
    """First triangle, end and first vertex (k, levels, 3) of every item at every level.

    `flat` are all shapes and `meshes` all triangles, each once, in the order in which they lie.
    """
    vertices = np.cumsum([0] + [shape.number for shape in flat])
    triangles = np.cumsum([0] + [len(mesh) for mesh in meshes])
    vertex = dict(zip(map(id, flat), vertices, strict=False))
    first = dict(zip(map(id, meshes), triangles, strict=False))
    ranges = np.zeros((len(shapes), levels, 3), np.int64)
    for item, own in enumerate(shapes):
        for level, shape in enumerate(own):
            start = first[id(shape.triangles)]
            ranges[item, level:] = start, start + len(shape.triangles), vertex[id(shape)]
    return ranges
