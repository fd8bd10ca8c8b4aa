"""Collision detection, with other fishes and with obstacles (Tu §6.6.1, SMC §6.2)."""

import math
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Ints
from subsea.geometry.rotation import conjugate, rotate
from subsea.geometry.solids import (
    NEVER,
    from_pillar,
    from_rock,
    height_at,
    is_far_from_rocks,
    ray_meets_pillar,
    ray_meets_rock,
    ray_meets_seabed,
)
from subsea.geometry.vector import Vector, dot, minus, norm, plus, times, vector
from subsea.kernels import kernel
from subsea.perception.crowd import Crowd, Path, find_meetings, place_of, radius_of, room_for
from subsea.perception.vision import (
    FIELD_COS,
    ahead_of,
    along_body,
    along_body_near,
    along_from,
    eye_of,
)
from subsea.state import (
    APPROACHING,
    AVOID,
    BATHE,
    CLEAN,
    EAT,
    GRAZE,
    NOBODY,
    PICK,
    POSE,
    PREDATOR,
    SCHOOL,
    SEABED,
    SHELTER,
    SURFACE,
    WALL,
    Fishes,
    Minds,
    Nature,
    Sea,
)
from subsea.state.habits import keeps_low
from subsea.state.places import place_near

ANTENNA_BL = 1.0  # length of the ray that detects obstacles (Tu §6.6.1) ...
ENLARGED = 1.5  # ... and factor on all sizes for fishes with recorded motion (SMC §6.2)
BERTH_WIDTHS = 1.5  # widths of the body by which obstacles are enlarged
LOW = 0.4  # factor on both for a fish of the ground or of stone, which has it about it always
# The sensitivity region is a box around the body with a margin on all sides ...
MARGIN_BL = 0.08
SCHOOLING_BL = 0.02  # in formation (Tu §7.9.2)
COURTING_BL = 0.0  # in courtship (Tu §7.9.3)
# ... swept along the relative velocity for this time.
FORESIGHT_S = 0.6
SCHOOLING_S = 0.3
COURTING_S = 0.1
HELD = 1.3  # factor on the region for what a fish is already avoiding: hysteresis
STATIONS = 7  # least number of points of a centre line ...
FINEST, MOST_STATIONS = 0.3, 64  # ... which are at most 0.3 lengths of the other apart


@kernel
def find_threats(who: Ints, fishes: Fishes, minds: Minds, crowd: Crowd, nature: Nature) -> None:
    """Set `minds.threat` of the fishes `who`: the fish that is most likely to collide with it.

    The crowd has all fishes. The threat is the fish with the largest share of its centre line in
    the sensitivity region; of equal ones the nearest. Hunted prey and the partner in courtship are
    not threats.
    """
    slots = room_for(crowd)
    for i in who:
        region = sensitivity(minds, i, nature)
        worst = (np.int64(NOBODY), 0.0, np.inf)
        before = np.int64(minds.threat[i])
        avoids = minds.intention[i] == AVOID and before != NOBODY and before != region.welcome
        if avoids and fishes.alive[before]:
            share = share_inside(fishes, i, before, HELD * region.margin, HELD * region.foresight)
            here = along_body(fishes, i, 0.5)
            gap = minus(along_body_near(fishes, before, 0.5, here), here)
            if share > 0.0:
                worst = (before, share, dot(gap, gap))
        minds.threat[i] = worst_threat(fishes, i, region, crowd, slots, worst)


class SensitivityRegion(NamedTuple):
    """The collision sensitivity region of a fish."""

    margin: float  # body lengths beyond the body, on all sides
    foresight: float  # s, for which the relative motion is extrapolated
    welcome: int  # the fish that may enter it, or NOBODY


@kernel
def caution(minds: Minds, i: int, nature: Nature) -> float:
    """Factor on the sizes of all that fish i uses to foresee collisions (Tu §6.6.1)."""
    return ENLARGED * nature.timidity * float(minds.timidity[i])


