"""Run the directions of a scenario in each tick (Tu §11.6.1, "Higher Directability").

A direction moves no fish directly. It changes hunger, fear, a destination or the like, and the
fish acts accordingly. All progress is in `state.Directions`, so that snapshots, rewinding and
clusters include it. Of direction `k` of `scenario.direction`, a reader finds there:

- `began[k]`, the tick in which it last began, -1 for never: captions and cameras go by it;
- `times[k]`, how often it has begun: a difference between two ticks is an event;
- `cast[k]` (2,), the fishes involved, NOBODY or SUBMARINE. "courting", "spawned" and
  `pair`: male and female; "eaten": prey and predator; "caught", "sated": the fish; "fleeing":
  the fish and its predator; "hunting": hunter and prey; "passes": the passing fish. Without
  an event: those of the preceding direction;
- `running[k]`, True while it acts, and `ceded[k]`, the influences that later directions took over.
"""

import numpy as np

from subsea.directing.events import cast_of, triggered_cast
from subsea.directing.influences import advance, start
from subsea.directing.script import DirectingContext, Script
from subsea.scenario.schema import Scenario
from subsea.state import NOBODY, Clock, Nature, State


def direct(
    script: Script, state: State, nature: Nature, current_cm_s: tuple[float, float], clock: Clock
) -> None:
    """Start the directions that are due, and advance those that run."""
    if not script.cues:
        return
    context, log = DirectingContext(script, state, nature, current_cm_s, clock), state.directions
    for k in script.order:
        if (cast := triggered_cast(context, k)) is not None:
            start(context, k, cast)
    for k in np.argsort(log.began, kind="stable"):
        if log.running[k]:
            log.running[k] = advance(context, int(k))
    log.alive[:], log.courtship[:] = state.fishes.alive, state.minds.courtship


def cue(context: DirectingContext, k: int) -> None:
    """Start direction k in the coming tick, whatever its conditions.

    Its fishes are those of its event, if that happens now, else nobody.
    """
    start(context, k, cast_of(context, k) or (NOBODY, NOBODY))


def latest(scenario: Scenario, state: State, what: str) -> int | None:
    """Index of the direction with an influence, such as "camera", that began last.

    Of several in the same tick the last of the file; None if none has begun.
    """
    began = [
        (int(state.directions.began[k]), k)
        for k, one in enumerate(scenario.direction)
        if getattr(one, what) is not None and state.directions.began[k] >= 0
    ]
    return max(began)[1] if began else None
