"""What a scenario's directions do to its world, tick by tick (Tu §11.6.1, "Higher Directability").

A direction moves nobody: it puts something into a mind, an appetite, a fright, a place to be
bound for, and the fish does what such a fish does.

What became of directions is `state.Directions`, and so part of what snapshots, rewinds and
clusters hold. Whoever shows a world reads there, of direction `k` of `scenario.direction`:

- `began[k]`, the tick in which it began last, -1 if it never did: a caption is up for so long
  after that, a camera is that of the direction with one that began last (`latest`);
- `times[k]`, how often it has begun: what two ticks differ in is what happened between them;
- `cast[k]` (2,), whom it is about, NOBODY or the SUBMARINE: of "courting" and "spawned" he and
  she, of "eaten" who was and by whom, of "caught" and "sated" the fish, of "fleeing" it and its
  predator, of "hunting" the hunter and its prey, of "passes" who passes, of `pair` he and she;
  without an event those of the direction `after` which it comes;
- `running[k]`, whether it still moves anything, and `ceded[k]`, what of it others do now.

Nothing else remembers anything: all of it is a function of scenario and state.
"""

import numpy as np

from subsea.directing.events import due
from subsea.directing.influences import begin, goes_on
from subsea.directing.script import Scene, Script, make_script
from subsea.scenario.schema import Scenario
from subsea.state import Clock, Nature, State

__all__ = ["Script", "direct", "latest", "make_script"]


def direct(
    script: Script, state: State, nature: Nature, current_cm_s: tuple[float, float], clock: Clock
) -> None:
    """Begin the directions whose time has come, and go on with those that run."""
    if not script.acts:
        return
    scene, log = Scene(script, state, nature, current_cm_s, clock), state.directions
    for k in script.order:
        if (cast := due(scene, k)) is not None:
            begin(scene, k, cast)
    for k in np.argsort(log.began, kind="stable"):
        if log.running[k]:
            log.running[k] = goes_on(scene, int(k))
    log.alive[:], log.courtship[:] = state.fishes.alive, state.minds.courtship


def latest(scenario: Scenario, state: State, what: str) -> int | None:
    """The number of the direction with that influence, such as "camera", that began last.

    Of several that began in the same tick the last of the file; None if none has begun.
    """
    began = [
        (int(state.directions.began[k]), k)
        for k, one in enumerate(scenario.direction)
        if getattr(one, what) is not None and state.directions.began[k] >= 0
    ]
    return max(began)[1] if began else None
