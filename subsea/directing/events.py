"""Events that start directions, and the fishes they are about."""

import numpy as np

from subsea.base.arrays import Ints
from subsea.directing.script import Cast, Cue, DirectingContext, hunger_of
from subsea.state import (
    EAT,
    FEAR,
    HOOKED,
    LOOPING,
    NO_COURTSHIP,
    NOBODY,
    PREDATOR,
    SPAWNING,
    SUBMARINE,
)

PULSES = ("spawned", "eaten")  # events of a single tick


def triggered_cast(context: DirectingContext, k: int) -> Cast | None:
    """The fishes of direction k if it starts now, else None."""
    one, log = context.script.cues[k].direction, context.state.directions
    if log.times[k] and one.once and one.every_s is None:
        return None
    since = _watched_since(context, k)
    cast = None if since is None else cast_of(context, k)
    begins = since is not None and cast is not None and _begins(context, k, since)
    log.ready[k] = cast is not None
    return cast if begins else None


def _watched_since(context: DirectingContext, k: int) -> int | None:
    """First tick in which direction k may start, None if that is in the future."""
    cue, log, clock = context.script.cues[k], context.state.directions, context.clock
    since = round((cue.direction.at_s or 0.0) / clock.dt)
    if cue.after >= 0:
        if log.began[cue.after] < 0:
            return None
        since = max(since, int(log.began[cue.after]) + round(cue.direction.delay_s / clock.dt))
    return since if clock.tick >= since else None


def _begins(context: DirectingContext, k: int, since: int) -> bool:
    """True if direction k, whose condition holds, starts now."""
    one, log, tick = context.script.cues[k].direction, context.state.directions, context.clock.tick
    if log.times[k] == 0:
        return True
    if one.every_s is not None:
        return bool(tick - log.began[k] >= round(one.every_s / context.clock.dt))
    again = not log.ready[k] or since > log.began[k] or one.event in PULSES
    return not one.once and bool(again)


def cast_of(context: DirectingContext, k: int) -> Cast | None:
    """The fishes of direction k if its event happens and few enough are left."""
    cue, state = context.script.cues[k], context.state
    one = cue.direction
    if one.fewer_than is not None and state.fishes.alive[cue.of].sum() >= one.fewer_than:
        return None
    if one.event is not None:
        return EVENTS[one.event](context, cue)
    if cue.after >= 0:
        first, second = state.directions.cast[cue.after]
        return int(first), int(second)
    return NOBODY, NOBODY


def _courting(context: DirectingContext, cue: Cue) -> Cast | None:
    """Two fishes are looping, or in a later state of courtship."""
    minds = context.state.minds
    those = cue.of[minds.courtship[cue.of] >= LOOPING]
    her = minds.partner[those]
    mutual = (her >= 0) & (minds.courtship[her] >= LOOPING) & (minds.partner[her] == those)
    return _couple(context, those[mutual])


def _spawned(context: DirectingContext, cue: Cue) -> Cast | None:
    """Two fishes have mated in the last tick."""
    minds, log, clock = context.state.minds, context.state.directions, context.clock
    ended = (log.courtship[cue.of] == SPAWNING) & (minds.courtship[cue.of] == NO_COURTSHIP)
    just = minds.last_mating[cue.of] >= (clock.tick - 1.5) * clock.dt
    those = cue.of[ended & just]
    if not len(those):
        return None
    other = minds.shunned[those[0]]  # its mate
    male = bool(minds.male[those[0]])
    return (int(those[0]), int(other)) if male else (int(other), int(those[0]))


def _couple(context: DirectingContext, those: Ints) -> Cast | None:
    """Male and female of the first courting fish."""
    if not len(those):
        return None
    i, j = int(those[0]), int(context.state.minds.partner[those[0]])
    return (i, j) if context.state.minds.male[i] else (j, i)


def _eaten(context: DirectingContext, cue: Cue) -> Cast | None:
    """A fish was eaten in the last tick."""
    fishes, minds, log, clock = (
        context.state.fishes, context.state.minds, context.state.directions, context.clock,
    )  # fmt: skip
    those = cue.of[log.alive[cue.of] & ~fishes.alive[cue.of]]
    fed = np.flatnonzero(
        (minds.kind == PREDATOR) & (minds.last_meal >= (clock.tick - 1.5) * clock.dt)
    )
    if not len(those) or not len(fed):  # else it was landed by the hook
        return None
    gaps = np.linalg.norm(fishes.position[fed] - fishes.position[those[0]], axis=1)
    return int(those[0]), int(fed[np.argmin(gaps)])


def _caught(context: DirectingContext, cue: Cue) -> Cast | None:
    """A fish hangs on the hook."""
    state, fish = context.state.sea.catch
    return (int(fish), NOBODY) if state == HOOKED and fish in cue.of else None


def _sated(context: DirectingContext, cue: Cue) -> Cast | None:
    """A fish is no longer hungry enough to eat."""
    alive = context.state.fishes.alive[cue.of]
    return _one(cue.of[alive & (hunger_of(context, cue.of) <= context.nature.keen)])


def _fleeing(context: DirectingContext, cue: Cue) -> Cast | None:
    """A fish is afraid enough to flee or to school closely."""
    fishes, minds = context.state.fishes, context.state.minds
    afraid = fishes.alive[cue.of] & (minds.mental[cue.of, FEAR] > context.nature.alarmed)
    those = cue.of[afraid]
    # Fear lasts longer than the sight of its cause.
    sees = minds.predator[those] != NOBODY
    those = those[sees] if sees.any() else those
    return (int(those[0]), int(minds.predator[those[0]])) if len(those) else None


def _hunting(context: DirectingContext, cue: Cue) -> Cast | None:
    """A predator hunts a prey."""
    fishes, minds = context.state.fishes, context.state.minds
    hunts = fishes.alive & (minds.kind == PREDATOR) & (minds.intention == EAT) & (minds.target >= 0)
    those = cue.of[hunts[cue.of]]
    return (int(those[0]), int(minds.target[those[0]])) if len(those) else None


def _passes(context: DirectingContext, cue: Cue) -> Cast | None:
    """The submarine, the median place of the fishes, or one of their leaders is at the gate."""
    one, fishes, minds = cue.direction, context.state.fishes, context.state.minds
    gate = np.array(one.gate_cm)
    if one.of is None:
        near = np.linalg.norm(context.state.submarine.position - gate) <= one.radius_cm
        return (SUBMARINE, NOBODY) if near else None
    those = cue.of[fishes.alive[cue.of]]
    if not len(those):
        return None
    leads = those[minds.leads[those] | (len(those) == 1)]
    gaps = np.linalg.norm(fishes.position[leads] - gate, axis=1)
    if (gaps <= one.radius_cm).any():
        return int(leads[np.argmin(gaps)]), NOBODY
    middle = np.median(fishes.position[those], axis=0)
    return _one(those) if np.linalg.norm(middle - gate) <= one.radius_cm else None


def _one(those: Ints) -> Cast | None:
    return (int(those[0]), NOBODY) if len(those) else None


EVENTS = {
    "courting": _courting,
    "spawned": _spawned,
    "eaten": _eaten,
    "caught": _caught,
    "sated": _sated,
    "fleeing": _fleeing,
    "hunting": _hunting,
    "passes": _passes,
}
