"""Keep bodies upright (SMC §5.2, appendix B), in the sea and out of solids.

Fishes steer clear (`behavior/steering.py`) and slide along what they touch (`habitat/contact.py`),
but both foresee a straight way. A turn swings snout or tail aside, and a burst begins within a
tick. After the motion, this moves back each fish that reaches beyond a barrier.
"""

import math

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.geometry.angles import arc_tangent
from subsea.geometry.rotation import Quaternion, about, multiply, quaternion, rotate, x_axis
from subsea.geometry.solids import (
    far_from_rock,
    from_pillar,
    from_rock,
    height_at,
    is_far_from_rocks,
    is_over_all,
)
from subsea.geometry.vector import Vector, minus, norm, plus, store, times, vector
from subsea.kernels import kernel
from subsea.motor.pose import ends
from subsea.state import Fishes, Sea

ROLL_TIME_S = 0.25  # time constant of the smoothed roll: a steady beat wobbles by ±3°
ROLL_GAIN = 0.9  # 1/s: share of the roll corrected per second
ROLL_RATE = np.radians(50.0)  # rad/s: the fastest correction
VERTICAL = 0.98  # sine of the pitch beyond which roll is undefined


@kernel
def roll_of(q: Quaternion) -> float:
    """The roll in radians about x, positive when the back leans to the right (SMC app. B).

    The signed angle from the upright y' = z' × x with z' = x × up; the arccos of SMC has no sign.
    0 for nearly vertical fishes.
    """
    x = x_axis(q)
    y = rotate(q, (0.0, 1.0, 0.0))
    if abs(x[2]) > VERTICAL:
        return 0.0
    # Both arguments carry the same factor, which cancels.
    return arc_tangent(y[0] * x[1] - y[1] * x[0], y[2])


@kernel
def balanced(fishes: Fishes, i: int, q: Quaternion, bank: float, dt: float) -> Quaternion:
    """Roll toward the `bank` of the recorded fish, rad, at a bounded rate, on the smoothed gap."""
    roll = roll_of(q) - bank
    smooth = float(fishes.roll[i])
    if roll - smooth > np.pi:
        smooth += 2.0 * np.pi
    elif smooth - roll > np.pi:
        smooth -= 2.0 * np.pi
    smooth += (roll - smooth) * dt / ROLL_TIME_S
    rate = min(max(ROLL_GAIN * smooth, -ROLL_RATE), ROLL_RATE)
    fishes.roll[i] = smooth - rate * dt
    return multiply(q, about(1.0, 0.0, 0.0, -rate * dt))


GAP_CM = 0.1  # gap that is left, above the rounding of positions
PASSES = 12  # steps out of barriers that overlap
SWING = 0.25  # share of the body length: farthest swing of an end by a turn in a tick


@kernel
def contain(who: Ints, fishes: Fishes, nodes: Array, sea: Sea, dt: float) -> None:
    """Move each of the fishes `who` back by as much as snout, middle or tail is beyond a barrier.

    `nodes` are the library's. A body that fits nowhere near keeps the place and attitude of the
    last tick. One that a panel put into a solid is let out at the speed of its own motion. A fish
    on the hook may leave the water.
    """
    for i in who:
        if not fishes.alive[i] or i == sea.catch[1]:
            continue
        # In double precision, as all else that follows.
        here, length = times(1.0, vector(fishes.position[i])), float(fishes.length[i])
        if not _is_near(here, length, sea):
            continue
        q = quaternion(fishes.orientation[i])
        nose, edge = ends(fishes, nodes, i)
        nose, edge = rotate(q, nose), rotate(q, edge)
        before = times(1.0, vector(fishes.previous_position[i]))
        most = norm(minus(here, before)) + SWING * length
        place, free = here, False
        shell = float(fishes.shell[i])
        for _ in range(PASSES):
            gap, way = deepest(place, nose, edge, sea, shell)
            free = gap >= 0.0
            if free or norm(minus(place, here)) > most:
                break
            place = plus(place, times(GAP_CM - gap, way))
        off = norm(minus(place, here))
        if off == 0.0:
            continue
        if off > most:
            place = plus(here, times(most / off, minus(place, here)))
        elif not free:
            place = before
            if not fishes.live[i]:
                store(fishes.orientation[i], quaternion(fishes.previous_orientation[i]))
        store(fishes.position[i], place)
        store(fishes.velocity[i], times(1.0 / dt, minus(place, before)))


@kernel
def _is_near(p: Vector, length: float, sea: Sea) -> bool:
    """True if a body with its middle at p may reach a barrier."""
    away = math.sqrt(p[0] * p[0] + p[1] * p[1])
    if sea.radius - away < length or p[2] > -length:
        return True
    if is_over_all(sea.skyline, sea.half_width, p, length):
        return False
    if p[2] - length < sea.crest:
        return True
    near = False
    for k in range(len(sea.pillars)):
        near = near or from_pillar(sea.pillars[k], p)[1] < length
    clear = is_far_from_rocks(sea.tops, sea.half_width, p, length)
    for k in range(0 if clear else len(sea.rocks)):
        near = near or not far_from_rock(sea.rocks[k], p, length)
    return near


@kernel
def deepest(
    here: Vector, nose: Vector, edge: Vector, sea: Sea, shell: float
) -> tuple[float, Vector]:
    """The least gap, cm, of snout, middle and tail to any barrier, and the way out, a unit vector.

    The gap is negative inside; of pillars and rocks it begins `shell` cm below what fishes avoid,
    for a fish that feeds on the drawn stone. `nose` and `edge` are the ends from the middle, in
    world axes. The way out of the seabed is up.
    """
    least, out = math.inf, (0.0, 0.0, 1.0)
    for part in (here, plus(here, nose), plus(here, edge)):
        away = max(math.sqrt(part[0] * part[0] + part[1] * part[1]), 1e-6)
        if sea.radius - away < least:
            least, out = sea.radius - away, (-part[0] / away, -part[1] / away, 0.0)
        if -part[2] < least:
            least, out = -part[2], (0.0, 0.0, -1.0)
        if part[2] - sea.crest < least:
            above = part[2] - height_at(sea.heights, sea.half_width, part[0], part[1])
            if above < least:
                least, out = above, (0.0, 0.0, 1.0)
        for k in range(len(sea.pillars)):
            way, gap = from_pillar(sea.pillars[k], part)
            if gap + shell < least:
                least, out = gap + shell, way
        for k in range(len(sea.rocks)):
            if least >= 0.0 and far_from_rock(sea.rocks[k], part, 0.0):
                continue
            way, gap = from_rock(sea.rocks[k], part)
            if gap + shell < least:
                least, out = gap + shell, way
    return least, out
