"""Measure a repertoire against docs/developers/biomechanics-figures.md, or the plan of its spine.

Except for the timing, a muscle-driven fish is simulated again from the plans in the provenance.
"""

from collections.abc import Iterator

import numpy as np

from capture.inspection.gait import (
    entries,
    frame_cost,
    replay_cost,
    speed_kept,
    step_cost,
    swim_beats,
    turned,
)
from capture.inspection.targets import (
    Measure,
    Range,
    at_least,
    at_most,
    compare,
    limit_at_any_phase,
    limit_at_phase_0,
    within,
)
from capture.recording.record import (
    ROWED,
    Motion,
    spine_from_provenance,
)
from capture.recording.segment import motion_of_segment
from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.biomechanics.body import (
    LOWER_TAIL,
    UPPER_TAIL,
    Body,
    Floats,
    body_frame,
    build_body,
    to_world,
)
from subsea.biomechanics.controllers import S_MAX
from subsea.biomechanics.fins import (
    balance,
    contraction_step,
    pectoral_force,
    snout_bend,
    straightness,
    sweep,
)
from subsea.biomechanics.simulation import STILL, BodyState, at_rest, copy_state, simulate
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK
from subsea.biomechanics.trial import (
    Trial,
    beat_contraction,
    displacement,
    grade_contraction,
)
from subsea.fish.spine import SpinePlan
from subsea.fish.surface import SurfacePlan
from subsea.geometry.rotation import matrix
from subsea.repertoire import Repertoire, Segment
from subsea.repertoire.segments import run_trial, steady_contraction

STEADY_BEATS = 20
REPLAYED_CYCLES = 10
TURN_ANGLES = (30.0, 45.0, 60.0, 90.0)
FIN_AREA = 0.01  # area of a pectoral fin over the square of the body length
LEAN = np.radians(15.0)


def replay(segment: Segment, origin: Array, rotation: Array, cycles: int) -> Floats:
    """World nodes (cycles × T, 23, 3) of a segment replayed from a pose (SMC eqs. 10-12)."""
    turns = matrix(segment.increment_rotation)
    frames = []
    for _ in range(cycles):
        for turn, step, nodes in zip(
            turns, segment.increment_translation, segment.nodes, strict=True
        ):
            origin = origin + rotation @ step
            rotation = rotation @ turn
            frames.append(to_world(nodes, origin, rotation))
    return np.array(frames)


def measure_simulated(motion: Motion, repertoire: Repertoire) -> Iterator[Measure]:
    """All measures of a repertoire, each as soon as it is taken."""
    body = build_body(motion.body)
    length = motion.body.length
    trials = {name: run_trial(motion, name) for name in repertoire.segments if name not in ROWED}
    yield from _swimming(motion, body, trials)
    yield from _straightness(motion, body, trials["swim_fast"].state)
    yield from _attitude(motion, body, trials["swim_medium"].state)
    if motion.body.water == "tu":
        yield from _turning(motion, body, trials["swim_medium"].state)
    sharp = repertoire.segments["turn_left_sharp"].turn_deg - motion.turn.sharp
    name = f"recorded turn of {motion.turn.sharp:g}°"
    yield compare(name, sharp, "+.2f", "°", within(15), within(5))
    kept = speed_kept(body, trials["turn_left_sharp"].frames)
    yield Measure("speed kept in the sharp turn", f"{kept:.2f} ×")
    cyclic = [name for name, segment in repertoire.segments.items() if segment.cyclic]
    closure = max(repertoire.segments[name].loop_error_bl for name in cyclic)
    yield compare("loop closure, worst cycle", closure, ".1e", " L", at_most(1e-3), at_most(1e-5))
    error = max(
        _replay_error(motion, body, trials[name], repertoire.segments[name], name)
        for name in cyclic
        if name in trials and not repertoire.segments[name].slowing
    )
    name = f"{REPLAYED_CYCLES} cycles replayed against simulation"
    yield compare(name, error / length, ".1e", " L", at_most(0.01), at_most(1e-4))
    segment = repertoire.segments["swim_fast"]
    step = step_cost(body, trials["swim_fast"].state)
    nodes, frame = replay_cost(segment), frame_cost(segment)
    yield compare("one step of simulation", step, ".2f", " µs", at_most(5), at_most(2.5))
    yield compare("replay of 23 nodes", nodes, ".3f", " µs", at_most(0.15), at_most(0.06))
    yield compare("replay of a body frame", frame, ".3f", " µs", at_most(0.03), at_most(0.01))
    ratio = STEPS_PER_TICK * step / nodes
    yield Measure("a tick simulated over one replayed", f"{ratio:.0f} ×")


