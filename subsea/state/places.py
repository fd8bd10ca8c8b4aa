"""The places of other fishes, as a fish sees them in a sea with or without a box."""

from subsea.geometry.periodic import nearest_image
from subsea.geometry.vector import Vector, vector
from subsea.kernels import kernel
from subsea.state.groups import Fishes


@kernel
def place_near(fishes: Fishes, j: int, here: Vector) -> Vector:
    """Return the place of fish j, in a box that of its image nearest to `here`, cm."""
    return nearest_image(vector(fishes.position[j]), here, fishes.period)
