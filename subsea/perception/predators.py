"""Predators that prey see, and how fearful each of them is (Tu §7.4)."""

import numpy as np

from subsea.base.arrays import Ints
from subsea.geometry.vector import dot, minus, norm, vector
from subsea.kernels import kernel
from subsea.perception.grid import ROUNDING, Grid, insert, near_slots
from subsea.perception.vision import SUBMARINE_CM, eye_of, sees_fish, sees_point, sight
from subsea.state import NOBODY, PREY, SUBMARINE, Fishes, Minds, Nature, Sea

CELL_CM = 400.0  # large, as predators are few and seen from afar
FELT_BL = 0.8  # distance, in lengths of the predator, at which its bow wave is felt


@kernel
def see_predators(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, grid: Grid, nature: Nature
) -> None:
    """Set what the fishes `who` fear, from the predators in `grid`.

    Predator j, d cm away, is as fearful as Fʲ = min(D₀/d, 1). The submarine counts as one
    more, with its own D₀, unless that is 0. Only prey fear (Tu §7.9). `minds.menaces` is the
    sum, at most 1; once it is 1, only more fearful predators are examined. The lateral line
    feels the bow wave of a predator that is near, also in the blind angle.
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
            dread = nature.submarine_cm * float(minds.hull_dread[i])
            if dread > 0.0 and sees_point(fishes, i, sea, there, sight(SUBMARINE_CM, nature)):
                danger = fearfulness(dread, norm(minus(there, eye)))
                total += min(danger, 1.0)
                insert(worst, cost, SUBMARINE, -danger)
            for k in range(near_slots(grid, eye, farthest, slots)):
                j = grid.member[slots[k]]
                gap = minus(vector(grid.place[slots[k]]), eye)
                if dot(gap, gap) > ROUNDING * farthest * farthest:
                    continue
                danger = fearfulness(float(minds.dread[i]), norm(gap))
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
def fearfulness(dread: float, distance: float) -> float:
    """D₀/d."""
    return dread / max(distance, 1e-6)
