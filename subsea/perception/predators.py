"""Predators that prey see, and how fearful each of them is (Tu §7.4)."""

import numpy as np

from subsea.base.arrays import Ints
from subsea.geometry.vector import dot, minus, norm, vector
from subsea.kernels import kernel
from subsea.perception.grid import ROUNDING, Grid, insert, near_slots
from subsea.perception.vision import SUBMARINE_CM, eye_of, sees_fish, sees_point, sight
from subsea.state import NOBODY, PREY, SUBMARINE, Fishes, Minds, Nature, Sea
from subsea.state.feelings import dread_of

CELL_CM = 400.0  # large, as predators are few and seen from afar
FELT_BL = 0.8  # distance, in lengths of the predator, at which its bow wave is felt
# Speeds of a predator, in its lengths per second: of one that cruises, and of one that is feared
# fully. Prey distinguish attackers from predators that pass (Helfman, Anim. Behav. 37:838, 1989).
CALM_BL_S, ROUSED_BL_S = 0.6, 1.0


@kernel
def see_predators(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, grid: Grid, nature: Nature
) -> None:
    """Set what the fishes `who` fear, from the predators in `grid`.

    Predator j, d cm away, is as fearful as Fʲ = min(D₀/d, 1); D₀ is less while it cruises. The
    submarine counts as one more, with its own D₀, unless that is 0. Only prey fear (Tu §7.9).
    `minds.menaces` is the sum, at most 1; once it is 1, only more fearful predators are examined.
    The lateral line feels the bow wave of a predator that is near, also in the blind angle.
    """
    longest = 0.0
    for j in grid.member:
        longest = max(longest, float(fishes.length[j]))
    farthest = sight(longest, nature)
    cost = np.empty(minds.predators.shape[1])
    slots = np.empty(len(grid.member), np.int64)
    for i in who:
        worst = minds.predators[i]
        worst[:] = NOBODY
        cost[:] = np.inf
        total = 0.0
        if minds.kind[i] == PREY:
            eye = eye_of(fishes, i)
            there = vector(sea.submarine)
            dread = dread_of(minds, i, SUBMARINE, nature)
            if dread > 0.0 and sees_point(fishes, i, sea, there, sight(SUBMARINE_CM, nature)):
                danger = fearfulness(dread, norm(minus(there, eye)))
                total += min(danger, 1.0)
                insert(worst, cost, SUBMARINE, -danger)
            for k in range(near_slots(grid, eye, farthest, slots)):
                j = grid.member[slots[k]]
                gap = minus(vector(grid.place[slots[k]]), eye)
                if dot(gap, gap) > ROUNDING * farthest * farthest:
                    continue
                dread = threat_of(fishes, j, nature) * dread_of(minds, i, j, nature)
                danger = fearfulness(dread, norm(gap))
                if total >= 1.0 and -danger > cost[-1]:
                    continue  # it adds nothing, and the test of sight is the most expensive
                felt = norm(gap) < FELT_BL * float(fishes.length[j])
                if felt or sees_fish(fishes, i, j, sea, nature):
                    total += min(danger, 1.0)
                    insert(worst, cost, j, -danger)
        minds.predator[i] = worst[0]
        minds.menace[i] = min(-cost[0], 1.0) if worst[0] != NOBODY else 0.0
        minds.menaces[i] = min(total, 1.0)


@kernel
def threat_of(fishes: Fishes, j: int, nature: Nature) -> float:
    """Share of D₀ of predator j: `nature.calm_dread` while it cruises, 1 while it is fast."""
    way = minus(vector(fishes.velocity[j]), vector(fishes.drift[j]))
    speed = norm(way) / float(fishes.length[j])
    share = min(max((speed - CALM_BL_S) / (ROUSED_BL_S - CALM_BL_S), 0.0), 1.0)
    return nature.calm_dread + (1.0 - nature.calm_dread) * share


@kernel
def fearfulness(dread: float, distance: float) -> float:
    """D₀/d."""
    return dread / max(distance, 1e-6)
