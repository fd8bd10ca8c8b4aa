"""Build, train and draw the flat fish of KS: `python docs/fish_in_two_dimensions.py [FOLDER]`.

The script of docs/concepts/two-dimensional-fish.md: prints the numbers of
docs/developers/two-dimensional-fish-figures.md and draws FOLDER/flat_*.png (default docs/pictures).
`--only NAME` runs one part, `--quick` all parts briefly, for the tests. All seeds are fixed. Units
are cm, g and tu (0.1 s); the plane is seen from above, x ahead and y to the left of a fish at rest.
"""

import argparse
from collections.abc import Callable, Iterable
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np
from matplotlib import rc_context
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from numba import njit
from numpy.typing import NDArray
from picture_files import BLACK, BLUE, GREEN, GREY, ORANGE, PINK, STYLE, save_plot

from subsea.biomechanics.controllers import ease
from subsea.fish.species import load_species
from subsea.fish.spine import (
    JOINTS,
    MIDDLES,
    UNITS,
    Spines,
    Swing,
    phase,
    pose_spine,
    swing_angles,
)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

STEP_TU = 0.055  # the step of the three-dimensional fish
FRAME = 6  # steps between two stored states
MUSCLES = 6  # three segments, left and right
DRAG = 2.0  # µ of the water, g/(cm² tu)
LARGEST = 0.15  # bound of the amplitudes, relative to a muscle's length
FREQUENCIES = (0.05, 0.4)  # bounds of the frequencies, beats a tu
SWIM_TU = TURN_TU = 60.0  # duration of an evaluation
MEAN = 30  # frames, about 10 tu, over which headings are averaged: the yaw of a beat cancels
RISE_TU = 4.0  # duration of a fade-in, and of a transition between controllers


class Effort(NamedTuple):
    """Sizes of the experiments."""

    seeds: int = 8
    tries: int = 600
    turn_seeds: int = 4
    turn_tries: int = 400
    folds: int = 150
    bound_seeds: int = 3
    moments: int = 40


QUICK = Effort(2, 60, 1, 40, 12, 1, 4)


# I.B: the body


class Body(NamedTuple):
    """A scaffold of point masses and viscoelastic units in the plane; arrays for kernels."""

    rest: Floats  # (n, 2) cm
    mass: Floats  # (n,) g
    units: Ints  # (s, 2) nodes; the first six are muscles
    length: Floats  # (s,) cm at rest
    stiffness: Floats  # (s,) g/tu²
    viscosity: Floats  # (s,) g/tu
    hull: Ints  # (e, 2) nodes, anticlockwise: outside is to the right
    height: Floats  # (e,) cm, of the fish at this edge
    triangles: Ints  # (t, 3) of the scaffold, anticlockwise
    drag: float  # g/(cm² tu)

    @property
    def long(self) -> float:
        """Body length, cm."""
        return float(np.ptp(self.rest[:, 0]))

    def at_rest(self, stretch: float = 1.0) -> Floats:
        """The state (2, n, 2) of a body that does not move, longer by a factor."""
        return np.stack([stretch * self.rest, np.zeros_like(self.rest)])


def flat_body() -> Body:
    """The scaffold of a fusilier in Tu's water, from above, with nodes above each other merged."""
    muscles = load_species(str(Path(__file__).with_name("tu_fusilier.toml"))).muscles
    assert muscles
    plan = muscles.body
    x, wide = -np.array(plan.stations), np.array(plan.half_widths)
    rings = [(1 + 2 * k, 2 + 2 * k) for k in range(5)]  # left, right
    tip = 11
    rest = np.zeros((12, 2))
    rest[0], rest[tip] = (x[0], 0.0), (x[6], 0.0)
    for k, (left, right) in enumerate(rings):
        rest[left], rest[right] = (x[1 + k], wide[k]), (x[1 + k], -wide[k])
    mass = np.repeat(np.array(plan.masses) * [1, 2, 2, 2, 2, 2, 2], [1, 2, 2, 2, 2, 2, 1])
    sides = [(a[k], b[k]) for a, b in pairwise(rings) for k in (0, 1)]
    cross = [pair for a, b in pairwise(rings)
             for pair in ((a[0], b[1]), (a[1], b[0]))]  # fmt: skip
    other = [*sides[MUSCLES:], *rings, (0, 1), (0, 2), (9, tip), (10, tip)]
    units = np.array([*sides[:MUSCLES], *cross, *other])
    each = [plan.muscle_stiffness, plan.cross_stiffness, plan.other_stiffness]
    stiffness = 2.0 * np.repeat(each, [MUSCLES, len(cross), len(other)])
    around = [0, *(left for left, _ in rings), tip, *(right for _, right in rings[::-1]), 0]
    hull = np.array([around[:-1], around[1:]]).T
    tall = np.array([0.0, *plan.half_heights, plan.tail_half_height])
    at_node = np.repeat(tall, [1, 2, 2, 2, 2, 2, 1])
    triangles = [(0, 1, 2), (9, tip, 10)]
    for (a, b), (c, d) in pairwise(rings):
        triangles += [(a, c, d), (a, d, b)]
    return Body(
        rest, mass, units,
        np.linalg.norm(rest[units[:, 1]] - rest[units[:, 0]], axis=1),
        stiffness, np.full(len(units), 2.0 * plan.viscosity),
        hull, at_node[hull].sum(axis=1), np.array(triangles), DRAG,
    )  # fmt: skip


# I.C: water and time


@njit(cache=True, error_model="numpy")
def _direction(x: Floats, i: int, j: int) -> tuple[float, float, float]:
    """Unit vector from node i to node j, and their distance."""
    wx, wy = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1]
    length = np.sqrt(wx * wx + wy * wy)
    return wx / length, wy / length, length


@njit(cache=True, error_model="numpy")
def add_forces(x: Floats, v: Floats, body: Body, rest: Floats, force: Floats) -> None:
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


