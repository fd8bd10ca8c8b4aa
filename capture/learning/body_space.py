"""The box of bodies and gaits that learning searches, around a given species.

A body is its material and the distribution of its mass; its shape is that of the species. The
stiffness is at most one that the time step bears.
"""

import msgspec
import numpy as np

from capture.learning.swim import beat_at, beat_point
from subsea.biomechanics.body import Body, Floats, build_body
from subsea.biomechanics.body_plan import DENSITIES, NODES_AT_STATION, BodyPlan, SwimPlan
from subsea.fish.scaffold import DENSITY, bearable, three_digits

TICKS = {"fast": (12, 20), "medium": (20, 32), "slow": (26, 40), "burst": (10, 17)}
"""Range of the ticks of a beat in the search, for each grade."""
FIRST_TICKS = {"fast": 17, "medium": 26, "slow": 35, "burst": 14}  # where it starts
STIFFNESS, VISCOSITY = (20.0, 800.0), (0.1, 3.0)
MASS_FACTOR = 2.0  # of a station's mass over that of the drawn fish around it, up or down
MASS = (0.8, 1.2)  # g for each cm³ of the drawn fish, times DENSITY
WIDTH = (0.75, 1.5)  # factor of the half-widths, which are the muscles' levers
SKIN_DRAG = (0.012, 0.032)  # coefficient of friction, with which the Strouhal number rises
GAIT_SIZE, BODY_SIZE = 4, 13
"""Coordinates of a gait, and of a body, which follow it."""


def species_point(plan: BodyPlan, swim: SwimPlan, volumes: Floats, firm: bool = False) -> Floats:
    """The point of a species in the unit box, clipped to it: where a search may begin.

    The gait is that of grade fast. A ``firm`` one has at least a stiffness that carries the mass of
    the water, and beats at the FIRST_TICKS.
    """
    least = 0.5 if firm else 0.0
    factors = np.array(plan.masses) * NODES_AT_STATION / plan.mass * volumes.sum()
    factors = np.log(factors / np.maximum(volumes, 1e-9)) / np.log(MASS_FACTOR)
    values = [
        *gait_point(build_body(plan), swim, "fast", FIRST_TICKS["fast"] if firm else None),
        *(max(_share(k, STIFFNESS), least) for k in _stiffness(plan)),
        _share(plan.viscosity, VISCOSITY),
        (plan.mass / (DENSITY * volumes.sum()) - MASS[0]) / (MASS[1] - MASS[0]),
        *(0.5 * (1.0 + factors[1:])),
        (1.0 - WIDTH[0]) / (WIDTH[1] - WIDTH[0]),
        (plan.skin_drag - SKIN_DRAG[0]) / (SKIN_DRAG[1] - SKIN_DRAG[0]),
    ]
    return np.clip(values, 0.0, 1.0)


def at_mass(point: Floats, ratio: float) -> Floats:
    """The point of a body that is ``ratio`` times as heavy and as stiff, of a fish's density."""
    moved = point.copy()
    moved[GAIT_SIZE : GAIT_SIZE + 3] += np.log(ratio) / np.log(STIFFNESS[1] / STIFFNESS[0])
    moved[GAIT_SIZE + 3] += np.log(ratio) / np.log(VISCOSITY[1] / VISCOSITY[0])
    moved[GAIT_SIZE + 4] = (1.0 - MASS[0]) / (MASS[1] - MASS[0])
    return np.clip(moved, 0.0, 1.0)


def gait_point(body: Body, swim: SwimPlan, grade: str, ticks: int | None = None) -> Floats:
    """The point (GAIT_SIZE,) of a grade in the unit box, clipped to it, of a beat of ``ticks``."""
    gait = swim.at(grade)
    contraction = swim.amplitude(grade) * np.array(gait.contraction)
    ticks = ticks or gait.ticks_per_beat
    return np.clip(beat_point(body, contraction, gait.lag, ticks, TICKS[grade]), 0.0, 1.0)


def body_at(base: BodyPlan, point: Floats, volumes: Floats) -> BodyPlan:
    """The body at a point (BODY_SIZE,) of the unit box; ``volumes`` are those of the drawn fish."""
    cross, muscle, other = (_between(share, STIFFNESS) for share in point[:3])
    factors = MASS_FACTOR ** (2.0 * np.asarray(point[5:11]) - 1.0)
    weights = volumes / NODES_AT_STATION * [factors[0], *factors]
    total = DENSITY * volumes.sum() * (MASS[0] + float(point[4]) * (MASS[1] - MASS[0]))
    width = WIDTH[0] + float(point[11]) * (WIDTH[1] - WIDTH[0])
    widths = tuple(three_digits(width * w) for w in base.half_widths)
    shaped = msgspec.structs.replace(base, half_widths=widths, masses=tuple(base.masses))
    low, high = (0.99 * DENSITIES[1], 1.01 * DENSITIES[0])
    total = float(np.clip(total, high * shaped.hull_volume, low * shaped.hull_volume))
    weights *= total / float(weights @ NODES_AT_STATION)
    plan = msgspec.structs.replace(
        shaped,
        masses=tuple(map(three_digits, weights)),
        cross_stiffness=three_digits(cross),
        muscle_stiffness=three_digits(muscle),
        other_stiffness=three_digits(other),
        viscosity=three_digits(_between(point[3], VISCOSITY)),
        skin_drag=three_digits(SKIN_DRAG[0] + float(point[12]) * (SKIN_DRAG[1] - SKIN_DRAG[0])),
    )
    return bearable(plan)


def gait_at(body: Body, base: SwimPlan, grade: str, point: Floats | tuple[float, ...]) -> SwimPlan:
    """The plan with the gait of a grade at a point (GAIT_SIZE,): contractions, lag and ticks."""
    contraction, lag, ticks = beat_at(body, point, TICKS[grade])
    if grade == "fast":
        return msgspec.structs.replace(base, ticks_per_beat=ticks, contraction=contraction, lag=lag)
    own = {"ticks": ticks, "contraction": contraction, "lag": lag}
    named = {f"{grade}_{key}": value for key, value in own.items()}
    return msgspec.structs.replace(base, **named, **{grade: 1.0})


def _stiffness(plan: BodyPlan) -> tuple[float, float, float]:
    return plan.cross_stiffness, plan.muscle_stiffness, plan.other_stiffness


def _share(value: float, limits: tuple[float, float]) -> float:
    low, high = limits
    return float(np.log(value / low) / np.log(high / low))


def _between(share: float, limits: tuple[float, float]) -> float:
    low, high = limits
    return float(low * (high / low) ** share)
