"""Checks of an edited species, as sentences that say what to do.

`static_checks` read the numbers; `swim_checks` judge a test swim with the fish's own controllers.
"""

from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import numpy as np
from msgspec import structs

from subsea.base.errors import UserError
from subsea.biomechanics.body import (
    KINDS,
    LOWER_TAIL,
    TRIANGLES,
    UNITS,
    UPPER_TAIL,
    Body,
    Floats,
    build_body,
)
from subsea.biomechanics.body_plan import DENSITIES, NODES_AT_STATION, BodyPlan, Muscles, SwimPlan
from subsea.biomechanics.controllers import S_MAX, ease
from subsea.biomechanics.fins import contraction_step, headings, sweep
from subsea.biomechanics.simulation import BodyState, at_rest, is_sound, simulate
from subsea.biomechanics.solver import STEP, STRAIN_LIMITS, longest_step
from subsea.biomechanics.trial import grade_contraction, steady_beat
from subsea.fish.scaffold import OUTSIDE
from subsea.fish.species import Species, UnstableSpecies
from subsea.fish.surface import SurfacePlan, along
from subsea.repertoire.findings import (
    LEAST_TURN_DEG,
    FishFinding,
    FishMotion,
    Severity,
    judge,
    motion_findings,
    try_motion,
)

GOOD, WARNING, FAULT = Severity
AFLOAT = (0.7, 1.4)  # mass over mass of the displaced water
NEUTRAL = 0.1  # deviation of this from 1 that counts as neutrally buoyant
LEAST_STEP = 5  # percent by which the longest stable step exceeds that of the simulation
REAR = 0.02  # body lengths from the fins back to the centre of mass
BEATS = 40  # of a test swim
SWEEP = (0.12, 0.3)  # of the tail, body lengths
BENDS = (0.3, 0.24, 0.18, 0.14, 0.1, 0.07, 0.05, 0.03)  # of gradual turns that are tried
MOST_TURN_DEG = 45.0  # of a gradual turn, by beat
WEAKER, WIDER = (0.8, 0.6), (1.5, 2.5)  # shares of contractions and of a width that are tried
UNIT_NAMES = ("muscle", "cross unit", "unit")
NODE_PLACES = (
    "the nose",
    *(f"ring {ring}" for ring in range(1, 6) for _ in range(4)),
    *["the tail"] * 2,
)


_good, _warning, _fault = (partial(FishFinding, severity) for severity in Severity)


def static_checks(species: Species) -> list[FishFinding]:
    """Check shape, scaffold, buoyancy and material."""
    findings = [_shape(species.surface)]
    if species.body:
        body = build_body(species.body)
        findings += [check_faces(body), _rings(species.body, species.surface)]
        water = displaced_cm3(species)
        light = species.body.mass < water
        findings += _buoyancy(species.body, water)
        findings.append(_material(body, light, isinstance(species, UnstableSpecies)))
    return findings


def displaced_cm3(species: Species) -> float:
    """Volume of the drawn body without fins at model length, cm³."""
    surface = species.surface
    x = np.linspace(0.0, surface.tail.begin, 200)
    tall = np.clip(along(surface.back, x) - along(surface.belly, x), 0.0, None)
    wide = np.clip(along(surface.width, x), 0.0, None)
    return float(np.trapezoid(0.5 * np.pi * tall * wide, x)) * species.length_cm**3


def _shape(surface: SurfacePlan) -> FishFinding:
    x = np.linspace(0.01, surface.tail.begin, 120)
    width = along(surface.width, x)
    if (width <= 0.0).any():
        at = float(x[int(np.argmin(width))])
        return _fault(f"The body has no width at {at:.2f}: raise the line in the top view.")
    for name, fin, ridge, sign in (
        ("dorsal", surface.dorsal, surface.back, 1.0),
        ("ventral", surface.ventral, surface.belly, -1.0),
    ):
        if fin:
            edge = np.array(fin.edge)
            above = sign * (edge[:, 1] - along(ridge, edge[:, 0]))
            if (above < 0.005).all():
                return _warning(f"The {name} fin lies inside the body: drag its edge outward.")
    return _good("The outline is whole: back above belly, and width all along.")


def check_faces(body: Body) -> FishFinding:
    """Check for hull faces that look inward, as after a ring passed another."""
    a, b, c = (body.rest[TRIANGLES[:, k]] for k in range(3))
    outward = (a + b + c) / 3 * (0.0, 1.0, 1.0)
    facing = (np.cross(b - a, c - a) * outward).sum(axis=1)
    wrong = np.flatnonzero(facing < -1e-6)
    if len(wrong):
        place = NODE_PLACES[int(TRIANGLES[wrong[0]].min())]
        return _fault(
            f"The scaffold is folded behind {place}: its faces look inward. "
            "Make the rings there more alike, or move them apart."
        )
    return _good("No ring is inverted: all 78 faces of the scaffold look outward.")