@njit(cache=True, error_model="numpy")
def add_slopes(
    x: Floats, v: Floats, body: Body, rest: Floats, by_place: Floats, by_speed: Floats
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


@njit(cache=True, error_model="numpy")
def _add_pair(
    matrix: Floats, n: int, i: int, j: int, sign: float, xx: float, xy: float, yy: float
) -> None:
    """Add a block (xx, xy; xy, yy) at both nodes, and ``sign`` times it between them."""
    for k in (i, j):
        for m in (i, j):
            one = 1.0 if k == m else sign
            matrix[k, m] += one * xx
            matrix[k, n + m] += one * xy
            matrix[n + k, m] += one * xy
            matrix[n + k, n + m] += one * yy


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
def swim(
    body: Body, start: Floats, muscles: Floats, step: float, implicit: bool, every: int
) -> Floats:
    """Simulate: states (frames, 2, n, 2) of positions and velocities, each ``every`` steps.

    ``muscles`` (steps, 6) are their lengths at rest, cm. Explicit Euler uses forces and
    velocities of the start of a step, implicit Euler those of its end, from one linear system
    (Baraff, KS [2]): (M + h D + h² K) Δv = h (f - h K v), with K = -∂f/∂x and D = -∂f/∂v.
    """
    n = start.shape[1]
    x, v = start[0].copy(), start[1].copy()
    frames = np.full((len(muscles) // every + 1, 2, n, 2), np.nan)
    frames[0] = start
    rest = body.length.copy()
    force, load = np.empty((n, 2)), np.empty(2 * n)
    by_place, by_speed = np.empty((2 * n, 2 * n)), np.empty((2 * n, 2 * n))
    for t in range(len(muscles)):
        rest[: muscles.shape[1]] = muscles[t]
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
            for i in range(n):
                for k in range(2):
                    v[i, k] += load[k * n + i]
                    x[i, k] += step * v[i, k]
        else:
            for i in range(n):
                for k in range(2):
                    x[i, k] += step * v[i, k]
                    v[i, k] += step / body.mass[i] * force[i, k]
        if not np.abs(x).max() < 1e6:
            break  # it has exploded: all later states would be NaN
        if (t + 1) % every == 0:
            frames[(t + 1) // every, 0], frames[(t + 1) // every, 1] = x, v
    return frames


def energy(body: Body, frames: Floats) -> Floats:
    """Energy (frames,) of motion and of the units at their natural lengths, g cm²/tu²."""
    x, v = frames[:, 0], frames[:, 1]
    way = x[:, body.units[:, 1]] - x[:, body.units[:, 0]]
    beyond = np.linalg.norm(way, axis=2) - body.length
    motion = 0.5 * (body.mass * (v**2).sum(axis=2)).sum(axis=1)
    return np.asarray(motion + 0.5 * (body.stiffness * beyond**2).sum(axis=1))


def middle(body: Body, x: Floats) -> Floats:
    """The centre of mass (…, 2) of nodes (…, n, 2)."""
    return np.asarray(np.einsum("n,...nk->...k", body.mass, x) / body.mass.sum())


def heading(body: Body, x: Floats) -> Floats:
    """Mean rotation (T,) of nodes (T, n, 2) to the left, rad."""
    complex_rest = (body.rest - middle(body, body.rest)) @ [1.0, 1.0j]
    now = (x - middle(body, x)[:, None]) @ [1.0, 1.0j]
    return np.unwrap(np.angle((body.mass * complex_rest.conj() * now).sum(axis=1)))


def room(body: Body, x: Floats) -> Floats:
    """The least relative area (T,) of a triangle of the scaffold; negative if folded."""
    return np.asarray((areas(body, x) / areas(body, body.rest)).min(axis=-1))


def areas(body: Body, x: Floats) -> Floats:
    """Signed areas (…, t) of the triangles, cm²."""
    a, b, c = (x[..., body.triangles[:, k], :] for k in range(3))
    first, second = b - a, c - a
    return np.asarray(0.5 * (first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]))


def explicit_limit(body: Body) -> float:
    """The largest step, tu, at which explicit Euler is stable about rest in a vacuum.

    Each eigenvalue λ of the linear motion must fulfil |1 + hλ| ≤ 1, so h ≤ -2 Re λ/|λ|².
    """
    values = modes(body)
    live = values[np.abs(values) > 1e-3]  # those of rigid motion stay as they are
    return float((-2.0 * live.real / np.abs(live) ** 2).min())


def modes(body: Body) -> NDArray[np.complex128]:
    """Eigenvalues (4n,), 1/tu, of the linear motion about rest in a vacuum."""
    n = len(body.mass)
    place, speed = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, 2 * n))
    add_slopes(body.rest, np.zeros((n, 2)), body, body.length, place, speed)
    inverse = 1.0 / np.tile(body.mass, 2)[:, None]
    system = np.block([[np.zeros_like(place), np.eye(2 * n)], [-inverse * place, -inverse * speed]])
    return np.asarray(np.linalg.eigvals(system))


# I.D: muscle controllers


class Controller(NamedTuple):
    """A muscle's length at rest is l (1 + amplitude sin(2π frequency t + phase))."""

    amplitude: Floats  # (6,)
    frequency: Floats  # (6,) a tu
    phase: Floats  # (6,) rad

    def mirrored(self) -> "Controller":
        """The mirrored controller."""
        return Controller(*(part.reshape(3, 2)[:, ::-1].ravel() for part in self))


def controller_at(point: Floats, largest: float = LARGEST) -> Controller:
    """The controller at a point of the unit box: amplitudes, phases, then one frequency or six."""
    low, high = FREQUENCIES
    frequency = low + point[2 * MUSCLES :] * (high - low)
    return Controller(
        largest * point[:MUSCLES],
        np.broadcast_to(frequency, MUSCLES).copy(),
        2.0 * np.pi * point[MUSCLES : 2 * MUSCLES],
    )


def steps_of(tu: float) -> int:
    """Number of steps of whole frames in this time."""
    return round(tu / STEP_TU / FRAME) * FRAME


def angles(one: Controller, time: Floats) -> Floats:
    """Angles (t, 6), rad, of the sinusoids of a controller."""
    return np.asarray(2.0 * np.pi * one.frequency * time[:, None] + one.phase)


def lengths(body: Body, one: Controller, steps: int) -> Floats:
    """Rest lengths (steps, 6) of the muscles, cm, faded in at the start."""
    time = STEP_TU * np.arange(steps)
    wave = one.amplitude * np.sin(angles(one, time))
    return np.asarray(body.length[:MUSCLES] * (1.0 + ease(time / RISE_TU)[:, None] * wave))


def run(body: Body, muscles: Floats, start: Floats | None = None) -> Floats:
    """Swim, implicitly, from a state (2, n, 2) or from rest: states (frames, 2, n, 2)."""
    start = body.at_rest() if start is None else start
    return np.asarray(swim(body, start, muscles, STEP_TU, True, FRAME))


def is_sound(body: Body, frames: Floats) -> bool:
    """True if the scaffold has never folded."""
    return bool(np.isfinite(frames).all() and room(body, frames[:, 0]).min() > 0.0)


def distance(body: Body, one: Controller) -> float:
    """The score of KS: body lengths of the centre of mass ahead; -1 for a folded fish."""
    frames = run(body, lengths(body, one, steps_of(SWIM_TU)))
    if not is_sound(body, frames):
        return -1.0
    return float((middle(body, frames[-1, 0]) - middle(body, body.rest))[0] / body.long)


class Annealing(NamedTuple):
    """The evaluations of a search, in order."""

    points: Floats  # (tries, d)
    scores: Floats  # (tries,)
    held: Floats  # (tries,) the score that it stood at

    @property
    def best(self) -> Floats:
        """The best score so far (tries,)."""
        return np.maximum.accumulate(self.scores)

    @property
    def winner(self) -> Floats:
        """The best point (d,)."""
        return np.asarray(self.points[self.scores.argmax()])


def anneal(
    score: Callable[[Floats], float], dimensions: int, tries: int, seed: int, hot: float
) -> Annealing:
    """Simulated annealing in the unit box, from a random point (Metropolis, geometric cooling).

    A step worse by d is accepted with probability exp(-d/T); T falls from ``hot`` to a hundredth
    of it, and the step size falls with its square root. Walls reflect.
    """
    rng = np.random.default_rng(seed)
    here, points, scores, held = rng.random(dimensions), [], [], []
    now = -np.inf
    for temperature in hot * np.geomspace(1.0, 0.01, tries):
        step = 0.25 * np.sqrt(temperature / hot) * rng.normal(size=dimensions)
        point = here if not points else 1.0 - np.abs(1.0 - np.abs(here + step) % 2.0)
        found = score(point)
        if found >= now or rng.random() < np.exp((found - now) / temperature):
            here, now = point, found
        points.append(point)
        scores.append(found)
        held.append(now)
    return Annealing(np.array(points), np.array(scores), np.array(held))


def search(
    score: Callable[[Floats], float], dimensions: int, tries: int, seeds: int, hot: float
) -> tuple[Annealing, ...]:
    """Annealings with the seeds 1 to `seeds`."""
    return tuple(anneal(score, dimensions, tries, seed, hot) for seed in range(1, seeds + 1))


def best_of(runs: Iterable[Annealing]) -> Annealing:
    """The run with the best score."""
    return max(runs, key=lambda one: one.scores.max())


class Lessons(NamedTuple):
    """The controllers learned with all seeds."""

    swims: tuple[Annealing, ...]  # with one frequency
    many: tuple[Annealing, ...]  # with one for each muscle
    turns: tuple[Annealing, ...]  # to the left

    @property
    def swimmer(self) -> Controller:
        """The best of all swimming controllers."""
        return controller_at(best_of(self.swims).winner)

    @property
    def turner(self) -> Controller:
        """The best of all turning controllers."""
        return controller_at(best_of(self.turns).winner)


HOT_L, HOT_DEG = 0.3, 5.0  # first temperatures: a step that is worse by this is often taken


@lru_cache(maxsize=2)
def learn(effort: Effort) -> Lessons:
    """Anneal swimming and turning with several seeds."""
    body = flat_body()

    def far(point: Floats) -> float:
        return distance(body, controller_at(point))

    def angle(point: Floats) -> float:
        return turned(body, start, controller_at(point))

    one, six = (
        search(far, dimensions, effort.tries, effort.seeds, HOT_L)
        for dimensions in (2 * MUSCLES + 1, 3 * MUSCLES)
    )
    swimmer = controller_at(best_of(one).winner)
    start = run(body, lengths(body, swimmer, steps_of(SWIM_TU)))[-1]
    turns = search(angle, 2 * MUSCLES + 1, effort.turn_tries, effort.turn_seeds, HOT_DEG)
    return Lessons(one, six, turns)


def turn(body: Body, start: Floats, one: Controller) -> Floats:
    """States of a fish that starts to turn while it swims, at ``start``."""
    return run(body, lengths(body, one, steps_of(TURN_TU)), start)


def turned(body: Body, start: Floats, one: Controller) -> float:
    """The final angle to the left, degrees; -180 for a folded fish."""
    frames = turn(body, start, one)
    if not is_sound(body, frames):
        return -180.0
    return gained(np.degrees(heading(body, frames[:, 0])))


def gained(angle: Floats) -> float:
    """Change of a heading (T,) between means over its first and last beat."""
    return float(angle[-MEAN:].mean() - angle[:MEAN].mean())


# From one controller to the next

WAYS = ("parameters", "phases", "lengths")


def passage(body: Body, old: Controller, new: Controller, begin: float, way: str) -> Floats:
    """Lengths (steps, 6) of a transition from ``old`` to ``new`` that starts at ``begin``, tu.

    Linear in the ``parameters`` (amplitudes, frequencies, phases, as in KS); in ``phases``: the
    same with a continuous phase; or in ``lengths``: a blend of both outputs.
    """
    time = begin + STEP_TU * np.arange(steps_of(RISE_TU))
    share = np.linspace(0.0, 1.0, len(time))[:, None]
    first, last = angles(old, time), angles(new, time)
    if way == "lengths":
        wave = (1 - share) * old.amplitude * np.sin(first) + share * new.amplitude * np.sin(last)
    elif way == "parameters":
        mixed = Controller(*((1 - share) * a + share * b for a, b in zip(old, new, strict=True)))
        wave = mixed.amplitude * np.sin(angles(mixed, time))
    else:
        frequency = (1 - share) * old.frequency + share * new.frequency
        angle = first[0] + 2.0 * np.pi * STEP_TU * np.cumsum(frequency, axis=0)
        late = (last[-1] - angle[-1] + np.pi) % (2.0 * np.pi) - np.pi
        wave = ((1 - share) * old.amplitude + share * new.amplitude) * np.sin(angle + share * late)
    return np.asarray(body.length[:MUSCLES] * (1.0 + wave))


def steady(body: Body, one: Controller, begin: float, steps: int) -> Floats:
    """Lengths (steps, 6) of a controller from the time ``begin`` on, tu."""
    time = begin + STEP_TU * np.arange(steps)
    return np.asarray(body.length[:MUSCLES] * (1.0 + one.amplitude * np.sin(angles(one, time))))


NEAR_L = 0.5  # body lengths from its goal at which a fish has arrived
ASTRAY_DEG, RIGHT_DEG = 30.0, 10.0  # off course by more it begins to turn, by less it ends


def swim_to(
    body: Body, lessons: Lessons, goal: Floats, way: str, longest_tu: float = 600.0
) -> Floats:
    """States of a fish that swims from rest to ``goal`` (2,), cm, by three controllers (KS I.D)."""
    controllers = {0: lessons.swimmer, 1: lessons.turner, -1: lessons.turner.mirrored()}
    now, time = 0, RISE_TU
    frames = [run(body, lengths(body, lessons.swimmer, steps_of(RISE_TU)))]
    while time < longest_tu:
        state = frames[-1][-1]
        if not np.isfinite(state).all():
            break
        to = goal - middle(body, state[0])
        if np.hypot(*to) < NEAR_L * body.long:
            break
        off = np.arctan2(to[1], to[0]) - heading(body, state[:1])[0]
        off = np.degrees((off + np.pi) % (2.0 * np.pi) - np.pi)
        wanted = int(np.sign(off)) if abs(off) > (RIGHT_DEG if now else ASTRAY_DEG) else 0
        if wanted == now:
            muscles = steady(body, controllers[now], time, FRAME * 3)
        else:
            muscles = passage(body, controllers[now], controllers[wanted], time, way)
            now = wanted
        frames.append(run(body, muscles, state)[1:])
        time += STEP_TU * len(muscles)
    return np.concatenate(frames)


def tightest(body: Body, old: Controller, new: Controller, moments: Floats, way: str) -> Floats:
    """The least room (m,) of the scaffold in transitions at several times."""
    whole = run(body, lengths(body, old, steps_of(moments.max() + 1.0)))
    least = []
    for moment in moments:
        frame = round(moment / STEP_TU / FRAME)
        begin = frame * FRAME * STEP_TU
        muscles = [passage(body, old, new, begin, way)]
        muscles.append(steady(body, new, begin + STEP_TU * len(muscles[0]), steps_of(RISE_TU)))
        frames = run(body, np.concatenate(muscles), whole[frame])
        tight = room(body, frames[:, 0])
        least.append(tight.min() if np.isfinite(tight).all() else -np.inf)
    return np.array(least)


# III.A: the body that is seen

SLIM = 0.8  # width of the body over that of its scaffold


@lru_cache(maxsize=1)
def skin() -> tuple[Ints, Floats]:
    """Triangle (p,) and barycentric coordinates (p, 3) of the outline of the fish's body.

    As in KS, a point is bound to the triangle of the scaffold that contains it.
    """
    body = flat_body()
    hull = body.rest[body.hull[:7, 0]]  # nose, left side, tail
    at = np.linspace(hull[0, 0], hull[-1, 0], 60)
    wide = SLIM * np.interp(at, hull[::-1, 0], hull[::-1, 1])
    outline = np.concatenate([np.stack([at, wide], 1), np.stack([at, -wide], 1)[::-1]])
    corners = body.rest[body.triangles]  # (t, 3, 2)
    basis = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=-1)
    shares = np.linalg.solve(basis, (outline[:, None] - corners[:, 0])[..., None])[..., 0]
    shares = np.concatenate([1.0 - shares.sum(axis=2, keepdims=True), shares], axis=2)
    inside = shares.min(axis=2).argmax(axis=1)
    return inside, shares[np.arange(len(outline)), inside]


