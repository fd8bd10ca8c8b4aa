"""Judge the motion of a fish by its recorded segments, in sentences that say what to do.

Learning, recording and the fish builder show the same list.
"""

from collections.abc import Mapping
from enum import IntEnum
from functools import partial
from itertools import pairwise
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from subsea.base.errors import UserError
from subsea.biomechanics.body import Floats
from subsea.biomechanics.body_plan import GRADES, Muscles
from subsea.biomechanics.manoeuvres import sketched_turn
from subsea.biomechanics.solver import TICK_S
from subsea.geometry.rotation import matrix
from subsea.repertoire.schema import SEGMENTS, Segment
from subsea.repertoire.segments import make_segment, run_trial


class Severity(IntEnum):
    """Severity of a finding."""

    GOOD = 0
    WARNING = 1  # it works, but not well
    FAULT = 2  # it will not work


class FishFinding(NamedTuple):
    """A sentence about the fish."""

    severity: Severity
    text: str


STRAIGHT_DEG = 0.1  # by which a swim may turn or roll in a beat
SWAY_DEG = 10.0  # by which a fish may roll to each side within a beat
PER_BEAT = 0.35  # body lengths in fast swimming: docs/developers/biomechanics-figures.md
FASTER = 1.05  # least ratio of the speeds of two grades
LEAST_TURN_DEG = 10.0  # of a gradual turn, by beat
LEAST_CYCLE_DEG = {"gradual": LEAST_TURN_DEG, "row": 4.0, "coast": 1.0}  # of turns that go on
LEAST_SHARP_DEG = 20.0  # of any other turn
SIDES = ("left", "right")
TURNS = {
    "gradual": "gradual turn",
    "sharp": "sharp turn",
    "rest": "turn from rest",
    "glide": "turn from a glide",
    "moderate": "moderate escape",
    "wide": "wide escape",
    "coast": "turn in a coast",
    "row": "rowing turn",
}
CYCLES = {"gradual": " a beat", "row": " a stroke", "coast": " in four ticks"}
CALM = "Contract the swimming muscles less, or let Learn find a calmer gait."

_good, _warning, _fault = (partial(FishFinding, severity) for severity in Severity)


def judge(passed: bool, good: str, bad: str) -> FishFinding:
    """Return a good finding if `passed`, else a warning."""
    return _good(good) if passed else _warning(bad)


class FishMotion(NamedTuple):
    """The segments of a fish by name, and why others could not be recorded."""

    segments: Mapping[str, Segment]
    length_cm: float
    failures: Mapping[str, str] = MappingProxyType({})


def motion_findings(
    motion: FishMotion, advice: Mapping[str, str] = MappingProxyType({})
) -> list[FishFinding]:
    """Judge the motion of a fish; `advice` by the name of a segment replaces the usual one."""
    segments, length_cm, failures = motion
    swims = {name: segments[name] for name in map("swim_{}".format, GRADES) if name in segments}
    findings = [
        *(
            _fault(f"The {words_of(name)} fails: {why}. {advice.get(name, CALM)}")
            for name, why in failures.items()
        ),
        *_courses(swims),
        *_speeds(swims, length_cm),
    ]
    for name in SEGMENTS:
        if name in segments and name.split("_")[1] in SIDES:
            findings += _turn(name, segments[name], advice)
    return _joined(findings)


def words_of(name: str) -> str:
    """Name a segment as texts do: `medium swim`, `sharp turn to the left`."""
    kind, *more = name.split("_")
    if kind == "swim":
        return f"{more[0]} swim"
    return f"{TURNS[more[1]]} to the {more[0]}" if len(more) == 2 else name.replace("_", " ")


def _courses(swims: Mapping[str, Segment]) -> list[FishFinding]:
    """Find swims that turn or roll."""
    findings = []
    for name, segment in swims.items():
        rolls = _rolled(segment)
        turn, roll = (round(float(degrees), 1) for degrees in (segment.turn_deg, rolls[-1]))
        sway = round(float(np.ptp(rolls)) / 2, 1)
        faults = {
            f"turns by {turn:+g}° a beat": abs(turn) > STRAIGHT_DEG,
            f"rolls over by {roll:+g}° a beat": abs(roll) > STRAIGHT_DEG,
            f"rolls by {sway:g}° to each side": sway > SWAY_DEG,
        }
        if any(faults.values()):
            words = " and ".join(fault for fault, true in faults.items() if true)
            findings.append(_warning(f"The {words_of(name)} {words}. {CALM}"))
    if swims and not findings:
        grades = ", ".join(words_of(name).split()[0] for name in swims)
        findings.append(_good(f"It swims straight and upright: {grades}."))
    return findings


