"""Track the leader's place, by a fish's own eyes or from its companions."""

import numpy as np

from subsea.core.arrays import Ints
from subsea.core.kernels import kernel
from subsea.geometry.vector import store, vector
from subsea.perception.vision import Bodies, Surroundings, sees_fish
from subsea.state import Clock, Minds, Nature


@kernel
def watch_leader(
    who: Ints, bodies: Bodies, minds: Minds, scene: Surroundings, nature: Nature, clock: Clock
) -> None:
    """Update `leader_place` and `leader_seen` of the fishes `who` that school.

    A fish that does not see its leader takes over the latest sighting of its companions: so a
    school finds its way around a pillar that hides the leader.
    """
    now = clock.tick * clock.dt
    for i in who:
        leader = np.int64(minds.leader[i])
        if leader < 0 or not minds.schools[i] or not bodies.alive[leader]:
            continue
        if sees_fish(bodies, i, leader, scene, nature):
            minds.leader_seen[i] = now
            store(minds.leader_place[i], vector(bodies.position[leader]))
            continue
        for j in minds.neighbour[i]:
            if j < 0:
                break
            if minds.leader[j] == leader and minds.leader_seen[j] > minds.leader_seen[i]:
                minds.leader_seen[i] = minds.leader_seen[j]
                store(minds.leader_place[i], vector(minds.leader_place[j]))
