"""Automatic steering: a tour of the scenario, or an autopilot that follows the action."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.geometry.solids import ray_meets_pillar, ray_meets_rock
from subsea.geometry.vector import Vector, vector
from subsea.state import (
    APPROACHING,
    CIRCLING,
    COURTSHIP,
    EAT,
    HOOKED,
    HULL_CM,
    NOBODY,
    PREDATOR,
    SINKING,
)
from subsea.submarine.vessel import (
    MAX_PITCH,
    Course,
    Helm,
    Rail,
    board,
    hull_axes,
    middle_of,
    rail_at,
)
from subsea.world.world import TICK_S, World

# Kinds of subjects, the most interesting first.
HOOK, HUNT, PAIR, FISH, SHOAL = range(5)
KEEP_S = 4.0  # time to keep looking at an ended subject: it may only be interrupted
FAITH = 0.5  # factor on the distance of the current hunter or pair, which is preferred
TURN_S = 2.0  # to change to another subject
DIPPED_CM = 30.0  # least depth of a hook to look at
COURT_CM = 350.0  # largest distance of a pair to look at
HUNT_CM = 900.0  # and of a hunter: farther ones are specks, and outrun the submarine
# A shoal and a large fish by turns; of fewer fishes than FEW it shows a large one instead.
SHOAL_S, FISH_S, FEW = 18.0, 22.0, 6
FISH_CM, LARGE_CM = 900.0, 20.0  # largest distance of a large fish, and least length

# Close enough to see a fish's eye, far enough not to crowd it: a pair stops dancing if it is.
SHOAL_CM, HOOK_CM, NEAREST_CM, FARTHEST_CM = 140.0, 140.0, 62.0, 600.0
# Framing. A picture is about 1.85 times as wide as its subject is far away.
GATHERED_CM, SHIFTS = 260.0, 3  # reach of what is seen of a shoal at a time, and steps to find it
MOST = 0.8  # share of those gathered that must not be cropped
FILLED = 1.3  # distance of a subject over its width, so that it fills 40% of the picture's width
PORTRAIT = 1.6  # distance of one fish over its length: from the side a third of the width
LEAD, LEAD_CM_S = 0.24, 12.0  # room before a moving subject over its distance; a brisk speed
LOW = (
    0.05  # how far below a shoal the view aims, over its distance: the sea floor is in the picture
)
# Three slow swings with incommensurate periods keep the view moving while the fishes hover.
NEARER, NEARER_S = 0.15, 31.0
ASIDE_RAD, ASIDE_S = 0.20, 23.0
ABOVE, ABOVE_S = 0.22, 17.0
LOOKAHEAD_S = 1.5  # the hull slips: begin to brake early
MOST_YAW = 0.27  # share of full thrust: it turns at 15° a second at most, as tours do
TILT_RAD_S, TILT = math.radians(10.0), 0.5  # change of the pitch asked for, and its largest share

MARGIN_CM = 10.0  # added to pillars and rocks when they hide something
DETOURS = np.radians([20.0, 35.0, 50.0, 65.0, 80.0])  # tried in turn, to get around an obstacle
DETOUR_CM, DETOUR_SURGE = 300.0, 0.3


Steer = Callable[[World], Helm | Rail]  # called once a tick; returns the command to the submarine


def steer_along(world: World, course: Course | None) -> Steer:
    """Put the submarine on a course at once and steer along it; None: the autopilot."""
    if course is None:
        return Tour().helm
    tick = world.state.tick
    board(
        world.state.submarine,
        rail_at(course, world.state, max(tick - 1, 0) * TICK_S),
        rail_at(course, world.state, tick * TICK_S),
    )
    return lambda world: rail_at(course, world.state, (world.state.tick + 1) * TICK_S)


class Subject(NamedTuple):
    """The subject of a tour: a kind from HOOK to SHOAL, and its members.

    Members of a hook: its catch, if any; of a hunt: hunter and prey; of a pair: male and female;
    of a large fish: itself; of a shoal: its species and number of living fishes.
    """

    kind: int
    members: tuple[int, ...] = ()


class Tour:
    """The autopilot. It depends on the world alone: the same dive has the same tour.

    It faces and follows its subject, with slow changes of distance, bearing and height, and gets
    around obstacles. Without fishes it cruises.
    """

    def __init__(self) -> None:
        self.subject: Subject | None = None
        self.aim = np.zeros(4)  # cm: the place to look at, and its distance
        self._seen = 0.0  # s, world time, when the subject was last seen
        self._changed = 0.0  # s, when the subject last changed
        self._offset = np.zeros(4)  # from the subject to the aim, at that moment
        self._side = 0.0  # on which it passes an obstacle: 1 left, -1 right
        self._pitch = 0.0  # the last command

    def helm(self, world: World) -> Helm:
        """The command for this tick; call once a tick."""
        now = world.state.tick * TICK_S
        subject = self._choose(world, now)
        if subject is None:
            return Helm(surge=0.3, yaw=0.1)
        aim = _aim(world, subject)
        if subject != self.subject:
            self._offset = self.aim - aim if self.subject else np.zeros(4)
            self.subject, self._changed = subject, now
        self.aim = aim + _faded((now - self._changed) / TURN_S) * self._offset
        return self._steer(world, now)

    def _choose(self, world: World, now: float) -> Subject | None:
        """The most interesting subject; or the current one, for a while after its end.

        A hook is dropped at once: it has left the water.
        """
        found = _subjects(world, self.subject, now)
        kind = self.subject.kind if self.subject else HOOK
        worse = found and found[0].kind > kind > HOOK
        if worse and now - self._seen < KEEP_S:
            return self.subject
        self._seen = now
        return found[0] if found else None

    def _steer(self, world: World, now: float) -> Helm:
        boat = world.state.submarine
        x, y, z = self.aim[:3] - boat.position
        level = math.hypot(x, y)
        wanted = self.aim[3] * (1.0 - NEARER * _swing(now, NEARER_S))
        wanted = max(wanted, NEAREST_CM)
        aside = self._detour(world, math.atan2(y, x))
        ahead = float(boat.velocity @ hull_axes(boat.angles[0], 0.0)[0])
        surge = _within((level - wanted - LOOKAHEAD_S * ahead) / 130.0, -0.4, 0.6)
        if aside:
            surge = max(surge, DETOUR_SURGE)
        else:
            aside = ASIDE_RAD * _swing(now, ASIDE_S)
        bearing = math.remainder(math.atan2(y, x) + aside - boat.angles[0], math.tau)
        pitch = _within(math.atan2(z, max(level, wanted)) / MAX_PITCH, -TILT, TILT)
        most = TILT_RAD_S / MAX_PITCH * TICK_S
        self._pitch += _within(pitch - self._pitch, -most, most)
        above = ABOVE * self.aim[3] * _swing(now, ABOVE_S)
        return Helm(
            surge=surge * math.cos(bearing / 2.0),
            yaw=_within(0.9 * bearing - 0.5 * boat.rates[0], -MOST_YAW, MOST_YAW),
            pitch=self._pitch,
            heave=_within((z + above) / 200.0, -0.4, 0.4),
        )

    def _detour(self, world: World, bearing: float) -> float:
        """Angle (rad) to steer left of the subject to see it again; 0 while it is visible."""
        boat = vector(world.state.submarine.position)
        if not hidden(world, boat, vector(self.aim[:3]), MARGIN_CM):
            self._side = 0.0
            return 0.0
        for angle in DETOURS:
            for side in (self._side,) if self._side else (1.0, -1.0):
                way = bearing + side * angle
                x, y, z = boat
                tip = x + DETOUR_CM * math.cos(way), y + DETOUR_CM * math.sin(way), z
                if not hidden(world, tip, boat, HULL_CM):
                    self._side = side
                    return float(side * angle)
        return float((self._side or 1.0) * DETOURS[-1])


def _subjects(world: World, present: Subject | None, now: float) -> list[Subject]:
    """All possible subjects, the most interesting first.

    The nearest hunt and the furthest advanced pair come first; the current ones are preferred, and
    a pair that circles is kept to its end. Hunts count within HUNT_CM, or the visibility
    if that is less, pairs within COURT_CM. Without them it looks at a shoal and a large fish by
    turns.
    """
    fishes, minds, sea = world.state.fishes, world.state.minds, world.state.sea
    if len(fishes.position) == 0:
        return []
    found = []
    state, catch = (int(value) for value in sea.catch)
    if SINKING <= state <= HOOKED and sea.hook[2] < -DIPPED_CM:
        found.append(Subject(HOOK, (catch,) if catch >= 0 else ()))
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
    stage = minds.courtship.astype(int)
    if lead != NOBODY and stage[lead] >= CIRCLING:
        stage[lead] = len(COURTSHIP)
    males = sorted(np.flatnonzero(courting), key=lambda i: (-stage[i], away[i]))
    found += [Subject(PAIR, (int(i), int(minds.partner[i]))) for i in males]
    counts = np.bincount(fishes.species[fishes.alive])
    if not len(counts):
        return found
    shoal = Subject(SHOAL, (int(counts.argmax()), int(counts.max())))
    large = fishes.alive & (away < min(world.scenario.water.visibility_cm, FISH_CM))
    large &= fishes.length > LARGE_CM
    if not large.any():
        return [*found, shoal]
    # Seen as large as possible, if it is reached soon.
    size = np.where(large, fishes.length / np.maximum(away, 3.0 * NEAREST_CM), 0.0)
    one = Subject(FISH, (int(size.argmax()),))
    if counts.max() < FEW or now % (SHOAL_S + FISH_S) >= SHOAL_S:
        return [*found, one]
    return [*found, shoal]


def _aim(world: World, subject: Subject) -> Array:
    """The place of a subject and the distance to look from: (4,), cm."""
    fishes = world.state.fishes
    if subject.kind == HOOK:
        return np.array([*world.state.sea.hook, HOOK_CM])
    if subject.kind == SHOAL:
        shoal = fishes.species == subject.members[0]
        living = shoal & fishes.alive
        return _gathered(world, np.flatnonzero(living if living.any() else shoal))
    members = list(subject.members)
    if subject.kind == FISH:
        far = _within(PORTRAIT * float(fishes.length[members[0]]), NEAREST_CM, FARTHEST_CM)
        return np.array([*fishes.position[members[0]].astype(np.float64), far])
    one, other = fishes.position[members].astype(np.float64)
    apart, longest = float(np.linalg.norm(one - other)), float(fishes.length[members].max())
    distance = PORTRAIT * longest + 0.5 * apart
    return np.array([*(one + other) / 2.0, _within(distance, NEAREST_CM, FARTHEST_CM)])


def _gathered(world: World, shoal: Ints) -> Array:
    """The place to look at, and the distance, for the part of a shoal that is gathered nearby.

    Fishes that swim on are at a third of the picture, with room before them.
    """
    fishes, eye = world.state.fishes, world.state.submarine.position
    there = fishes.position[shoal].astype(np.float64)
    middle = middle_of(there, eye)
    for _ in range(SHIFTS):
        away = np.linalg.norm(there - middle, axis=1)
        near = away <= max(GATHERED_CM, float(away.min()))
        middle = there[near].mean(axis=0)
    wide = 2.0 * float(np.quantile(np.linalg.norm(there[near] - middle, axis=1), MOST))
    length = float(fishes.length[shoal[near]].max())
    distance = _within(FILLED * (wide + length), SHOAL_CM, FARTHEST_CM)
    going = fishes.velocity[shoal[near]].mean(axis=0).astype(np.float64)
    lead = LEAD * distance * going / max(float(np.linalg.norm(going)), LEAD_CM_S)
    sight = (middle - eye) / max(float(np.linalg.norm(middle - eye)), 1e-6)
    lead -= (lead @ sight) * sight  # across the picture
    return np.array([*(middle + lead * (1.0, 1.0, 0.3)), distance]) - (
        0.0,
        0.0,
        LOW * distance,
        0.0,
    )


def hidden(world: World, a: Vector, b: Vector, margin: float) -> bool:
    """True if a pillar or rock lies between a and b, except one that contains b."""
    sea = world.state.sea
    return any(0.0 < ray_meets_pillar(row, margin, b, a) <= 1.0 for row in sea.pillars) or any(
        0.0 < ray_meets_rock(row, margin, b, a) <= 1.0 for row in sea.rocks
    )


def _faded(share: float) -> float:
    """Smooth step from 1 at 0 to 0 at 1."""
    t = min(max(share, 0.0), 1.0)
    return 1.0 - t * t * (3.0 - 2.0 * t)


def _swing(now: float, period: float) -> float:
    return math.sin(math.tau * now / period)


def _within(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)