def _rolled(segment: Segment) -> Floats:
    """Roll (T,) since the segment began, degrees."""
    rotation, rolls = np.eye(3), []
    for turn in matrix(segment.increment_rotation):
        rotation = rotation @ turn
        rolls.append(np.degrees(np.arctan2(rotation[1, 2], rotation[1, 1])))
    return np.array(rolls)


def _speeds(swims: Mapping[str, Segment], length_cm: float) -> list[FishFinding]:
    """Find a slow fast swim, and grades that are hardly faster than the grade below."""
    findings = []
    if fast := swims.get("swim_fast"):
        speed = fast.speed_cm_s / length_cm
        beat = round(speed * len(fast.nodes) * TICK_S, 2)
        words = f"{speed:.2f} body lengths a second, {beat:.2f} a beat"
        findings.append(
            judge(
                beat >= PER_BEAT,
                f"It swims {words}.",
                f"It swims slowly: {words}; {PER_BEAT:g} a beat are expected. Learn finds better "
                "controllers.",
            )
        )
    names = list(swims)
    for below, above in pairwise(names):
        ratio = round(swims[above].speed_cm_s / max(swims[below].speed_cm_s, 1e-9), 2)
        if ratio < FASTER:
            findings.append(
                _warning(
                    f"The {words_of(above)} is only {ratio:.2f} times as fast as the "
                    f"{words_of(below)}. Learn sets the amplitudes by the speeds."
                )
            )
    return findings


def _turn(name: str, segment: Segment, advice: Mapping[str, str]) -> list[FishFinding]:
    """Judge a turn or an escape."""
    cycle = CYCLES.get(segment.grade, "")
    turned = segment.turn_deg * (1.0 if "left" in name else -1.0)
    least = LEAST_CYCLE_DEG[segment.grade] if cycle else LEAST_SHARP_DEG
    by = f"{round(abs(turned))}°{cycle}"
    remedy = advice.get(name, "Contract the turning muscles more." if cycle else CALM)
    if round(turned) < 0:
        return [_fault(f"A {words_of(name)} turns the wrong way, by {by}. {remedy}")]
    if round(turned) < least:
        return [
            _warning(
                f"A {words_of(name)} turns the fish by {by}; {least:g}° are expected. {remedy}"
            )
        ]
    return [_good(f"A {words_of(name)} turns the fish by {by}.")]


def _joined(findings: list[FishFinding]) -> list[FishFinding]:
    """Say once what holds to both sides: turns to the right are often mirrored."""
    texts = {text for _, text in findings}
    out = []
    for severity, text in findings:
        if text.replace(" to the right", " to the left") in texts and " to the right" in text:
            continue
        if text.replace(" to the left", " to the right") in texts and " to the left" in text:
            text = text.replace(" to the left", " to either side")
        out.append(FishFinding(severity, text))
    return out


def try_motion(muscles: Muscles) -> FishMotion:
    """Record all swims, and the gradual and sharp turns to both sides, as recording does.

    Only the first sharp turns are tried of those that a recording searches.
    """
    names = [f"swim_{grade}" for grade in muscles.swim.grades]
    names += [f"turn_{side}_{grade}" for grade in ("gradual", "sharp") for side in SIDES]
    length, failures = muscles.body.length, dict[str, str]()
    segments = dict[str, Segment]()
    for name in names:
        _, *side, grade = name.split("_")
        if side and "swim_medium" in failures:
            continue  # turns begin with that swim
        sharp = grade == "sharp"
        try:
            frames = (sketched_turn if sharp else run_trial)(muscles, name).frames
        except UserError as fault:
            failures[name] = str(fault)
            continue
        pattern = side[0] if side else "forward"
        segments[name] = make_segment(frames, length, pattern, grade, not sharp)
    return FishMotion(segments, length, failures)


def complaints(motion: FishMotion) -> list[str]:
    """List what is not good in the motion of a fish, the worst first."""
    bad = [finding for finding in motion_findings(motion) if finding.severity]
    return [text for _, text in sorted(bad, key=lambda finding: -finding.severity)]
