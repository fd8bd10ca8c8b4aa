"""Drag of a body that coasts, and the Strouhal number that drag asks for."""

import numpy as np

from capture.recording.record import Motion
from subsea.biomechanics.body import MUSCLES, Floats, build_body
from subsea.biomechanics.simulation import at_rest, is_sound, simulate
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK
from subsea.fish.surface import SurfacePlan, along

WATER_DENSITY = 1.0  # g/cm³
VISCOSITY_CM2_S = 0.01  # kinematic
GLIDE_TICKS = 90
SLOWED = 0.5  # the fit ends at this share of the first speed
TURBULENT = 5e5  # Reynolds number
SWIMMING_DRAG = 4.0  # drag of a body that undulates over that of a straight one (Lighthill 1971)
SLIP = 0.7  # speed over that of the body wave
SECTIONS = 201


def wetted_area(surface: SurfacePlan) -> float:
    """Area of body, tail and wings, in squared body lengths; both sides of fins."""
    at = np.linspace(0.0, 1.0, SECTIONS)
    a = np.maximum(0.5 * (along(surface.back, at) - along(surface.belly, at)), 0.0)
    b = np.maximum(along(surface.width, at), 0.0)
    if surface.wing:
        behind, right = np.array(surface.wing.outline).T
        b = np.maximum(b, np.interp(at, behind, right, right=0.0))
    h = ((a - b) / np.maximum(a + b, 1e-9)) ** 2
    around = np.pi * (a + b) * (1 + 3 * h / (10 + np.sqrt(4 - 3 * h)))  # Ramanujan's ellipse
    return float(np.trapezoid(around, at))


def tail_span(surface: SurfacePlan) -> float:
    """Height of the tail fin in body lengths."""
    at = np.linspace(surface.tail.begin, 1.0, SECTIONS)
    return float((along(surface.back, at) - along(surface.belly, at)).max())


def expected_strouhal(surface: SurfacePlan, length_cm: float, speed_cm_s: float) -> float:
    """Strouhal number at which elongated-body thrust balances the drag of a swimming fish.

    Thrust is that of Lighthill with little slope at the tail's edge; drag is friction, laminar or
    turbulent by the Reynolds number, times `SWIMMING_DRAG`. Small fishes come out higher (Eloy
    2012).
    """
    reynolds = speed_cm_s * length_cm / VISCOSITY_CM2_S
    friction = 1.328 * reynolds**-0.5 if reynolds < TURBULENT else 0.074 * reynolds**-0.2
    area, span = wetted_area(surface), tail_span(surface)
    return strouhal_of_drag(SWIMMING_DRAG * friction, area / span**2)


def strouhal_of_drag(drag: float, area_over_span2: float) -> float:
    """The Strouhal number √(8 S C_D / (π³ b² (1 - β²))) of steady swimming."""
    return float(np.sqrt(8 * area_over_span2 * drag / (np.pi**3 * (1 - SLIP**2))))


def glide(motion: Motion, speed: float) -> Floats:
    """Speeds (GLIDE_TICKS + 1,), cm/tu, of the straight passive body that starts at `speed`.

    NaN from the tick at which it loses its shape.
    """
    body = build_body(motion.body)
    state = at_rest(body)
    state.v[:, 0] = speed
    frames = [state.x.copy()]
    frames.extend(simulate(body, state, np.zeros((GLIDE_TICKS * STEPS_PER_TICK, MUSCLES))))
    middle = np.array(frames)[..., 0] @ body.mass / body.mass.sum()
    found = np.concatenate([[speed], np.diff(middle) / (STEPS_PER_TICK * STEP)])
    return found if is_sound(state) else np.full(GLIDE_TICKS + 1, np.nan)


def drag_coefficient(speeds: Floats, tick_tu: float, mass: float, area: float) -> float:
    """Coefficient of quadratic drag on the wetted area, cm², of a coasting mass, g.

    Quadratic drag makes 1/U grow linearly, by ρ S C_D / 2 m in a unit of time. `speeds` (t,) are
    means over each tick but the first, which is that of the start.
    """
    use = np.flatnonzero(speeds[1:] >= SLOWED * speeds[0])
    if len(use) < 2:
        use = np.arange(2)
    time = (use + 0.5) * tick_tu
    rate = np.polyfit(time, 1.0 / speeds[1:][use], 1)[0]
    return float(2 * mass * rate / (WATER_DENSITY * area))


def glide_drag(motion: Motion, surface: SurfacePlan, speed: float) -> float:
    """Drag coefficient of a coasting fish, from its simulation at `speed`, cm/tu."""
    mass = float(build_body(motion.body).mass.sum())
    area = wetted_area(surface) * motion.body.length**2
    return drag_coefficient(glide(motion, speed), STEPS_PER_TICK * STEP, mass, area)
