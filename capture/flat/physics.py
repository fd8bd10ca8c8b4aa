"""Simulate a flat fish in water: forces, Euler's methods, and measures of its motion (KS I.C)."""

import numpy as np
from numpy.typing import NDArray

from capture.flat.scaffold import FlatBody
from subsea.biomechanics.body import Floats
from subsea.kernels import kernel


@kernel
def _direction(x: Floats, i: int, j: int) -> tuple[float, float, float]:
    """Unit vector from node i to node j, and their distance."""
    wx, wy = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1]
    length = np.sqrt(wx * wx + wy * wy)
    return wx / length, wy / length, length


@kernel
def add_forces(x: Floats, v: Floats, body: FlatBody, rest: Floats, force: Floats) -> None:
    """Add the forces of units with rest lengths ``rest`` (s,) and of water to ``force`` (n, 2).

    An edge of the hull takes min(0, -µ A (n·v)) n (KS I.C), half of it at each end.
    """
    for s in range(len(body.units)):
        i, j = body.units[s, 0], body.units[s, 1]
        wx, wy, length = _direction(x, i, j)
        faster = (v[j, 0] - v[i, 0]) * wx + (v[j, 1] - v[i, 1]) * wy
        tension = body.stiffness[s] * (length - rest[s]) + body.viscosity[s] * faster
        force[i, 0] += tension * wx
        force[i, 1] += tension * wy
        force[j, 0] -= tension * wx
        force[j, 1] -= tension * wy
    for e in range(len(body.hull)):
        a, b = body.hull[e, 0], body.hull[e, 1]
        ny, nx, length = _direction(x, b, a)
        nx = -nx  # outward: to the right of the edge
        outward = 0.5 * ((v[a, 0] + v[b, 0]) * nx + (v[a, 1] + v[b, 1]) * ny)
        half = 0.5 * min(0.0, -body.drag * length * body.height[e] * outward)
        for k in (a, b):
            force[k, 0] += half * nx
            force[k, 1] += half * ny


@kernel
def add_slopes(
    x: Floats, v: Floats, body: FlatBody, rest: Floats, by_place: Floats, by_speed: Floats
) -> None:
    """Add -∂f/∂x and -∂f/∂v of the same forces to (2n, 2n): x of all nodes, then y of all."""
    n = len(x)
    for s in range(len(body.units)):
        i, j = body.units[s, 0], body.units[s, 1]
        wx, wy, length = _direction(x, i, j)
        # A compressed spring gives way sideways: left out, or the matrix could be indefinite.
        aside = body.stiffness[s] * max(0.0, 1.0 - rest[s] / length)
        stiff, thick = body.stiffness[s] - aside, body.viscosity[s]
        _add_pair(by_place, n, i, j, -1.0, stiff * wx * wx + aside, stiff * wx * wy,
                  stiff * wy * wy + aside)  # fmt: skip
        _add_pair(by_speed, n, i, j, -1.0, thick * wx * wx, thick * wx * wy, thick * wy * wy)
    for e in range(len(body.hull)):
        a, b = body.hull[e, 0], body.hull[e, 1]
        ny, nx, length = _direction(x, b, a)
        nx = -nx
        if (v[a, 0] + v[b, 0]) * nx + (v[a, 1] + v[b, 1]) * ny > 0.0:
            quarter = 0.25 * body.drag * length * body.height[e]
            _add_pair(by_speed, n, a, b, 1.0, quarter * nx * nx, quarter * nx * ny,
                      quarter * ny * ny)  # fmt: skip


@kernel
def _add_pair(
    matrix: Floats, n: int, i: int, j: int, sign: float, xx: float, xy: float, yy: float
) -> None:
    """Add a block (xx, xy; xy, yy) at both nodes, and ``sign`` times it between them."""
    for k in (i, j):
        for m in (i, j):
            factor = 1.0 if k == m else sign
            matrix[k, m] += factor * xx
            matrix[k, n + m] += factor * xy
            matrix[n + k, m] += factor * xy
            matrix[n + k, n + m] += factor * yy


@kernel
def solve(matrix: Floats, load: Floats) -> None:
    """Solve matrix · z = load in place, by Gauss; the matrix is positive definite."""
    n = len(load)
    for i in range(n):
        for k in range(i + 1, n):
            factor = matrix[k, i] / matrix[i, i]
            for m in range(i + 1, n):
                matrix[k, m] -= factor * matrix[i, m]
            load[k] -= factor * load[i]
    for i in range(n - 1, -1, -1):
        for m in range(i + 1, n):
            load[i] -= matrix[i, m] * load[m]
        load[i] /= matrix[i, i]


