"""Fit the amplitudes of the grades, so that the tail beats about as far at each of them."""

import msgspec
import numpy as np

from capture.learning.lifelike import Wave, swim_and_measure
from capture.recording.trial import beat_contraction
from subsea.base.errors import UserError
from subsea.biomechanics.body import Body
from subsea.biomechanics.body_plan import MAX_CONTRACTION, SwimPlan
from subsea.biomechanics.controllers import S_MAX
from subsea.biomechanics.gait import contraction_step

TAIL = {"slow": 0.8, "medium": 0.9, "burst": 1.0}  # amplitude of the tail over that at fast
ROUNDS, NEAR = 5, 0.02  # of the fit, and share by which a grade may miss its amplitude


def with_amplitudes(body: Body, swim: SwimPlan) -> SwimPlan:
    """The plan with amplitudes that move the tail as TAIL says, within what muscles can do.

    UserError where the body loses its shape.
    """
    aim = _wave(body, swim, "fast").tail
    found = {}
    for grade in (grade for grade in swim.grades if grade != "fast"):
        most = _greatest(body, swim, grade)
        amplitude = min(swim.amplitude(grade), most)
        for _ in range(ROUNDS):
            gear = msgspec.structs.replace(swim, **{grade: amplitude})
            ratio = TAIL[grade] * aim / _wave(body, gear, grade).tail
            better = round(min(most, amplitude * float(np.clip(ratio, 0.5, 2.0))), 3)
            if abs(ratio - 1.0) <= NEAR or better == amplitude:
                break
            amplitude = better
        found[grade] = amplitude
    return msgspec.structs.replace(swim, **found)


def grade_waves(body: Body, swim: SwimPlan) -> dict[str, Wave]:
    """Measures of every grade; UserError where the body loses its shape."""
    return {grade: _wave(body, swim, grade) for grade in swim.grades}


def _wave(body: Body, swim: SwimPlan, grade: str) -> Wave:
    """Measures of a grade, swum from rest."""
    rng = np.random.default_rng(0)
    wave, _, _ = swim_and_measure(body, swim.at(grade), swim.amplitude(grade), 0.0, rng)
    if wave is None:
        raise UserError(f"it loses its shape at grade {grade}")
    return wave


def _greatest(body: Body, swim: SwimPlan, grade: str) -> float:
    """The greatest amplitude of a grade: by speed and share of contraction, and that of fast."""
    step = contraction_step(body, beat_contraction(swim.at(grade), 1.0))
    share = MAX_CONTRACTION / max(*swim.contraction, 1e-3)
    most = min(S_MAX / max(step, 1e-6), share, 1.0)
    return float(np.floor(1000 * most) / 1000)