def _swimming(motion: Motion, body: Body, trials: dict[str, Trial]) -> Iterator[Measure]:
    length, ticks = motion.body.length, motion.swim.ticks_per_beat
    beat_tu = ticks * STEPS_PER_TICK * STEP
    speeds = {
        grade: float(np.linalg.norm(displacement(trials[f"swim_{grade}"].frames)))
        / (length * motion.swim.at(grade).ticks_per_beat)
        for grade in ("slow", "medium", "fast")
    }
    fast = speeds["fast"] * ticks
    rate = fast / beat_tu
    yield compare("fast swim, per beat", fast, ".3f", " L", at_least(0.35), at_least(0.5))
    yield compare("fast swim, per tu (0.1 s)", rate, ".4f", " L", at_least(0.08), at_least(0.1))
    s = contraction_step(body, beat_contraction(motion.swim, 1.0))
    yield compare("its contraction a step", s, ".4f", " cm", at_most(S_MAX))
    for slow, quick in (("slow", "medium"), ("medium", "fast")):
        ratio = speeds[quick] / speeds[slow]
        yield compare(f"{quick} over {slow}", ratio, ".2f", " ×", at_least(1.1), at_least(1.4))
    trial = trials["swim_fast"]
    tail = sweep(trial.frames, [UPPER_TAIL, LOWER_TAIL]) / length
    head = sweep(trial.frames, [0]) / length
    yield compare("tail sweep, fast", tail, ".3f", " L", Range(0.14, 0.25), Range(0.18, 0.22))
    yield Measure("head sweep, fast", f"{head:.3f} L")
    snout = snout_bend(trial.frames)
    yield Measure("bend of the snout, fast", f"{snout:.1f}°")
    yield compare("Strouhal number, fast", tail / fast, ".3f", "", at_most(0.55), at_most(0.45))


def _straightness(motion: Motion, body: Body, steady: BodyState) -> Iterator[Measure]:
    frames = swim_beats(body, copy_state(steady), beat_contraction(motion.swim, 1.0), STEADY_BEATS)
    drift, aside = straightness(frames, motion.swim.ticks_per_beat)
    name = f"drift of heading in {STEADY_BEATS} beats"
    yield compare(name, drift, ".4f", "°", at_most(1), at_most(0.1))
    yield compare("drift aside meanwhile", aside / motion.body.length, ".1e", " L", at_most(0.02))


def _attitude(motion: Motion, body: Body, steady: BodyState) -> Iterator[Measure]:
    beat = grade_contraction(motion.swim, "medium")
    lean = _mean_attitude(swim_beats(body, copy_state(steady), beat, STEADY_BEATS))
    yield compare("roll, pitch without fins", lean, ".4f", "°", at_most(0.1))
    tall = build_body(motion.body, back=1.1)
    lean = _balanced(motion, tall, at_rest(tall), 60)
    yield compare("the same, back 10% taller, balanced", lean, ".3f", "°", at_most(2), at_most(1))
    leaning = copy_state(steady)
    _lean(leaning, body.mass)
    lean = _balanced(motion, body, leaning, 40)
    yield compare(
        "40 beats after a roll of 15°, balanced", lean, ".3f", "°", at_most(2), at_most(1)
    )


def _mean_attitude(frames: Floats) -> tuple[float, float]:
    """Roll and pitch in degrees, positive, averaged over whole beats, as the frame sways."""
    rotation = body_frame(frames)[1]
    roll, pitch = (np.degrees(np.arcsin(np.mean(rotation[1:, 1, axis]))) for axis in (2, 0))
    return abs(float(roll)), abs(float(pitch))


def _lean(state: BodyState, mass: Floats) -> None:
    """Roll a swimming fish about its direction of motion."""
    velocity = mass @ state.v
    axis = velocity / np.linalg.norm(velocity)
    turn = matrix(np.concatenate([[np.cos(LEAN / 2)], np.sin(LEAN / 2) * axis]))
    state.x[:] = state.x @ turn.T
    state.v[:] = state.v @ turn.T