def _rings(body: BodyPlan, surface: SurfacePlan) -> FishFinding:
    at = np.array(body.stations[1:6]) / body.length
    half = np.minimum(along(surface.back, at), -along(surface.belly, at)) * body.length
    most = np.round(half * OUTSIDE, 2)
    over = np.round(body.half_heights, 2) - most
    ring = int(over.argmax())
    return judge(
        over[ring] <= 0.0,
        "The scaffold lies inside the outline, as far as fishes' do.",
        f"Ring {ring + 1} stands out of the body: {body.half_heights[ring]:.2f} cm against "
        f"{half[ring]:.2f} cm. Lower it in the side view to {most[ring]:.2f} cm.",
    )


def _buoyancy(body: BodyPlan, water: float) -> Iterator[FishFinding]:
    share = body.mass / water
    dense = body.mass / body.hull_volume
    masses = f"{body.mass:.0f} g on the nodes, {water:.0f} g of water displaced"
    other = "lighter" if share < 1.0 else "heavier"
    off = f"{abs(share - 1.0):.0%} {other} than the water it displaces"
    remedy = "Neutral, in tab Body, sets its masses."
    near = abs(share - 1.0) <= NEUTRAL
    way = "light: it would rise" if share < 1.0 else "heavy: it would sink"
    yield judge(
        AFLOAT[0] <= share <= AFLOAT[1],
        f"About neutrally buoyant: {masses}." if near else f"It is {off}: {masses}. {remedy}",
        f"Too {way}. There are {masses}; {remedy}",
    )
    low, high = DENSITIES
    if dense < 1.5 * low or dense > high / 1.5:
        limits = f"{low:g} to {high:g}"
        yield _warning(
            f"{dense:.1f} g for each cm³ between the nodes is near the limit of {limits}."
        )
    heart = float(np.average(body.stations, weights=np.multiply(body.masses, NODES_AT_STATION)))
    behind = round((heart - body.stations[2]) / body.length, 2) + 0.0  # no -0.00
    if behind < REAR:
        yield _warning(
            "Its weight lies too far forward: the fins push on ring 2, and the centre of mass "
            f"should lie {REAR:g} lengths behind it or more (now {behind:.2f}). "
            "Move mass to ring 3."
        )


def _material(body: Body, light: bool, unstable: bool) -> FishFinding:
    """Check that the simulation bears the body; a body that is not light is made softer."""
    limit, node = longest_step(body)
    longer = round(100 * (limit / STEP - 1))
    heavier = f"Make {NODE_PLACES[node]} heavier, or the units softer."
    remedy = heavier if light else "Make the units softer."
    if unstable:
        return _fault(f"Unstable: the simulation takes longer steps than the body bears. {remedy}")
    return judge(
        longer >= LEAST_STEP,
        f"Stable: it bears steps {longer}% longer than are taken.",
        f"The step of the simulation is only {longer}% below the longest that the body bears. "
        f"{remedy}",
    )


class SwimTrial(NamedTuple):
    """Measures of a test swim, and segments of the fish if it keeps its shape."""

    sound: bool
    strain: tuple[float, float]  # least and greatest length of a unit over its rest length
    worst: str  # the unit that came nearest to a limit
    sweep: float  # of the tail, body lengths
    step_cm: float  # greatest change of a muscle's length in one step
    motion: FishMotion | None
    advice: dict[str, str]  # by the name of a segment; that for the shape by ""


def try_swimming(muscles: Muscles) -> SwimTrial:
    """Swim fast from rest; then try all swims, and turns to both sides."""
    plan, swim = muscles.body, muscles.swim
    body, beat = build_body(plan), grade_contraction(swim, "fast")
    with np.errstate(all="ignore"):  # a body that loses its shape may end in NaN
        frames, state = _from_rest(body, beat, BEATS)
        strain, worst = _strain(body, frames, state)
        sound, motion, advice = is_sound(state), None, {}
        if not sound:
            advice[""] = _remedy(muscles, "fast")
        else:
            motion = try_motion(muscles)
            failed = [name for name in motion.failures if name.startswith("swim_")]
            if failed:
                grade = failed[-1].removeprefix("swim_")
                advice = dict.fromkeys(failed, _remedy(muscles, grade))
            gradual = motion.segments.get("turn_left_gradual")
            weak = gradual is not None and round(gradual.turn_deg) < LEAST_TURN_DEG
            if weak or "turn_left_gradual" in motion.failures:
                names = "turn_left_gradual", "turn_right_gradual"
                advice |= dict.fromkeys(names, _better_bend(body, muscles))
        return SwimTrial(
            sound=sound,
            strain=strain,
            worst=worst,
            sweep=sweep(frames[-swim.ticks_per_beat - 1 :], [UPPER_TAIL, LOWER_TAIL]) / plan.length,
            step_cm=contraction_step(body, beat),
            motion=motion,
            advice=advice,
        )


