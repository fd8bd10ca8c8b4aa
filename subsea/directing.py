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
- `running[k]`, whether it still moves anything.

Nothing else remembers anything: all of it is a function of scenario and state.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.behavior.hunting import STALK
from subsea.behavior.mating import REST_S
from subsea.behavior.temper import HABITS, set_hunger, set_libido, urge_to_eat, urge_to_mate
from subsea.direction import Direction, Shoals, Whose, numbers_of
from subsea.scenario import Scenario
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
    SUBMARINE,
    Clock,
    Nature,
    State,
)

Ints = NDArray[np.integer[Any]]
Array = NDArray[np.floating[Any]]
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
PULSES = ("spawned", "eaten")  # events of a single tick


class Act(NamedTuple):
    """A direction in the numbers of a world."""

    direction: Direction
    who: Ints  # whom it moves
    of: Ints  # whose event it waits for
    prey: Ints  # whom they hunt
    shown: Ints  # whom its camera follows
    after: int  # which direction it follows, -1 for none


class Script(NamedTuple):
    """All directions of a world. Constant."""

    acts: tuple[Act, ...]
    order: tuple[int, ...]  # each behind the one that it follows
    fastest_cm_s: Array  # (n,) float32, of each fish
    species: tuple[str, ...]  # as they are numbered


class Scene(NamedTuple):
    """What a direction acts on."""

    script: Script
    state: State
    nature: Nature
    current_cm_s: tuple[float, float]  # as it is without directions
    clock: Clock


def make_script(scenario: Scenario, numbers: list[int], fastest_cm_s: Array) -> Script:
    """The directions of a scenario of whose shoals so many fishes each live in its world."""
    shoals = Shoals([shoal.species for shoal in scenario.fish], numbers, [])
    everybody = np.arange(sum(numbers))

    def those(whose: Whose | None) -> Ints:
        return everybody if whose is None else np.array([*numbers_of(whose, shoals)], np.int64)

    def shown(one: Direction) -> Ints:
        follow = None if one.camera is None else one.camera.follow
        return those(follow) if isinstance(follow, Whose) else np.zeros(0, np.int64)

    names = {one.name: k for k, one in enumerate(scenario.direction) if one.name}
    acts = tuple(
        Act(
            one,
            those(one.who),
            those(one.of),
            those(one.hunts if isinstance(one.hunts, Whose) else None),
            shown(one),
            names.get(one.after or "", -1),
        )
        for one in scenario.direction
    )

    def depth(k: int) -> int:
        return 0 if acts[k].after < 0 else 1 + depth(acts[k].after)

    order = tuple(sorted(range(len(acts)), key=depth))
    return Script(acts, order, fastest_cm_s, tuple(scenario.species))


def direct(
    script: Script, state: State, nature: Nature, current_cm_s: tuple[float, float], clock: Clock
) -> None:
    """Begin the directions whose time has come, and go on with those that run."""
    if not script.acts:
        return
    scene, log = Scene(script, state, nature, current_cm_s, clock), state.directions
    for k in script.order:
        since = _watched_since(scene, k)
        cast = _cast(scene, k) if since is not None else None
        if since is not None and cast is not None and _begins(scene, k, since):
            _make_way(scene, k)
            log.began[k], log.running[k], log.stage[k] = clock.tick, True, 0
            log.cast[k] = cast if script.acts[k].direction.pair is None else NOBODY
            log.times[k] += 1
            for name in script.acts[k].direction.influences:
                if name in START:
                    START[name](scene, script.acts[k])
        log.ready[k] = cast is not None
    for k in np.argsort(log.began, kind="stable"):
        if log.running[k]:
            log.running[k] = _goes_on(scene, int(k))
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


# When.


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


def _cast(scene: Scene, k: int) -> Cast | None:
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
    return _one(act.of[alive & (_urge_to_eat(scene, act.of) <= scene.nature.keen)])


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


# What.


def _make_way(scene: Scene, k: int) -> None:
    """End what runs of the same kind as direction k for the same fishes, also itself."""
    acts, log = scene.script.acts, scene.state.directions
    kinds, mine = _kinds(acts[k].direction), _moved(scene, k)
    for other in np.flatnonzero(log.running):
        theirs = np.isin(_moved(scene, int(other)), mine)
        common = theirs.any() if acts[other].direction.pair is not None else theirs.all()
        if other == k or (kinds & _kinds(acts[other].direction) and common):
            _release(scene, int(other))
            log.running[other] = False


