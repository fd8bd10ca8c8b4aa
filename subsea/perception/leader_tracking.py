"""Track the place of the leader, or of the middle of the school."""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.geometry.periodic import nearest_image
from subsea.geometry.vector import minus, norm, store, times, vector
from subsea.kernels import kernel
from subsea.perception.companions import sees_school
from subsea.perception.vision import sees_fish
from subsea.state import Clock, Fishes, Minds, Nature, Sea
from subsea.state.places import place_near
from subsea.state.schools import known_by


@kernel
def see_leader(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, seen: Bools
) -> None:
    """Set `seen` (n,) of the fishes `who`: whether they see the leader that they follow."""
    for i in who:
        leader = np.int64(minds.leader[i])
        follows = leader >= 0 and minds.led[i] and minds.schools[i] and fishes.alive[leader]
        seen[i] = follows and sees_fish(fishes, i, leader, sea, nature)


@kernel
def watch_leader(who: Ints, fishes: Fishes, minds: Minds, seen: Bools, clock: Clock) -> None:
    """Update `leader_place` and `leader_seen` of the fishes `who` that school.

    A fish that does not see its leader takes over the latest sighting of its companions: so a
    school finds its way around a pillar that hides the leader. In order of the index, as
    sightings are passed on.
    """
    now = clock.tick * clock.dt
    for i in who:
        leader = np.int64(minds.leader[i])
        if leader < 0 or not minds.led[i] or not minds.schools[i] or not fishes.alive[leader]:
            continue
        here = vector(fishes.position[i])
        if seen[i]:
            minds.leader_seen[i] = now
            store(minds.leader_place[i], place_near(fishes, leader, here))
            continue
        for j in minds.neighbour[i]:
            if j < 0:
                break
            if minds.leader[j] == leader and minds.leader_seen[j] > minds.leader_seen[i]:
                minds.leader_seen[i] = minds.leader_seen[j]
                place = nearest_image(vector(minds.leader_place[j]), here, fishes.period)
                store(minds.leader_place[i], place)


class Schools(NamedTuple):
    """The schools without a leader, each at the index of the fish by which it is known."""

    middle: Array  # (n, 3) cm, sum of the places of its fishes
    size: Array  # (n,) number of its fishes


@kernel
def schools_of(fishes: Fishes, minds: Minds) -> Schools:
    """Sum up places and numbers of the fishes of each school without a leader.

    In a box the places are those of the images about the circular mean of the school. So the middle
    of a school that is smaller than half the box is the one that it has in open water.
    """
    n = len(minds.leader)
    middle, size = np.zeros((n, 3)), np.zeros(n)
    about = _circular_means(fishes, minds) if fishes.period[0] > 0.0 else middle
    for i in range(n):
        school = known_by(minds, i)
        if _keeps_to_school(fishes, minds, i):
            size[school] += 1.0
            place = place_near(fishes, i, vector(about[school]))
            for axis in range(3):
                middle[school, axis] += place[axis]
    return Schools(middle, size)


@kernel
def _keeps_to_school(fishes: Fishes, minds: Minds, i: int) -> bool:
    """True if fish i lives, and schools without a leader."""
    return bool(fishes.alive[i] and minds.schools[i] and not minds.led[i])


@kernel
def _circular_means(fishes: Fishes, minds: Minds) -> Array:
    """Average the places of each school (n, 3) on the circles that x and y are in a box."""
    n = len(minds.leader)
    sums, mean = np.zeros((n, 4)), np.zeros((n, 3))
    for i in range(n):
        if _keeps_to_school(fishes, minds, i):
            school = known_by(minds, i)
            for axis in range(2):
                angle = 2.0 * np.pi * fishes.position[i, axis] / fishes.period[axis]
                sums[school, 2 * axis] += np.cos(angle)
                sums[school, 2 * axis + 1] += np.sin(angle)
    for school in range(n):
        for axis in range(2):
            angle = np.arctan2(sums[school, 2 * axis + 1], sums[school, 2 * axis])
            mean[school, axis] = angle / (2.0 * np.pi) * fishes.period[axis]
    return mean


@kernel
def watch_schools(
    who: Ints, fishes: Fishes, minds: Minds, nature: Nature, schools: Schools, clock: Clock
) -> None:
    """Update place and size of the schools without a leader, for the fishes `who` that see theirs.

    The place is the middle of all fishes of the school: fishes pass on where it is, as they do
    with the place of a leader.
    """
    for i in who:
        if minds.schools[i] and not minds.led[i]:
            school = known_by(minds, i)
            size = schools.size[school]
            here = vector(fishes.position[i])
            middle = times(1.0 / size, vector(schools.middle[school]))
            middle = nearest_image(middle, here, fishes.period)
            gap = norm(minus(middle, here))
            if not sees_school(fishes, minds, i, nature, gap):
                continue
            minds.leader_seen[i] = clock.tick * clock.dt
            minds.school_size[i] = size
            store(minds.leader_place[i], middle)
