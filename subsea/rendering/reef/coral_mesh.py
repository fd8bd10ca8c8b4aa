"""Meshes of growths: surfaces over rings of points, isosurfaces (Gibson 1998), and branches.

Points are arrays (b, r, c, 3): b pieces of r rings of c points, whose first and last coincide. Seen
from outside, points run counter-clockwise about the direction from ring to ring.
"""

from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints


def surface_net(field: Array) -> tuple[Array, Ints]:
    """The zero surface of a field (a, b, c): vertices (n, 3) in cells, triangles (m, 3).

    Each cell that the surface crosses has one vertex, the mean of the crossings of its edges; each
    edge of the grid that it crosses has one square. Triangles are counter-clockwise seen from
    where the field is positive. The surface ends at the edge of the grid.
    """
    inside = field < 0.0
    total = np.zeros([n - 1 for n in field.shape] + [3])
    count = np.zeros([n - 1 for n in field.shape], np.int64)
    crossings = []
    for axis in range(3):
        low, high = (
            tuple(slice(k, n - 1 + k) if a == axis else slice(n) for a, n in enumerate(field.shape))
            for k in (0, 1)
        )
        at = np.argwhere(inside[low] != inside[high])
        here, there = field[low][tuple(at.T)], field[high][tuple(at.T)]
        place = at.astype(np.float64)
        place[:, axis] += here / (here - there)
        crossings.append((at, here < 0.0))
        # Four cells share each edge.
        for cell in _about(at, axis):
            valid = ((cell >= 0) & (cell < count.shape)).all(axis=1)
            np.add.at(total, tuple(cell[valid].T), place[valid])
            np.add.at(count, tuple(cell[valid].T), 1)
    used = count > 0
    number = np.full(count.shape, -1)
    number[used] = np.arange(int(used.sum()))
    squares = []
    for axis, (at, leaving) in enumerate(crossings):
        cells = np.stack(_about(at, axis), axis=1)
        whole = ((cells >= 0) & (cells < count.shape)).all(axis=(1, 2))
        corner = number[tuple(np.moveaxis(cells[whole], 2, 0))]
        squares.append(np.where(leaving[whole, None], corner, corner[:, ::-1]))
    a, b, c, d = np.concatenate(squares).T
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return total[used] / count[used][:, None], triangles


def _about(edges: Ints, axis: int) -> list[Ints]:
    """The four cells (n, 3) around edges along an axis, counter-clockwise from its far end."""
    one, other = (axis + 1) % 3, (axis + 2) % 3
    around = []
    for step in ((-1, -1), (0, -1), (0, 0), (-1, 0)):
        cell = edges.copy()
        cell[:, one] += step[0]
        cell[:, other] += step[1]
        around.append(cell)
    return around


Rng = np.random.Generator
UP = np.array([0.0, 0.0, 1.0])


class CoralMesh(NamedTuple):
    """n vertices and m triangles, counter-clockwise from outside; size 1."""

    place: Array  # (n, 3)
    normal: Array  # (n, 3), unit
    along: Array  # (n, 2), coordinates along the surface
    tip: Array  # (n,) from 0 at the body to 1 at the tip, to mix their colours
    light: Array  # (n,) share of the light that reaches it
    sway: Array  # (n,) share of the full sway
    triangles: Ints  # (m, 3)


def single(mesh: CoralMesh) -> CoralMesh:
    """The mesh in single precision."""
    parts = mesh._asdict()
    triangles = parts.pop("triangles")
    return CoralMesh(
        **{name: part.astype(np.float32) for name, part in parts.items()}, triangles=triangles
    )


