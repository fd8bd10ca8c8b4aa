"""The force of the water on the hull (Tu eq. 4.3)."""

import math

from subsea.biomechanics.body import TRIANGLE_WEIGHTS, TRIANGLES, Floats
from subsea.kernels import kernel
from subsea.kernels.lanes import any_positive, where_positive


@kernel
def add_water_force(x: Floats, v: Floats, water: Floats, drag: float, force: Floats) -> None:
    """Add the force of the water on the hull to ``force`` (23, 3) (Tu eq. 4.3).

    x, v (23, 3) are positions (cm) and velocities (cm/tu), ``water`` (3,) the velocity of the
    water, ``drag`` its µ. A triangle of area A and outward normal n that moves at v relative to
    the water contributes -µ A |v| (n·v) n where it pushes outwards (n·v > 0) and nothing where
    it recedes. Each corner receives a third.
    """
    for k in range(TRIANGLES.shape[0]):
        a, b, c = TRIANGLES[k, 0], TRIANGLES[k, 1], TRIANGLES[k, 2]
        px, py, pz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
        qx, qy, qz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
        # Twice the area times the normal, and three times the mean relative velocity; `scale`
        # corrects the factors.
        nx, ny, nz = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
        ux = v[a, 0] + v[b, 0] + v[c, 0] - 3.0 * water[0]
        uy = v[a, 1] + v[b, 1] + v[c, 1] - 3.0 * water[1]
        uz = v[a, 2] + v[b, 2] + v[c, 2] - 3.0 * water[2]
        outward = nx * ux + ny * uy + nz * uz
        if any_positive(outward):
            speed_per_area = math.sqrt(
                (ux * ux + uy * uy + uz * uz) / (nx * nx + ny * ny + nz * nz)
            )
            push = -drag * TRIANGLE_WEIGHTS[k] * speed_per_area * outward / 54.0
            scale = where_positive(outward, push)
            fx, fy, fz = scale * nx, scale * ny, scale * nz
            for node in (a, b, c):
                force[node, 0] += fx
                force[node, 1] += fy
                force[node, 2] += fz
