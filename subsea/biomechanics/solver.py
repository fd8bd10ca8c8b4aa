"""One semi-implicit step of the fish body after another (Tu §4.5)."""

import numpy as np
from numba import njit

from subsea.biomechanics.body import (
    MUSCLES,
    NODES,
    SKYLINE_DIAGONAL,
    SKYLINE_FIRST,
    SKYLINE_SIZE,
    UNITS,
    Floats,
)
from subsea.biomechanics.water import add_water_force

STEP = 0.055
"""Time step in tu (Tu §4.5.2): 5.5 ms."""
STEPS_PER_TICK = 6
"""Steps between two recorded frames: one tick is 0.33 tu."""
TIME_UNIT_S = 0.1
TICK_S = STEP * STEPS_PER_TICK * TIME_UNIT_S
"""One tick, 0.033 s."""
STRAIN_LIMITS = (0.65, 1.4)
"""Length over rest length that every unit must keep; beyond, a ring may have turned inside out."""


@njit(cache=True, error_model="numpy")
def factorize(packed: Floats) -> float:
    """Replace a packed skyline matrix (126,) by its factors L and D (Tu eq. 4.12).

    Row i keeps columns SKYLINE_FIRST[i]..i one after another. L has a unit diagonal that is not
    stored; the diagonal places take 1/D. Returns the smallest pivot of D: at or below zero the
    matrix was not positive definite and the factors mean nothing.
    """
    smallest = np.inf
    for i in range(NODES):
        first = SKYLINE_FIRST[i]
        row = SKYLINE_DIAGONAL[i] - i  # packed place of (i, j) is row + j
        pivot = packed[row + i]
        for j in range(first, i):
            start = max(first, SKYLINE_FIRST[j])
            other = SKYLINE_DIAGONAL[j] - j
            total = packed[row + j]
            for k in range(start, j):
                total -= packed[row + k] * packed[other + k]
            packed[row + j] = total  # L_ij D_j for now
        for j in range(first, i):
            scaled = packed[row + j]
            factor = scaled * packed[SKYLINE_DIAGONAL[j]]
            pivot -= scaled * factor
            packed[row + j] = factor
        smallest = min(smallest, pivot)
        packed[row + i] = 1.0 / pivot
    return smallest


@njit(cache=True, error_model="numpy")
def substitute(packed: Floats, load: Floats) -> None:
    """Solve L D Lᵀ V = G in place: ``load`` (23, 3) is G and becomes V (Tu eqs. 4.13, 4.14)."""
    for i in range(NODES):
        row = SKYLINE_DIAGONAL[i] - i
        gx, gy, gz = load[i, 0], load[i, 1], load[i, 2]
        for j in range(SKYLINE_FIRST[i], i):
            factor = packed[row + j]
            gx -= factor * load[j, 0]
            gy -= factor * load[j, 1]
            gz -= factor * load[j, 2]
        load[i, 0], load[i, 1], load[i, 2] = gx, gy, gz
    for i in range(NODES):
        inverse = packed[SKYLINE_DIAGONAL[i]]
        for axis in range(3):
            load[i, axis] *= inverse
    for i in range(NODES - 1, 0, -1):
        row = SKYLINE_DIAGONAL[i] - i
        gx, gy, gz = load[i, 0], load[i, 1], load[i, 2]
        for j in range(SKYLINE_FIRST[i], i):
            factor = packed[row + j]
            load[j, 0] -= factor * gx
            load[j, 1] -= factor * gy
            load[j, 2] -= factor * gz


@njit(cache=True, error_model="numpy")
def assemble(
    x: Floats,
    v: Floats,
    mass: Floats,
    length: Floats,
    stiffness: Floats,
    viscosity: Floats,
    muscle: Floats,
    step: float,
    packed: Floats,
    load: Floats,
    strain: Floats,
) -> None:
    """Add the units and the inertia to A (packed, 126) and G (load, 23 by 3): Tu eqs. 4.10, 4.11.

    ``length`` (91,) are rest lengths; those of the muscles, the first twelve, are replaced by
    ``muscle`` (12,). ``strain`` (2,) keeps the extremes of length over natural rest length.
    """
    for s in range(UNITS.shape[0]):
        i, j = UNITS[s, 0], UNITS[s, 1]
        rx, ry, rz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
        squared = rx * rx + ry * ry + rz * rz
        inverse = 1.0 / np.sqrt(squared)
        distance = squared * inverse
        ratio = distance / length[s]
        strain[0] = min(strain[0], ratio)
        strain[1] = max(strain[1], ratio)
        rest = muscle[s] if s < MUSCLES else length[s]
        along = (
            (v[j, 0] - v[i, 0]) * rx + (v[j, 1] - v[i, 1]) * ry + (v[j, 2] - v[i, 2]) * rz
        ) * inverse
        eta = (stiffness[s] * (distance - rest) + viscosity[s] * along) * inverse  # Tu eq. 4.1
        load[i, 0] += eta * rx
        load[i, 1] += eta * ry
        load[i, 2] += eta * rz
        load[j, 0] -= eta * rx
        load[j, 1] -= eta * ry
        load[j, 2] -= eta * rz
        # Under compression eta is negative and could cost A its definiteness; the true force is
        # in the load all the same, so only the implicit part is held back.
        if eta > 0.0:
            packed[SKYLINE_DIAGONAL[i]] += eta * step
            packed[SKYLINE_DIAGONAL[j]] += eta * step
            packed[SKYLINE_DIAGONAL[j] - j + i] -= eta * step
    for i in range(NODES):
        inertia = mass[i] / step
        packed[SKYLINE_DIAGONAL[i]] += inertia
        for axis in range(3):
            load[i, axis] += inertia * v[i, axis]


@njit(cache=True, error_model="numpy")
def advance(
    x: Floats,
    v: Floats,
    mass: Floats,
    length: Floats,
    stiffness: Floats,
    viscosity: Floats,
    drag: float,
    muscles: Floats,
    water: Floats,
    force: Floats,
    step: float,
    watch: Floats,
) -> None:
    """Advance x and v (23, 3; cm, cm/tu) in place by one step for each row of ``muscles``.

    ``muscles`` (steps, 12) are the muscles' rest lengths in cm, ``water`` (3,) the velocity of
    the water in cm/tu, ``force`` (23, 3) a constant further force (pectoral fins). ``watch`` (3,)
    keeps the least and the greatest length ratio of any unit and the smallest pivot. The other
    arguments are the fields of :class:`~subsea.biomechanics.body.Body` (Tu §4.5.2).
    """
    packed = np.empty(SKYLINE_SIZE)
    load = np.empty((NODES, 3))
    for n in range(muscles.shape[0]):
        packed[:] = 0.0
        load[:] = force
        add_water_force(x, v, water, drag, load)
        assemble(
            x, v, mass, length, stiffness, viscosity, muscles[n], step, packed, load, watch[:2]
        )
        watch[2] = min(watch[2], factorize(packed))
        substitute(packed, load)
        for i in range(NODES):
            for axis in range(3):
                v[i, axis] = load[i, axis]
                x[i, axis] += step * load[i, axis]
