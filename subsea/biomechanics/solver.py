"""The semi-implicit solver of the fish body (Tu §4.5).

The system matrix is stored as a band. Tu packs its skyline, 126 of the band's 184 entries; the
constant width of a band lets the compiler vectorise the inner loops, which outweighs the zeros
four times. Rows beyond the last node are padding, so that no loop has to test for the end.

The source serves one body (arrays of floats) and several at once (arrays of `kernels.lanes`).

The stability limit of the time step, from the material of a body.

At rest the effective stiffness of the units is zero, so a step is symplectic Euler with damping at
the old velocity: v ← v - h M⁻¹ (K x + C v), x ← x + h v. It conserves an energy that is positive
definite while 4 M - h² K - 2 h C is, for the stiffness K and the damping C at rest; with a longer
step h the stiffest mode grows. Water only dissipates energy.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable

from subsea.base.arrays import Array
from subsea.biomechanics.body import (
    HALF_BANDWIDTH,
    UNITS,
    Body,
    Floats,
    Ints,
    Material,
    build_body,
)
from subsea.biomechanics.body_plan import NODES_AT_STATION, BodyPlan
from subsea.biomechanics.reactive_water import (
    ALL_KEPT,
    Kept,
    add_section_forces,
    section_frames,
    section_means,
)
from subsea.biomechanics.water import add_water_force
from subsea.kernels import kernel
from subsea.kernels.lanes import first, room, uncounted, zero_of

STEP = 0.055  # time step in tu (Tu §4.5.2): 5.5 ms
STEPS_PER_TICK = 6  # steps between two recorded frames
TIME_UNIT_S = 0.1
TICK_TU = STEP * STEPS_PER_TICK  # one recorded frame
TICK_S = TICK_TU * TIME_UNIT_S  # one tick, 0.033 s
STRAIN_LIMITS = (0.65, 1.4)
"""Limits of length over rest length; beyond, a ring may have turned inside out."""


class Chain(NamedTuple):
    """A chain of rings with muscles; a fish has five rings."""

    material: Material
    units: Ints  # (91, 2) pairs of nodes, muscles first
    kept: Kept  # as in `add_section_forces`


class Workspace(NamedTuple):
    """Arrays that a step writes before it reads them, made once for many steps."""

    memory: Array  # of all others, which are views of it
    band: Array  # (30, 8) matrix A, then its factors
    load: Array  # (30, 3) G, then V
    column: Array  # (8,) of `factorize`
    axes: Array  # (3, 6, 3) tangents, normals and former normals of the sections
    columns: Array  # (30, 6) means of the sections, then L⁻¹ times these
    resistance: Array  # (6,)
    matrix: Array  # (6, 6)
    push: Array  # (6,) along the normals
    scaled: Array  # (30,) a column over D


class Solver(NamedTuple):
    """A chain, and the workspace of its steps."""

    chain: Chain
    workspace: Workspace


@register_jitable
def make_workspace(x: Floats, sections: int) -> Workspace:
    """Make the workspace of a body, or of lanes, with nodes ``x`` (23, 3)."""
    rows, width = len(x) + HALF_BANDWIDTH, HALF_BANDWIDTH + 1
    sizes = (
        rows * width, 3 * rows, width, 9 * sections, rows * sections, sections,
        sections * sections, sections, rows,
    )  # fmt: skip
    total = 0
    for size in sizes:
        total += size
    memory, at = room((total,), x), 0
    band = uncounted(memory[: sizes[0]].reshape(rows, width))
    at += sizes[0]
    load = uncounted(memory[at : at + sizes[1]].reshape(rows, 3))
    at += sizes[1]
    column = uncounted(memory[at : at + sizes[2]])
    at += sizes[2]
    axes = uncounted(memory[at : at + sizes[3]].reshape(3, sections, 3))
    at += sizes[3]
    columns = uncounted(memory[at : at + sizes[4]].reshape(rows, sections))
    at += sizes[4]
    resistance = uncounted(memory[at : at + sizes[5]])
    at += sizes[5]
    matrix = uncounted(memory[at : at + sizes[6]].reshape(sections, sections))
    at += sizes[6]
    push = uncounted(memory[at : at + sizes[7]])
    at += sizes[7]
    scaled = uncounted(memory[at : at + sizes[8]])
    return Workspace(memory, band, load, column, axes, columns, resistance, matrix, push, scaled)


@kernel
def factorize(band: Floats, column: Floats) -> float:
    """Replace a banded matrix by its factors L and D (Tu eq. 4.12).

    ``band`` (30, 8) holds a_{i+k,i} at [i, k]. The unit diagonal of L is not stored; the diagonal
    holds 1/D. Returns the smallest pivot of D: at or below zero the matrix was not positive
    definite and the factors are meaningless. Overwrites ``column`` (8,).
    """
    smallest = zero_of(band) + np.inf
    for i in range(len(band) - HALF_BANDWIDTH):
        pivot = band[i, 0]
        smallest = min(smallest, pivot)
        inverse = 1.0 / pivot
        band[i, 0] = inverse
        for k in range(1, HALF_BANDWIDTH + 1):
            column[k] = band[i, k]
            band[i, k] *= inverse
        for k in range(1, HALF_BANDWIDTH + 1):
            factor = band[i, k]
            for j in range(HALF_BANDWIDTH + 1 - k):
                band[i + k, j] -= factor * column[k + j]
    return smallest


@kernel
def substitute(band: Floats, load: Floats) -> None:
    """Solve L D Lᵀ V = G in place: ``load`` (30, 3) is G and becomes V (Tu eqs. 4.13, 4.14)."""
    _forward(band, load)
    _backward(band, load)


@kernel
def couple_sections(workspace: Workspace) -> None:
    """Solve for V with the added mass and the cross-flow of the sections, in place.

    The matrix is A + Σ r_k (n_k ⊗ c_k)(n_k ⊗ c_k)ᵀ: the mean velocity c_k·V of section k along its
    normal n_k meets the ``resistance`` r_k (6,). A acts on each axis alone, so that A⁻¹ is needed
    for six columns c_k (``columns`` (30, 6), overwritten) and not for all of their products
    (Woodbury). ``band`` holds the factors of A and ``load`` (30, 3) the right-hand side.
    """
    band, load, columns = workspace.band, workspace.load, workspace.columns
    normal, resistance = workspace.axes[1], workspace.resistance
    matrix, push, scaled = workspace.matrix, workspace.push, workspace.scaled
    nodes, sections = len(band) - HALF_BANDWIDTH, len(push)
    # A column is zero before its ring, which begins at node 1 + 4 c.
    for i in range(1, nodes):
        for c in range((i + 3) // 4):
            value = columns[i, c]
            for back in range(min(HALF_BANDWIDTH, i - 1 - 4 * c), 0, -1):
                value -= band[i - back, back] * columns[i - back, c]
            columns[i, c] = value
    _forward(band, load)
    # Matrix (its lower triangle) and right-hand side of the pushes along the normals; then
    # Cholesky.
    for c in range(sections):
        nx, ny, nz = normal[c, 0], normal[c, 1], normal[c, 2]
        total = zero_of(band)
        for i in range(1 + 4 * c, nodes):
            scaled[i] = columns[i, c] * band[i, 0]
            along = nx * load[i, 0] + ny * load[i, 1]
            total += scaled[i] * (along + nz * load[i, 2])
        push[c] = total
        for d in range(c + 1):
            total = zero_of(band)
            for i in range(1 + 4 * c, nodes):
                total += scaled[i] * columns[i, d]
            alike = nx * normal[d, 0] + ny * normal[d, 1]
            matrix[c, d] = total * (alike + nz * normal[d, 2])
        matrix[c, c] += 1.0 / resistance[c]
    for c in range(sections):
        for d in range(c):
            matrix[c, c] -= matrix[c, d] * matrix[c, d]
            push[c] -= matrix[c, d] * push[d]
        matrix[c, c] = math.sqrt(matrix[c, c])
        push[c] /= matrix[c, c]
        for row in range(c + 1, sections):
            for d in range(c):
                matrix[row, c] -= matrix[row, d] * matrix[c, d]
            matrix[row, c] /= matrix[c, c]
    for c in range(sections - 1, -1, -1):
        for row in range(c + 1, sections):
            push[c] -= matrix[row, c] * push[row]
        push[c] /= matrix[c, c]
    for c in range(sections):
        px, py, pz = push[c] * normal[c, 0], push[c] * normal[c, 1], push[c] * normal[c, 2]
        for i in range(1 + 4 * c, nodes):
            load[i, 0] -= columns[i, c] * px
            load[i, 1] -= columns[i, c] * py
            load[i, 2] -= columns[i, c] * pz
    _backward(band, load)


@kernel
def _forward(band: Floats, load: Floats) -> None:
    """Solve L X = G in place."""
    for i in range(1, len(band) - HALF_BANDWIDTH):
        x, y, z = load[i, 0], load[i, 1], load[i, 2]
        for back in range(min(HALF_BANDWIDTH, i), 0, -1):
            factor = band[i - back, back]
            x -= factor * load[i - back, 0]
            y -= factor * load[i - back, 1]
            z -= factor * load[i - back, 2]
        load[i, 0], load[i, 1], load[i, 2] = x, y, z


@kernel
def _backward(band: Floats, load: Floats) -> None:
    """Solve D Lᵀ V = X in place."""
    nodes = len(band) - HALF_BANDWIDTH
    for i in range(nodes, len(load)):
        for axis in range(3):
            load[i, axis] = 0.0
    for i in range(nodes - 1, -1, -1):
        inverse = band[i, 0]
        x, y, z = load[i, 0] * inverse, load[i, 1] * inverse, load[i, 2] * inverse
        for k in range(1, HALF_BANDWIDTH + 1):
            factor = band[i, k]
            x -= factor * load[i + k, 0]
            y -= factor * load[i + k, 1]
            z -= factor * load[i + k, 2]
        load[i, 0], load[i, 1], load[i, 2] = x, y, z


@kernel
def assemble(
    x: Floats,
    v: Floats,
    chain: Chain,
    muscle: Floats,
    step: float,
    band: Floats,
    load: Floats,
    strain: Floats,
) -> None:
    """Add units and inertia to A (``band`` (30, 8)) and G (``load`` (30, 3)): Tu eqs. 4.10, 4.11.

    ``muscle`` (12,) replaces the rest lengths of the first twelve units. ``strain`` (2,) keeps
    the extremes of length over natural rest length.
    """
    material, units = chain.material, chain.units
    length, stiffness, viscosity = material.length, material.stiffness, material.viscosity
    least, greatest = strain[0], strain[1]
    for s in range(len(units)):
        i, j = units[s, 0], units[s, 1]
        rx, ry, rz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
        squared = rx * rx + ry * ry + rz * rz
        inverse = 1.0 / math.sqrt(squared)
        distance = squared * inverse
        ratio = distance / length[s]
        least, greatest = min(least, ratio), max(greatest, ratio)
        stretch = distance - muscle[s] if s < len(muscle) else distance - length[s]
        along = (
            (v[j, 0] - v[i, 0]) * rx + (v[j, 1] - v[i, 1]) * ry + (v[j, 2] - v[i, 2]) * rz
        ) * inverse
        eta = (stiffness[s] * stretch + viscosity[s] * along) * inverse  # Tu eq. 4.1
        load[i, 0] += eta * rx
        load[i, 1] += eta * ry
        load[i, 2] += eta * rz
        load[j, 0] -= eta * rx
        load[j, 1] -= eta * ry
        load[j, 2] -= eta * rz
        # Under compression eta is negative and could make A indefinite: leave out the implicit
        # part; the load has the full force.
        held = max(0.0, eta) * step
        band[i, 0] += held
        band[j, 0] += held
        band[i, j - i] -= held
    strain[0], strain[1] = least, greatest
    for i in range(len(x)):
        inertia = material.mass[i] / step
        band[i, 0] += inertia
        for axis in range(3):
            load[i, axis] += inertia * v[i, axis]


@kernel
def advance(
    x: Floats,
    v: Floats,
    material: Material,
    muscles: Floats,
    water: Floats,
    force: Floats,
    step: float,
    watch: Floats,
) -> None:
    """Advance x and v (23, 3; cm, cm/tu) in place by one step for each row of ``muscles``.

    ``muscles`` (steps, 12) are the muscles' rest lengths in cm, ``water`` (3,) the velocity of
    the water in cm/tu, ``force`` (23, 3) a constant further force (pectoral fins). ``watch`` (3,)
    keeps the least and the greatest length ratio of any unit and the smallest pivot (Tu §4.5.2).
    """
    advance_chain(x, v, Chain(material, UNITS, ALL_KEPT), muscles, water, force, step, watch)


@kernel
def advance_chain(
    x: Floats,
    v: Floats,
    chain: Chain,
    muscles: Floats,
    water: Floats,
    force: Floats,
    step: float,
    watch: Floats,
) -> None:
    """Advance a body of any number of rings: as `advance`.

    Only the hull of 23 nodes can be in Tu's water.
    """
    solver = Solver(chain, make_workspace(x, len(chain.kept)))
    advance_solver(x, v, solver, muscles, water, force, step, watch)


@kernel
def advance_solver(
    x: Floats,
    v: Floats,
    solver: Solver,
    muscles: Floats,
    water: Floats,
    force: Floats,
    step: float,
    watch: Floats,
) -> None:
    """Advance a body, or lanes, as `advance_chain`, in a workspace that exists."""
    chain, workspace = solver
    material, kept = chain.material, chain.kept
    band, load, axes = workspace.band, workspace.load, workspace.axes
    tangent, normal, before = axes[0], axes[1], axes[2]
    nodes, rows, sections = len(x), len(load), len(kept)
    slender = first(material.sections.added[sections - 1]) > 0.0
    for i in range(rows):
        for axis in range(3):
            load[i, axis] = 0.0
    if slender:
        for i in range(nodes):
            for axis in range(3):
                load[i, axis] = x[i, axis] - step * v[i, axis]
        section_frames(load, tangent, normal)
    for n in range(muscles.shape[0]):
        for i in range(rows):
            for k in range(HALF_BANDWIDTH + 1):
                band[i, k] = 0.0
        for i in range(nodes):
            for axis in range(3):
                load[i, axis] = force[i, axis]
        if slender:
            for k in range(sections):
                for axis in range(3):
                    before[k, axis] = normal[k, axis]
            section_frames(x, tangent, normal)
            add_section_forces(
                v, water, material.sections, kept, step, axes, load, workspace.resistance
            )
        else:
            add_water_force(x, v, water, material.drag, load)
        assemble(x, v, chain, muscles[n], step, band, load, watch)
        watch[2] = min(watch[2], factorize(band, workspace.column))
        if slender:
            section_means(workspace.columns)
            couple_sections(workspace)
        else:
            substitute(band, load)
        for i in range(nodes):
            for axis in range(3):
                value = load[i, axis]
                v[i, axis] = value
                x[i, axis] += step * value


ROUNDS = 4  # number of rounds. Two are exact to 1e-6 for a fish; extreme bodies may need more


def check_step(plan: BodyPlan) -> None:
    """Raise ValueError for a body that is too stiff for its masses at the usual step."""
    body = build_body(plan)
    stiff, damped = _per_mass(body, UNITS)
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


def longest_step(body: Body, units: Ints = UNITS) -> tuple[float, int]:
    """The longest stable step in tu, and the node that moves most in the mode that limits it.

    A mode z of unit mass is stable up to the h with h² zᵀKz + 2 h zᵀCz = 4; the limit is the least
    over all modes. Each round takes the worst mode at the present step, and its limit.
    """
    stiff, damped = _per_mass(body, units)
    step = STEP
    for _ in range(ROUNDS):
        z = np.linalg.eigh(step**2 * stiff + 2 * step * damped)[1][:, -1]
        k, c = z @ stiff @ z, z @ damped @ z
        step = float((np.sqrt(c * c + 4 * k) - c) / k)
    moved = np.linalg.norm((z / np.sqrt(np.repeat(body.mass, 3))).reshape(-1, 3), axis=1)
    return step, int(moved.argmax())


def _per_mass(body: Body, units: Ints) -> tuple[Floats, Floats]:
    """Stiffness and damping matrices (69, 69) at rest, scaled by the roots of the masses."""
    root = np.repeat(1.0 / np.sqrt(body.mass), 3)
    scale = np.outer(root, root)
    matrices = (_lengthwise(body, modulus, units) for modulus in (body.stiffness, body.viscosity))
    stiff, damped = (scale * matrix for matrix in matrices)
    return stiff, damped


def _lengthwise(body: Body, modulus: Floats, units: Ints) -> Floats:
    """Matrix (69, 69) of units that resist along their length with ``modulus`` (91,) each."""
    i, j = units.T
    nodes = len(body.mass)
    along = (body.rest[j] - body.rest[i]) / body.length[:, None]
    block = modulus[:, None, None] * along[:, :, None] * along[:, None, :]
    matrix = np.zeros((nodes, nodes, 3, 3))
    np.add.at(matrix, (i, i), block)
    np.add.at(matrix, (j, j), block)
    np.subtract.at(matrix, (i, j), block)
    np.subtract.at(matrix, (j, i), block)
    return np.asarray(matrix.transpose(0, 2, 1, 3).reshape(3 * nodes, 3 * nodes))
