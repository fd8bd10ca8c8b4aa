"""Schools with a leader: follow it, align with neighbours, keep apart (Tu §7.9.2)."""

from subsea.base.arrays import Ints
from subsea.behavior.chasing import set_urge
from subsea.behavior.detour import detour, rocks_in_way
from subsea.behavior.moods import temper_of
from subsea.geometry.vector import ZERO, Vector, dot, minus, norm, plus, times, vector
from subsea.kernels import kernel
from subsea.state import Clock, Fishes, Minds, Sea
from subsea.state.places import place_near

SPACING_BL = 1.0  # distance to each neighbour
FOLLOW_BL = 5.0  # distance to the leader at which a follower catches up
OWN_WAY, COMPANY = 2.0, 0.3  # weights of way and company in passing an obstacle, ...
HURRY = 0.7  # ... and least speed there, to rejoin soon
SIGHT_S = 1.0  # how recently a leader must have been seen to copy its heading
LOST_S = 25.0  # how long a fish swims on to where it last saw its leader
# A school of n extends REACH_BL n^(1/3) from its leader, which waits while more than the share
# LEFT_BEHIND is farther away.
REACH_BL, LEFT_BEHIND = 3.0, 0.1


@kernel
def follow_leader(i: int, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """Follow the leader in company, or head for where it was last seen."""
    now = clock.tick * clock.dt
    here, length = vector(fishes.position[i]), float(fishes.length[i])
    leader = minds.leader[i]
    lost = now - minds.leader_seen[i]
    ahead = vector(fishes.goal_direction[leader]) if lost < SIGHT_S else ZERO
    toward = minus(vector(minds.leader_place[i]), here) if lost < LOST_S else ZERO
    pace = fishes.goal_speed[leader] if lost < SIGHT_S else fishes.goal_speed[i]
    spacing = SPACING_BL * temper_of(minds, i).spacing
    company = _company(fishes, minds.neighbour[i], i, spacing)
    urge = plus(plus(_pull(toward, length), ahead), company)
    rocks = rocks_in_way(sea, here, length)
    way = detour(urge, vector(fishes.velocity[i]), here, length, sea.pillars, rocks, 0.0)
    if norm(way) > 0.0:
        # Meanwhile climb or dive to the leader, as under an arch.
        way = (way[0], way[1], toward[2] / max(norm(toward), 1.0))
        urge = plus(times(OWN_WAY, way), (COMPANY * company[0], COMPANY * company[1], 0.0))
        pace = max(pace, HURRY)
    set_urge(minds, i, urge)
    whim = 0.08 * (fishes.identity[i] - 0.5)
    fishes.goal_speed[i] = _pace(toward, ahead, length, pace + whim)


@kernel
def _pull(toward: Vector, length: float) -> Vector:
    """Pull toward the leader, stronger with distance."""
    distance = norm(toward)
    lag = distance / (FOLLOW_BL * length)
    return times(min(lag * lag, 2.5) / max(distance, 1.0), toward)


@kernel
def _company(fishes: Fishes, neighbour: Ints, i: int, spacing: float) -> Vector:
    """Alignment with the neighbours, and separation at `spacing` body lengths."""
    out, ahead = ZERO, ZERO
    here = vector(fishes.position[i])
    count = 0
    for j in neighbour:
        if j < 0:
            break
        away = minus(here, place_near(fishes, j, here))
        distance = norm(away)
        space = spacing * 0.5 * (fishes.length[i] + fishes.length[j])
        if distance < 1.5 * space:
            crowd = 1.5 - distance / space
            out = plus(out, times(1.8 * crowd / max(distance, 0.1), away))
        its = vector(fishes.velocity[j])
        ahead = plus(ahead, times(1.0 / max(norm(its), 1.0), its))
        count += 1
    return plus(out, times(0.7 / max(count, 1), ahead))


@kernel
def _pace(toward: Vector, ahead: Vector, length: float, pace: float) -> float:
    """Speed: faster behind the leader or far away, slower ahead of it, never zero."""
    behind = max(dot(toward, ahead) / (FOLLOW_BL * length), -1.0)
    distance = norm(toward) / (FOLLOW_BL * length)
    return min(max(pace + 0.25 * behind + 0.5 * max(distance - 1.5, 0.0), 0.08), 1.0)


@kernel
def leaves_behind(fishes: Fishes, minds: Minds, leader: int, now: float) -> bool:
    """True if too many followers are farther from their leader than their school extends.

    Followers that lost the leader long ago do not count: a school does not wait for ever.
    """
    here, followers, behind = vector(fishes.position[leader]), 0, 0
    for i in range(len(minds.leader)):
        if _is_followed_by(fishes, minds, leader, i, now):
            followers += 1
    reach = REACH_BL * fishes.length[leader] * followers ** (1.0 / 3.0)
    for i in range(len(minds.leader)):
        if _is_followed_by(fishes, minds, leader, i, now):
            behind += norm(minus(place_near(fishes, i, here), here)) > reach
    return behind > LEFT_BEHIND * followers


@kernel
def _is_followed_by(fishes: Fishes, minds: Minds, leader: int, i: int, now: float) -> bool:
    """True if fish i is alive, follows that leader and knows where it is."""
    return minds.leader[i] == leader and fishes.alive[i] and now - minds.leader_seen[i] < LOST_S
