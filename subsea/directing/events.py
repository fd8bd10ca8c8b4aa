"""When directions begin: what they wait for, and whom that is about."""

import numpy as np

from subsea.core.arrays import Ints
from subsea.directing.script import Act, Scene, hunger_of
from subsea.state import (
    EAT,
    FEAR,
    HOOKED,
    LOOPING,
    NO_COURTSHIP,
    NOBODY,
    NUZZLING,
    PREDATOR,
    SUBMARINE,
)

Cast = tuple[int, int]

PULSES = ("spawned", "eaten")  # events of a single tick


def due(scene: Scene, k: int) -> Cast | None:
    """Whom direction k is about, if it begins now."""
    one, log = scene.script.acts[k].direction, scene.state.directions
    if log.times[k] and one.once and one.every_s is None:
        return None
    since = _watched_since(scene, k)
    cast = None if since is None else _cast_of(scene, k)
    begins = since is not None and cast is not None and _begins(scene, k, since)
    log.ready[k] = cast is not None
    return cast if begins else None


def _watched_since(scene: Scene, k: int) -> int | None:
    """The tick from which direction k could begin, None while that is to come."""
    act, log, clock = scene.script.acts[k], scene.state.directions, scene.clock
    since = round((act.direction.at_s or 0.0) / clock.dt)
    if act.after >= 0:
        if log.began[act.after] < 0:
            return None
        since = max(since, int(log.began[act.after]) + round(act.direction.delay_s / clock.dt))
    return since if clock.tick >= since else None


def _begins(scene: Scene, k: int, since: int) -> bool:
    """Whether direction k, for which all is ready, begins now."""
    one, log, tick = scene.script.acts[k].direction, scene.state.directions, scene.clock.tick
    if log.times[k] == 0:
        return True
    if one.every_s is not None:
        return bool(tick - log.began[k] >= round(one.every_s / scene.clock.dt))
    anew = not log.ready[k] or since > log.began[k] or one.event in PULSES
    return not one.once and bool(anew)


def _cast_of(scene: Scene, k: int) -> Cast | None:
    """Whom direction k is about, if its event happens and as few are left as it says."""
    act, state = scene.script.acts[k], scene.state
    one = act.direction
    if one.fewer_than is not None and state.fishes.alive[act.of].sum() >= one.fewer_than:
        return None
    if one.event is not None:
        return EVENTS[one.event](scene, act)
    if act.after >= 0:
        return _pair_of(state.directions.cast[act.after])
    return NOBODY, NOBODY


def _courting(scene: Scene, act: Act) -> Cast | None:
    """Two show off to each other, or are further already."""
    minds = scene.state.minds
    those = act.of[minds.courtship[act.of] >= LOOPING]
    her = minds.partner[those]
    mutual = (her >= 0) & (minds.courtship[her] >= LOOPING) & (minds.partner[her] == those)
    return _couple(scene, those[mutual])


def _spawned(scene: Scene, act: Act) -> Cast | None:
    """Two have mated in the last tick."""
    minds, log, clock = scene.state.minds, scene.state.directions, scene.clock
    ended = (log.courtship[act.of] == NUZZLING) & (minds.courtship[act.of] == NO_COURTSHIP)
    just = minds.last_mating[act.of] >= (clock.tick - 1.5) * clock.dt
    those = act.of[ended & just]
    if not len(those):
        return None
    other = minds.shunned[those[0]]  # whom it has just mated with
    male = bool(minds.male[those[0]])
    return (int(those[0]), int(other)) if male else (int(other), int(those[0]))


def _couple(scene: Scene, those: Ints) -> Cast | None:
    """He and she, of the first of `those`."""
    if not len(those):
        return None
    i, j = int(those[0]), int(scene.state.minds.partner[those[0]])
    return (i, j) if scene.state.minds.male[i] else (j, i)


def _eaten(scene: Scene, act: Act) -> Cast | None:
    """One was swallowed in the last tick."""
    fishes, minds, log, clock = (
        scene.state.fishes, scene.state.minds, scene.state.directions, scene.clock,
    )  # fmt: skip
    those = act.of[log.alive[act.of] & ~fishes.alive[act.of]]
    fed = np.flatnonzero(
        (minds.kind == PREDATOR) & (minds.last_meal >= (clock.tick - 1.5) * clock.dt)
    )
    if not len(those) or not len(fed):  # else it was drawn up by the hook
        return None
    gaps = np.linalg.norm(fishes.position[fed] - fishes.position[those[0]], axis=1)
    return int(those[0]), int(fed[np.argmin(gaps)])


def _caught(scene: Scene, act: Act) -> Cast | None:
    """One hangs on the hook."""
    state, fish = scene.state.sea.catch
    return (int(fish), NOBODY) if state == HOOKED and fish in act.of else None


def _sated(scene: Scene, act: Act) -> Cast | None:
    """One is no longer hungry enough to eat."""
    alive = scene.state.fishes.alive[act.of]
    return _one(act.of[alive & (hunger_of(scene, act.of) <= scene.nature.keen)])


def _fleeing(scene: Scene, act: Act) -> Cast | None:
    """One fears so much that it flees, or closes the ranks of its school."""
    fishes, minds = scene.state.fishes, scene.state.minds
    afraid = fishes.alive[act.of] & (minds.mental[act.of, FEAR] > scene.nature.alarmed)
    those = act.of[afraid]
    return (int(those[0]), int(minds.predator[those[0]])) if len(those) else None


def _hunting(scene: Scene, act: Act) -> Cast | None:
    """One is after a prey."""
    fishes, minds = scene.state.fishes, scene.state.minds
    hunts = fishes.alive & (minds.kind == PREDATOR) & (minds.intention == EAT) & (minds.target >= 0)
    those = act.of[hunts[act.of]]
    return (int(those[0]), int(minds.target[those[0]])) if len(those) else None


def _passes(scene: Scene, act: Act) -> Cast | None:
    """The submarine is at the gate; or the middle of fishes, or one that leads them."""
    one, fishes, minds = act.direction, scene.state.fishes, scene.state.minds
    gate = np.array(one.gate_cm)
    if one.of is None:
        near = np.linalg.norm(scene.state.submarine.position - gate) <= one.radius_cm
        return (SUBMARINE, NOBODY) if near else None
    those = act.of[fishes.alive[act.of]]
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


def _pair_of(cast: Ints) -> Cast:
    return int(cast[0]), int(cast[1])


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