def outline_of(body: Body, x: Floats) -> Floats:
    """The outline (p, 2) of the body on a scaffold (n, 2)."""
    inside, shares = skin()
    return np.asarray(np.einsum("pk,pkc->pc", shares, x[body.triangles[inside]]))


def midline(x: Floats) -> Floats:
    """Nose, middles of the rings, tail (…, 7, 2)."""
    rings = 0.5 * (x[..., 1:11:2, :] + x[..., 2:11:2, :])
    return np.concatenate([x[..., :1, :], rings, x[..., 11:, :]], axis=-2)


# Pictures


def draw(axis: Any, body: Body, x: Floats, colour: str = BLUE, alpha: float = 1.0) -> None:
    """Draw the body on a scaffold, in body lengths."""
    shape = outline_of(body, x) / body.long
    axis.fill(*shape.T, facecolor=colour, edgecolor="none", alpha=0.25 * alpha)
    axis.plot(*np.concatenate([shape, shape[:1]]).T, color=colour, linewidth=0.9, alpha=alpha)


def draw_scaffold(axis: Any, body: Body, x: Floats, scale: float = 1.0) -> None:
    """Draw the units, muscles in colour, in body lengths."""
    lines = x[body.units] / body.long
    axis.add_collection(LineCollection(lines[MUSCLES:], colors=BLACK, linewidths=0.8 * scale))
    axis.add_collection(LineCollection(lines[:MUSCLES], colors=ORANGE, linewidths=2.6 * scale))


