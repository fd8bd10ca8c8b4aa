"""The control points of the drawn surface, from the nodes (SMC eq. 9, Tu §5.4)."""

from subsea.biomechanics.body import build_body
from subsea.kinematics.coupling import Coupling, couple
from subsea.kinematics.surface import rest_control_points
from subsea.species import Species


def surface_coupling(species: Species) -> Coupling:
    """How a species' 426 control points hang on its nodes, in any frame."""
    nodes = build_body(species.body).rest
    points = rest_control_points(species.surface, species.body.length, nodes[0, 0])
    return couple(species.surface.coupling, nodes, points)
