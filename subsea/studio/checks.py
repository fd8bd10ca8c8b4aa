"""Checks of an edited species, as sentences that say what to do.

`static_checks` read the numbers; `swim_checks` judge a test swim with the fish's own controllers.
"""

from enum import IntEnum
from functools import partial
from typing import NamedTuple

import numpy as np

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
from subsea.biomechanics.body_plan import (
    DENSITIES,
    NODES_AT_STATION,
    BodyPlan,
    Muscles,
    SwimPlan,
)
from subsea.biomechanics.controllers import (
    LEFT,
    S_MAX,
    bend_contraction,
    ease,
    swim_contraction,
)
from subsea.biomechanics.fins import contraction_step, headings, straightness, sweep
from subsea.biomechanics.simulation import BodyState, at_rest, is_sound, simulate
from subsea.biomechanics.solver import (
    STEP,
    STEPS_PER_TICK,
    STRAIN_LIMITS,
    TICK_S,
    longest_step,
)
from subsea.fish.species import Species
from subsea.fish.surface import SurfacePlan, along


class Severity(IntEnum):
    """Severity of a finding."""

    GOOD = 0
    WARNING = 1  # it works, but not well
    FAULT = 2  # it will not work


class FishFinding(NamedTuple):
    """A sentence about the fish."""

    severity: Severity
    text: str


GOOD, WARNING, FAULT = Severity
AFLOAT = (0.7, 1.4)  # mass over mass of the displaced water
NEUTRAL = 0.1  # deviation of this from 1 that counts as neutrally buoyant
LEAST_STEP = 1.05  # longest stable step over the step of the simulation
OUTSIDE = (1.05, 1.05, 1.05, 1.3, 1.8)  # usual height of rings over that of the outline
REAR = 0.02  # body lengths from the fins back to the centre of mass
PER_BEAT = 0.35  # body lengths in fast swimming: docs/developers/biomechanics-figures.md
DRIFT_DEG, ASIDE = 1.0, 0.02  # in the measured beats
BEATS, MEASURED = 40, 10  # of a test swim; the last ones are measured
SWEEP = (0.12, 0.3)  # of the tail, body lengths
LEAST_TURN_DEG = 10.0  # of a gradual turn, by beat
UNIT_NAMES = ("muscle", "cross unit", "unit")
NODE_PLACES = (
    "the nose",
    *(f"ring {ring}" for ring in range(1, 6) for _ in range(4)),
    *["the tail"] * 2,
)


_good, _warning, _fault = (partial(FishFinding, severity) for severity in Severity)


def _judge(passed: bool, good: str, bad: str) -> FishFinding:
    """A good finding if `passed`, else a warning."""
    return _good(good) if passed else _warning(bad)


def static_checks(species: Species) -> list[FishFinding]:
    """Check shape, scaffold, buoyancy and material."""
    findings = [_shape(species.surface)]
    if species.body:
        body = build_body(species.body)
        findings += [check_faces(body), _rings(species.body, species.surface)]
        findings += [*_buoyancy(species.body, displaced_cm3(species)), _material(body)]
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
    over = np.array(body.half_heights) / np.maximum(half, 1e-6) / OUTSIDE
    ring = int(over.argmax())
    return _judge(
        over[ring] <= 1.0,
        "The scaffold lies inside the outline, as far as fishes' do.",
        f"Ring {ring + 1} stands out of the body: {body.half_heights[ring]:.2f} cm against "
        f"{half[ring]:.2f} cm. Lower it in the side view.",
    )


def _buoyancy(body: BodyPlan, water: float) -> list[FishFinding]:
    share = body.mass / water
    dense = body.mass / body.hull_volume
    masses = f"{body.mass:.0f} g on the nodes, {water:.0f} g of water displaced"
    other = "lighter" if share < 1.0 else "heavier"
    off = f"{abs(share - 1.0):.0%} {other} than the water it displaces"
    remedy = "Neutral, in tab Body, sets its masses."
    near = abs(share - 1.0) <= NEUTRAL
    way = "light: it would rise" if share < 1.0 else "heavy: it would sink"
    findings = [
        _judge(
            AFLOAT[0] <= share <= AFLOAT[1],
            f"About neutrally buoyant: {masses}." if near else f"It is {off}: {masses}. {remedy}",
            f"Too {way}. There are {masses}; {remedy}",
        )
    ]
    low, high = DENSITIES
    if dense < 1.5 * low or dense > high / 1.5:
        findings.append(
            _warning(
                f"{dense:.1f} g for each cm³ between the nodes is near the limit of "
                f"{low:g} to {high:g}."
            )
        )
    heart = float(np.average(body.stations, weights=np.multiply(body.masses, NODES_AT_STATION)))
    behind = (heart - body.stations[2]) / body.length
    if behind < REAR:
        findings.append(
            _warning(
                "Its weight lies too far forward: the fins push on ring 2, and the centre of mass "
                f"should lie {REAR:g} lengths behind it or more (now {behind:.2f}). "
                "Move mass to ring 3."
            )
        )
    return findings


def _material(body: Body) -> FishFinding:
    limit, node = longest_step(body)
    percent = f"{100 * (limit / STEP - 1):.0f}%"
    return _judge(
        limit / STEP >= LEAST_STEP,
        f"Stable: it bears steps {percent} longer than are taken.",
        f"The step of the simulation is only {percent} below the longest that the body bears. "
        f"Make {NODE_PLACES[node]} heavier, or the units softer.",
    )


