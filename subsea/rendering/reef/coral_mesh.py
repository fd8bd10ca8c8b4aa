"""Meshes of growths: surfaces over rings of points, as tubes, turned profiles and thin plates.

Points are arrays (b, r, c, 3): b pieces of r rings of c points, whose first and last coincide. Seen
from outside, points run counter-clockwise about the direction from ring to ring.
"""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints

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
    top: Array, thick: float, *, tip: Array | float = 0.0, light: Array | float = 1.0
) -> CoralMesh:
    """Thin two-sided plates with upper sides (b, r, c, 3), from the foot to the rim.

    They are `thick` at the foot and sharp at the rim. Other values broadcast to (b, r, c).
    """
    top = top[:, :, ::-1]
    b, r, c, _ = top.shape
    down = thick * np.linspace(1.0, 0.0, r)[:, None, None] ** 0.5
    closed = skin(np.concatenate([top, top[:, :, :1]], axis=2))
    face = closed.normal.reshape(b, r, c + 1, 3)[:, :, 1:-2]
    face = np.concatenate([face[:, :, :1], face, face[:, :, -1:]], axis=2)
    under = top - down * unit(face)
    place = np.concatenate([top, under[:, :, ::-1], top[:, :, :1]], axis=2)

    def both(x: Array | float, below: float) -> Array:
        x = np.broadcast_to(x, (b, r, c))[:, :, ::-1]
        return np.concatenate([x, below * x[:, :, ::-1], x[:, :, :1]], axis=2)

    return skin(place, tip=both(tip, 0.6), light=both(light, 0.55))


def joined(*meshes: CoralMesh) -> CoralMesh:
    """Join meshes."""
    starts = np.cumsum([0] + [len(mesh.place) for mesh in meshes])
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=False)]
    parts = [np.concatenate(part) for part in list(zip(*meshes, strict=True))[:-1]]
    return CoralMesh(*parts, np.concatenate(triangles))  # type: ignore[call-arg]


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
