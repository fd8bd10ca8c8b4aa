"""Forms of bodies beside that of most fishes: a flatfish lies on its side, a boxfish is stiff.

A flatfish is simulated upright and recorded lying: what was its right flank looks up.
"""

from typing import Literal

import numpy as np

from subsea.base.arrays import Array

Form = Literal["fish", "flatfish", "boxfish"]
# The nodes of an upright body that are at the places of nodes 0 to 22 of a lying one.
LYING = np.array([0, *(1 + 4 * ring + k for ring in range(5) for k in (1, 2, 3, 0)), 21, 22])


def lay(points: Array) -> Array:
    """Lay points (…, 3) of an upright fish on its left side; axes are ahead, up and right."""
    return np.stack([points[..., 0], points[..., 2], -points[..., 1]], axis=-1)


def lay_nodes(nodes: Array) -> Array:
    """Lay nodes (…, 23, 3), in the order in which rings of a lying body have them."""
    return lay(nodes)[..., LYING, :]
