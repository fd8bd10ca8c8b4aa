"""Begin and end courtships (Tu §7.9.3), whose states are in `behavior/courtship.py`."""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import follow
from subsea.behavior.courtship import ALONE_S, LIMIT_S, enter, perform
from subsea.behavior.laying import nest_of
from subsea.behavior.manoeuvring import hover
from subsea.behavior.wandering import wander
from subsea.geometry.vector import minus, norm, plus, store, times, vector
from subsea.kernels import kernel
from subsea.state import (
    APPROACHING,
    ASCENDING,
    CIRCLING,
    LIBIDO,
    LOOPING,
    MATE,
    NO_COURTSHIP,
    NOBODY,
    PACIFIST,
    SPAWNING,
    Clock,
    Fishes,
    Minds,
    Nature,
    Sea,
)
from subsea.state.feelings import feel

STILL_KEEN = 0.6  # share of `keen` below which a courting fish stops
DEVOTED = 1.5  # least desire of a courting fish over `keen`
LOST_CM = 250.0  # distance at which a partner is out of sight
BONDS = 0.7  # liking that grows for a mate by spawning
REST_S = 30.0  # after spawning, before a fish courts again
SHUN_S = 45.0  # how long a fish shuns a former partner
APART_CM = 260.0  # distance of the place to which it turns away
RETURN_BL = 2.0  # how far below the start of their rush a pair returns to, in body lengths
PARTING_S = 12.0  # how long it heads there


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Libido of pacifists, where it exceeds `keen` and there is a mate to court."""
    for i in who:
        libido = minds.mental[i, LIBIDO]
        out[i] = 0.0
        if minds.kind[i] != PACIFIST:
            continue
        if minds.partner[i] != NOBODY:
            if minds.courtship[i] == SPAWNING:
                out[i] = 1.0  # it sees this through
            elif libido > STILL_KEEN * nature.keen:
                out[i] = max(libido, DEVOTED * nature.keen)
            continue
        rested = clock.tick * clock.dt - minds.last_mating[i] > REST_S
        if libido > nature.keen and rested and _may_court(fishes, minds, i, minds.mate[i]):
            out[i] = libido


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Choose partners, perform the state of each courtship, and advance those completed."""
    choose_partner(who, fishes, minds, sea, clock)
    courtship = minds.courtship[who]
    for state in range(APPROACHING, SPAWNING + 1):
        those = who[courtship == state]
        done = perform(state, those, fishes, minds, sea, clock)
        enter_next_state(those[done], fishes, minds, sea, clock)


@kernel
def choose_partner(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """Begin a courtship with the most desirable fish in sight, unless fish i has a partner.

    A male approaches her. A female follows a male that does not intend to mate, and hovers while
    one approaches her. She does not mind a male that courts another (`perception/mates.py`).
    """
    for i in who:
        j = minds.target[i]
        able = _may_court(fishes, minds, i, j)
        if minds.male[i] and able and minds.partner[i] == NOBODY:
            enter(fishes, minds, i, APPROACHING)
            minds.partner[i] = j
        if minds.courtship[i] != NO_COURTSHIP:
            continue
        if able and minds.intention[j] != MATE:
            follow(fishes, minds, i, j)
            continue
        if able and minds.partner[j] == i:
            hover(fishes, minds, i, 0.0)
        else:
            wander(fishes, minds, i, sea, clock)


@kernel
def end_courtships(who: Ints, fishes: Fishes, minds: Minds) -> None:
    """End the courtships of the fishes `who` that cannot go on.

    The partner died, is lost, attends to something else for too long or turned to another fish,
    or the state takes too long.
    """
    for i in who:
        minds.shunning[i] -= minds.pause[i]
        if minds.shunning[i] <= 0.0:
            minds.shunning[i] = 0.0
            minds.shunned[i] = NOBODY
        j = np.int64(minds.partner[i])
        if j == NOBODY:
            continue
        state = minds.courtship[i]
        minds.courtship_time[i] += minds.pause[i]
        minds.alone[i] = minds.alone[i] + minds.pause[i] if _is_alone(fishes, minds, i) else 0.0
        lost_to_another = minds.partner[j] != i and minds.courtship[j] >= CIRCLING
        if (
            not fishes.alive[j]
            or lost_to_another
            or minds.courtship_time[i] > LIMIT_S[state]
            or minds.alone[i] > ALONE_S[state]
        ):
            if minds.partner[j] == i:
                _part(fishes, minds, j)
            _part(fishes, minds, i)


@kernel
def _is_alone(fishes: Fishes, minds: Minds, i: int) -> bool:
    """True if the partner attends to something else, or is out of sight."""
    j = np.int64(minds.partner[i])
    if minds.intention[i] != MATE or minds.intention[j] != MATE:
        return True
    if minds.courtship[i] > APPROACHING and minds.partner[j] != i:
        return True
    return norm(minus(vector(fishes.position[i]), vector(fishes.position[j]))) > LOST_CM


@kernel
def enter_next_state(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """Begin the next state for the fishes `who` and, from circling on, for their partners.

    The male begins looping alone; she notices by herself. A pair with a nest goes from circling to
    it. After the last state both have mated, and return home, or to the depth where their rush
    began, or lower.
    """
    for i in who:
        j = np.int64(minds.partner[i])
        after = minds.courtship[i] + 1
        nests = nest_of(minds, j if minds.male[i] else i, sea) >= 0
        after = SPAWNING if nests and after == ASCENDING else after
        if after == LOOPING:
            enter(fishes, minds, i, after)
        elif after <= SPAWNING:
            enter(fishes, minds, i, after)
            enter(fishes, minds, j, after)
        else:
            minds.last_mating[i] = clock.tick * clock.dt
            minds.last_mating[j] = clock.tick * clock.dt
            feel(minds, i, j, BONDS)
            feel(minds, j, i, BONDS)
            for fish in (j, i):
                minds.ardent[fish] = False
                low = minds.courtship_mark[fish] - RETURN_BL * fishes.length[fish]
                _part(fishes, minds, fish)
                if nests:
                    store(minds.waypoint[fish], vector(minds.home[fish]))
                else:
                    minds.waypoint[fish, 2] = low


@kernel
def _may_court(fishes: Fishes, minds: Minds, i: int, j: int) -> bool:
    """True if fish i may court fish j: alive, of the other sex, not shunned, not taken."""
    if j < 0 or j == minds.shunned[i]:
        return False
    if minds.courtship[j] >= CIRCLING and minds.partner[j] != i:
        return False
    return bool(fishes.alive[j] and minds.kind[j] == PACIFIST and minds.male[j] != minds.male[i])


@kernel
def _part(fishes: Fishes, minds: Minds, i: int) -> None:
    """End the courtship of fish i: turn away from the partner and shun it for a while."""
    j = np.int64(minds.partner[i])
    enter(fishes, minds, i, NO_COURTSHIP)
    minds.partner[i] = NOBODY
    minds.target[i] = NOBODY
    minds.shunned[i] = j
    minds.shunning[i] = SHUN_S
    away = minus(vector(fishes.position[i]), vector(fishes.position[j]))
    away = (away[0], away[1], 0.3 * away[2])
    away = times(APART_CM / max(norm(away), 1e-3), away)
    store(minds.waypoint[i], plus(vector(fishes.position[i]), away))
    minds.patience[i] = PARTING_S