class SwimTrial(NamedTuple):
    """Measures of a test swim."""

    sound: bool
    strain: tuple[float, float]  # least and greatest length of a unit over its rest length
    worst: str  # the unit that came nearest to a limit
    speed_bl_s: float
    per_beat: float  # body lengths
    drift_deg: float  # change of heading over the measured beats
    aside: float  # off the straight line, body lengths
    sweep: float  # of the tail, body lengths
    turned_deg: float  # by beat in a gradual turn to the left; NaN if it lost its shape
    step_cm: float  # greatest change of a muscle's length in one step


def beat_of(swim: SwimPlan, grade: str = "fast") -> Floats:
    """Contractions (6 T, 12) of a beat of a grade from phase 0."""
    swim, amplitude = swim.at(grade), swim.amplitude(grade)
    steps = swim.ticks_per_beat * STEPS_PER_TICK
    return swim_contraction(swim, 2 * np.pi * np.arange(steps) / steps, amplitude)


def try_swimming(muscles: Muscles) -> SwimTrial:
    """Swim fast from rest; then turn gradually at medium speed."""
    plan, swim, _ = muscles
    body, beat, ticks = build_body(plan), beat_of(swim), swim.ticks_per_beat
    with np.errstate(all="ignore"):  # a body that loses its shape may end in NaN
        frames, state = _from_rest(body, beat, BEATS)
        measured = frames[-MEASURED * ticks - 1 :]
        strain, worst = _strain(body, frames, state)
        way = float(np.linalg.norm((measured[-1] - measured[0]).mean(axis=0)))
        per_beat = way / MEASURED / plan.length
        drift, aside = straightness(measured, ticks)
        return SwimTrial(
            sound=is_sound(state),
            strain=strain,
            worst=worst,
            speed_bl_s=per_beat / (ticks * TICK_S),
            per_beat=per_beat,
            drift_deg=drift,
            aside=aside / plan.length,
            sweep=sweep(measured[-ticks - 1 :], [UPPER_TAIL, LOWER_TAIL]) / plan.length,
            turned_deg=_turned(body, muscles),
            step_cm=contraction_step(body, beat),
        )


def swim_checks(swim: SwimTrial, muscles: Muscles) -> list[FishFinding]:
    """Judge a test swim."""
    low, high = STRAIN_LIMITS
    if not swim.sound:
        return [
            _fault(
                f"It loses its shape: {swim.worst} leaves {low:g} to {high:g} of its length at "
                "rest. Contract the muscles less, or make the ring there wider."
            )
        ]
    speed = f"{swim.speed_bl_s:.2f} body lengths a second, {swim.per_beat:.2f} a beat"
    findings = [
        _good(
            "It keeps its shape in fast swimming: units keep within "
            f"{swim.strain[0]:.2f} to {swim.strain[1]:.2f} of their length."
        ),
        _judge(
            swim.per_beat >= PER_BEAT,
            f"It swims {speed}.",
            f"It swims slowly: {speed}; {PER_BEAT:g} a beat are asked. Learn finds better "
            "controllers.",
        ),
        _judge(
            swim.drift_deg <= DRIFT_DEG and swim.aside <= ASIDE,
            f"It swims straight: {swim.drift_deg:.2f}° of drift.",
            f"It drifts by {swim.drift_deg:.1f}° in {MEASURED} beats: it has not settled. Raise "
            "the viscosity a little.",
        ),
    ]
    if not SWEEP[0] <= swim.sweep <= SWEEP[1]:
        much = "little" if swim.sweep < SWEEP[0] else "far"
        findings.append(
            _warning(
                f"Its tail sweeps {much}: {swim.sweep:.2f} body lengths; fishes' sweep about 0.2."
            )
        )
    if np.isfinite(swim.turned_deg):
        turns = f"A gradual turn turns it by {swim.turned_deg:.0f}° a beat"
        findings.append(
            _judge(
                swim.turned_deg >= LEAST_TURN_DEG,
                f"{turns}.",
                f"{turns}; {LEAST_TURN_DEG:g}° are asked. Contract the turning muscles more.",
            )
        )
    else:
        findings.append(
            _fault("It loses its shape in a gradual turn. Contract the turning muscles less.")
        )
    if swim.step_cm > S_MAX * 1.01:
        findings.append(
            _warning(
                f"Its muscles contract by {swim.step_cm:.3f} cm a step, faster than the {S_MAX:g} "
                "cm that muscles can. Contract less, or take more ticks a beat."
            )
        )
    return findings


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


def _turned(body: Body, muscles: Muscles) -> float:
    """Change of the mean heading by beat of a gradual turn to the left, degrees.

    The other turns need no check: recording finds bends and a couple that suit the body.
    """
    _, swim, turn = muscles
    beat = beat_of(swim, "medium") + bend_contraction(turn.gradual, LEFT)
    frames, state = _from_rest(body, beat, BEATS)
    if not is_sound(state):
        return float("nan")
    ticks = swim.at("medium").ticks_per_beat
    heading = headings(frames[-(MEASURED + 1) * ticks :])
    return float(heading[-ticks:].mean() - heading[:ticks].mean()) / MEASURED
