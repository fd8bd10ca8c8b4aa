"""The box of bodies and gaits that learning searches, around a given species.

A body is its material and the distribution of its mass; its shape is that of the species. The
stiffness is at most one that the time step bears.
"""

import msgspec
import numpy as np

from capture.learning.swim import LAGS, max_contractions
from subsea.biomechanics.body import Floats, build_body
from subsea.biomechanics.body_plan import DENSITIES, NODES_AT_STATION, BodyPlan, SwimPlan
from subsea.biomechanics.solver import STEP, longest_step
from subsea.fish.surface import SurfacePlan, along

TICKS, FIRST_TICKS = (12, 20), 17  # of a fast beat: range of the search, and its start
BURST_TICKS, MEDIUM_TICKS, SLOW_TICKS = 0.8, 1.45, 2.25  # over those of fast
STIFFNESS, VISCOSITY = (20.0, 800.0), (0.03, 3.0)
MASS_FACTOR = 4.0  # of a station's share in the mass, up or down
MASS = (0.8, 1.2)  # g for each cm³ of the drawn fish, times DENSITY
DENSITY = 1.05  # g/cm³
WIDTH = (0.75, 1.25)  # factor of the half-widths, which are the muscles' levers
MARGIN = 1.15  # of the longest stable step over the step
SWIM_SIZE, BODY_SIZE = 4, 12
"""Coordinates of a gait, and of a body, which follow it."""


def outline_volume(surface: SurfacePlan, length: float) -> float:
    """Volume of the drawn body, cm³: elliptic sections, without dorsal and ventral fins."""
    at = np.linspace(0.0, 1.0, 201)
    height = along(surface.back, at) - along(surface.belly, at)
    area = np.pi / 2 * height * np.maximum(along(surface.width, at), 0.0)
    return float((area[1:] + area[:-1]).sum() / 2 * (at[1] - at[0]) * length**3)


def species_point(plan: BodyPlan, swim: SwimPlan, volume: float, firm: bool = False) -> Floats:
    """The point of a species in the unit box, clipped to it: where a search may begin.

    A ``firm`` one has at least a stiffness that carries the mass of the water, and beats at
    FIRST_TICKS.
    """
    fewest, most = TICKS
    low, high = LAGS
    ticks = FIRST_TICKS if firm else swim.ticks_per_beat
    least = 0.5 if firm else 0.0
    contraction = np.array(swim.contraction) / max_contractions(
        build_body(plan), _burst_ticks(ticks)
    )
    values = [
        *contraction,
        (swim.lag - low) / (high - low),
        (ticks + 0.5 - fewest) / (most + 1 - fewest),
        *(max(_share(k, STIFFNESS), least) for k in _stiffness(plan)),
        _share(plan.viscosity, VISCOSITY),
        (plan.mass / (DENSITY * volume) - MASS[0]) / (MASS[1] - MASS[0]),
        *np.full(len(plan.masses) - 1, 0.5),
        (1.0 - WIDTH[0]) / (WIDTH[1] - WIDTH[0]),
    ]
    return np.clip(values, 0.0, 1.0)


def body_at(base: BodyPlan, point: Floats, volume: float) -> BodyPlan:
    """The body at a point (BODY_SIZE,) of the unit box; ``volume`` is that of the drawn fish."""
    cross, muscle, other = (_between(share, STIFFNESS) for share in point[:3])
    factors = MASS_FACTOR ** (2.0 * np.asarray(point[5:11]) - 1.0)
    weights = np.array(base.masses) * [factors[0], *factors]
    total = DENSITY * volume * (MASS[0] + float(point[4]) * (MASS[1] - MASS[0]))
    width = WIDTH[0] + float(point[11]) * (WIDTH[1] - WIDTH[0])
    widths = tuple(_rounded(width * w) for w in base.half_widths)
    shaped = msgspec.structs.replace(base, half_widths=widths, masses=tuple(base.masses))
    low, high = (0.99 * DENSITIES[1], 1.01 * DENSITIES[0])
    total = float(np.clip(total, high * shaped.hull_volume, low * shaped.hull_volume))
    weights *= total / float(weights @ NODES_AT_STATION)
    plan = msgspec.structs.replace(
        shaped,
        masses=tuple(map(_rounded, weights)),
        cross_stiffness=_rounded(cross),
        muscle_stiffness=_rounded(muscle),
        other_stiffness=_rounded(other),
        viscosity=_rounded(_between(point[3], VISCOSITY)),
    )
    return bearable(plan)


def bearable(plan: BodyPlan) -> BodyPlan:
    """The body with all stiffness and viscosity lowered until the time step has its MARGIN."""
    for _ in range(8):
        room = longest_step(build_body(plan))[0] / (MARGIN * STEP)
        if room >= 1.0:
            break
        # A spring's limit falls with the root of its stiffness, a damper's with its viscosity.
        plan = msgspec.structs.replace(
            plan,
            cross_stiffness=_rounded(plan.cross_stiffness * room**2 * 0.99),
            muscle_stiffness=_rounded(plan.muscle_stiffness * room**2 * 0.99),
            other_stiffness=_rounded(plan.other_stiffness * room**2 * 0.99),
            viscosity=_rounded(plan.viscosity * room * 0.99),
        )
    return plan


def gait_at(plan: BodyPlan, base: SwimPlan, point: Floats) -> SwimPlan:
    """The gait at a point (SWIM_SIZE,): both contractions, lag and ticks of fast, all grades.

    The burst has the contractions of fast, so that they are within what a muscle can do then.
    """
    fewest, most = TICKS
    low, high = LAGS
    ticks = min(int(fewest + point[3] * (most + 1 - fewest)), most)
    greatest = max_contractions(build_body(plan), _burst_ticks(ticks))
    front, back = np.floor(1000 * np.array(point[:2]) * greatest) / 1000
    return msgspec.structs.replace(
        base,
        ticks_per_beat=ticks,
        contraction=(float(front), float(back)),
        lag=round(float(low + point[2] * (high - low)), 3),
        slow=0.8,
        medium=0.9,
        burst=1.0,
        slow_ticks=round(SLOW_TICKS * ticks),
        medium_ticks=round(MEDIUM_TICKS * ticks),
        burst_ticks=_burst_ticks(ticks),
    )


def _burst_ticks(ticks: int) -> int:
    return round(BURST_TICKS * ticks)


def _stiffness(plan: BodyPlan) -> tuple[float, float, float]:
    return plan.cross_stiffness, plan.muscle_stiffness, plan.other_stiffness


def _share(value: float, limits: tuple[float, float]) -> float:
    low, high = limits
    return float(np.log(value / low) / np.log(high / low))


def _between(share: float, limits: tuple[float, float]) -> float:
    low, high = limits
    return float(low * (high / low) ** share)


def _rounded(value: float) -> float:
    """Three digits, as species files have."""
    return float(f"{value:.3g}")
