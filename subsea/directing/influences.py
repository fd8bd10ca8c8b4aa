"""Influences of directions on minds, the hook, the current and the lights."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.hunting import STALK
from subsea.behavior.mating import REST_S
from subsea.behavior.mental_state import HABITS, set_hunger, set_libido, urge_to_mate
from subsea.directing.script import Cast, Cue, DirectingContext, hunger_of, now_s
from subsea.scenario.directions import INFLUENCES, MOVES, FishSelector
from subsea.state import (
    ANYONE,
    CIRCLING,
    EAT,
    FEAR,
    HANGING,
    HOOKED,
    LANDED,
    LOOPING,
    NO_COURTSHIP,
    NOBODY,
    PACIFIST,
    PREDATOR,
    PREY,
    SINKING,
    SPAWNING,
    STOWED,
)

DIRECTED_LULL_S = 0.5  # longest rest of a predator that is to hunt
CRUISING = 0.62  # default share of its fastest speed on an errand
# Body lengths at which a point of a path is reached, and at which it is once the fish recedes:
# fishes turn in wide circles.
ARRIVED_BL, PASSED_BL = 1.0, 4.0
# A pair has gathered within the first distance of its place, is apart beyond the second, and
# returns from beyond the third.
TOGETHER_CM, APART_CM, HOME_CM = 90.0, 250.0, 60.0
COY = 0.08  # share of her fastest speed at which she turns to him
# Stages of a pair.
GATHERING, READY, COURTING, OVER = range(4)
MOST_SUITORS = 200  # candidates for the nearest two, at most
STRANGE_CM = 1e6  # added to the distance of different species


def start(context: DirectingContext, k: int, cast: Cast) -> None:
    """Start direction k with these two fishes."""
    cue, log = context.script.cues[k], context.state.directions
    _take_over(context, k)
    log.began[k], log.running[k], log.stage[k] = context.clock.tick, True, 0
    log.ceded[k] = 0
    log.cast[k] = cast if cue.direction.pair is None else NOBODY
    log.times[k] += 1
    for name in cue.influences:
        if name in ON_START:
            ON_START[name](context, cue)


def _take_over(context: DirectingContext, k: int) -> None:
    """Take over influences of the same kinds on the same fishes from all running directions.

    A direction ends when its path is taken over.
    """
    cues, log = context.script.cues, context.state.directions
    kinds, mine = _kinds(cues[k].influences), _moved(context, k)
    for other in map(int, np.flatnonzero(log.running)):
        theirs = np.isin(_moved(context, other), mine)
        common = theirs.any() if cues[other].direction.pair is not None else theirs.all()
        held = _active(context, other)
        if other == k or (common and "way" in kinds & _kinds(held)):
            ceded = held
        else:
            ceded = [name for name in held if common and kinds & _kinds([name])]
        _release(context, other, ceded)
        log.ceded[other] |= sum(1 << INFLUENCES.index(name) for name in ceded)
        log.running[other] = len(ceded) < len(held)


def advance(context: DirectingContext, k: int) -> bool:
    """Advance direction k by a tick; returns whether it continues."""
    going = False
    held = _active(context, k)
    for name in held:
        if _lasts(context, k, 0.0 if name in TRANSIENT else np.inf):
            going |= ADVANCE[name](context, k)
    if not going:
        _release(context, k, held)
    return going


def _active(context: DirectingContext, k: int) -> list[str]:
    """Influences of direction k in every tick, except those that others took over."""
    ceded = int(context.state.directions.ceded[k])
    names = context.script.cues[k].influences
    return [name for name in names if name in ADVANCE and not ceded >> INFLUENCES.index(name) & 1]


def _release(context: DirectingContext, k: int, names: list[str]) -> None:
    """Undo these influences of direction k on its fishes."""
    cue, minds = context.script.cues[k], context.state.minds
    for name in names:
        if name in ("path_cm", "hunts"):
            minds.errand[cue.who] = 0.0
        if name in ("hunts", "rests"):
            minds.quarry[cue.who] = ANYONE
        if name == "pair":
            two = context.state.directions.cast[k]
            two = two[two >= 0]
            minds.betrothed[two], minds.errand[two] = NOBODY, 0.0
        if name == "fear":
            minds.fright[cue.who] = -1.0
            minds.mental[cue.who, FEAR] = minds.menaces[cue.who]  # nothing imposed is remembered
        if name == "likes":
            minds.fancy[cue.who] = -1


def _kinds(names: Iterable[str]) -> set[str]:
    """Kinds of these influences; two of a kind exclude each other on the same fishes."""
    kinds = {"path_cm": {"way"}, "pair": {"way"}, "hunts": {"way", "prey"}, "rests": {"prey"}}
    return {kind for name in names if name in ADVANCE for kind in kinds.get(name, {name})}


def _moved(context: DirectingContext, k: int) -> Ints:
    """Fishes that direction k moves; empty if it moves the water, for example."""
    cue, pair = context.script.cues[k], context.state.directions.cast[k]
    those = cue.who if any(name in MOVES for name in cue.influences) else cue.who[:0]
    if isinstance(cue.direction.pair, tuple):
        return np.append(those, cue.direction.pair)
    if cue.direction.pair is not None:
        return np.append(those, pair[pair >= 0])
    return those


def _share(context: DirectingContext, k: int) -> float:
    """Share of the remaining change that is due in this tick, for an even change."""
    one, began = context.script.cues[k].direction, int(context.state.directions.began[k])
    left = round(one.over_s / context.clock.dt) - (context.clock.tick - began)
    return 1.0 / max(left, 1)


def _lasts(context: DirectingContext, k: int, held_s: float) -> bool:
    """True if direction k lasts on; `held_s` is its default duration after the change."""
    one, log = context.script.cues[k].direction, context.state.directions
    held = held_s if one.for_s is None else one.for_s
    ticks = max((one.over_s + held) / context.clock.dt, 1.0)
    return bool(context.clock.tick - log.began[k] < ticks)


# Each of these acts for one tick and returns whether it continues.


def _lead(context: DirectingContext, k: int) -> bool:
    """Send the leaders to the next point of the path, until the last is reached."""
    cue, log = context.script.cues[k], context.state.directions
    minds, one = context.state.minds, cue.direction
    points = one.path_cm or []
    minds.errand[cue.who] = 0.0
    those = cue.who[context.state.fishes.alive[cue.who]]
    if len(cue.who) > 1:
        free = those[minds.leader[those] == NOBODY]
        leads = free[minds.leads[free]]
        those = leads if len(leads) else free
    if not len(those) or log.stage[k] == len(points):
        return False
    if _arrived(context, those, np.array(points[log.stage[k]])):
        log.stage[k] += 1
        if log.stage[k] == len(points) and not one.loop:
            minds.patience[those] = 0.0
            return False
        log.stage[k] %= len(points)
    share = np.float32(CRUISING)
    if one.speed_cm_s is not None:
        share = np.clip(one.speed_cm_s / context.state.fishes.fast[those], 0.05, 1.0)
    _send(context, those, points[log.stage[k]], share)
    return True


def _arrived(context: DirectingContext, those: Ints, point: Array) -> bool:
    """True if half of the fishes are at a point, cm, or have just passed it."""
    fishes = context.state.fishes
    toward = point - fishes.position[those]
    lengths = np.linalg.norm(toward, axis=1) / fishes.length[those]
    recedes = (toward * fishes.velocity[those]).sum(axis=1) < 0.0
    return bool(np.median(lengths < np.where(recedes, PASSED_BL, ARRIVED_BL)) >= 0.5)


def _send(context: DirectingContext, those: Ints, place: Any, share: Any) -> None:
    """Send fishes to a place, cm, at a share of their fastest speed."""
    minds = context.state.minds
    minds.waypoint[those], minds.errand[those] = place, share


def _hunger(context: DirectingContext, k: int) -> bool:
    """Ease hunger to the given value, and hold it."""
    cue, minds = context.script.cues[k], context.state.minds
    assert cue.direction.hunger is not None
    now = hunger_of(context, cue.who)
    wish = now + _share(context, k) * (cue.direction.hunger - now)
    set_hunger(minds, cue.who, np.clip(wish, 0.0, 1.0), now_s(context))
    return True


def _libido(context: DirectingContext, k: int) -> bool:
    """Ease libido to the given value, and hold it."""
    cue, minds = context.script.cues[k], context.state.minds
    assert cue.direction.libido is not None
    now = urge_to_mate(minds, cue.who, now_s(context))
    hunger = hunger_of(context, cue.who)
    wish = now + _share(context, k) * (cue.direction.libido - now)
    set_libido(minds, cue.who, hunger, wish, now_s(context))
    minds.ardent[cue.who] = True
    return True


def _fear(context: DirectingContext, k: int) -> bool:
    """Ease fear to the given value, and hold it."""
    cue, minds = context.script.cues[k], context.state.minds
    assert cue.direction.fear is not None
    fright = minds.fright[cue.who]
    now = np.where(fright < 0.0, minds.mental[cue.who, FEAR], fright)
    minds.fright[cue.who] = now + _share(context, k) * (cue.direction.fear - now)
    return True


def _likes(context: DirectingContext, k: int) -> bool:
    """Impose habits."""
    cue = context.script.cues[k]
    bits = sum(1 << HABITS.index(habit) for habit in {*(cue.direction.likes or ())})
    context.state.minds.fancy[cue.who] = bits
    return True


def _current(context: DirectingContext, k: int) -> bool:
    """Ease the strength of the current to the given value."""
    current = context.state.directions.current
    wish = np.array(context.script.cues[k].direction.current_cm_s) - context.current_cm_s
    current += _share(context, k) * (wish - current)
    return True


def _make_hungry(context: DirectingContext, cue: Cue) -> None:
    """Make predators hungry and fresh, and limit their prey."""
    minds, hunts = context.state.minds, cue.direction.hunts
    those = _hunters(context, cue)
    set_hunger(minds, those, 1.0, now_s(context))
    minds.fatigue[EAT, those] = minds.lull[those] = 0.0
    if isinstance(hunts, FishSelector) and hunts.species is not None:
        minds.quarry[those] = *ANYONE[:2], context.script.species.index(hunts.species)
    else:
        minds.quarry[those] = (cue.prey[0], cue.prey[-1] + 1, -1) if len(cue.prey) else NOBODY
    _forget_prey(context, those)


def _sate(context: DirectingContext, cue: Cue) -> None:
    """Make predators sated, without prey."""
    minds, those = context.state.minds, _hunters(context, cue)
    set_hunger(minds, those, 0.0, now_s(context))
    minds.quarry[those] = NOBODY
    _forget_prey(context, those)


def _hunters(context: DirectingContext, cue: Cue) -> Ints:
    return cue.who[context.state.minds.kind[cue.who] == PREDATOR]


def _forget_prey(context: DirectingContext, those: Ints) -> None:
    minds = context.state.minds
    for name in ("target", "food", "foods", "memory", "memory_target"):
        getattr(minds, name)[those] = -1
    minds.food_distance[those] = np.inf


def _hunt(context: DirectingContext, k: int) -> bool:
    """Send hungry predators that perceive no prey to the nearest one, and shorten their rests."""
    cue, state = context.script.cues[k], context.state
    fishes, minds = state.fishes, state.minds
    if cue.direction.path_cm is None:
        those = _hunters(context, cue)
        minds.errand[those] = 0.0
        minds.lull[those] = np.minimum(minds.lull[those], DIRECTED_LULL_S)
        prey = cue.prey[fishes.alive[cue.prey] & (minds.kind[cue.prey] == PREY)]
        seeks = fishes.alive[those] & (minds.food[those] < 0)
        for i in those[seeks & (hunger_of(context, those) > context.nature.keen)]:
            if len(prey):
                gaps = np.linalg.norm(fishes.position[prey] - fishes.position[i], axis=1)
                _send(context, np.array([i]), fishes.position[prey[np.argmin(gaps)]], STALK)
    return True


def _pair(context: DirectingContext, k: int) -> bool:
    """Bring a pair together, at a place if one is given, until it has spawned.

    If the two part before, they gather again.
    """
    cue, log, state = context.script.cues[k], context.state.directions, context.state
    minds, fishes = state.minds, state.fishes
    if log.cast[k, 0] < 0:
        log.cast[k] = _choose_pair(context, cue)
        if log.cast[k, 0] < 0:
            return True
    two, other = log.cast[k], log.cast[k, ::-1]
    spawned = (log.courtship[two] == SPAWNING) & (minds.courtship[two] == NO_COURTSHIP)
    just = minds.last_mating[two] >= now_s(context) - 1.5 * context.clock.dt
    if not fishes.alive[two].all() or (spawned & just).all():
        log.stage[k] = OVER
    if log.stage[k] == OVER:
        minds.betrothed[two], minds.errand[two] = NOBODY, 0.0
        return False
    minds.betrothed[two], minds.errand[two] = other, 0.0
    set_hunger(minds, two, 0.0, now_s(context))
    if (minds.courtship[two] >= LOOPING).all() and (minds.partner[two] == other).all():
        log.stage[k] = COURTING
        return True
    place = cue.direction.place_cm
    meet = fishes.position[two].mean(axis=0) if place is None else np.array(place)
    gaps = np.linalg.norm(fishes.position[two] - meet, axis=1)
    gathers = gaps.max() > (TOGETHER_CM if log.stage[k] == GATHERING else APART_CM)
    log.stage[k] = GATHERING if gathers else READY
    minds.shunned[two] = NOBODY
    set_libido(minds, two, 0.0, float(not gathers), now_s(context))
    if not gathers:
        rested = now_s(context) - REST_S - 1.0
        minds.last_mating[two] = np.minimum(minds.last_mating[two], rested)
        if gaps[1] <= HOME_CM:
            _send(context, two[1:], fishes.position[two[0]], COY)
    _send(context, two[gaps > HOME_CM], meet, CRUISING)
    return True


def _choose_pair(context: DirectingContext, cue: Cue) -> Cast:
    """Male and female: the two given, or the two nearest to each other and the place."""
    fishes, minds, one = context.state.fishes, context.state.minds, cue.direction
    those = np.array(one.pair) if isinstance(one.pair, tuple) else cue.who
    those = those[those < len(fishes.alive)]
    those = those[fishes.alive[those] & (minds.kind[those] == PACIFIST)]
    if one.pair == "nearest":
        those = those[(minds.courtship[those] < CIRCLING) & (minds.betrothed[those] == NOBODY)]
    if len(those) < 2:
        return NOBODY, NOBODY
    meet = fishes.position[those].mean(axis=0) if one.place_cm is None else np.array(one.place_cm)
    way = np.linalg.norm(fishes.position[those] - meet, axis=1)
    those = those[np.argsort(way, kind="stable")[:MOST_SUITORS]]
    he, she = those[minds.male[those]], those[~minds.male[those]]
    if not len(he) or not len(she):
        return NOBODY, NOBODY
    cost = np.linalg.norm(fishes.position[he][:, None] - fishes.position[she], axis=2)
    if one.place_cm is not None:
        cost += np.linalg.norm(fishes.position[he] - meet, axis=1)[:, None]
        cost += np.linalg.norm(fishes.position[she] - meet, axis=1)
    cost[fishes.species[he][:, None] != fishes.species[she]] += STRANGE_CM
    i, j = np.unravel_index(np.argmin(cost), cost.shape)
    return int(he[i]), int(she[j])


def _lower(context: DirectingContext, cue: Cue) -> None:
    """Lower the hook, or raise it without a catch."""
    sea, down = context.state.sea, cue.direction.hook == "down"
    if down and sea.catch[0] in (STOWED, LANDED):
        sea.hook[:] = *sea.tackle[:2], 0.0
        sea.catch[0] = SINKING
    elif not down and sea.catch[0] in (SINKING, HANGING):
        sea.catch[:] = HOOKED, NOBODY


def _light(context: DirectingContext, cue: Cue) -> None:
    """Switch the submarine's lights."""
    context.state.submarine.lights[:] = bool(cue.direction.lights)


# Influences when a direction starts ...
ON_START = {"hunts": _make_hungry, "rests": _sate, "hook": _lower, "lights": _light}
# ... and in every tick as long as it lasts; transient ones end once their value is reached.
TRANSIENT = ("hunger", "libido", "current_cm_s")
ADVANCE = {
    "path_cm": _lead,
    "hunger": _hunger,
    "libido": _libido,
    "fear": _fear,
    "likes": _likes,
    "hunts": _hunt,
    "rests": lambda context, k: True,  # goes on without prey
    "pair": _pair,
    "current_cm_s": _current,
}
