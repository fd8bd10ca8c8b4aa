"""The control points of the drawn surface, from the nodes (SMC eq. 9, Tu §5.4)."""

from subsea.biomechanics.body import build_body
from subsea.biomechanics.body_plan import BodyPlan
from subsea.fish.coupling import Coupling, couple
from subsea.fish.surface import SurfacePlan, rest_control_points


def surface_coupling(surface: SurfacePlan, body: BodyPlan) -> Coupling:
    """How a surface's 426 control points hang on a body's nodes, in any frame."""
    nodes = build_body(body).rest
    points = rest_control_points(surface, body.length, nodes[0, 0])
    return couple(surface.coupling, nodes, points)
