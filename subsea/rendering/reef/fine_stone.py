"""Stone at arm's length: each triangle of a piece split in four, on the surface of the stone."""

from functools import partial
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.habitat.formations import on_the_surface
from subsea.habitat.stone import box_of
from subsea.rendering.gl.static_batch import LazyMesh, StaticMesh

STEPS = 2  # toward the surface
WITHIN_CM = 1.0  # distance to the surface of a vertex that has come to it
TRIED = 12  # vertices by which the formation of a piece is found


class Halved(NamedTuple):
    """A mesh whose edges are halved."""

    mesh: StaticMesh
    ends: Ints  # (e, 2) vertices of each edge
    triangles: Ints  # (4 m, 3) among the vertices of the mesh and, after them, its edges' middles

    @property
    def rough(self) -> Array:
        """The vertices (n + e, c), with those of the middles in the triangles that they split."""
        vertices = self.mesh.vertices
        return np.concatenate([vertices, vertices[self.ends].mean(axis=1)])


def halved(mesh: StaticMesh) -> Halved:
    """Halve the edges of a mesh."""
    number, corners = len(mesh.vertices), mesh.triangles.astype(np.int64)
    sides = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2), axis=2)
    keys, edge = np.unique(sides[..., 0] * number + sides[..., 1], return_inverse=True)
    middle = number + edge.reshape(-1, 3)  # of the side from each corner to the next
    at_corners = np.stack([corners, middle, np.roll(middle, 1, axis=1)], axis=2)
    fours = np.concatenate([at_corners, middle[:, None]], axis=1)
    triangles = fours.reshape(-1, 3).astype(np.int32)
    return Halved(mesh, np.stack(np.divmod(keys, max(number, 1)), axis=1), triangles)


def finer(piece: Halved, formations: list[Array]) -> LazyMesh:
    """The mesh of a piece with middles of edges on the stone of the one of these formations."""
    number = len(piece.mesh.vertices) + len(piece.ends)
    return LazyMesh(partial(_on_stone, piece, formations), number, piece.triangles)


def _on_stone(piece: Halved, formations: list[Array]) -> Array:
    """The vertices of a finer piece."""
    vertices, first = piece.rough, len(piece.mesh.vertices)
    middles = vertices[first:, :3].astype(np.float64)
    if not len(middles):
        return vertices
    blocks = _formation_at(piece.mesh.vertices[:, :3].astype(np.float64), formations)
    place, normal, error = on_the_surface(blocks, middles, STEPS)
    ends = piece.mesh.vertices[piece.ends, :3]
    reach = 0.5 * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    moved = (error < WITHIN_CM) & (np.linalg.norm(place - middles, axis=1) < reach)
    vertices[first:, :3][moved], vertices[first:, 3:6][moved] = place[moved], normal[moved]
    long = np.linalg.norm(vertices[first:, 3:6], axis=1, keepdims=True)
    vertices[first:, 3:6] /= np.maximum(long, 1e-3)
    return vertices


def _formation_at(places: Array, formations: list[Array]) -> Array:
    """The blocks of the formation on whose surface these places (n, 3) lie."""
    low, high = places.min(axis=0), places.max(axis=0)
    near = []
    for blocks in formations:
        bottom, top = box_of(blocks)
        if (low <= top).all() and (bottom <= high).all():
            near.append(blocks)
    tried = np.ascontiguousarray(places[:: max(len(places) // TRIED, 1)])
    errors = [float(np.median(on_the_surface(blocks, tried, 0)[2])) for blocks in near]
    return near[int(np.argmin(errors))] if near else formations[0]