@kernel
def sensitivity(minds: Minds, i: int, nature: Nature) -> SensitivityRegion:
    """The region of fish i, by what it intends."""
    scale = caution(minds, i, nature)
    intention = minds.intention[i]
    interrupted = minds.memory[i] if intention == AVOID else intention
    margin, foresight, welcome = MARGIN_BL, FORESIGHT_S, int(NOBODY)
    if minds.courtship[i] > APPROACHING:
        margin, foresight, welcome = COURTING_BL, COURTING_S, int(minds.partner[i])
    elif interrupted in (SCHOOL, PICK) or (interrupted == EAT and minds.schools[i]):
        margin, foresight = SCHOOLING_BL, SCHOOLING_S
    elif interrupted in (GRAZE, POSE, CLEAN, SHELTER, BATHE):
        # They tolerate neighbours, and the cleaner and its client touch.
        margin, foresight = SCHOOLING_BL, SCHOOLING_S
        if interrupted == POSE:
            welcome = int(minds.cleaner[i])
        elif interrupted == CLEAN:
            welcome = int(minds.client[i])
    elif interrupted == EAT and minds.kind[i] == PREDATOR:
        prey = minds.memory_target[i] if intention == AVOID else minds.target[i]
        welcome = int(prey)
    return SensitivityRegion(scale * margin, scale * foresight, welcome)


@kernel
def worst_threat(
    fishes: Fishes, i: int, region: SensitivityRegion, crowd: Crowd, slots: Ints,
    worst: tuple[int, float, float],
) -> int:  # fmt: skip
    """The worst threat to fish i in a crowd, or that of `worst` where none is worse.

    `worst` is a fish or NOBODY, the share of it inside the region, and its distance squared.
    `slots` is memory from `room_for`.
    """
    margin, foresight, welcome = region
    here, velocity = along_body(fishes, i, 0.5), vector(fishes.velocity[i])
    around = radius_of(fishes, i) + 3.0 * margin * float(fishes.length[i])
    row, count = find_meetings(crowd, Path(here, velocity, around, foresight), slots)
    for k in range(count):
        slot = slots[row, k]
        j = crowd.member[slot]
        if j in (i, welcome, NOBODY):
            continue
        gap = minus(place_of(crowd, slot), here)
        squared = dot(gap, gap)
        share = share_inside(fishes, i, j, margin, foresight)
        nearer = squared < worst[2] or (squared == worst[2] and j < worst[0])
        if share > worst[1] or (share == worst[1] > 0.0 and nearer):
            worst = (j, share, squared)
    return worst[0]


@kernel
def share_inside(fishes: Fishes, i: int, j: int, margin: float, foresight: float) -> float:
    """The share of the centre line of fish j that lies in the sensitivity region of fish i.

    A point is inside if it would enter the box around i, enlarged by half the girths of j and by
    `margin` body lengths, within `foresight` seconds at the velocity of j relative to i. So a fish
    alongside is not a threat, however near, and one met head-on is one from afar. Points in the
    blind angle behind i do not count.
    """
    back = conjugate(fishes.orientation[i])
    length, other = float(fishes.length[i]), float(fishes.length[j])
    room = margin * length
    tall = 0.5 * (float(fishes.girth[i, 0]) + float(fishes.girth[j, 0])) + room
    wide = 0.5 * (float(fishes.girth[i, 1]) + float(fishes.girth[j, 1])) + room
    front, tail = float(fishes.snout[i]) + room, float(fishes.snout[i]) - length - room
    low, high = (tail, -tall, -wide), (front, tall, wide)
    drift = minus(vector(fishes.velocity[j]), vector(fishes.velocity[i]))
    way = times(foresight, rotate(back, drift))
    here = vector(fishes.position[i])
    there = place_near(fishes, j, here)
    middle = rotate(back, minus(along_from(there, fishes, j, 0.5), here))
    if not _sweeps(middle, way, low, high, 0.5 * other):
        return 0.0
    first = rotate(back, minus(along_from(there, fishes, j, 0.0), here))
    step = times(2.0, minus(middle, first))
    stations = int(min(max(math.ceil(other / (FINEST * length)), STATIONS), MOST_STATIONS))
    inside = 0
    for k in range(stations):
        p = plus(first, times(k / (stations - 1.0), step))
        ray = (p[0] - float(fishes.snout[i]), p[1], p[2])
        if ray[0] > FIELD_COS * norm(ray) and _sweeps(p, way, low, high, 0.0):
            inside += 1
    return inside / stations