def _balanced(motion: Motion, body: Body, state: BodyState, count: int) -> tuple[float, float]:
    """Roll and pitch of the last of ``count`` beats swum at grade medium with balancing fins."""
    beat = grade_contraction(motion.swim, "medium")
    area = FIN_AREA * motion.body.length**2
    frames = []
    for _ in range(count):
        frames = [state.x.copy()]
        for tick in np.split(beat, len(beat) // STEPS_PER_TICK):
            force = pectoral_force(state, area, *balance(state), STILL)
            frames.extend(simulate(body, state, tick, force=force))
    return _mean_attitude(np.array(frames))


def _turned(body: Body, motion: Motion, angle: float, start: BodyState, phase: float) -> float:
    """The angle of a turn, degrees; NaN where the body loses its shape."""
    try:
        return turned(body, motion.swim, motion.turn, angle, start, phase)
    except UserError:
        return float("nan")


def _turning(motion: Motion, body: Body, steady: BodyState) -> Iterator[Measure]:
    starts = entries(body, motion.swim, steady)
    for angle in TURN_ANGLES:
        errors = [_turned(body, motion, angle, *start) - angle for start in starts]
        worst = errors[int(np.argmax(np.abs(errors)))]  # NaN, a body out of shape, is the worst
        entered, anywhere = limit_at_phase_0(angle), limit_at_any_phase(angle)
        aim = within(1) if angle <= 60 else within(3)
        name = f"turn of {angle:g}°"
        yield compare(f"{name}, entered at phase 0", errors[0], "+.2f", "°", entered, aim)
        yield compare(f"{name}, at the worst phase", worst, "+.2f", "°", anywhere, within(3))


def _replay_error(motion: Motion, body: Body, trial: Trial, segment: Segment, name: str) -> float:
    """Largest distance, cm, between some replayed cycles and the simulation."""
    origin, rotation = body_frame(trial.frames[-1])
    played = replay(segment, origin, rotation, REPLAYED_CYCLES)
    beat = steady_contraction(motion, name)
    swum = swim_beats(body, copy_state(trial.state), beat, REPLAYED_CYCLES)[1:]
    return float(np.linalg.norm(played - swum, axis=2).max())


def measure_spine_driven(repertoire: Repertoire) -> Iterator[Measure]:
    """Measures of a complete repertoire with the source `spine`.

    msgspec.ValidationError where the provenance holds no plan. Swimming speed has no target: it
    is part of the plan.
    """
    plan, surface = spine_from_provenance(repertoire.provenance)
    segments = repertoire.segments
    speeds = [segments[f"swim_{grade}"].speed_cm_s for grade in ("slow", "medium", "fast")]
    yield compare("medium over slow", speeds[1] / speeds[0], ".2f", " ×", at_least(1.4))
    yield compare("fast over medium", speeds[2] / speeds[1], ".2f", " ×", at_least(1.4))
    for grade, asked in (("gradual", plan.turn.gradual), ("sharp", plan.turn.sharp)):
        left, right = (segments[f"turn_{side}_{grade}"].turn_deg for side in ("left", "right"))
        name = f"{grade} turn of {asked:g}°, left and right"
        yield compare(name, (left - asked, -right - asked), "+.3f", "°", within(1), within(0.1))
    cyclic = [name for name, segment in segments.items() if segment.cyclic]
    closure = max(segments[name].loop_error_bl for name in cyclic)
    yield compare("loop closure, worst cycle", closure, ".1e", " L", at_most(1e-3), at_most(1e-5))
    errors = [_spine_replay_error(plan, surface, repertoire, name) for name in cyclic]
    name = f"{REPLAYED_CYCLES} cycles replayed against the plan"
    yield compare(name, max(errors) / plan.length, ".1e", " L", at_most(0.01), at_most(1e-4))
    nodes = motion_of_segment(plan, surface, "swim_fast").nodes
    tail = nodes[:, 21:].mean(axis=1)[:, 2]
    yield Measure("tail sweep, fast", f"{np.ptp(tail) / plan.length:.3f} L")


def _spine_replay_error(
    plan: SpinePlan, surface: SurfacePlan, repertoire: Repertoire, name: str
) -> float:
    """Largest error of a node after some cycles of replay, cm."""
    nodes = motion_of_segment(plan, surface, name).nodes
    origin, rotation = body_frame(nodes)
    replayed = replay(repertoire.segments[name], origin[0], rotation[0], REPLAYED_CYCLES)[-1]
    # Each cycle moves the fish by the same rigid motion.
    turn = rotation[-1] @ rotation[0].T
    step = origin[-1] - turn @ origin[0]
    last = nodes[-1]
    for _ in range(REPLAYED_CYCLES - 1):
        last = last @ turn.T + step
    return float(np.linalg.norm(replayed - last, axis=1).max())
