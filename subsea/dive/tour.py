"""Automatic steering: a tour of the scenario, or an autopilot that follows the action."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.dive.camera_way import beside, nearer
from subsea.geometry.rotation import matrix
from subsea.geometry.solids import height_at
from subsea.geometry.vector import vector
from subsea.habitat.contact import clearance
from subsea.state import (
    APPROACHING,
    CIRCLING,
    EAT,
    HOOKED,
    NOBODY,
    PREDATOR,
    SINKING,
)
from subsea.submarine.vessel import (
    AHEAD_CM_S,
    GAZE,
    Course,
    Helm,
    Rail,
    angles_of,
    board,
    hull_axes,
    middle_of,
    rail_at,
)
from subsea.view.display_rigs import WINDOW_AHEAD_CM
from subsea.world.world import TICK_S, World

# Kinds of subjects, the most interesting first.
HOOK, HUNT, PAIR, FISH, SHOAL = range(5)
DWELL_S = 8.0  # least time for a hunt, a pair or a large fish
KEEP_S = 4.0  # time to keep looking at an ended subject: it may only be interrupted
FAITH = 0.5  # factor on the distance of the current hunter or pair, which is preferred
DIPPED_CM = 30.0  # least depth of a hook to look at
COURT_CM, APART_CM = 350.0, 120.0  # largest distance of a pair to look at, and of its members
TO_ITS_END = 10**6  # in place of the stage of a pair that is kept
HUNT_CM = 900.0  # and of a hunter: farther ones are specks, and outrun the submarine
# A shoal and a large fish by turns; of fewer fishes than FEW it shows a large one instead.
SHOAL_S, FISH_S, FEW = 20.0, 40.0, 6
FISH_CM, LARGE_CM = 700.0, 26.0  # largest distance of a large fish, and least length
BEHIND = 1.5  # the larger, the less does it matter where a large fish is in the picture
AWAY = 0.25  # weight of the way to a large fish beside the distance that it is seen from
FASTEST = 2.0  # lengths a second of a fish that is framed easily
# Nearer to the ground a fish is hidden by growth, and out of the hull's reach: it counts less.
HIDES_CM, HIDDEN = 25.0, 0.35
BAIT_CM = 120.0  # largest distance of a fish from a hook to be shown with it
SMALL_CM = 16.0  # smaller fishes at a hook and in pairs are specks at the hull's least distance

# Close enough to see a fish's eye, far enough not to crowd it: a pair stops dancing if it is.
SHOAL_CM, PAIR_CM, NEAREST_CM, FARTHEST_CM = 110.0, 66.0, 58.0, 600.0
# Framing. A picture is about 1.85 times as wide as its subject is far away, and 1.04 times as high.
GATHERED, SHIFTS = 0.12, 3  # reach of a shoal over the visibility, and steps to find its middle
MOST = 0.8  # share of those gathered within its width
FILLED, FAR = 1.8, 0.45  # distance of a shoal over its width; at most, over the visibility
# Least distance of a moving fish over its speed, as the view turns slowly, up to a share of its
# distance at rest: from the side it covers a twentieth of the picture at 3.2 times the root of
# length times height.
PACE_S, SMALLEST, SIDE_ON = 2.2, 1.1, 1.9
SPECKS = 10.0  # most distance of a shoal over the length of its fishes
PORTRAIT = 1.15  # distance of one fish over its length: from the side half of the width
TOGETHER = 1.2  # L: farther apart than this, only the first of two fishes is framed
LEAD, LEAD_CM_S = 0.05, 12.0  # room before a moving shoal over its distance; a brisk speed
# The view is from the side that a swimming fish shows, and a little from ahead.
SIDE, AHEAD = 1.5, 0.5  # weights beside that of the present bearing
TURN, FREE = 0.4, 0.8  # rad from ahead of it, and more for each distance that it is farther away
FOLLOWS = 2.0  # 1/s: the aim follows its subject like a mass on a critically damped spring
GAZE_LAG_S = 2.0 / GAZE  # of the critically damped gaze behind a steady turn
# Three slow swings with incommensurate periods keep the view moving while the fishes hover.
NEARER, NEARER_S = 0.12, 31.0
ASIDE_RAD, ASIDE_S = 0.20, 23.0
ABOVE, ABOVE_S = 0.22, 17.0
FLAT = 0.6  # slope of the view down on a ray: from the side it is a line


Steer = Callable[[World], Helm | Rail]  # called once a tick; returns the command to the submarine


def steer_along(world: World, course: Course | None) -> Steer:
    """Put the submarine on a course at once and steer along it; None: the autopilot."""
    if course is None:
        return Tour().steer
    tick = world.state.tick
    board(
        world.state.submarine,
        rail_at(course, world.state, max(tick - 1, 0) * TICK_S),
        rail_at(course, world.state, tick * TICK_S),
    )
    return lambda world: rail_at(course, world.state, (world.state.tick + 1) * TICK_S)


class Subject(NamedTuple):
    """The subject of a tour: a kind from HOOK to SHOAL, and its members.

    Members of a hook: its catch, else a fish nearby; of a hunt: hunter and prey; of a pair: male
    and female; of a large fish: itself; of a shoal: its species and number of living fishes.
    """

    kind: int
    members: tuple[int, ...] = ()

    def same_as(self, other: "Subject") -> bool:
        """True if both are of one kind and led by the same fish."""
        return self.kind == other.kind and self.members[:1] == other.members[:1]


class Tour:
    """The autopilot. It depends on the world alone: the same dive has the same tour.

    It accompanies its subject at its side, with slow changes of distance, bearing and height, and
    gets around obstacles. Without fishes it cruises.
    """

    def __init__(self) -> None:
        self.subject: Subject | None = None
        self.aim: Array = np.zeros(4)  # cm: the place to look at, and its distance
        self._since = 0.0  # s, when the subject was chosen
        self._seen = 0.0  # s, world time, when the subject was last seen
        self._rate: Array = np.zeros(4)  # cm/s, of the aim

    def steer(self, world: World) -> Helm | Rail:
        """The command for this tick; call once a tick."""
        now = world.state.tick * TICK_S
        subject = self._choose(world, now)
        if subject is None:
            return Helm(surge=0.3, yaw=0.1)
        aim, going = _aim(world, subject)
        if self.subject is None:
            self.aim, self._rate = aim, np.array([*going, 0.0])
        self.subject = subject
        pull = FOLLOWS**2 * (aim - self.aim) + 2.0 * FOLLOWS * (
            np.array([*going, 0.0]) - self._rate
        )
        self._rate += TICK_S * pull
        self.aim = self.aim + TICK_S * self._rate
        return self._accompany(world, now)

    def _choose(self, world: World, now: float) -> Subject | None:
        """The most interesting subject; or the current one, for a while after its end.

        A hook is dropped at once: it has left the water.
        """
        found = _subjects(world, self.subject, now)
        kind = self.subject.kind if self.subject else HOOK
        worse = found and found[0].kind > kind > HOOK
        if worse and now - self._seen < KEEP_S:
            return self.subject
        if self.subject and HOOK < kind < SHOAL and now - self._since < DWELL_S:
            still = [one for one in found if one.same_as(self.subject)]
            if still:
                self._seen = now
                return still[0]
        if found and not (self.subject and found[0].same_as(self.subject)):
            self._since = now
        self._seen = now
        return found[0] if found else None

    def _accompany(self, world: World, now: float) -> Rail:
        """The submarine a tick later, on its way to the side of the subject."""
        boat, target, going = world.state.submarine, self.aim[:3], self._rate[:3]
        least = PAIR_CM if self.subject and self.subject.kind == PAIR else NEAREST_CM
        far = max(self.aim[3] * (1.0 - NEARER * _swing(now, NEARER_S)), least)
        away = boat.position - target
        shown, slope = going, 0.0
        if self.subject and self.subject.kind == FISH:
            fish = self.subject.members[0]
            shown = going + LEAD_CM_S * matrix(world.state.fishes.orientation[fish])[:, 0]
            high, wide = world.state.fishes.girth[fish]
            slope = FLAT if wide > 2.0 * high else 0.0
        bearing = _side(away, shown) + ASIDE_RAD * _swing(now, ASIDE_S)
        # It turns slowly: near its subject it moves so that it sees it ahead.
        most = TURN + FREE * max(float(np.linalg.norm(away)) / far - 1.0, 0.0)
        back = float(boat.angles[0]) + math.pi
        bearing = back + _within(math.remainder(bearing - back, math.tau), -most, most)
        way = np.array([math.cos(bearing), math.sin(bearing), 0.0])
        place = beside(world, target, way, slope + ABOVE * _swing(now, ABOVE_S), far)
        going = going * min(1.0, AHEAD_CM_S / max(float(np.linalg.norm(going)), 1e-6))
        place, velocity = nearer(world, place, going, 0.0)
        # The gaze lags: look where the subject will be.
        seen = target - place + GAZE_LAG_S * (going - velocity)
        return Rail(place, velocity, angles_of(seen, world.state))


def _side(way: Array, going: Array) -> float:
    """The bearing (rad) from a subject to a view of its side, near that of `way` (3,)."""
    away, ahead = way[:2] / max(math.hypot(*way[:2]), 1e-6), going[:2]
    speed = math.hypot(*ahead)
    ahead = ahead / max(speed, 1e-6)
    left = np.array([-ahead[1], ahead[0]])
    side = SIDE * math.copysign(1.0, left @ away) * left + AHEAD * ahead
    x, y = away + min(speed / LEAD_CM_S, 1.0) * side
    return math.atan2(y, x)


def _subjects(world: World, present: Subject | None, now: float) -> list[Subject]:
    """All possible subjects, the most interesting first.

    A hook with a fish near it comes first, then the nearest hunt, then the pair that is far
    advanced, large and near. The current ones are preferred, and a pair that circles is kept to
    its end. Hunts count within HUNT_CM, or the visibility if that is less, pairs within COURT_CM.
    Without them it looks at a shoal and a large fish by turns.
    """
    fishes, minds, sea = world.state.fishes, world.state.minds, world.state.sea
    if len(fishes.position) == 0:
        return []
    found = []
    state, catch = (int(value) for value in sea.catch)
    if SINKING <= state <= HOOKED and sea.hook[2] < -DIPPED_CM:
        near_hook = catch if catch >= 0 else _at_hook(world, present)
        if near_hook != NOBODY:
            found.append(Subject(HOOK, (near_hook,)))
    away = np.linalg.norm(fishes.position - world.state.submarine.position, axis=1)
    lead = present.members[0] if present and present.kind in (HUNT, PAIR, FISH) else NOBODY
    if lead != NOBODY:
        away[lead] *= FAITH
    near = fishes.alive & (away < min(world.scenario.water.visibility_cm, HUNT_CM))
    hunting = near & (minds.kind == PREDATOR) & (minds.intention == EAT) & (minds.target >= 0)
    hunting[hunting] = fishes.alive[minds.target[hunting]]
    hunters = sorted(np.flatnonzero(hunting), key=lambda i: away[i])
    found += [Subject(HUNT, (int(i), int(minds.target[i]))) for i in hunters]
    courting = fishes.alive & (away < COURT_CM) & minds.male
    courting &= (minds.courtship > APPROACHING) & (minds.partner >= 0)
    courting &= fishes.length > SMALL_CM
    apart = fishes.position - fishes.position[minds.partner]
    courting &= np.linalg.norm(apart, axis=1) < APART_CM
    stage = minds.courtship.astype(int)
    if lead != NOBODY and stage[lead] >= CIRCLING:
        stage[lead] = TO_ITS_END
    shown = stage * fishes.length / np.maximum(away, NEAREST_CM)
    males = sorted(np.flatnonzero(courting), key=lambda i: -shown[i])
    found += [Subject(PAIR, (int(i), int(minds.partner[i]))) for i in males]
    living = fishes.alive & minds.schools
    if not living.any():
        living = fishes.alive
    if not living.any():
        return found
    sizes = np.bincount(fishes.species[living], weights=np.minimum(fishes.length[living], LARGE_CM))
    species = int(sizes.argmax())
    count = int(np.count_nonzero(fishes.species[living] == species))
    shoal, few = Subject(SHOAL, (species, count)), count < FEW
    sight = world.scenario.water.visibility_cm
    large = fishes.alive & (away < (sight if few else min(sight, FISH_CM)))
    large &= fishes.length > (0.0 if few else LARGE_CM)
    clear = np.zeros(len(large), bool)
    for fish in np.flatnonzero(large):
        clear[fish] = _open(world, int(fish), 0.5 if fish == lead else 1.0)
    if not few:
        large &= clear
    if not large.any() or (not few and now % (SHOAL_S + FISH_S) < SHOAL_S):
        return [*found, shoal]
    who = np.flatnonzero(large)
    shown = _shown(world, who, away[who], lead) * np.where(clear[who], 1.0, HIDDEN)
    return [*found, Subject(FISH, (int(who[shown.argmax()]),))]


def _shown(world: World, who: Ints, away: Array, lead: int) -> Array:
    """How well large fishes (n,) can be shown: large in the picture, soon, calm, ahead."""
    fishes, boat = world.state.fishes, world.state.submarine
    places, length = fishes.position[who].astype(np.float64), fishes.length[who]
    far = np.maximum(PORTRAIT * length, NEAREST_CM)
    size = length / (far + AWAY * np.maximum(away - far, 0.0))
    speed = np.linalg.norm(fishes.velocity[who], axis=1)
    size = size / (1.0 + (speed / np.minimum(FASTEST * length, AHEAD_CM_S)) ** 2)
    gaze = (places - boat.position) @ hull_axes(*boat.angles)[0]
    return (
        size**2 * (BEHIND + gaze / np.maximum(away, 1.0)) * np.where(who == lead, 1.0 / FAITH, 1.0)
    )


def _open(world: World, fish: int, share: float) -> bool:
    """True if a fish swims clear of stone and ground, by a `share` of HIDES_CM."""
    sea, place = world.state.sea, vector(world.state.fishes.position[fish])
    over = place[2] - height_at(sea.floor, sea.half_width, place[0], place[1])
    return bool(min(over, clearance(sea.pillars, sea.rocks, place)) > share * HIDES_CM)


def _at_hook(world: World, present: Subject | None) -> int:
    """The largest fish near the hook, the present one preferred; or NOBODY if all are small."""
    fishes, size = world.state.fishes, world.state.fishes.length.copy()
    size[~fishes.alive | (size < SMALL_CM)] = 0.0
    size[np.linalg.norm(fishes.position - world.state.sea.hook, axis=1) > BAIT_CM] = 0.0
    if present and present.kind == HOOK and present.members:
        size[present.members[0]] /= FAITH
    return int(size.argmax()) if size.max() > 0.0 else NOBODY


def _aim(world: World, subject: Subject) -> tuple[Array, Array]:
    """The place of a subject with the distance to look from (4,), cm, and its velocity (3,)."""
    fishes = world.state.fishes
    if subject.kind == SHOAL:
        shoal = fishes.species == subject.members[0]
        living = shoal & fishes.alive
        if (living & world.state.minds.schools).any():
            living &= world.state.minds.schools
        return _gathered(world, np.flatnonzero(living if living.any() else shoal))
    members = list(subject.members)
    places = fishes.position[members].astype(np.float64)
    if subject.kind == HOOK:
        places = np.array([*places, world.state.sea.hook])
    going = _moved(world, np.array(members))
    longest = float(fishes.length[members].max())
    reach = 0.5 * (places[-1] - places[0])  # none of a single fish
    share = _faded(4.0 * float(np.linalg.norm(reach)) / (TOGETHER * longest) - 1.0)
    both = float(fishes.length[members[0]])
    if len(members) > 1:
        both += share * float(fishes.length[members[1]])
    side = SIDE_ON * math.sqrt(both * float(fishes.girth[members, 0].max()))
    far = max(PORTRAIT * both, side + WINDOW_AHEAD_CM) + share * float(np.linalg.norm(reach))
    middle, velocity = places[0] + share * reach, going[0] + 0.5 * share * (going[-1] - going[0])
    far = max(far, min(PACE_S * float(np.linalg.norm(velocity)), SMALLEST * far))
    return np.array([*middle, _within(far, NEAREST_CM, FARTHEST_CM)]), velocity


def _moved(world: World, who: Ints) -> Array:
    """Velocities (n, 3) in the last tick, cm/s; a fish that grazes pushes against the ground."""
    fishes = world.state.fishes
    way = fishes.position[who].astype(np.float64) - fishes.previous_position[who]
    return np.asarray(way / TICK_S)


def _gathered(world: World, shoal: Ints) -> tuple[Array, Array]:
    """The place of the part of a shoal that is gathered nearby, with the distance; its velocity.

    Fishes that swim on have some more room before them than behind.
    """
    fishes, eye = world.state.fishes, world.state.submarine.position
    sight = world.scenario.water.visibility_cm
    there = fishes.position[shoal].astype(np.float64)
    middle = middle_of(there, eye)
    for _ in range(SHIFTS):
        away = np.linalg.norm(there - middle, axis=1)
        near = away <= max(GATHERED * sight, float(away.min()))
        middle = there[near].mean(axis=0)
    wide = 2.0 * float(np.quantile(np.linalg.norm(there[near] - middle, axis=1), MOST))
    length = float(fishes.length[shoal[near]].max())
    most = max(min(FAR * sight, SPECKS * length), SHOAL_CM)
    distance = _within(FILLED * (wide + length), SHOAL_CM, most)
    going = _moved(world, shoal[near]).mean(axis=0)
    lead = LEAD * distance * going / max(float(np.linalg.norm(going)), LEAD_CM_S)
    ahead = (middle - eye) / max(float(np.linalg.norm(middle - eye)), 1e-6)
    lead -= (lead @ ahead) * ahead  # across the picture
    return np.array([*(middle + lead * (1.0, 1.0, 0.3)), distance]), going


def _faded(share: float) -> float:
    """Smooth step from 1 at 0 to 0 at 1."""
    t = min(max(share, 0.0), 1.0)
    return 1.0 - t * t * (3.0 - 2.0 * t)


def _swing(now: float, period: float) -> float:
    return math.sin(math.tau * now / period)


def _within(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)