@kernel
def _sweeps(p: Vector, way: Vector, low: Vector, high: Vector, more: float) -> bool:
    """True if p moved by `way` enters a box that is `more` cm larger on all sides."""
    first, last = 0.0, 1.0
    for axis in range(3):
        a, b = low[axis] - more - p[axis], high[axis] + more - p[axis]
        if abs(way[axis]) < 1e-9:
            if a > 0.0 or b < 0.0:
                return False
            continue
        enter, leave = a / way[axis], b / way[axis]
        first = max(first, min(enter, leave))
        last = min(last, max(enter, leave))
    return first <= last


@kernel
def find_barriers(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature) -> None:
    """Set `minds.barrier` of the fishes `who`: the nearest obstacle that a ray ahead meets.

    A pillar, a rock, seabed, surface or wall, each enlarged by 1.5 widths of the body. A flat body
    enlarges seabed and surface by 1.5 times its height. A fish that keeps to the ground or lives on
    stone looks less far and keeps a narrower berth. None for a fish that feeds or hides close to
    stone.
    """
    for i in who:
        if fishes.close[i]:
            minds.barrier[i] = -1
            continue
        antenna = caution(minds, i, nature) * ANTENNA_BL * float(fishes.length[i])
        held = HELD if minds.intention[i] == AVOID and minds.barrier[i] != -1 else 1.0
        share = LOW if keeps_low(minds, i) else 1.0
        minds.barrier[i] = nearest_barrier(
            fishes, i, sea, share * held * antenna, share * BERTH_WIDTHS
        )


@kernel
def nearest_barrier(fishes: Fishes, i: int, sea: Sea, antenna: float, widths: float) -> int:
    """The obstacle that a ray of `antenna` cm ahead of fish i meets, or -1.

    Obstacles are enlarged by a berth of `widths` widths of the body. Of several it is the one whose
    boundary is nearest to the eye (Tu §6.6.1). An obstacle within the berth of the fish counts only
    if the fish heads for it.
    """
    berth = widths * float(fishes.girth[i, 1])
    level = widths * float(min(fishes.girth[i, 0], fishes.girth[i, 1]))
    eye, ahead = eye_of(fishes, i), ahead_of(fishes, i)
    tip = plus(eye, times(antenna, ahead))
    found, nearest = -1, NEVER
    for k in range(len(sea.pillars)):
        t = ray_meets_pillar(sea.pillars[k], berth, eye, tip)
        if t < NEVER:
            normal, gap = from_pillar(sea.pillars[k], eye)
            if gap < nearest and (t > 0.0 or dot(normal, ahead) < 0.0):
                found, nearest = k, gap
    clear = is_far_from_rocks(sea.tops, sea.half_width, eye, antenna + berth)
    for k in range(0 if clear else len(sea.rocks)):
        t = ray_meets_rock(sea.rocks[k], berth, eye, tip)
        if t < NEVER:
            normal, gap = from_rock(sea.rocks[k], eye)
            if gap < nearest and (t > 0.0 or dot(normal, ahead) < 0.0):
                found, nearest = len(sea.pillars) + k, gap
    if tip[2] > -level and ahead[2] > 0.0 and -eye[2] < nearest:
        found, nearest = SURFACE, -eye[2]
    edge = sea.radius - berth
    outward = tip[0] * ahead[0] + tip[1] * ahead[1]
    if tip[0] * tip[0] + tip[1] * tip[1] > edge * edge and outward > 0.0:
        gap = sea.radius - math.sqrt(eye[0] * eye[0] + eye[1] * eye[1])
        if gap < nearest:
            found, nearest = WALL, gap
    t = ray_meets_seabed(sea.floor, sea.half_width, level, eye, tip)
    above = eye[2] - height_at(sea.floor, sea.half_width, eye[0], eye[1])
    if t < NEVER and above < nearest and (t > 0.0 or ahead[2] < 0.0):
        found = SEABED
    return found