def _goes_on(scene: Scene, k: int) -> bool:
    """Do what direction k does in every tick; whether there is more to come."""
    one = scene.script.acts[k].direction
    going = False
    for name in one.influences:
        if name in HOLD and _lasts(scene, k, 0.0 if name in LET_GO else np.inf):
            going |= HOLD[name](scene, k)
    if not going:
        _release(scene, k)
    return going


def _release(scene: Scene, k: int) -> None:
    """Leave those whom direction k has moved to themselves."""
    act, minds = scene.script.acts[k], scene.state.minds
    for name in act.direction.influences:
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


def _kinds(one: Direction) -> set[str]:
    """What a direction does that another cannot do to the same fishes at the same time."""
    kinds = {"path_cm": "way", "hunts": "way", "pair": "way"}
    prey = {"prey"} if one.hunts or one.rests else set()
    return prey | {kinds.get(name, name) for name in one.influences if name in HOLD}


def _moved(scene: Scene, k: int) -> Ints:
    """Whom direction k moves; nobody if it moves the water, say."""
    act, pair = scene.script.acts[k], scene.state.directions.cast[k]
    if isinstance(act.direction.pair, tuple):
        return np.array(act.direction.pair)
    if act.direction.pair is not None:
        return pair[pair >= 0]
    return act.who if act.direction.who is not None else act.who[:0]


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


def _urge_to_eat(scene: Scene, those: Ints) -> Array:
    urge: Array = urge_to_eat(scene.state.minds, those, _now_s(scene))
    return urge


def _now_s(scene: Scene) -> float:
    return scene.clock.tick * scene.clock.dt


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
    now = _urge_to_eat(scene, act.who)
    wish = now + _share(scene, k) * (act.direction.hunger - now)
    set_hunger(minds, act.who, np.clip(wish, 0.0, 1.0), _now_s(scene))
    return True


def _libido(scene: Scene, k: int) -> bool:
    """Ease libido to what it is to be, and hold it there."""
    act, minds, now_s = scene.script.acts[k], scene.state.minds, _now_s(scene)
    assert act.direction.libido is not None
    now, hunger = urge_to_mate(minds, act.who, now_s), _urge_to_eat(scene, act.who)
    wish = now + _share(scene, k) * (act.direction.libido - now)
    set_libido(minds, act.who, hunger, wish, now_s)
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
    set_hunger(minds, those, 1.0, _now_s(scene))
    minds.fatigue[EAT, those] = 0.0
    if isinstance(hunts, Whose) and hunts.species is not None:
        minds.quarry[those] = *ANYONE[:2], scene.script.species.index(hunts.species)
    else:
        minds.quarry[those] = (act.prey[0], act.prey[-1] + 1, -1) if len(act.prey) else NOBODY
    _forget_prey(scene, those)


def _lull(scene: Scene, act: Act) -> None:
    """Let predators be sated, and mind nobody."""
    minds, those = scene.state.minds, _hunters(scene, act)
    set_hunger(minds, those, 0.0, _now_s(scene))
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
        for i in those[seeks & (_urge_to_eat(scene, those) > scene.nature.keen)]:
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
    just = minds.last_mating[two] >= _now_s(scene) - 1.5 * scene.clock.dt
    if not fishes.alive[two].all() or (spawned & just).all():
        log.stage[k] = OVER
    if log.stage[k] == OVER:
        minds.betrothed[two], minds.errand[two] = NOBODY, 0.0
        return False
    minds.betrothed[two], minds.errand[two] = other, 0.0
    set_hunger(minds, two, 0.0, _now_s(scene))
    if (minds.courtship[two] >= LOOPING).all() and (minds.partner[two] == other).all():
        log.stage[k] = COURTING
        return True
    place = act.direction.place_cm
    meet = fishes.position[two].mean(axis=0) if place is None else np.array(place)
    gaps = np.linalg.norm(fishes.position[two] - meet, axis=1)
    gathers = gaps.max() > (TOGETHER_CM if log.stage[k] == GATHERING else APART_CM)
    log.stage[k] = GATHERING if gathers else READY
    minds.shunned[two] = NOBODY
    set_libido(minds, two, 0.0, float(not gathers), _now_s(scene))
    if not gathers:
        rested = _now_s(scene) - REST_S - 1.0
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
