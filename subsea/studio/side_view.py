"""A fish at rest seen from its left, and its deformable meshes in a picture.

Points on a fish are (distance from the snout, height) in body lengths, points in a picture pixels,
x to the right and y down. A matrix (2, 3) maps the first to the second.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.fish import surface
from subsea.geometry.curves import basis_at, dense, greville, through
from subsea.studio.deformable_mesh import DORSAL, VENTRAL, FishMeshes, make_fin, make_mesh

FINER = 4  # default subdivision of a mesh
SHOWS = 0.006  # body lengths from which on the edge of a fin stands out of the body


class SideViewFin(NamedTuple):
    """A dorsal or ventral fin with twelve stations, at fractions `greville(12)` of its base."""

    row: int  # of the body that it is rooted on
    places: Array  # (12,) node indices along that row where it leaves the body
    root: Array  # (12, 2) these points
    leaves: Array  # (12,) their fraction of the way from the sunk row to the edge
    edge: Array  # (12, 2)
    shows: NDArray[np.bool_]  # (12,) whether it stands out of the body


class SideView(NamedTuple):
    """Nodes of the drawn surface at rest: the flank and its fins."""

    body: Array  # (9, 21, 2): rows from the back to the belly, columns from the snout
    fins: dict[str, SideViewFin]


def side_view(plan: surface.SurfacePlan) -> SideView:
    """The side of a fish; UserError for one with wings."""
    if plan.wing:
        raise UserError("a body with wings needs a photograph from above, which is not supported")
    half = surface.rest_surface(plan)[surface.RIGHT].reshape(surface.U, surface.V, 3)
    even = np.linspace(1.0, -1.0, surface.U)[:, None]
    middle, reach = (half[0, :, 1] + half[-1, :, 1]) / 2, (half[0, :, 1] - half[-1, :, 1]) / 2
    control = np.stack([half[..., 0], middle + even * reach], axis=2)
    # Across the body these are control points; the nodes lie on the surface.
    body = np.tensordot(dense(basis_at(surface.U, greville(surface.U)), surface.U), control, 1)
    fins = {}
    for name, row, one, ridge in (
        (DORSAL, 0, plan.dorsal, plan.back),
        (VENTRAL, surface.U - 1, plan.ventral, plan.belly),
    ):
        if one:
            fins[name] = _rest_fin(one, row, body[row], np.asarray(ridge, np.float64))
    return SideView(body, fins)


def _rest_fin(plan: surface.FinPlan, row: int, line: Array, ridge: Array) -> SideViewFin:
    """A fin, from where its way from the sunk root to the edge crosses the ridge."""
    share = greville(surface.FIN_V)
    base = plan.base[0] + (plan.base[1] - plan.base[0]) * share
    sunk = np.stack([base, surface.SUNK * surface.along(ridge, base)], axis=1)
    edge = surface.points_along(plan.edge, share)
    up = np.linspace(0.0, 1.0, 129)[:, None]
    x = sunk[:, 0] + up * (edge[:, 0] - sunk[:, 0])
    y = sunk[:, 1] + up * (edge[:, 1] - sunk[:, 1])
    out = np.abs(y) - np.abs(surface.along(ridge, x))
    shows = out[-1] > SHOWS
    left = np.where(shows, np.argmax(out > 0.0, axis=0), len(up) - 1)
    # Roots keep the order of the nodes whose springs they share.
    root_x = np.maximum.accumulate(np.where(shows, x[left, np.arange(surface.FIN_V)], base))
    places = np.interp(root_x, line[:, 0], np.arange(surface.V))
    root = np.stack([np.interp(places, np.arange(surface.V), axis) for axis in line.T], axis=1)
    return SideViewFin(row, places, root, up[left, 0], edge, shows)


def make_fish_meshes(plan: surface.SurfacePlan, matrix: Array) -> FishMeshes:
    """Meshes in a picture, at rest in the species' shape; only outlines attract the picture.

    The back under a fin, the belly at pelvic fins and fin edges inside the body are not outlines.
    """
    rest = side_view(plan)
    body = make_mesh(to_picture(matrix, rest.body))
    if plan.pelvic:
        begin, end = plan.pelvic.at - 0.02, plan.pelvic.at + plan.pelvic.length
        under = (rest.body[-1, :, 0] > begin) & (rest.body[-1, :, 0] < end)
        body.edge_weight[-1, under] = 0.0
    fins = {}
    for name, one in rest.fins.items():
        fins[name] = make_fin(body, one.row, one.places, to_picture(matrix, one.edge))
        fins[name].mesh.edge_weight[1, ~one.shows] = 0.0
        column = np.arange(surface.V)
        under = (column > one.places[0]) & (column < one.places[-1])
        hidden = np.interp(column, one.places, one.shows.astype(float)) < 0.5
        body.edge_weight[one.row, under & hidden] = 1.0  # the back between two fins
    return FishMeshes(body, fins)


def to_picture(matrix: Array, places: Array) -> Array:
    """Map points (…, 2) on a fish at rest to the picture."""
    return np.asarray(places @ np.asarray(matrix)[:, :2].T + np.asarray(matrix)[:, 2])


def centred_matrix(width: float, height: float, plan: surface.SurfacePlan) -> Array:
    """The matrix of a fish that heads left and fills most of a picture."""
    rest = side_view(plan)
    every = np.concatenate([rest.body.reshape(-1, 2), *(one.edge for one in rest.fins.values())])
    low, high = every.min(axis=0), every.max(axis=0)
    length = 0.8 * min(width / (high - low)[0], height / (high - low)[1])
    middle = (low + high) / 2
    across, down = width / 2 - length * middle[0], height / 2 + length * middle[1]
    return np.array([[length, 0.0, across], [0.0, -length, down]])


def subdivide(nodes: Array, times: int = FINER) -> Array:
    """Subdivide a mesh (m, n, 2) `times` each way by smooth curves through the nodes."""
    for axis in (0, 1):
        count = nodes.shape[axis]
        if count < 3:
            continue
        solved = through(np.moveaxis(nodes, axis, 0))
        nodes = np.moveaxis(np.tensordot(_finer(count, times), solved, 1), 0, axis)
    return nodes


@cache  # a window draws the same meshes in every frame
def _finer(count: int, times: int) -> Array:
    """Compute the weights of `count` control points at `times` as many places."""
    at = np.arange(times * (count - 1) + 1) / times
    return dense(basis_at(count, np.interp(at, np.arange(count), greville(count))), count)


def outline(nodes: Array) -> Array:
    """Return the border (k, 2) of a mesh (m, n, 2) in order, each node once."""
    return np.concatenate([nodes[0], nodes[1:, -1], nodes[-1, -2::-1], nodes[-2:0:-1, 0]])


def mesh_outlines(meshes: FishMeshes, times: int = FINER) -> list[Array]:
    """Closed outlines (k, 2) of all meshes; they overlap at the roots of fins."""
    return [outline(subdivide(mesh.nodes, times)) for mesh in meshes.parts.values()]
