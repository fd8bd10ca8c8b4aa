"""Learn a swim controller: contractions, lag and ticks of a beat, and its grades."""

from collections.abc import Iterator, Sequence
from itertools import islice

import msgspec
import numpy as np

from capture.learning.fitness import UNSOUND, gait_faults, swim_faults, swim_loss
from capture.learning.search import Optimizer, distinct
from subsea.base.errors import UserError
from subsea.biomechanics.body import MUSCLES, Body, Floats
from subsea.biomechanics.body_plan import SwimPlan
from subsea.biomechanics.controllers import S_MAX, swim_amplitude
from subsea.biomechanics.solver import STEPS_PER_TICK
from subsea.biomechanics.trial import speed_map

TICKS_PER_BEAT = (8, 24)  # range of the search, unless the number is given
MAX_CONTRACTION = 0.6  # limit of the species file
LAGS = (0.0, 3.2)
GRADES = (1 / 1.5**2, 1 / 1.5)  # speeds of slow and medium relative to fast
MIN_GAIN = 0.002  # least improvement of the loss over the old controller
MAX_VERIFIED = 12  # most candidates of a search that are verified


def verified_swims(
    body: Body,
    old: SwimPlan,
    ticks: int | None,
    economy: float,
    seed: int,
    optimize: Optimizer[SwimPlan],
    notes: list[str],
) -> Iterator[SwimPlan]:
    """Verified swim controllers better than the old one, best first; ``notes`` collects faults."""
    start = swim_point(body, old)
    tried = optimize(
        lambda swim: swim_loss(body, swim, seed, economy),
        lambda point: swim_at(body, old, point, ticks),
        start if ticks is None else start[:3],
    )
    faults = swim_faults(body, old, seed)
    bound = swim_loss(body, old, seed, economy)
    if faults:
        bound = UNSOUND
        notes.append(f"swim: the old controller is faulty: {faults[0]}")
    better = (one for one in distinct(tried) if one.loss < bound - MIN_GAIN)
    for one in islice(better, MAX_VERIFIED):
        swim = swim_at(body, old, one.point, ticks)
        faults = gait_faults(body, swim)
        if not faults:
            try:
                swim = with_grades(body, swim)
                faults = swim_faults(body, swim, seed)
            except UserError as fault:
                faults = [str(fault)]
        if faults:
            notes.append(f"swim: rejected: {faults[0]}")
        else:
            yield swim


def swim_point(body: Body, swim: SwimPlan) -> Floats:
    """The point (4,) of a swim controller in the unit box, the inverse of :func:`swim_at`."""
    return beat_point(body, swim.contraction, swim.lag, swim.ticks_per_beat, TICKS_PER_BEAT)


def swim_at(
    body: Body, base: SwimPlan, point: Floats | tuple[float, ...], ticks: int | None = None
) -> SwimPlan:
    """The swim controller at a point of the unit box, with the grades of ``base``, rounded.

    The point holds both contractions as fractions of the greatest within S_MAX, the lag and,
    unless given, the ticks of a beat.
    """
    contraction, lag, ticks = beat_at(body, point, TICKS_PER_BEAT, ticks)
    return msgspec.structs.replace(base, ticks_per_beat=ticks, contraction=contraction, lag=lag)


def beat_point(
    body: Body, contraction: Sequence[float] | Floats, lag: float, ticks: int, span: tuple[int, int]
) -> Floats:
    """The point (4,) of a beat in the box of beats of ``span`` ticks, the inverse of beat_at."""
    (low, high), (fewest, most) = LAGS, span
    return np.array(
        [
            *(np.array(contraction) / max_contractions(body, ticks)),
            (lag - low) / (high - low),
            (ticks + 0.5 - fewest) / (most + 1 - fewest),
        ]
    )


def beat_at(
    body: Body,
    point: Floats | tuple[float, ...],
    span: tuple[int, int],
    ticks: int | None = None,
) -> tuple[tuple[float, float], float, int]:
    """The contractions, lag and, unless given, ticks of the beat at a point."""
    (low, high), (fewest, most) = LAGS, span
    if ticks is None:
        ticks = min(int(fewest + point[3] * (most + 1 - fewest)), most)
    # Rounded down, so that the strongest beat keeps S_MAX.
    front, back = np.floor(1000 * np.array(point[:2]) * max_contractions(body, ticks)) / 1000
    return (float(front), float(back)), round(float(low + point[2] * (high - low)), 3), ticks


def max_contractions(body: Body, ticks: int) -> Floats:
    """The greatest contractions (2,) of the swimming segments in a beat of ``ticks`` ticks.

    A sine of contraction c on a muscle of length l over n steps is steepest with c l sin(π/n).
    """
    lengths = body.length[:MUSCLES].reshape(3, 4).max(axis=1)[1:]
    return np.minimum(MAX_CONTRACTION, S_MAX / (lengths * np.sin(np.pi / (ticks * STEPS_PER_TICK))))


def with_grades(body: Body, swim: SwimPlan) -> SwimPlan:
    """Set slow and medium to fixed fractions of the fast speed; UserError without steady gaits."""
    speeds = speed_map(body, swim)
    if not (np.diff(speeds.speed) > 0).all():
        raise UserError("its speed does not rise with the amplitude")
    slow, medium = swim_amplitude(speeds, np.array(GRADES) * speeds.speed[-1])
    return msgspec.structs.replace(swim, slow=round(float(slow), 3), medium=round(float(medium), 3))
