"""The control points of the drawn surface, from the nodes (SMC eq. 9, Tu §5.4)."""

import numpy as np

from subsea.biomechanics.body import Floats, build_body
from subsea.kinematics.skin import skin_weights
from subsea.kinematics.surface import rest_control_points
from subsea.species import Species


def control_weights(species: Species) -> Floats:
    """The matrix (426, 23) that gives a species' control points from its nodes, in any frame."""
    nodes = build_body(species.body).rest
    points = rest_control_points(species.surface, species.body.length, nodes[0, 0])
    return np.asarray(skin_weights(nodes, points), dtype=np.float64)
