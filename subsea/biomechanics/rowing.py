"""Rowing with the pectoral fins: the body is rigid and each stroke of both fins pushes it.

The fins sweep backwards with their whole area against the water and forwards edge-on, as drag-based
rowers do, or flap up and down and push all the time (Walker and Westneat 2000, 2002). Each strip of
a fin is a plate as in Tu eq. 4.16.
"""

from typing import Annotated, NamedTuple

import msgspec
import numpy as np

from subsea.biomechanics.body import MUSCLES, Body, Floats
from subsea.biomechanics.body_plan import Ticks
from subsea.biomechanics.simulation import at_rest, simulate
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK
from subsea.kernels import kernel

MIDDLE = np.pi / 3  # angle between the body and the fin in the middle of a stroke
STRIPS = 8  # of a fin along its length
SUBSTEPS = 4  # of a step of the simulation
PERIODIC = 1e-12  # change of speed from stroke to stroke, relative, at which it is steady
MAX_STROKES = 4000
COAST_TICKS = 20  # in which the drag of the hull is measured


class RowPlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The pectoral gait of a species, at the recorded tempo."""

    ticks_per_stroke: Ticks
    amplitude: Annotated[float, msgspec.Meta(gt=0, le=60)] = 45.0  # degrees, half of the sweep
    flaps: bool = False  # up and down, not backwards and forwards


class Oars(NamedTuple):
    """Both pectoral fins as elliptic plates, and the hull that they drive; cm, g and tu."""

    length: float
    width: float
    amplitude: float  # rad
    period: float  # tu
    mass: float  # of the fish
    drag: float  # g/cm: the force on the hull over its speed squared
    flaps: bool = False


@kernel
def sweep_angle(phase: float, amplitude: float) -> float:
    """Angle between body and fin, rad: foremost at phase 0, hindmost at phase π."""
    return float(MIDDLE + amplitude * np.cos(phase))


@kernel
def broadside(phase: float) -> float:
    """Share of the fin's area that meets the water: the power stroke lasts from phase 0 to π."""
    return float(min(max(2.0 * np.sin(phase), 0.0), 1.0))


@kernel
def thrust(oars: Oars, phase: float, speed: float) -> float:
    """Forward force of both fins, g cm/tu², at a phase and at a forward speed of the hull.

    A strip that flaps is turned halfway into the flow that meets it at an angle φ: there
    the thrust of a plate is greatest, area · speed² · sin²(φ/2).
    """
    angle = sweep_angle(phase, oars.amplitude)
    rate = -oars.amplitude * np.sin(phase) * 2.0 * np.pi / oars.period
    total = 0.0
    for k in range(STRIPS):
        share = (k + 0.5) / STRIPS
        chord = oars.width * np.sqrt(1.0 - (2.0 * share - 1.0) ** 2)
        area = chord * oars.length / STRIPS
        if oars.flaps:
            flow = np.sqrt((rate * share * oars.length) ** 2 + speed * speed)
            total += area * flow * 0.5 * (flow - speed)
            continue
        across = rate * share * oars.length + speed * np.sin(angle)
        along = speed * np.cos(angle)
        total -= area * np.sqrt(across * across + along * along) * across * np.sin(angle)
    return float(2.0 * total if oars.flaps else 2.0 * broadside(phase) * total)


@kernel
def row_stroke(oars: Oars, speed: float, steps: int) -> Floats:
    """Speeds (steps + 1,) over one stroke that begins at ``speed``, cm/tu (midpoint rule)."""
    speeds = np.empty(steps + 1)
    speeds[0] = speed
    step = oars.period / steps
    for k in range(steps):
        middle = speeds[k] + 0.5 * step * _acceleration(oars, k / steps, speeds[k])
        speeds[k + 1] = speeds[k] + step * _acceleration(oars, (k + 0.5) / steps, middle)
    return speeds


@kernel
def _acceleration(oars: Oars, share: float, speed: float) -> float:
    force = thrust(oars, 2.0 * np.pi * share, speed) - oars.drag * abs(speed) * speed
    return float(force / oars.mass)


def steady_stroke(oars: Oars, steps: int) -> Floats:
    """Speeds (steps + 1,) of the stroke that repeats, cm/tu; ValueError if none does."""
    speed = balanced_speed(oars)
    for _ in range(MAX_STROKES):
        speeds = row_stroke(oars, speed, steps)
        if abs(speeds[-1] - speed) <= PERIODIC * speeds.max():
            return speeds
        speed = float(speeds[-1])
    raise ValueError(f"no steady speed after {MAX_STROKES} strokes")


def balanced_speed(oars: Oars) -> float:
    """The constant speed, cm/tu, at which the mean thrust of a stroke is the drag of the hull."""
    phases = 2.0 * np.pi * (np.arange(400) + 0.5) / 400
    low, high = 0.0, oars.length * oars.amplitude * 2.0 * np.pi / oars.period
    while high - low > 1e-9 * high:
        speed = 0.5 * (low + high)
        mean = np.mean([thrust(oars, float(phase), speed) for phase in phases])
        low, high = (speed, high) if mean > oars.drag * speed**2 else (low, speed)
    return low


def hull_drag(body: Body) -> float:
    """Drag of a straight body that coasts, over its speed squared, g/cm, in the water it is in.

    From the speed lost in some ticks from 1 L/s: 1/U grows by drag / mass in a unit of time.
    """
    state = at_rest(body)
    speed = 0.1 * float(np.ptp(body.rest[:, 0]))
    state.v[:, 0] = speed
    simulate(body, state, np.zeros((COAST_TICKS * STEPS_PER_TICK, MUSCLES)))
    after = float(body.mass @ state.v[:, 0] / body.mass.sum())
    return float(
        body.mass.sum() * (1.0 / after - 1.0 / speed) / (COAST_TICKS * STEP * STEPS_PER_TICK)
    )


def oars_of(body: Body, plan: RowPlan, fin: tuple[float, float]) -> Oars:
    """The fins of length and width ``fin``, cm, that drive a body."""
    return Oars(
        *fin,
        np.radians(plan.amplitude),
        plan.ticks_per_stroke * STEPS_PER_TICK * STEP,
        float(body.mass.sum()),
        hull_drag(body),
        plan.flaps,
    )


def row_ticks(body: Body, plan: RowPlan, fin: tuple[float, float]) -> Floats:
    """Distances (T,), cm, of the ticks of a steady stroke with fins of length and width ``fin``."""
    oars = oars_of(body, plan, fin)
    per_tick = STEPS_PER_TICK * SUBSTEPS
    speeds = steady_stroke(oars, plan.ticks_per_stroke * per_tick)
    mean = 0.5 * (speeds[1:] + speeds[:-1]).reshape(plan.ticks_per_stroke, per_tick).mean(axis=1)
    return np.asarray(mean * STEP * STEPS_PER_TICK)