def show_body(effort: Effort, folder: Path) -> None:
    """Draw the scaffold at rest, and the forces of water while it swims."""
    body, lessons = flat_body(), learn(effort)
    picture = Figure(figsize=(7.4, 4.4), layout="constrained")
    top, below = picture.subplots(2, 1)
    draw(top, body, body.rest)
    draw_scaffold(top, body, body.rest)
    top.scatter(*(body.rest / body.long).T, s=3.0 * body.mass, color=BLACK, zorder=3)
    top.set_title("at rest: muscles in orange, the area of a dot is its mass", loc="left")
    frames = run(body, lengths(body, lessons.swimmer, steps_of(SWIM_TU)))
    # The moment at which the water pushes the most ahead.
    limp = body._replace(stiffness=0.0 * body.stiffness, viscosity=0.0 * body.viscosity)
    force = np.zeros((len(frames), *body.rest.shape))
    for (x, v), one in zip(frames, force, strict=True):
        add_forces(x, v, limp, body.length, one)
    angle = heading(body, frames[:, 0])
    ahead = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    late = len(frames) // 2
    k = late + int(np.einsum("tnk,tk->t", force[late:], ahead[late:]).argmax())
    turn_back = np.array([[ahead[k, 0], -ahead[k, 1]], [ahead[k, 1], ahead[k, 0]]])
    x = (frames[k, 0] - middle(body, frames[k, 0])) @ turn_back + middle(body, body.rest)
    draw(below, body, x)
    draw_scaffold(below, body, x)
    edge = x[body.hull].mean(axis=1)
    along = np.diff(x[body.hull], axis=1)[:, 0]
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1)
    speed = (frames[k, 1] @ turn_back)[body.hull].mean(axis=1)
    pushed = -body.drag * body.height[:, None] * np.maximum(
        0.0, (normal * speed).sum(axis=1, keepdims=True)
    ) * normal / np.linalg.norm(along, axis=1, keepdims=True)  # fmt: skip
    longest = np.linalg.norm(pushed, axis=1).max()
    for place, arrow in zip(edge / body.long, 0.16 * pushed / longest, strict=True):
        if np.hypot(*arrow) > 0.01:
            below.annotate("", place, place - arrow,
                           arrowprops={"arrowstyle": "-|>", "color": GREEN, "shrinkA": 0,
                                       "shrinkB": 0, "linewidth": 1.4})  # fmt: skip
    below.set_title(
        f"as it swims: the water's force, at most {longest:.0f} g cm/tu² on an edge",
        loc="left",
    )
    below.set_xlabel("along the body at rest, L; the nose is at 0")
    for axis in (top, below):
        axis.set(aspect="equal", xlim=(-1.08, 0.06), ylim=(-0.2, 0.2))
        axis.set_ylabel("to the left, L")
    save_plot(picture, folder / "flat_body.png")


STEPS = {  # of the comparison: the step over explicit Euler's limit, explicit or not, colour
    "explicit, 0.9 of the limit": (0.9, False, GREEN),
    "explicit, 1.2 times": (1.2, False, PINK),
    "explicit, 2 times": (2.0, False, "#e69f00"),
    "explicit, 19 times": (19.0, False, ORANGE),
    "implicit, 19 times": (19.0, True, BLUE),
}