def swim_checks(swim: SwimTrial) -> list[FishFinding]:
    """Judge a test swim."""
    return list(_swim_findings(swim))


def _swim_findings(swim: SwimTrial) -> Iterator[FishFinding]:
    low, high = STRAIN_LIMITS
    if swim.motion is None:
        yield _fault(
            f"It loses its shape: {swim.worst} leaves {low:g} to {high:g} of its length at "
            f"rest. {swim.advice['']}"
        )
        return
    least, most = swim.strain
    within = f"{least:.2f} to {most:.2f} of their length"
    yield _good(f"It keeps its shape in fast swimming: units keep within {within}.")
    yield from motion_findings(swim.motion, swim.advice)
    if not SWEEP[0] <= round(swim.sweep, 2) <= SWEEP[1]:
        much = "little" if swim.sweep < SWEEP[0] else "far"
        usual = "fishes' sweep about 0.2"
        yield _warning(f"Its tail sweeps {much}: {swim.sweep:.2f} body lengths; {usual}.")
    if swim.step_cm > S_MAX * 1.01:
        yield _warning(
            f"Its muscles contract by {swim.step_cm:.3f} cm a step, faster than the {S_MAX:g} "
            "cm that muscles can. Contract less, or take more ticks a beat."
        )


def _remedy(muscles: Muscles, grade: str) -> str:
    """Say what makes a swim steady: the first of some changes that a trial bears out."""
    plan, swim, _ = muscles
    for share in WEAKER:
        weaker = structs.replace(swim, contraction=tuple(share * c for c in swim.contraction))
        if _is_steady(plan, weaker, grade):
            enough = f"{share:.0%} of the present contractions are enough"
            return f"Contract the swimming muscles less: {enough}."
    ring = int(np.argmin(plan.half_widths))
    for factor in WIDER:
        widths = list(plan.half_widths)
        widths[ring] = round(factor * widths[ring], 2)
        if _is_steady(structs.replace(plan, half_widths=tuple(widths)), swim, grade):
            return f"Make ring {ring + 1} wider in the top view: {widths[ring]:.2f} cm are enough."
    return (
        f"Neither weaker contractions nor a wider ring {ring + 1} help. Give it the material and "
        "masses of a species like it, or let `subsea-capture learn --body --gait` find them."
    )


def _is_steady(plan: BodyPlan, swim: SwimPlan, grade: str) -> bool:
    try:
        steady_beat(build_body(plan), grade_contraction(swim, grade))
    except (UserError, ValueError):  # ValueError: no such body
        return False
    return True


def _better_bend(body: Body, muscles: Muscles) -> str:
    """Say which contraction of the turning muscles makes a gradual turn, by trying some."""
    swim, bend = muscles.swim, max(muscles.turn.gradual)
    ticks = swim.at("medium").ticks_per_beat
    for tried in BENDS:
        frames, state = _from_rest(body, grade_contraction(swim, "medium", (tried, tried)), BEATS)
        heading = headings(frames[-ticks - 1 :])
        turned = float(heading[-1] - heading[0])
        if is_sound(state) and LEAST_TURN_DEG < turned < MOST_TURN_DEG:
            way = "less" if tried < bend else "more"
            return (
                f"Contract the turning muscles {way}. "
                f"A contraction of {tried:g} turns the fish by {turned:.0f}° a beat."
            )
    ring = int(np.argmin(muscles.body.half_widths)) + 1
    return f"No contraction of the turning muscles helps. Make ring {ring} wider in the top view."


def _from_rest(body: Body, beat: Floats, beats: int) -> tuple[Floats, BodyState]:
    """Nodes (T, 23, 3) by tick; the amplitude rises during the first beat."""
    state = at_rest(body)
    first = simulate(body, state, ease(np.arange(len(beat)) / len(beat))[:, None] * beat)
    rest = simulate(body, state, np.tile(beat, (beats - 1, 1)))
    return np.concatenate([first, rest]), state


def _strain(body: Body, frames: Floats, state: BodyState) -> tuple[tuple[float, float], str]:
    """Extremes of the strain, and the unit that came nearest to a limit."""
    i, j = UNITS.T
    ratio = np.linalg.norm(frames[:, j] - frames[:, i], axis=2) / body.length
    least, most = ratio.min(axis=0), ratio.max(axis=0)
    low, high = STRAIN_LIMITS
    near = np.where(
        np.isfinite(least), np.maximum((1 - least) / (1 - low), (most - 1) / (high - 1)), 9
    )
    unit = int(near.argmax())
    a, b = (NODE_PLACES[int(node)] for node in UNITS[unit])
    between = f"of {a}" if a == b else f"between {a} and {b}"
    return (float(state.watch[0]), float(state.watch[1])), f"a {UNIT_NAMES[KINDS[unit]]} {between}"
