"""Learn a swim controller: its contractions, lag and ticks of a beat, and from them its grades."""

from collections.abc import Iterator
from itertools import islice

import msgspec
import numpy as np

from capture.learning.fitness import UNSOUND, gait_faults, swim_faults, swim_loss
from capture.learning.search import Optimizer, distinct
from capture.recording.trial import speed_map
from subsea.biomechanics.body import MUSCLES, Body, Floats
from subsea.biomechanics.body_plan import SwimPlan
from subsea.biomechanics.controllers import S_MAX, swim_amplitude
from subsea.biomechanics.solver import STEPS_PER_TICK
from subsea.core.errors import UserError

TICKS = (8, 24)
"""Ticks of a beat that are searched, unless the number is given."""
STRONGEST = 0.6
"""Greatest contraction, as in the species file."""
LAGS = (0.0, 3.2)
GRADES = (1 / 1.5**2, 1 / 1.5)
"""Speeds of slow and medium relative to fast."""
BETTER = 0.002
"""By how much a winner's loss must lie below the old one's."""
VERIFIED = 12
"""Candidates of a search that are verified at most."""


def verified_swims(
    body: Body,
    old: SwimPlan,
    ticks: int | None,
    thrift: float,
    seed: int,
    hunt: Optimizer[SwimPlan],
    notes: list[str],
) -> Iterator[SwimPlan]:
    """Verified swim controllers that beat the old one, best first; ``notes`` tell the others."""
    start = swim_point(body, old)
    tried = hunt(
        lambda swim: swim_loss(body, swim, seed, thrift),
        lambda point: swim_at(body, old, point, ticks),
        start if ticks is None else start[:3],
    )
    faults = swim_faults(body, old, seed)
    bound = swim_loss(body, old, seed, thrift)
    if faults:
        bound = UNSOUND
        notes.append(f"swim: the old controller is faulty: {faults[0]}")
    better = (one for one in distinct(tried) if one.loss < bound - BETTER)
    for one in islice(better, VERIFIED):
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
    """The point (4,) of the unit box at which a swim controller lies, see :func:`swim_at`."""
    low, high = LAGS
    return np.array(
        [
            *(np.array(swim.contraction) / strongest(body, swim.ticks_per_beat)),
            (swim.lag - low) / (high - low),
            (swim.ticks_per_beat + 0.5 - TICKS[0]) / (TICKS[1] + 1 - TICKS[0]),
        ]
    )


def swim_at(
    body: Body, base: SwimPlan, point: Floats | tuple[float, ...], ticks: int | None = None
) -> SwimPlan:
    """The swim controller at a point of the unit box; grades are those of ``base``.

    Contractions are shares of the greatest that keeps to S_MAX, then the lag and, unless it is
    given, the ticks of a beat. Numbers are rounded as they are written.
    """
    if ticks is None:
        ticks = min(int(TICKS[0] + point[3] * (TICKS[1] + 1 - TICKS[0])), TICKS[1])
    # Rounded down, or the strongest stroke would be too fast.
    front, back = np.floor(1000 * np.array(point[:2]) * strongest(body, ticks)) / 1000
    low, high = LAGS
    return msgspec.structs.replace(
        base,
        ticks_per_beat=ticks,
        contraction=(float(front), float(back)),
        lag=round(float(low + point[2] * (high - low)), 3),
    )


def strongest(body: Body, ticks: int) -> Floats:
    """The greatest contractions (2,) of the swimming segments with beats of ``ticks`` ticks.

    A sine of contraction c on a muscle of length l over n steps is steepest with c l sin(π/n).
    """
    lengths = body.length[:MUSCLES].reshape(3, 4).max(axis=1)[1:]
    return np.minimum(STRONGEST, S_MAX / (lengths * np.sin(np.pi / (ticks * STEPS_PER_TICK))))


def with_grades(body: Body, swim: SwimPlan) -> SwimPlan:
    """The controller with amplitudes of slow and medium that make them clearly slower grades.

    Raises UserError where the body does not swim steadily at any amplitude.
    """
    speeds = speed_map(body, swim)
    if not (np.diff(speeds.speed) > 0).all():
        raise UserError("its speed does not rise with the amplitude")
    slow, medium = swim_amplitude(speeds, np.array(GRADES) * speeds.speed[-1])
    return msgspec.structs.replace(swim, slow=round(float(slow), 3), medium=round(float(medium), 3))