def released(body: Body, tu: float) -> dict[str, tuple[Floats, Floats]]:
    """Times, tu, and relative energies of a released, stretched fish, by step size."""
    limit, natural = explicit_limit(body), np.tile(body.length[:MUSCLES], (1, 1))
    found = {}
    for name, (share, implicit, _) in STEPS.items():
        step = share * limit
        steps = round(tu / step)
        muscles = np.repeat(natural, steps, axis=0)
        frames = swim(body._replace(drag=0.0), body.at_rest(1.05), muscles, step, implicit, 1)
        shown = energy(body, frames)
        found[name] = (step * np.arange(len(shown)), shown / shown[0])
    return found


def show_integrators(effort: Effort, folder: Path) -> None:
    """Compare explicit and implicit Euler: energies, stability, and KS's movie 1."""
    body = flat_body()
    limit = explicit_limit(body)
    print(f"explicit Euler is stable to a step of {limit:.5f} tu, here {STEP_TU} tu are taken")
    picture = Figure(figsize=(7.4, 5.4), layout="constrained")
    above, below = picture.subfigures(2, 1, height_ratios=(1.9, 1.0))
    left, right = above.subplots(1, 2, width_ratios=(1.25, 1.0))
    for name, (time, shown) in released(body, 60.0).items():
        left.semilogy(time, shown, color=STEPS[name][2], label=name, linewidth=1.2)
    left.set(ylim=(1e-6, 1e8), xlabel="time, tu", ylabel="energy over that at first",
             title="a stretched fish in a vacuum is let go")  # fmt: skip
    left.legend(loc="center right", bbox_to_anchor=(1.0, 0.72), fontsize=8)
    around = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 200))
    right.fill(*np.stack([around.real - 1, around.imag]), color=GREEN, alpha=0.2)
    right.text(-1.05, 0.0, "explicit\nis stable\nhere", ha="center", va="center", color=GREEN)
    right.plot(*np.stack([around.real + 1, around.imag]), color=BLUE)
    right.text(1.05, 0.0, "implicit\nis stable\noutside", ha="center", va="center",
               color=BLUE)  # fmt: skip
    values = STEP_TU * modes(body)
    right.plot(values.real, values.imag, ".", color=ORANGE, markersize=7,
               label="of the fish, h = 0.055 tu")  # fmt: skip
    right.set(aspect="equal", xlim=(-2.1, 2.1), ylim=(-1.5, 1.75), xlabel="Re hλ", ylabel="Im hλ",
              title="where a step may lie")  # fmt: skip
    right.legend(loc="upper center", fontsize=8)
    lessons = learn(effort)
    muscles = lengths(body, lessons.swimmer, 200)
    both = [swim(body, body.at_rest(), muscles, STEP_TU, way, 1) for way in (False, True)]
    fold = int(np.argmax(room(body, both[0][:, 0]) <= 0))
    shown = [0, *range(fold - 4, fold + 13, 4)]
    print(f"movie 1: explicit Euler folds the fish after {fold} steps of {STEP_TU} tu")
    rows = below.subplots(2, len(shown), sharex=True, sharey=True)
    for row, frames, implicit in zip(rows, both, (False, True), strict=True):
        for axis, k in zip(row, shown, strict=True):
            x = frames[k, 0]
            if np.isfinite(x).all():
                if room(body, x) > 0:
                    draw(axis, body, x)
                draw_scaffold(axis, body, x, 0.6)
            axis.set(aspect="equal", xlim=(-1.25, 0.25), ylim=(-0.3, 0.3), xticks=[], yticks=[])
            axis.spines[:].set_visible(False)
            if not implicit:
                axis.set_title(f"step {k}", fontsize=9)
    rows[0, 0].set_ylabel("explicit")
    rows[1, 0].set_ylabel("implicit")
    save_plot(picture, folder / "flat_integrators.png")
    print("a step of            explicit  implicit: body lengths swum in 60 tu")
    for step in (0.0005, 0.002, 0.01, STEP_TU, 0.11, 0.22):
        far = []
        for implicit in (False, True):
            steps = round(SWIM_TU / step)
            time, one = step * np.arange(steps), lessons.swimmer
            wave = ease(time / RISE_TU)[:, None] * one.amplitude * np.sin(angles(one, time))
            muscles = body.length[:MUSCLES] * (1 + wave)
            frames = swim(body, body.at_rest(), muscles, step, implicit, steps)
            far.append((middle(body, frames[-1, 0]) - middle(body, body.rest))[0] / body.long)
        print(f"    {step:8.4f} tu     {far[0]:8.3f}  {far[1]:8.3f}")


def show_learning(effort: Effort, folder: Path) -> None:
    """Plot an annealing, all seeds, and one frequency against six."""
    lessons = learn(effort)
    picture = Figure(figsize=(7.4, 6.2), layout="constrained")
    above, below = picture.subfigures(2, 1)
    axis = above.subplots()
    first = lessons.swims[0]
    tries = np.arange(1, len(first.scores) + 1)
    axis.plot(tries, first.scores, ".", color=GREY, markersize=3, label="a try")
    axis.plot(tries, first.held, color=BLUE, linewidth=1.0, label="where it stands")
    axis.plot(tries, first.best, color=ORANGE, linewidth=1.8, label="best so far")
    axis.set(xlabel="tries", ylabel="way ahead in 60 tu, L", title="one annealing")
    axis.set_ylim(-1.1, 1.08 * max(one.scores.max() for one in lessons.swims))
    cold = axis.twinx()
    cold.semilogy(tries, HOT_L * np.geomspace(1.0, 0.01, len(tries)), color=PINK, linestyle="--")
    cold.set_ylabel("temperature, L", color=PINK)
    cold.spines["right"].set_visible(True)
    axis.legend(loc="lower right", ncols=3)
    left, right = below.subplots(1, 2, sharey=True, width_ratios=(1.6, 1.0))
    families = {"one frequency": (lessons.swims, BLUE), "six frequencies": (lessons.many, ORANGE)}
    for place, (name, (runs, colour)) in enumerate(families.items()):
        best = np.array([one.best for one in runs])
        left.plot(tries, best.T, color=colour, alpha=0.35, linewidth=0.9)
        left.plot(tries, np.median(best, axis=0), color=colour, linewidth=2.4, label=name)
        rng = np.random.default_rng(1)
        right.plot(place + rng.uniform(-0.12, 0.12, len(best)), best[:, -1], "o", color=colour,
                   alpha=0.7)  # fmt: skip
        right.hlines(
            np.median(best[:, -1]), place - 0.25, place + 0.25, color=colour, linewidth=2.4
        )
        print(f"{name}: median {np.median(best[:, -1]):.2f} L, "
              f"{best[:, -1].min():.2f} to {best[:, -1].max():.2f}")  # fmt: skip
    left.set(xlabel="tries", ylabel="best way so far, L", ylim=(0, None),
             title=f"{effort.seeds} seeds, and their median")  # fmt: skip
    left.legend(loc="upper left")
    right.set_xticks([0, 1], ["one", "six"])
    right.set(xlabel="frequencies", xlim=(-0.5, 1.5), title=f"after {effort.tries} tries")
    save_plot(picture, folder / "flat_learning.png")
    one = lessons.swimmer
    print(f"the best: {one.frequency[0]:.3f} beats a tu, amplitudes {np.round(one.amplitude, 3)}, "
          f"phases of left against right "
          f"{np.round(np.degrees(one.phase[::2] - one.phase[1::2]) % 360)}°")  # fmt: skip