def skin(
    place: Array,
    *,
    tip: Array | float = 0.0,
    light: Array | float = 1.0,
    sway: Array | float = 0.0,
    along: Array | None = None,
) -> CoralMesh:
    """The closed surface over points (b, r, c, 3); other arguments broadcast to (b, r, c)."""
    b, r, c, _ = place.shape
    around = np.empty_like(place)
    around[:, :, 1:-1] = place[:, :, 2:] - place[:, :, :-2]
    around[:, :, 0] = around[:, :, -1] = place[:, :, 1] - place[:, :, -2]
    onward = np.empty_like(place)
    onward[:, 1:-1] = place[:, 2:] - place[:, :-2]
    onward[:, 0], onward[:, -1] = place[:, 1] - place[:, 0], place[:, -1] - place[:, -2]
    normal = cross(around, onward)
    # At a ring of radius 0: the mean normal of the triangles about it.
    shrunk = (around * around).sum(axis=(2, 3)) < 1e-12
    for ring, beside, sign in ((0, 1, -1.0), (-1, -2, 1.0)):
        spoke = place[:, beside] - place[:, ring]
        whole = sign * cross(spoke[:, :-1], spoke[:, 1:]).sum(axis=1, keepdims=True)
        normal[:, ring] = np.where(shrunk[:, ring, None, None], whole, normal[:, ring])
    normal = unit(normal)
    if along is None:
        step = np.linalg.norm(np.diff(place, axis=1), axis=3).mean(axis=2)
        far = np.concatenate([np.zeros((b, 1)), np.cumsum(step, axis=1)], axis=1)
        girth = np.linalg.norm(np.diff(place, axis=2), axis=3).sum(axis=2).mean(axis=1)
        across = girth[:, None] * np.linspace(0.0, 1.0, c)
        along = np.empty((b, r, c, 2))
        along[..., 0], along[..., 1] = far[:, :, None], across[:, None, :]
    k, j = np.meshgrid(np.arange(r - 1), np.arange(c - 1), indexing="ij")
    a = (k * c + j).ravel()
    cell = np.concatenate([np.stack([a, a + 1, a + c], 1), np.stack([a + 1, a + c + 1, a + c], 1)])
    triangles = (np.arange(b)[:, None, None] * (r * c) + cell).reshape(-1, 3)
    flat = place.reshape(-1, 3)
    corner = flat[triangles]
    area = cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    triangles = triangles[(area * area).sum(axis=1) > 1e-16]
    tip, light, sway = (np.broadcast_to(x, (b, r, c)).ravel() for x in (tip, light, sway))
    return CoralMesh(flat, normal.reshape(-1, 3), along.reshape(-1, 2), tip, light, sway, triangles)


def tubes(
    path: Array,
    radius: Array,
    sides: int,
    *,
    way: Array | None = None,
    tip: Array | float = 0.0,
    light: Array | float = 1.0,
    sway: Array | float = 0.0,
) -> CoralMesh:
    """Tubes along paths (b, r, 3) with radii (b, r), open where the last radius is not 0.

    `way` (b, r, 3) is the direction of the axis, if not that of the path. Other values broadcast to
    (b, r).
    """
    way = unit(np.gradient(path, axis=1) if way is None else way)
    whole = way.sum(axis=1)
    # A reference direction far from the whole path.
    aside = np.where(np.abs(whole[:, 1:2]) < 0.8 * np.linalg.norm(whole, axis=1)[:, None], 1.0, 0.0)
    aside = np.concatenate([1.0 - aside, aside, 0.0 * aside], axis=1)
    side = unit(cross(way, aside[:, None, :]))
    other = cross(way, side)
    turn = np.linspace(0.0, 2 * np.pi, sides + 1)
    ring = np.cos(turn)[:, None] * side[:, :, None] + np.sin(turn)[:, None] * other[:, :, None]
    ring = radius[:, :, None, None] * ring
    tip, light, sway = (np.asarray(x)[..., None] if np.ndim(x) else x for x in (tip, light, sway))
    return skin(path[:, :, None] + ring, tip=tip, light=light, sway=sway)


def capped(path: Array, radius: Array) -> tuple[Array, Array]:
    """Paths and radii with round ends: two more rings each, the last of radius 0."""
    end = unit(path[:, -1:] - path[:, -2:-1]) * radius[:, -1:, None]
    path = np.concatenate([path, path[:, -1:] + 0.6 * end * 0.8, path[:, -1:] + end * 0.8], 1)
    last = radius[:, -1:]
    return path, np.concatenate([radius, 0.72 * last, 0.0 * last], axis=1)


def turned(reach: Array, height: Array, **given: Array | float) -> CoralMesh:
    """A surface of revolution about z: radii and heights (r, c); other values broadcast to that."""
    turn = np.linspace(0.0, 2 * np.pi, reach.shape[1])
    place = np.stack([reach * np.cos(turn), reach * np.sin(turn), height], axis=-1)
    return skin(place[None], **given)  # type: ignore[arg-type]


def plates(
    top: Array,
    thick: float,
    *,
    tip: Array | float = 0.0,
    light: Array | float = 1.0,
    below: float = 0.55,
) -> CoralMesh:
    """Thin two-sided plates with upper sides (b, r, c, 3), from the foot to the rim.

    They are `thick` at the foot and sharp at the rim, and the light on their lower sides is `below`
    times that on the upper ones. Other values broadcast to (b, r, c).
    """
    top = top[:, :, ::-1]
    b, r, c, _ = top.shape
    down = thick * np.linspace(1.0, 0.0, r)[:, None, None] ** 0.5
    closed = skin(np.concatenate([top, top[:, :, :1]], axis=2))
    face = closed.normal.reshape(b, r, c + 1, 3)[:, :, 1:-2]
    face = np.concatenate([face[:, :, :1], face, face[:, :, -1:]], axis=2)
    under = top - down * unit(face)
    place = np.concatenate([top, under[:, :, ::-1], top[:, :, :1]], axis=2)

    def both(x: Array | float, under_share: float) -> Array:
        x = np.broadcast_to(x, (b, r, c))[:, :, ::-1]
        return np.concatenate([x, under_share * x[:, :, ::-1], x[:, :, :1]], axis=2)

    return skin(place, tip=both(tip, 0.6), light=both(light, below))