def swim(
    body: FlatBody, start: Floats, muscles: Floats, step: float, implicit: bool, every: int
) -> Floats:
    """Simulate: states (frames, 2, n, 2) of positions and velocities, each ``every`` steps.

    ``muscles`` (steps, m) are their lengths at rest, cm. Explicit Euler uses forces and
    velocities of the start of a step, implicit Euler those of its end, from one linear system
    (Baraff, KS [2]): (M + h D + h² K) Δv = h (f - h K v), with K = -∂f/∂x and D = -∂f/∂v.
    States of a body that has exploded are NaN.
    """
    frames = np.full((len(muscles) // every + 1, *start.shape), np.nan)
    frames[0] = start
    _swim(body, start.copy(), muscles, step, implicit, every, frames)
    return frames


@kernel
def _swim(
    body: FlatBody, state: Floats, muscles: Floats, step: float, implicit: bool, every: int,
    frames: Floats,
) -> None:  # fmt: skip
    """Advance ``state`` (2, n, 2), and write all ``frames`` but the first."""
    x, v = state[0], state[1]
    n = len(x)
    rest = body.length.copy()
    force, load = np.empty((n, 2)), np.empty(2 * n)
    by_place, by_speed = np.empty((2 * n, 2 * n)), np.empty((2 * n, 2 * n))
    # Number by number: assignments of whole arrays take seconds to compile.
    for t in range(len(muscles)):
        for m in range(muscles.shape[1]):
            rest[m] = muscles[t, m]
        force[:] = 0.0
        add_forces(x, v, body, rest, force)
        if implicit:
            by_place[:] = 0.0
            by_speed[:] = 0.0
            add_slopes(x, v, body, rest, by_place, by_speed)
            for i in range(2 * n):
                load[i] = step * force[i % n, i // n]
                for k in range(2 * n):
                    load[i] -= step * step * by_place[i, k] * v[k % n, k // n]
                    by_speed[i, k] = step * (by_speed[i, k] + step * by_place[i, k])
                by_speed[i, i] += body.mass[i % n]
            solve(by_speed, load)
        sound = True
        for i in range(n):
            for k in range(2):
                if implicit:
                    v[i, k] += load[k * n + i]
                    x[i, k] += step * v[i, k]
                else:
                    x[i, k] += step * v[i, k]
                    v[i, k] += step / body.mass[i] * force[i, k]
                sound = sound and abs(x[i, k]) < 1e6
        if not sound:
            return  # the body has exploded
        if (t + 1) % every == 0:
            for i in range(n):
                for k in range(2):
                    frames[(t + 1) // every, 0, i, k] = x[i, k]
                    frames[(t + 1) // every, 1, i, k] = v[i, k]


def energy(body: FlatBody, frames: Floats) -> Floats:
    """Energy (frames,) of motion and of the units at their natural lengths, g cm²/tu²."""
    x, v = frames[:, 0], frames[:, 1]
    way = x[:, body.units[:, 1]] - x[:, body.units[:, 0]]
    beyond = np.linalg.norm(way, axis=2) - body.length
    motion = 0.5 * (body.mass * (v**2).sum(axis=2)).sum(axis=1)
    return np.asarray(motion + 0.5 * (body.stiffness * beyond**2).sum(axis=1))


def middle(body: FlatBody, x: Floats) -> Floats:
    """The centre of mass (…, 2) of nodes (…, n, 2)."""
    return np.asarray(np.einsum("n,...nk->...k", body.mass, x) / body.mass.sum())


def heading(body: FlatBody, x: Floats) -> Floats:
    """Mean rotation (T,) of nodes (T, n, 2) to the left, rad."""
    complex_rest = (body.rest - middle(body, body.rest)) @ [1.0, 1.0j]
    complex_x = (x - middle(body, x)[:, None]) @ [1.0, 1.0j]
    return np.unwrap(np.angle((body.mass * complex_rest.conj() * complex_x).sum(axis=1)))


def room(body: FlatBody, x: Floats) -> Floats:
    """The least relative area (T,) of a triangle of the scaffold; negative if folded."""
    return np.asarray((areas(body, x) / areas(body, body.rest)).min(axis=-1))


def areas(body: FlatBody, x: Floats) -> Floats:
    """Signed areas (…, t) of the triangles, cm²."""
    a, b, c = (x[..., body.triangles[:, k], :] for k in range(3))
    first, second = b - a, c - a
    return np.asarray(0.5 * (first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]))


def explicit_limit(body: FlatBody) -> float:
    """The largest step, tu, at which explicit Euler is stable about rest in a vacuum.

    Each eigenvalue λ of the linear motion must fulfil |1 + hλ| ≤ 1, so h ≤ -2 Re λ/|λ|².
    """
    values = modes(body)
    live = values[np.abs(values) > 1e-3]  # those of rigid motion stay as they are
    return float((-2.0 * live.real / np.abs(live) ** 2).min())


def modes(body: FlatBody) -> NDArray[np.complex128]:
    """Eigenvalues (4n,), 1/tu, of the linear motion about rest in a vacuum."""
    n = len(body.mass)
    place, speed = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, 2 * n))
    add_slopes(body.rest, np.zeros((n, 2)), body, body.length, place, speed)
    inverse = 1.0 / np.tile(body.mass, 2)[:, None]
    system = np.block([[np.zeros_like(place), np.eye(2 * n)], [-inverse * place, -inverse * speed]])
    return np.asarray(np.linalg.eigvals(system))


def is_sound(body: FlatBody, frames: Floats) -> bool:
    """True if the scaffold has never folded."""
    return bool(np.isfinite(frames).all() and room(body, frames[:, 0]).min() > 0.0)