def show_swims(effort: Effort, folder: Path) -> None:
    """Draw a fish before, during and after learning."""
    body, lessons = flat_body(), learn(effort)
    best = best_of(lessons.swims)
    halfway = int(np.argmax(best.best >= 0.5 * best.best[-1]))
    shown_swims = {
        "before: the first try": best.points[0],
        f"meanwhile: try {halfway + 1}": best.points[halfway],
        f"after: the best of {len(best.points)} tries": best.winner,
    }
    picture = Figure(figsize=(7.4, 6.6), layout="constrained")
    above, below = picture.subfigures(2, 1, height_ratios=(2.6, 1.3))
    rows = above.subplots(3, 1, sharex=True)
    for axis, (name, point) in zip(rows, shown_swims.items(), strict=True):
        frames = run(body, lengths(body, controller_at(point), steps_of(SWIM_TU)))
        shown = np.linspace(0, len(frames) - 1, 5).astype(int)
        for k in shown:
            draw(axis, body, frames[k, 0], BLUE, 0.35 + 0.65 * k / shown[-1])
        path = middle(body, frames[:, 0]) / body.long
        axis.plot(*path.T, color=ORANGE, linewidth=1.6)
        far = path[-1, 0] - path[0, 0]
        axis.set(aspect="equal", ylim=(-0.32, 0.32), yticks=[-0.2, 0.0, 0.2], ylabel="L")
        axis.set_title(f"{name}: {far:+.2f} L in {SWIM_TU:g} tu", loc="left")
        print(f"{name}: {far:+.3f} L")
    rows[-1].set_xlabel("ahead, L; a fish each 15 tu, and the way of its centre of mass")
    rows[-1].set_xlim(-1.15, 0.15 + best.scores.max())
    strip = below.subplots(1, 8)
    one = lessons.swimmer
    beat = 1.0 / one.frequency[0]
    frames = run(body, lengths(body, one, steps_of(SWIM_TU)))
    for k, axis in enumerate(strip):
        frame = round((SWIM_TU - beat + beat * k / 8) / STEP_TU / FRAME)
        x = frames[frame, 0] - middle(body, frames[frame, 0])
        x = x @ np.array([[0.0, 1.0], [-1.0, 0.0]])  # upright: ahead is up
        draw(axis, body, x)
        draw_scaffold(axis, body, x, 0.5)
        axis.set(aspect="equal", xlim=(-0.22, 0.22), ylim=(-0.75, 0.5), xticks=[], yticks=[])
        axis.spines[:].set_visible(False)
        axis.set_title(f"{k}/8 beat", fontsize=8)
    save_plot(picture, folder / "flat_swims.png")


