"""What directions do: what they put into minds, and into the sea."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from subsea.behavior.hunting import STALK
from subsea.behavior.mating import REST_S
from subsea.behavior.temperament import HABITS, set_hunger, set_libido, urge_to_mate
from subsea.core.arrays import Array, Ints
from subsea.directing.script import Act, Scene, hunger_of, now_s
from subsea.scenario.directions import INFLUENCES, MOVES, Whose
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
    NUZZLING,
    PACIFIST,
    PREDATOR,
    PREY,
    SINKING,
    STOWED,
)

Cast = tuple[int, int]

CRUISING = 0.62  # share of its fastest speed at which a fish that is sent goes, if nothing is said
# A point of a path is reached within so many lengths, or within so many once the fish recedes
# from it: a fish turns in a wide circle.
ARRIVED_BL, PASSED_BL = 1.0, 4.0
# Two that are to court have come together within this, are apart again beyond that, and turn
# back to the place from where they are farther off than the last.
TOGETHER_CM, APART_CM, HOME_CM = 90.0, 250.0, 60.0
COY = 0.08  # share of her fastest speed with which she turns to him
# Stages of a pair.
GATHERING, READY, COURTING, OVER = range(4)
MOST_SUITORS = 200  # so many are looked at to find the nearest two ...
STRANGE_CM = 1e6  # ... of whom those of different species count as so much farther apart


def begin(scene: Scene, k: int, cast: Cast) -> None:
    """Enter that direction k, which is about those two, begins, and start what it does."""
    act, log = scene.script.acts[k], scene.state.directions
    _make_way(scene, k)
    log.began[k], log.running[k], log.stage[k] = scene.clock.tick, True, 0
    log.ceded[k] = 0
    log.cast[k] = cast if act.direction.pair is None else NOBODY
    log.times[k] += 1
    for name in act.influences:
        if name in START:
            START[name](scene, act)


def _make_way(scene: Scene, k: int) -> None:
    """End what others do of the same kinds as direction k to the same fishes, and k itself.

    Whose way ends does nothing any more.
    """
    acts, log = scene.script.acts, scene.state.directions
    kinds, mine = _kinds(acts[k].influences), _moved(scene, k)
    for other in map(int, np.flatnonzero(log.running)):
        theirs = np.isin(_moved(scene, other), mine)
        common = theirs.any() if acts[other].direction.pair is not None else theirs.all()
        held = _held(scene, other)
        if other == k or (common and "way" in kinds & _kinds(held)):
            ceded = held
        else:
            ceded = [name for name in held if common and kinds & _kinds([name])]
        _release(scene, other, ceded)
        log.ceded[other] |= sum(1 << INFLUENCES.index(name) for name in ceded)
        log.running[other] = len(ceded) < len(held)


def goes_on(scene: Scene, k: int) -> bool:
    """Do what direction k does in every tick; whether there is more to come."""
    going = False
    held = _held(scene, k)
    for name in held:
        if _lasts(scene, k, 0.0 if name in LET_GO else np.inf):
            going |= HOLD[name](scene, k)
    if not going:
        _release(scene, k, held)
    return going


def _held(scene: Scene, k: int) -> list[str]:
    """What direction k does in every tick, but for what others do now."""
    ceded = int(scene.state.directions.ceded[k])
    names = scene.script.acts[k].influences
    return [name for name in names if name in HOLD and not ceded >> INFLUENCES.index(name) & 1]


def _release(scene: Scene, k: int, names: list[str]) -> None:
    """Leave those whom direction k has moved to themselves, as far as these influences go."""
    act, minds = scene.script.acts[k], scene.state.minds
    for name in names:
        if name in ("path_cm", "hunts"):
            minds.errand[act.who] = 0.0
        if name in ("hunts", "rests"):
            minds.quarry[act.who] = ANYONE
        if name == "pair":
            two = scene.state.directions.cast[k]
            two = two[two >= 0]
            minds.betrothed[two], minds.errand[two] = NOBODY, 0.0
        if name == "fear":
            minds.fright[act.who] = -1.0
        if name == "likes":
            minds.fancy[act.who] = -1


def _kinds(names: Iterable[str]) -> set[str]:
    """What of these influences two cannot do to the same fishes at the same time."""
    kinds = {"path_cm": {"way"}, "pair": {"way"}, "hunts": {"way", "prey"}, "rests": {"prey"}}
    return {kind for name in names if name in HOLD for kind in kinds.get(name, {name})}


def _moved(scene: Scene, k: int) -> Ints:
    """Whom direction k moves; nobody if it moves the water, say."""
    act, pair = scene.script.acts[k], scene.state.directions.cast[k]
    those = act.who if any(name in MOVES for name in act.influences) else act.who[:0]
    if isinstance(act.direction.pair, tuple):
        return np.append(those, act.direction.pair)
    if act.direction.pair is not None:
        return np.append(those, pair[pair >= 0])
    return those


def _share(scene: Scene, k: int) -> float:
    """The share of what is left of a change that is due in this tick, so that it is even."""
    one, began = scene.script.acts[k].direction, int(scene.state.directions.began[k])
    left = round(one.over_s / scene.clock.dt) - (scene.clock.tick - began)
    return 1.0 / max(left, 1)


def _lasts(scene: Scene, k: int, held_s: float) -> bool:
    """Whether direction k, which is held for so long if it does not say so itself, lasts on."""
    one, log = scene.script.acts[k].direction, scene.state.directions
    held = held_s if one.for_s is None else one.for_s
    ticks = max((one.over_s + held) / scene.clock.dt, 1.0)
    return bool(scene.clock.tick - log.began[k] < ticks)


def _alive(scene: Scene, act: Act) -> Ints:
    return act.who[scene.state.fishes.alive[act.who]]


# Each of these does its part in a tick and says whether it is not over for good.


def _lead(scene: Scene, k: int) -> bool:
    """Bind those who lead for the next point of the path, until they were at the last."""
    act, log = scene.script.acts[k], scene.state.directions
    minds, one = scene.state.minds, act.direction
    points = one.path_cm or []
    minds.errand[act.who] = 0.0
    those = _alive(scene, act)
    if len(act.who) > 1:
        free = those[minds.leader[those] == NOBODY]
        leads = free[minds.leads[free]]
        those = leads if len(leads) else free
    if not len(those) or log.stage[k] == len(points):
        return False
    if _arrived(scene, those, np.array(points[log.stage[k]])):
        log.stage[k] += 1
        if log.stage[k] == len(points) and not one.loop:
            minds.patience[those] = 0.0
            return False
        log.stage[k] %= len(points)
    share = np.float32(CRUISING)
    if one.speed_cm_s is not None:
        share = np.clip(one.speed_cm_s / scene.script.fastest_cm_s[those], 0.05, 1.0)
    _send(scene, those, points[log.stage[k]], share)
    return True


def _arrived(scene: Scene, those: Ints, point: Array) -> bool:
    """Whether half of the fishes are at a point, cm, or have just passed it by."""
    fishes = scene.state.fishes
    toward = point - fishes.position[those]
    lengths = np.linalg.norm(toward, axis=1) / fishes.length[those]
    recedes = (toward * fishes.velocity[those]).sum(axis=1) < 0.0
    return bool(np.median(lengths < np.where(recedes, PASSED_BL, ARRIVED_BL)) >= 0.5)


def _send(scene: Scene, those: Ints, place: Any, share: Any) -> None:
    """Bind fishes for a place, cm, at a share of their fastest speed."""
    minds = scene.state.minds
    minds.waypoint[those], minds.errand[those] = place, share


def _hunger(scene: Scene, k: int) -> bool:
    """Ease hunger to what it is to be, and hold it there."""
    act, minds = scene.script.acts[k], scene.state.minds
    assert act.direction.hunger is not None
    now = hunger_of(scene, act.who)
    wish = now + _share(scene, k) * (act.direction.hunger - now)
    set_hunger(minds, act.who, np.clip(wish, 0.0, 1.0), now_s(scene))
    return True


def _libido(scene: Scene, k: int) -> bool:
    """Ease libido to what it is to be, and hold it there."""
    act, minds = scene.script.acts[k], scene.state.minds
    assert act.direction.libido is not None
    now, hunger = urge_to_mate(minds, act.who, now_s(scene)), hunger_of(scene, act.who)
    wish = now + _share(scene, k) * (act.direction.libido - now)
    set_libido(minds, act.who, hunger, wish, now_s(scene))
    return True


def _fear(scene: Scene, k: int) -> bool:
    """Ease fear to what it is to be, and hold it there."""
    act, minds = scene.script.acts[k], scene.state.minds
    assert act.direction.fear is not None
    fright = minds.fright[act.who]
    now = np.where(fright < 0.0, minds.mental[act.who, FEAR], fright)
    minds.fright[act.who] = now + _share(scene, k) * (act.direction.fear - now)
    return True


def _likes(scene: Scene, k: int) -> bool:
    """Have those habits."""
    act = scene.script.acts[k]
    bits = sum(1 << HABITS.index(habit) for habit in {*(act.direction.likes or ())})
    scene.state.minds.fancy[act.who] = bits
    return True


def _current(scene: Scene, k: int) -> bool:
    """Ease the strength of the current to what it is to be."""
    current = scene.state.directions.current
    wish = np.array(scene.script.acts[k].direction.current_cm_s) - scene.current_cm_s
    current += _share(scene, k) * (wish - current)
    return True


def _rouse(scene: Scene, act: Act) -> None:
    """Let predators be hungry and fresh, and mind those alone whom they may hunt."""
    minds, hunts = scene.state.minds, act.direction.hunts
    those = _hunters(scene, act)
    set_hunger(minds, those, 1.0, now_s(scene))
    minds.fatigue[EAT, those] = 0.0
    if isinstance(hunts, Whose) and hunts.species is not None:
        minds.quarry[those] = *ANYONE[:2], scene.script.species.index(hunts.species)
    else:
        minds.quarry[those] = (act.prey[0], act.prey[-1] + 1, -1) if len(act.prey) else NOBODY
    _forget_prey(scene, those)


def _lull(scene: Scene, act: Act) -> None:
    """Let predators be sated, and mind nobody."""
    minds, those = scene.state.minds, _hunters(scene, act)
    set_hunger(minds, those, 0.0, now_s(scene))
    minds.quarry[those] = NOBODY
    _forget_prey(scene, those)


def _hunters(scene: Scene, act: Act) -> Ints:
    return act.who[scene.state.minds.kind[act.who] == PREDATOR]


def _forget_prey(scene: Scene, those: Ints) -> None:
    minds = scene.state.minds
    for name in ("target", "food", "foods", "memory", "memory_target"):
        getattr(minds, name)[those] = -1
    minds.food_distance[those] = np.inf


def _hunt(scene: Scene, k: int) -> bool:
    """Send predators that are hungry, and perceive nobody of their prey, to where that is."""
    act, fishes, minds = scene.script.acts[k], scene.state.fishes, scene.state.minds
    if act.direction.path_cm is None:
        those = _hunters(scene, act)
        minds.errand[those] = 0.0
        prey = act.prey[fishes.alive[act.prey] & (minds.kind[act.prey] == PREY)]
        seeks = fishes.alive[those] & (minds.food[those] < 0)
        for i in those[seeks & (hunger_of(scene, those) > scene.nature.keen)]:
            if len(prey):
                gaps = np.linalg.norm(fishes.position[prey] - fishes.position[i], axis=1)
                _send(scene, np.array([i]), fishes.position[prey[np.argmin(gaps)]], STALK)
    return True


def _rest(scene: Scene, k: int) -> bool:
    """Mind nobody."""
    return True


def _court(scene: Scene, k: int) -> bool:
    """Bring two together, and to a place if one is said; there each minds the other alone.

    Until they have spawned: if they part before, they begin anew.
    """
    act, log, state = scene.script.acts[k], scene.state.directions, scene.state
    minds, fishes = state.minds, state.fishes
    if log.cast[k, 0] < 0:
        log.cast[k] = _betrothed(scene, act)
        if log.cast[k, 0] < 0:
            return True
    two, other = log.cast[k], log.cast[k, ::-1]
    spawned = (log.courtship[two] == NUZZLING) & (minds.courtship[two] == NO_COURTSHIP)
    just = minds.last_mating[two] >= now_s(scene) - 1.5 * scene.clock.dt
    if not fishes.alive[two].all() or (spawned & just).all():
        log.stage[k] = OVER
    if log.stage[k] == OVER:
        minds.betrothed[two], minds.errand[two] = NOBODY, 0.0
        return False
    minds.betrothed[two], minds.errand[two] = other, 0.0
    set_hunger(minds, two, 0.0, now_s(scene))
    if (minds.courtship[two] >= LOOPING).all() and (minds.partner[two] == other).all():
        log.stage[k] = COURTING
        return True
    place = act.direction.place_cm
    meet = fishes.position[two].mean(axis=0) if place is None else np.array(place)
    gaps = np.linalg.norm(fishes.position[two] - meet, axis=1)
    gathers = gaps.max() > (TOGETHER_CM if log.stage[k] == GATHERING else APART_CM)
    log.stage[k] = GATHERING if gathers else READY
    minds.shunned[two] = NOBODY
    set_libido(minds, two, 0.0, float(not gathers), now_s(scene))
    if not gathers:
        rested = now_s(scene) - REST_S - 1.0
        minds.last_mating[two] = np.minimum(minds.last_mating[two], rested)
        if gaps[1] <= HOME_CM:
            _send(scene, two[1:], fishes.position[two[0]], COY)
    _send(scene, two[gaps > HOME_CM], meet, CRUISING)
    return True


def _betrothed(scene: Scene, act: Act) -> Cast:
    """He and she: the two that are named, or the nearest two of them, also to the place."""
    fishes, minds, one = scene.state.fishes, scene.state.minds, act.direction
    those = np.array(one.pair) if isinstance(one.pair, tuple) else act.who
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


def _lower(scene: Scene, act: Act) -> None:
    """Let the hook down anew, or draw it up without a catch."""
    sea, down = scene.state.sea, act.direction.hook == "down"
    if down and sea.catch[0] in (STOWED, LANDED):
        sea.hook[:] = *sea.tackle[:2], 0.0
        sea.catch[0] = SINKING
    elif not down and sea.catch[0] in (SINKING, HANGING):
        sea.catch[:] = HOOKED, NOBODY


def _light(scene: Scene, act: Act) -> None:
    """Switch the submarine's lights."""
    scene.state.submarine.lights[:] = bool(act.direction.lights)


# What is done when a direction begins, ...
START = {"hunts": _rouse, "rests": _lull, "hook": _lower, "lights": _light}
# ... and in every tick from then on, as long as it lasts; some are let go once they are reached.
LET_GO = ("hunger", "libido", "current_cm_s")
HOLD = {
    "path_cm": _lead,
    "hunger": _hunger,
    "libido": _libido,
    "fear": _fear,
    "likes": _likes,
    "hunts": _hunt,
    "rests": _rest,
    "pair": _court,
    "current_cm_s": _current,
}