def joined(*meshes: CoralMesh) -> CoralMesh:
    """Join meshes."""
    starts = np.cumsum([0] + [len(mesh.place) for mesh in meshes])
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=False)]
    parts = [np.concatenate(part) for part in list(zip(*meshes, strict=True))[:-1]]
    return CoralMesh(*parts, np.concatenate(triangles))  # type: ignore[call-arg]


def welded(mesh: CoralMesh, seams: bool) -> CoralMesh:
    """The mesh with one vertex for all that are equal.

    With `seams` also for those that differ in their texture positions: textures then run backward
    along the seam of a tube, and turn about its end.
    """
    place = 1e5 * mesh.place, 1e3 * mesh.normal
    same = np.round(np.column_stack(place if seams else (*place, 1e3 * mesh.along)))
    _, first, number = np.unique(same, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.argsort(order)
    kept = first[order]
    return CoralMesh(
        mesh.place[kept], mesh.normal[kept], mesh.along[kept], mesh.tip[kept], mesh.light[kept],
        mesh.sway[kept], rank[number.reshape(-1)][mesh.triangles],
    )  # fmt: skip


def fitted(mesh: CoralMesh, height: float) -> CoralMesh:
    """The mesh scaled to a largest distance of 1 from the axis and to this height."""
    place = mesh.place
    wide = float(np.hypot(place[:, 0], place[:, 1]).max())
    scale = np.array([1.0 / wide, 1.0 / wide, height / float(place[:, 2].max())])
    return mesh._replace(
        place=place * scale, normal=unit(mesh.normal / scale), along=mesh.along / wide
    )


def bumps(rng: np.random.Generator, places: Array, wave: float, octaves: int = 2) -> Array:
    """Smooth noise (...) within about ±1 at points (..., 3); `wave` is the longest wavelength."""
    out = np.zeros(places.shape[:-1])
    for octave in range(octaves):
        share = 0.5**octave
        ways = unit(rng.normal(size=(5, 3))) * (2 * np.pi / (wave * share))
        out += share * np.sin(places @ ways.T + rng.uniform(0, 2 * np.pi, 5)).sum(axis=-1)
    return out / 3.2


def unit(rows: Array) -> Array:
    """Rows (..., 3) of length 1."""
    return np.asarray(rows / np.maximum(np.sqrt((rows * rows).sum(axis=-1, keepdims=True)), 1e-12))


def cross(a: Array, b: Array) -> Array:
    """Cross products of rows (..., 3), three times as fast as numpy's."""
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for k, i, j in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.multiply(a[..., i], b[..., j], out=out[..., k])
        out[..., k] -= a[..., j] * b[..., i]
    return out


class Branches(NamedTuple):
    """b branches, each bent evenly along its length."""

    start: Array  # (b, 3)
    way: Array  # (b, 3) unit, at the root
    length: Array  # (b,)
    bend: Array  # (b, 3), offset of the end over the length
    radius: Array  # (b, 2), at root and end
    order: Array  # (b,) 0 for stems, 1 for branches on them, ...

    def at(self, share: Array) -> Array:
        """Points (b, k, 3) at shares (b, k) of the length."""
        s = share[..., None]
        run = s * self.way[:, None] + s * s * self.bend[:, None]
        return np.asarray(self.start[:, None] + self.length[:, None, None] * run)

    def taken(self, chosen: Any) -> "Branches":
        """The chosen branches."""
        return Branches(*(part[chosen] for part in self))

    def tubes(
        self,
        rings: int,
        sides: int,
        cap: bool,
        thicker: float = 1.0,
        pale: float = 0.6,
        sway: float = 0.0,
        dark: float = 0.4,
    ) -> CoralMesh:
        """All branches as tubes, with round ends if `cap`.

        Branches of the last order get paler from the share `pale` of their length on; `dark` is
        the light in the middle of the growth, `sway` the share of the full sway at its outside.
        """
        share = np.tile(np.linspace(0.0, 1.0, rings), (len(self.length), 1))
        path = self.at(share)
        radius: Array = thicker * (self.radius[:, :1] + share * np.diff(self.radius))
        path, radius = capped(path, radius) if cap else pointed(path, radius)
        share = np.pad(share, ((0, 0), (0, path.shape[1] - rings)), constant_values=1.0)
        return self._tubes(path, radius, share, sides, pale, sway, dark)

    def spikes(
        self, widest: float, thicker: float, pale: float = 0.6, dark: float = 0.4
    ) -> CoralMesh:
        """All branches as triangular spikes, the widest at this share of the length.

        They have three triangles if that is 0, else six. Other values are those of `tubes`.
        """
        at = [0.0, 1.0] if widest == 0.0 else [0.0, widest, 1.0]
        share = np.tile(at, (len(self.length), 1))
        radius = thicker * self.radius.max(axis=1, keepdims=True) * (share == widest)
        return self._tubes(self.at(share), radius, share, 3, pale, 0.0, dark)

    def _tubes(
        self, path: Array, radius: Array, share: Array, sides: int, pale: float, sway: float,
        dark: float,
    ) -> CoralMesh:  # fmt: skip
        """Tubes along paths (b, r, 3) of the branches, at shares (b, r) of their lengths."""
        last = (self.order == self.order.max())[:, None]
        tip = np.where(last, np.clip((share - pale) / (1.0 - pale), 0.0, 1.0) ** 1.5, 0.0)
        light = thicket_light(path, dark)
        return tubes(path, radius, sides, tip=tip, light=light, sway=sway * out_share(path))


def pointed(path: Array, radius: Array) -> tuple[Array, Array]:
    """Paths and radii with blunt points: one more ring each, of radius 0."""
    end = unit(path[:, -1:] - path[:, -2:-1]) * radius[:, -1:, None]
    path = np.concatenate([path, path[:, -1:] + 0.5 * end], axis=1)
    return path, np.concatenate([radius, 0.0 * radius[:, -1:]], axis=1)


def out_share(path: Array) -> Array:
    """Distance of points from the root of a growth, as 0 to 1."""
    far = np.linalg.norm(path, axis=-1)
    return np.asarray(np.clip(far / far.max(), 0.0, 1.0) ** 1.5)


def thicket_light(path: Array, dark: float) -> Array:
    """Light at points of a thicket: `dark` in the middle, 1 outside."""
    return dark + (1.0 - dark) * out_share(path)


def grow_offshoots(
    rng: Rng,
    parents: Branches,
    number: int,
    spread: float,
    rise: float,
    shrink: float,
    first: float,
) -> Branches:
    """Grow `number` branches on each parent, from the share `first` of its length to its end."""
    p, n = len(parents.length), len(parents.length) * number
    share = (
        first + (1.0 - first) * (np.arange(number) + rng.uniform(0.2, 1.0, (p, number))) / number
    )
    share[:, -1] = 1.0
    start = parents.at(share).reshape(n, 3)
    along = unit(parents.way[:, None] + 2 * share[..., None] * parents.bend[:, None]).reshape(n, 3)
    aside = unit(cross(along, rng.normal(size=(n, 3))))
    way = unit(along + spread * rng.uniform(0.6, 1.4, (n, 1)) * aside + rise * UP)
    radius = parents.radius[:, None, :1] + share[..., None] * np.diff(parents.radius)[:, None]
    radius = 0.88 * radius.reshape(n, 1) * np.array([1.0, shrink])
    length = np.repeat(parents.length, number) * rng.uniform(0.55, 1.0, n) * shrink**0.5
    bend = 0.35 * rise * UP + 0.15 * rng.normal(size=(n, 3))
    return Branches(start, way, length, bend, radius, np.repeat(parents.order + 1, number))


def grow_stems(rng: Rng, number: int, lean: float, length: float, radius: float) -> Branches:
    """Grow `number` stems from one foot, which lean outward."""
    turn = 2 * np.pi * (np.arange(number) + rng.uniform(-0.4, 0.4, number)) / number
    out = lean * np.sqrt((np.arange(number) + 0.4) / number) * rng.uniform(0.7, 1.2, number)
    way = unit(np.stack([out * np.cos(turn), out * np.sin(turn), np.ones(number)], axis=1))
    start = 0.12 * way * (1, 1, 0) - 0.06 * UP
    return Branches(
        start, way, length * rng.uniform(0.7, 1.1, number),
        0.3 * UP + 0.12 * rng.normal(size=(number, 3)),
        np.tile([radius, 0.8 * radius], (number, 1)), np.zeros(number),
    )  # fmt: skip


def together(*parts: Branches) -> Branches:
    """Join branches."""
    return Branches(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))