def show_turns(effort: Effort, folder: Path) -> None:
    """Draw learned turns: heading, path and muscles."""
    body, lessons = flat_body(), learn(effort)
    start = run(body, lengths(body, lessons.swimmer, steps_of(SWIM_TU)))[-1]
    picture = Figure(figsize=(7.4, 3.6), layout="constrained")
    left, right = picture.subplots(1, 2, width_ratios=(1.0, 1.15))
    time = FRAME * STEP_TU * np.arange(steps_of(TURN_TU) // FRAME + 1)
    straight = run(body, steady(body, lessons.swimmer, SWIM_TU, steps_of(TURN_TU)), start)
    angle = np.degrees(heading(body, straight[:, 0]))
    thrash = np.abs(np.diff(angle)).sum() - abs(angle[-1] - angle[0])
    print(f"swimming on: {gained(angle):+.1f}°, to and fro {thrash:.0f}°")
    left.plot(time, angle - angle[0], color=GREY, linewidth=1.2, label="swims on")
    print("turns:       gained   fastest   to and fro   way")
    for number, one in enumerate(sorted(lessons.turns, key=lambda one: -one.scores.max())):
        frames = turn(body, start, controller_at(one.winner))
        angle = np.degrees(heading(body, frames[:, 0]))
        angle -= angle[0]
        left.plot(time, angle, color=BLUE, alpha=1.0 if number == 0 else 0.4,
                  linewidth=2.0 if number == 0 else 1.0,
                  label="learned, the best" if number == 0 else None)  # fmt: skip
        rate = np.abs(np.diff(angle)).max() / (FRAME * STEP_TU)
        thrash = np.abs(np.diff(angle)).sum() - abs(angle[-1])
        way = np.hypot(*(middle(body, frames[-1, 0]) - middle(body, frames[0, 0]))) / body.long
        print(f"    left  {gained(angle):+6.1f}°  {rate:5.1f}°/tu  {thrash:8.0f}°  {way:6.2f} L")
    left.set(xlabel="time, tu", ylabel="heading, ° to the left", title="headings")
    left.legend(loc="upper left")
    one = lessons.turner
    print(f"the best: {one.frequency[0]:.3f} beats a tu, amplitudes {np.round(one.amplitude, 3)}")
    frames = turn(body, start, lessons.turner)
    angle0 = heading(body, frames[:1, 0])[0]
    c, s = np.cos(angle0), np.sin(angle0)
    x = (frames[:, 0] - middle(body, frames[0, 0])) @ np.array([[c, -s], [s, c]])
    for k in np.linspace(0, len(x) - 1, 5).astype(int):
        draw(right, body, x[k], BLUE, 0.35 + 0.65 * k / len(x))
    right.plot(*(middle(body, x) / body.long).T, color=ORANGE, linewidth=1.6)
    right.set(aspect="equal", xlabel="ahead, L", ylabel="to the left, L",
              title="the best, a fish each 15 tu")  # fmt: skip
    save_plot(picture, folder / "flat_turns.png")


GOALS_L = ((4.0, 4.0), (-3.5, -4.5))
LATE_TU = 200.0
PASSED = (0.06, 0.09, 0.12, 0.15, 0.18, 0.21)


def show_switching(effort: Effort, folder: Path) -> None:
    """Draw transitions between controllers: a swim to a goal, and the room of the scaffold."""
    body, lessons = flat_body(), learn(effort)
    colours = dict(zip(WAYS, (ORANGE, GREEN, BLUE), strict=True))
    picture = Figure(figsize=(7.4, 6.6), layout="constrained")
    above, below = picture.subfigures(2, 1, height_ratios=(1.3, 1.0))
    for axis, goal in zip(above.subplots(1, 2), GOALS_L, strict=True):
        for way in ("parameters", "lengths"):
            frames = swim_to(body, lessons, body.long * np.array(goal), way)
            path = middle(body, frames[:, 0]) / body.long
            axis.plot(*path.T, color=colours[way], linewidth=1.6, label=way)
            for k in np.linspace(0, len(frames) - 1, 7).astype(int)[1:]:
                if np.isfinite(frames[k]).all() and room(body, frames[k, 0]) > 0:
                    draw(axis, body, frames[k, 0], colours[way], 0.6)
            tight = room(body, frames[:, 0])
            folds = np.flatnonzero((tight[1:] <= 0) & (tight[:-1] > 0))
            axis.plot(*path[folds].T, "x", color=BLACK, markersize=8)
            missed = np.hypot(*(path[-1] - goal))
            print(f"to {goal}, {way}: {len(frames) * FRAME * STEP_TU:.0f} tu, "
                  f"{missed:.2f} L away in the end, folded {len(folds)} times")  # fmt: skip
        draw(axis, body, body.rest, BLACK)
        axis.plot(*goal, "o", color="#c00000", markersize=9)
        axis.set(aspect="equal", xlabel="L", ylabel="L")
        axis.margins(0.08)
    left, right = below.subplots(1, 2)
    for way in WAYS:
        muscles = passage(body, lessons.swimmer, lessons.turner, LATE_TU, way)
        time = LATE_TU + STEP_TU * np.arange(len(muscles))
        left.plot(time, muscles[:, 4] / body.length[4], color=colours[way], linewidth=1.2)
    left.set(xlabel="time, tu", ylabel="length over that at rest",
             title="what a hind muscle is asked for")  # fmt: skip
    moments = np.linspace(30.0, 300.0, effort.moments)
    for way in WAYS:
        shares = []
        for bound in PASSED:
            old, new = (
                one._replace(amplitude=bound / LARGEST * one.amplitude)
                for one in (lessons.swimmer, lessons.turner)
            )
            shares.append(np.mean(tightest(body, old, new, moments, way) <= 0))
        right.plot(PASSED, 100 * np.array(shares), "o-", color=colours[way], label=way)
        print(f"{way}: folded " + ", ".join(
            f"{b:g}: {s:.0%}" for b, s in zip(PASSED, shares, strict=True)))  # fmt: skip
    right.set(xlabel="greatest amplitude, share of length", ylabel="passages that fold, %",
              ylim=(-3, 103), title=f"at {effort.moments} moments")  # fmt: skip
    right.legend(title="what passes linearly", title_fontsize=9)
    save_plot(picture, folder / "flat_switching.png")


LEVELS = np.round(np.arange(0.05, 0.61, 0.05), 2)
BOUNDS = (0.02, 0.05, 0.1, 0.15, 0.2, 0.3)


def folded(body: Body, level: float, number: int) -> float:
    """Fraction of random controllers of amplitude ``level`` that fold the body."""
    rng = np.random.default_rng(7)
    bad = 0
    for _ in range(number):
        point = rng.random(2 * MUSCLES + 1)
        point[:MUSCLES] = 1.0
        muscles = lengths(body, controller_at(point, level), steps_of(SWIM_TU))
        bad += not is_sound(body, run(body, muscles))
    return bad / number


def show_folding(effort: Effort, folder: Path) -> None:
    """Plot the need for a bound of the amplitudes."""
    body = flat_body()
    shares = [folded(body, level, effort.folds) for level in LEVELS]
    print("amplitude: folded  " + ", ".join(
        f"{a:g}: {s:.0%}" for a, s in zip(LEVELS, shares, strict=True)))  # fmt: skip
    picture = Figure(figsize=(7.4, 3.0), layout="constrained")
    left, right = picture.subplots(1, 2)
    left.plot(LEVELS, 100.0 * np.array(shares), "o-", color=ORANGE)
    left.set(xlabel="amplitude of all muscles, share of length", ylabel="folded, %",
             ylim=(-3, 103), title=f"{effort.folds} random controllers each")  # fmt: skip
    found = {}
    for bound in BOUNDS:
        runs = search(
            lambda point, bound=bound: distance(body, controller_at(point, bound)),
            2 * MUSCLES + 1, effort.tries // 2, effort.bound_seeds, HOT_L,
        )  # fmt: skip
        found[bound] = [one.scores.max() for one in runs]
    for bound, far in found.items():
        right.plot([bound] * len(far), far, "o", color=BLUE, alpha=0.6)
    right.plot([*found], [np.median(far) for far in found.values()], color=BLUE)
    right.set(xlabel="bound of the amplitudes, share of length", ylabel="way in 60 tu, L",
              ylim=(0, None), title=f"learned in {effort.tries // 2} tries")  # fmt: skip
    print("bound: learned  " + ", ".join(
        f"{b:g}: {np.median(far):.2f} L" for b, far in found.items()))  # fmt: skip
    save_plot(picture, folder / "flat_folding.png")


# II: motion by rules

FISH = Swing(
    angle=34.0,
    inflections=(0.02, 0.5, 0.98),
    flexibility=((0.0, 0.2), (0.25, 0.25), (0.6, 0.6), (1.0, 1.3)),
)
"""KS's common fish: three inflection points, a stiff head and a soft tail."""
FACTORS = {
    "swing function": (("sinusoidal", {}), ("linear", {"function": "linear"})),
    "inflection points": (
        ("far apart", {}),
        ("close", {"inflections": (0.26, 0.5, 0.74)}),
    ),
    "propagation": (("tailward", {}), ("at once", {"propagation": "at once"})),
    "stiffness": (
        ("stiff head", {}),
        ("even", {"flexibility": ((0.0, 0.6), (1.0, 0.6))}),
    ),
}


def ruled(swing: Swing, beat: Floats) -> Spines:
    """Spines (T, …) of a straight swimmer, in the axes of its path."""
    rules = load_species("ribbon_eel").spine
    assert rules
    easy = msgspec.structs.replace(rules.turn, sharp_beats=20)
    plan = msgspec.structs.replace(rules, swing=swing, turn=easy)
    straight = np.zeros((len(beat), UNITS))
    return pose_spine(plan, beat, 1.0, straight, np.ones(UNITS))


def show_rules(effort: Effort, folder: Path) -> None:
    """Plot KS's four factors, both swing functions, and the learned motion."""
    body, lessons = flat_body(), learn(effort)
    picture = Figure(figsize=(7.4, 9.6), layout="constrained")
    top, strips, bottom = picture.subfigures(3, 1, height_ratios=(1.6, 1.1, 1.0))
    beat = np.linspace(0.0, 0.5, 7)
    for axes, (name, choices) in zip(top.subplots(2, 4).T, FACTORS.items(), strict=True):
        for axis, (label, change) in zip(axes, choices, strict=True):
            swing = msgspec.structs.replace(FISH, **change)
            for k, place in enumerate(ruled(swing, beat).place):
                axis.plot(-place[:, 1], place[:, 0], color=BLUE, alpha=0.2 + 0.8 * k / len(beat))
            first = axis is axes[0]
            axis.set_title(f"{name}:\n{label}" if first else label, fontsize=9)
            axis.set(aspect="equal", xlim=(-0.16, 0.16), ylim=(-0.68, 0.38), xticks=[], yticks=[])
            axis.spines[:].set_visible(False)
            axis.axvline(0.0, color=GREY, linewidth=0.6, linestyle=":", zorder=0)
            axis.plot(
                [0.0] * 3, 0.35 - np.array(swing.inflections), "_", color=ORANGE, markersize=14
            )
    rows = strips.subplots(2, 8)
    hull = body.rest[body.hull[:7, 0]] / body.long
    wide = SLIM * np.interp(JOINTS, -hull[:, 0], hull[:, 1])
    for row, function in zip(rows, ("sinusoidal", "linear"), strict=True):
        swing = msgspec.structs.replace(FISH, function=function)
        shown = ruled(swing, np.arange(8) / 8)
        for k, axis in enumerate(row):
            place = shown.place[k]
            angle = np.interp(JOINTS, MIDDLES, shown.direction[k])
            side = wide[:, None] * np.stack([-np.sin(angle), np.cos(angle)], axis=1)
            shape = np.concatenate([place + side, (place - side)[::-1]])
            axis.fill(-shape[:, 1], shape[:, 0], facecolor=BLUE, alpha=0.25)
            axis.plot(-shape[:, 1], shape[:, 0], color=BLUE, linewidth=0.9)
            axis.set(aspect="equal", xlim=(-0.22, 0.22), ylim=(-0.7, 0.4), xticks=[], yticks=[])
            axis.spines[:].set_visible(False)
            if row is rows[0]:
                axis.set_title(f"{k}/8 beat", fontsize=8)
        row[0].set_ylabel(function)
    left, right = bottom.subplots(1, 2)
    over = np.linspace(0.0, 2.0, 400)
    for function, colour in (("sinusoidal", BLUE), ("linear", ORANGE)):
        swing = msgspec.structs.replace(FISH, function=function)
        rate = np.gradient(np.degrees(swing_angles(swing, np.full(1, 0.8), over, 1.0)), over)
        left.plot(over, rate, color=colour, label=function)
    left.set(xlabel="beats", ylabel="turning of a unit at 0.8 L,\n° a beat",
             title="the linear one ticks")  # fmt: skip
    left.set_ylim(None, 1.45 * left.get_ylim()[1])
    left.legend(loc="upper right", fontsize=8, ncols=2)
    at = np.linspace(0.0, 1.0, 7)
    for number, one in enumerate(sorted(lessons.swims, key=lambda one: -one.scores.max())[:4]):
        place, sway = envelope(body, controller_at(one.winner))
        right.plot(place, sway, color=GREEN, alpha=1.0 if number == 0 else 0.4, marker=".",
                   label="muscles, learned" if number == 0 else None)  # fmt: skip
    alike = body._replace(mass=np.full_like(body.mass, body.mass.mean()))
    runs = search(lambda point: distance(alike, controller_at(point)), 2 * MUSCLES + 1,
                  effort.tries, effort.bound_seeds, HOT_L)  # fmt: skip
    best = best_of(runs)
    place, sway = envelope(alike, controller_at(best.winner))
    right.plot(place, sway, color=GREEN, linestyle="--", marker=".", label="the same, even masses")
    print(
        f"with even masses it swims {best.scores.max():.2f} L, the snout swings by {sway[0]:.2f} L"
    )
    beat = np.arange(40) / 40
    sway = np.abs(ruled(FISH, beat).place[:, :, 1]).max(axis=0)
    right.plot(JOINTS, sway, color=BLUE, label="rules, stiff head")
    even = msgspec.structs.replace(FISH, flexibility=((0.0, 0.6), (1.0, 0.6)))
    sway = np.abs(ruled(even, beat).place[:, :, 1]).max(axis=0)
    right.plot(JOINTS, sway, color=BLUE, linestyle="--", label="rules, even")
    right.set(xlabel="behind the nose, L", ylabel="farthest to a side, L", ylim=(0, None),
              title="how far each part swings", xticks=at.round(2)[::2])  # fmt: skip
    right.set_ylim(0, 1.6 * right.get_ylim()[1])
    right.legend(loc="upper center", fontsize=8)
    linear = msgspec.structs.replace(FISH, function="linear")
    apart = np.abs(ruled(FISH, beat).place - ruled(linear, beat).place).max()
    print(f"sinusoidal and linear swing lie {apart:.3f} L apart at most; a wave of "
          f"{float(phase(FISH, np.ones(1))[0] / np.pi):.2f} halves behind the middle")  # fmt: skip
    save_plot(picture, folder / "flat_rules.png")


def envelope(body: Body, one: Controller) -> tuple[Floats, Floats]:
    """Positions along the midline, L, and their amplitudes about the mean path, L."""
    beat = 1.0 / one.frequency[0]
    tick = FRAME * STEP_TU
    frames = run(body, lengths(body, one, steps_of(SWIM_TU)))[-round(2 * beat / tick) :, 0]
    line, path = midline(frames), middle(body, frames)
    way = path[-1] - path[0]
    way = way / np.hypot(*way)
    # About the straight line that the centre follows in the mean.
    time = np.linspace(-0.5, 0.5, len(path))[:, None]
    mean = path.mean(axis=0) + time * (path[-1] - path[0])
    aside = (line - mean[:, None]) @ np.array([-way[1], way[0]])
    aside -= aside.mean(axis=0)
    place = -midline(body.rest)[:, 0] / body.long
    return place, np.abs(aside).max(axis=0) / body.long


PARTS: dict[str, Callable[[Effort, Path], None]] = {
    "body": show_body,
    "integrators": show_integrators,
    "learning": show_learning,
    "swims": show_swims,
    "turns": show_turns,
    "switching": show_switching,
    "folding": show_folding,
    "rules": show_rules,
}


def main(arguments: list[str] | None = None) -> None:
    """Run all parts, or one."""
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    parser.add_argument("folder", nargs="?", type=Path, default=Path(__file__).parent / "pictures")
    parser.add_argument("--quick", action="store_true", help="spend little")
    parser.add_argument("--only", choices=PARTS, action="append", help="this part (repeatable)")
    options = parser.parse_args(arguments)
    options.folder.mkdir(exist_ok=True)
    with rc_context(STYLE):
        for name in options.only or PARTS:
            PARTS[name](QUICK if options.quick else Effort(), options.folder)


if __name__ == "__main__":
    main()
