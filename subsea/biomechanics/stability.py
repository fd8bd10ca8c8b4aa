"""The stability limit of the time step, from the material of a body.

At rest the effective stiffness of the units is zero, so a step is symplectic Euler with damping at
the old velocity: v ← v - h M⁻¹ (K x + C v), x ← x + h v. It conserves an energy that is positive
definite while 4 M - h² K - 2 h C is, for the stiffness K and the damping C at rest; with a longer
step h the stiffest mode grows. Water only dissipates energy.
"""

import numpy as np

from subsea.biomechanics.body import NODES, UNITS, Body, Floats, build_body
from subsea.biomechanics.body_plan import NODES_AT_STATION, BodyPlan
from subsea.biomechanics.solver import STEP

ROUNDS = 4  # number of rounds. Two are exact to 1e-6 for a fish; extreme bodies may need more


def check_step(plan: BodyPlan) -> None:
    """Raise ValueError for a body that is too stiff for its masses at the usual step."""
    body = build_body(plan)
    stiff, damped = _per_mass(body)
    try:
        np.linalg.cholesky(4 * np.eye(len(stiff)) - STEP**2 * stiff - 2 * STEP * damped)
    except np.linalg.LinAlgError:
        limit, node = longest_step(body)
        station = int(np.repeat(np.arange(len(NODES_AT_STATION)), NODES_AT_STATION)[node])
        raise ValueError(
            f"masses[{station}] = {plan.masses[station]:g} g is too light for the stiffness: the "
            f"body bears steps of {limit:.2g} tu and takes {STEP:g}; raise the mass, or lower "
            "stiffness or viscosity"
        ) from None


def longest_step(body: Body) -> tuple[float, int]:
    """The longest stable step in tu, and the node that moves most in the mode that limits it.

    A mode z of unit mass is stable up to the h with h² zᵀKz + 2 h zᵀCz = 4; the limit is the least
    over all modes. Each round takes the worst mode at the present step, and its limit.
    """
    stiff, damped = _per_mass(body)
    step = STEP
    for _ in range(ROUNDS):
        z = np.linalg.eigh(step**2 * stiff + 2 * step * damped)[1][:, -1]
        k, c = z @ stiff @ z, z @ damped @ z
        step = float((np.sqrt(c * c + 4 * k) - c) / k)
    moved = np.linalg.norm((z / np.sqrt(np.repeat(body.mass, 3))).reshape(NODES, 3), axis=1)
    return step, int(moved.argmax())


def _per_mass(body: Body) -> tuple[Floats, Floats]:
    """Stiffness and damping matrices (69, 69) at rest, scaled by the roots of the masses."""
    root = np.repeat(1.0 / np.sqrt(body.mass), 3)
    scale = np.outer(root, root)
    return scale * _lengthwise(body, body.stiffness), scale * _lengthwise(body, body.viscosity)


def _lengthwise(body: Body, modulus: Floats) -> Floats:
    """Matrix (69, 69) of units that resist along their length with ``modulus`` (91,) each."""
    i, j = UNITS.T
    along = (body.rest[j] - body.rest[i]) / body.length[:, None]
    block = modulus[:, None, None] * along[:, :, None] * along[:, None, :]
    matrix = np.zeros((NODES, NODES, 3, 3))
    np.add.at(matrix, (i, i), block)
    np.add.at(matrix, (j, j), block)
    np.subtract.at(matrix, (i, j), block)
    np.subtract.at(matrix, (j, i), block)
    return np.asarray(matrix.transpose(0, 2, 1, 3).reshape(3 * NODES, 3 * NODES))
