"""Fit the scaffold of a fish to its outline: rings, masses, and a material that stays stable.

The numbers that an outline does not show are the means of the eight shipped bodies, which a search
found: where rings stand, how far inside the skin their nodes lie, and how the mass is spread.
Stiffness and viscosity are in proportion to the mass, so that a heavier body of the same shape
bends at the same frequency. Both are lowered until the time step bears the body.
"""

from typing import Any

import msgspec
import numpy as np

from subsea.biomechanics.body import Floats, build_body
from subsea.biomechanics.body_plan import NODES_AT_STATION, BodyPlan
from subsea.biomechanics.solver import STEP, longest_step
from subsea.fish.surface import FinPlan, SurfacePlan, along

MODEL_CM = 22.0  # length of a fitted model, about that of the shipped ones
DENSITY = 1.05  # of a fish, g/cm³
MARGIN = 1.15  # of the longest stable step over the step
RING_PLACES = np.array([0.13, 0.4, 0.645, 0.83, 1.0])  # of the rings, over the root of the tail
HINDMOST_ROOT = 0.86  # body lengths: the tail needs a section of some length behind the last ring
HEIGHT_SHARES = np.array([0.55, 0.58, 0.66, 0.78, 1.05])  # of rings over the outline
OUTSIDE = np.array([1.05, 1.05, 1.05, 1.3, 1.8])  # the same at most, of the shipped bodies
LEAST_HEIGHTS = np.array([0.025, 0.045, 0.05, 0.05, 0.058])  # body lengths, half
HALF_WIDTHS = np.array([0.036, 0.058, 0.054, 0.046, 0.046])  # body lengths: the muscles' levers
TAIL_SHARE, TAIL_HEIGHTS = 0.375, (0.085, 0.13)  # half height over the span; body lengths
MASS_SHARES = np.array([1.1, 1.1, 0.8, 1.3, 1.5, 3.0, 3.0])  # over the drawn fish at a station
STIFFNESS = (1.33, 1.37, 0.99)  # of cross units, muscles and others, over the mass, 1/tu²
VISCOSITY = 0.0055  # over the mass, 1/tu
SKIN_DRAG = 0.024
LEAST_SPAN = 0.02  # body lengths
LEAST_MASS = 0.003  # of a node, over the whole
SAMPLES = 400  # of an outline along the body
COUNTS = np.array(NODES_AT_STATION)


def fit_scaffold(surface: SurfacePlan, length: float = MODEL_CM) -> BodyPlan:
    """Fit the body of a fish of ``length`` cm to its outline.

    The fish is neutrally buoyant: it has the mass of the drawn volume at DENSITY. ValueError for an
    outline that no scaffold fits.
    """
    places = RING_PLACES * min(surface.tail.begin, HINDMOST_ROOT)
    back, belly = along(surface.back, places), along(surface.belly, places)
    half = np.minimum(back, -belly)
    heights = np.maximum(HEIGHT_SHARES * half, np.minimum(LEAST_HEIGHTS, 0.97 * OUTSIDE * half))
    span = surface.back[-1][1] - surface.belly[-1][1]
    spans = np.maximum([*_heights_with_fins(surface, places), span], LEAST_SPAN)
    stations: Any = tuple(np.round([0.0, *(places * length), length], 2).tolist())
    volumes = volumes_at(surface, stations)
    mass = DENSITY * float(volumes.sum())
    cross, muscle, other = (three_digits(share * mass) for share in STIFFNESS)
    plan = BodyPlan(
        stations=stations,
        half_widths=_digits(HALF_WIDTHS * length),
        half_heights=_digits(heights * length),
        tail_half_height=round(float(np.clip(TAIL_SHARE * span, *TAIL_HEIGHTS)) * length, 2),
        masses=_masses(mass, volumes),
        cross_stiffness=cross,
        muscle_stiffness=muscle,
        other_stiffness=other,
        viscosity=three_digits(VISCOSITY * mass),
        water="elongated",
        spans=_digits(spans * length),
        skin_drag=SKIN_DRAG,
    )
    return bearable(plan)


def volumes_at(surface: SurfacePlan, stations: tuple[float, ...]) -> Floats:
    """Volumes (7,) of the drawn body nearest to each station, cm³.

    Its sections are elliptic, without dorsal and ventral fins.
    """
    at = (np.arange(SAMPLES) + 0.5) / SAMPLES
    height = along(surface.back, at) - along(surface.belly, at)
    area = np.pi / 2 * height * np.maximum(along(surface.width, at), 0.0)
    length = stations[-1]
    nearest = np.abs(at[:, None] - np.array(stations) / length).argmin(axis=1)
    slices = area * length**3 / len(at)
    return np.asarray(np.bincount(nearest, slices, len(stations)), np.float64)


def bearable(plan: BodyPlan) -> BodyPlan:
    """The body with all stiffness and viscosity lowered until the time step has its MARGIN.

    A mode's limit falls with the root of its stiffness and with its viscosity: one step is exact.
    """
    room = longest_step(build_body(plan))[0] / (MARGIN * STEP)
    if room >= 1.0:
        return plan
    return msgspec.structs.replace(
        plan,
        cross_stiffness=three_digits(plan.cross_stiffness * room**2 * 0.99),
        muscle_stiffness=three_digits(plan.muscle_stiffness * room**2 * 0.99),
        other_stiffness=three_digits(plan.other_stiffness * room**2 * 0.99),
        viscosity=three_digits(plan.viscosity * room * 0.99),
    )


def three_digits(value: float) -> float:
    """Round to three digits, as species files have."""
    return float(f"{value:.3g}")


def _heights_with_fins(surface: SurfacePlan, places: Floats) -> Floats:
    """Heights (5,) at places along the body, with the fins that stand there, body lengths."""
    top, bottom = along(surface.back, places), along(surface.belly, places)
    if surface.dorsal:
        top = np.maximum(top, _fin_edge(surface.dorsal, places, -np.inf))
    if surface.ventral:
        bottom = np.minimum(bottom, _fin_edge(surface.ventral, places, np.inf))
    return np.asarray(top - bottom)


def _fin_edge(fin: FinPlan, places: Floats, beside: float) -> Floats:
    """Height (n,) of the free edge of a fin at places; ``beside`` it where it does not stand."""
    x, y = np.array(sorted(fin.edge)).T
    return np.asarray(np.interp(places, x, y, left=beside, right=beside))


def _masses(total: float, volumes: Floats) -> Any:
    """Masses of a node at each station, g, that add up to ``total``."""
    weights = np.maximum(MASS_SHARES * volumes, LEAST_MASS * volumes.sum() * COUNTS)
    return _digits(weights * total / weights.sum() / COUNTS)


def _digits(values: Floats) -> Any:
    """Round the numbers of a plan, a tuple."""
    return tuple(map(three_digits, values.tolist()))
