"""Coupling of surface points to the 23 nodes.

Methods: cross-sections interpolated along the body (`skinning.py`), the bilinear patches of Tu
§5.4 (`patches.py`), and the tetrahedra of KS III.A (`geometry/tetrahedra.py`). All are weighted
sums of the nodes; Tu's adds an offset in the axes of a face of the hull.
"""

from typing import Literal, NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.fish.patches import bind_to_patches, face_axes
from subsea.fish.skinning import skin_weights
from subsea.geometry.tetrahedra import tetrahedral_weights

CouplingMethod = Literal["sections", "patches", "tetrahedra"]


class Coupling(NamedTuple):
    """Weights and offsets of p points on the nodes."""

    weights: Array  # (p, 23) of the nodes; rows sum to one
    face: Ints  # (p,) face of the hull whose axes the offset is in
    offset: Array  # (p, 3) cm; zero except for patches


def couple(method: CouplingMethod, rest_nodes: Array, rest_points: Array) -> Coupling:
    """Couple points (p, 3) to nodes (23, 3), both at rest and in the same axes.

    The rings of nodes must be planes of constant x.
    """
    if method == "patches":
        return Coupling(*bind_to_patches(rest_nodes, rest_points))
    weigh = skin_weights if method == "sections" else tetrahedral_weights
    none = np.zeros(rest_points.shape)
    return Coupling(weigh(rest_nodes, rest_points), np.zeros(len(none), np.int32), none)


def place(coupling: Coupling, nodes: Array) -> Array:
    """The points (…, p, 3) for nodes (…, 23, 3), in the axes of the nodes."""
    points = coupling.weights @ nodes
    if coupling.offset.any():
        axes = face_axes(nodes)[..., coupling.face, :, :]
        points = points + (axes @ coupling.offset[:, :, None])[..., 0]
    return np.asarray(points)
