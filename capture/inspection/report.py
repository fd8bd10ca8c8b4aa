"""Report the segments of a repertoire file, the measures of their motion, and drag."""

from collections.abc import Callable, Iterator
from pathlib import Path

import msgspec
import numpy as np

from capture.inspection.simulated import measure_simulated, measure_spine_driven
from capture.inspection.targets import Measure
from capture.recording.record import Motion, motion_from_provenance
from capture.recording.spine_muscles import eel_of
from capture.recording.wing_muscles import ray_of
from subsea.base.errors import UserError
from subsea.biomechanics.body import MUSCLES, Floats, build_body
from subsea.biomechanics.simulation import at_rest, is_sound, simulate
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK, TICK_S
from subsea.fish.spine import SpinePlan
from subsea.fish.surface import SurfacePlan, along
from subsea.repertoire import BASIC_SEGMENTS, SEGMENTS, Repertoire, Segment, read_repertoire

HEADINGS = (
    "segment", "pattern", "grade", "frames", "cyclic", "cm/s", "L/s", "L/beat", "turn °",
    "loop error L", "radius L", "points",
)  # fmt: skip

SOURCES = {
    "biomechanics": "Measured by simulating again from the provenance",
    "spine": "Measured against the spine plan in the provenance",
}


def report(path: Path, write: Callable[[str], object]) -> bool:
    """Write the report on a file line by line; return whether every limit is kept.

    UserError where the file is damaged or not a repertoire.
    """
    repertoire = read_repertoire(path)
    missing = [name for name in BASIC_SEGMENTS if name not in repertoire.segments]
    write(
        f"{path}: {repertoire.species}, {repertoire.body_length_cm:g} cm, from "
        f"{repertoire.source}, a frame each {1000 * repertoire.tick_s:g} ms"
    )
    write("")
    for line in _table([HEADINGS, *_segment_rows(repertoire)]):
        write(line)
    write("")
    if repertoire.source not in SOURCES or missing:
        gap = f"no {', '.join(missing)}" if missing else f"its source is {repertoire.source!r}"
        write(f"Measures of the motion need a full repertoire of a known source; {gap}.")
        return not missing
    write(f"{SOURCES[repertoire.source]} (L: body length, tu: 0.1 s):")
    write("")
    write(_line("", "", "at least", "", "aim", ""))
    failed, missed = 0, 0
    for found in _measures(path, repertoire):
        failed += not found.passed
        missed += not found.aim_reached
        write(
            _line(
                found.name,
                found.value,
                found.limit,
                _verdict(found.limit, found.passed, "FALLS SHORT"),
                found.aim,
                _verdict(found.aim, found.aim_reached, "missed"),
            )
        )
    write("")
    write("Every limit is kept." if not failed else f"{failed} measures fall short.")
    write("Every aim is reached too." if not missed else f"{missed} of the aims are missed.")
    return not failed


def _measures(path: Path, repertoire: Repertoire) -> Iterator[Measure]:
    try:
        if repertoire.source == "spine":
            yield from measure_spine_driven(repertoire)
        else:
            yield from measure_simulated(motion_from_provenance(repertoire.provenance), repertoire)
    except msgspec.ValidationError as fault:
        raise UserError(f"attribute 'provenance' holds no plans ({fault})", file=path) from fault


def _line(name: str, value: str, at_least: str, passed: str, aim: str, reached: str) -> str:
    """A row of the table of measures."""
    cells = f"{name:<41} {value:>22}   {at_least:<12} {passed:<11}  {aim:<12} {reached}"
    return cells.rstrip()


def _verdict(target: str, reached: bool, missed: str) -> str:
    return "" if not target else "pass" if reached else missed


def _segment_rows(repertoire: Repertoire) -> Iterator[tuple[str, ...]]:
    length = repertoire.body_length_cm
    for name in sorted(repertoire.segments, key=_order):
        segment = repertoire.segments[name]
        frames = len(segment.nodes)
        per_second = segment.speed_cm_s / length
        yield (
            name,
            segment.pattern,
            segment.grade,
            str(frames),
            "yes" if segment.cyclic else "no",
            f"{segment.speed_cm_s:.2f}",
            f"{per_second:.3f}",
            f"{per_second * frames * repertoire.tick_s:.3f}" if segment.cyclic else "-",
            f"{segment.turn_deg:+.2f}",
            f"{segment.loop_error_bl:.1e}",
            f"{segment.bounding_radius_bl:.3f}",
            "no" if segment.control_points is None else str(segment.control_points.shape[1]),
        )


def _order(name: str) -> tuple[int, str]:
    return (SEGMENTS.index(name) if name in SEGMENTS else len(SEGMENTS), name)


def _table(rows: list[tuple[str, ...]]) -> Iterator[str]:
    """Lines of a table: words aligned to the left and numbers to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = [
            f"{cell:<{width}}" if column < 3 else f"{cell:>{width}}"
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        yield "  ".join(cells).rstrip()


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


def eel_glide_drag(plan: SpinePlan, surface: SurfacePlan, speed: float) -> float:
    """Drag coefficient of a coasting eel with muscles: as `glide_drag`."""
    eel = eel_of(plan, surface)
    speeds = np.diff(eel.glide(speed, GLIDE_TICKS)) / (STEPS_PER_TICK * STEP)
    mass, area = float(eel.long.body.mass.sum()), wetted_area(surface) * plan.length**2
    return drag_coefficient(np.insert(speeds, 0, speed), STEPS_PER_TICK * STEP, mass, area)


def ray_glide_drag(plan: SpinePlan, surface: SurfacePlan, speed: float) -> float:
    """Drag coefficient of a coasting ray with muscles: as `glide_drag`."""
    ray = ray_of(plan, surface)
    speeds = np.diff(ray.glide(speed, GLIDE_TICKS)) / (STEPS_PER_TICK * STEP)
    mass, area = float(ray.disc.mass.sum()), wetted_area(surface) * plan.length**2
    return drag_coefficient(np.insert(speeds, 0, speed), STEPS_PER_TICK * STEP, mass, area)


def coast_drag(motion: Motion, surface: SurfacePlan, coast: Segment) -> float:
    """Drag coefficient of a recorded coast, from the speed that it loses in a tick."""
    mass = float(build_body(motion.body).mass.sum())
    area = wetted_area(surface) * motion.body.length**2
    way = coast.speed_cm_s * TICK_S  # in a tick
    return 2.0 * mass * coast.slowing / (WATER_DENSITY * area * way)
