"""Forms of bodies beside that of most fishes: a flatfish lies on its side, a boxfish is stiff.

A flatfish is simulated upright and recorded lying: what was its right flank looks up.
"""

from typing import Literal

import numpy as np

from subsea.base.arrays import Array
from subsea.fish.skinning import Coupling, couple
from subsea.fish.surface import SurfacePlan, rest_control_points

Form = Literal["fish", "flatfish", "boxfish"]
# The nodes of an upright body that are at the places of nodes 0 to 22 of a lying one.
LYING = np.array([0, *(1 + 4 * ring + k for ring in range(5) for k in (1, 2, 3, 0)), 21, 22])


def lay(points: Array) -> Array:
    """Lay points (…, 3) of an upright fish on its left side; axes are ahead, up and right."""
    return np.stack([points[..., 0], points[..., 2], -points[..., 1]], axis=-1)


def lay_nodes(nodes: Array) -> Array:
    """Lay nodes (…, 23, 3), in the order in which rings of a lying body have them."""
    return lay(nodes)[..., LYING, :]


def couple_surface(form: Form, surface: SurfacePlan, length: float, nodes: Array) -> Coupling:
    """Couple a surface to nodes (23, 3) at rest, of a flatfish lying ones; ``length`` in cm.

    A lying body is a rotated one, so its surface has the same weights on the same nodes. They are
    those of sections, as other methods take axes of the hull.
    """
    rest = rest_control_points(surface, length, nodes[0, 0])
    if form != "flatfish":
        return couple(surface.coupling, nodes, rest)
    upright = np.empty(nodes.shape)
    upright[LYING] = np.stack([nodes[:, 0], -nodes[:, 2], nodes[:, 1]], axis=1)
    coupling = couple("sections", upright, rest)
    return coupling._replace(weights=coupling.weights[:, LYING])
