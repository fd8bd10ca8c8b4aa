"""Motion of seaweed as that of joints, which any program plays.

A leaf is a chain of nodes (`habitat/seaweed.py`). Its mesh follows four of them: joints that only
shift, so that one joint can serve leaves at different places. Leaves that move alike share joints:
however many leaves a meadow has, its skeleton stays small.
"""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.habitat.seaweed import NODES

KEYS_PER_S = 10.0  # seaweed swings in seconds; between two keys it moves evenly
MOTIONS = 48  # most motions of a kind that its leaves share
FOLLOWED = (2, 4, 6, NODES - 1)  # nodes of a chain that are joints; its root stands still
ROUNDS = 8  # in which leaves are shared out


class BentLeaves(NamedTuple):
    """The leaves that the n vertices of a mesh follow."""

    leaf: Ints  # (n,) in `state.seaweed`
    along: Array  # (n,) place on the chain of the leaf, 0 at the root to 1 at the tip


class PlantMotion(NamedTuple):
    """Motion of a mesh of n vertices by J joints, which only shift, at K keys.

    Between keys all moves evenly.
    """

    frames: Ints  # (K,) of the keys, rising from 0
    places: Array  # (J, 3) cm, of the joints at frame 0; the first one stands still
    shifts: Array  # (K, J, 3) cm from there
    joints: Ints  # (n, 2) that a vertex follows ...
    weights: Array  # (n, 2) ... and how much, of sum 1

    def at(self, frame: float) -> Array:
        """Compute the shifts (n, 3) of the vertices in a frame, cm."""
        moved = [
            np.interp(frame, self.frames, way)
            for way in self.shifts.reshape(len(self.frames), -1).T
        ]
        shifts = np.array(moved).reshape(-1, 3)
        return np.asarray((self.weights[:, :, None] * shifts[self.joints]).sum(axis=1))


def key_frames(frames: int, fps: float) -> Ints:
    """Choose the frames of keys: some in a second, the first and the last."""
    step = max(round(fps / KEYS_PER_S), 1)
    return np.unique(np.append(np.arange(0, frames, step), frames - 1))


def plant_motion(bent: BentLeaves, nodes: Array, frames: Ints) -> PlantMotion:
    """Make the motion of a mesh whose leaves have nodes (K, L, NODES, 3), cm, at `frames` (K,)."""
    leaves, mine = np.unique(bent.leaf, return_inverse=True)
    ways = nodes[:, leaves][:, :, FOLLOWED].astype(np.float64)
    moved = (ways - ways[0]).swapaxes(0, 1)  # (l, K, 4, 3)
    share = share_motions(moved.reshape(len(leaves), -1), MOTIONS)
    number = int(share.max()) + 1
    of_share = [share == k for k in range(number)]
    shifts = np.array([moved[chosen].mean(axis=0) for chosen in of_share])
    places = np.array([ways[0, chosen].mean(axis=0) for chosen in of_share])
    # Joint 0 is the ground.
    wide = len(FOLLOWED)
    joints, weights = _joints_along(bent.along)
    first = wide * share[mine]
    return PlantMotion(
        frames=frames,
        places=np.concatenate([nodes[0, leaves[:1], 0], places.reshape(-1, 3)]),
        shifts=np.pad(shifts.swapaxes(0, 1).reshape(len(frames), -1, 3), ((0, 0), (1, 0), (0, 0))),
        joints=np.where(joints > 0, joints + first[:, None], 0),
        weights=weights,
    )


def _joints_along(along: Array) -> tuple[Ints, Array]:
    """Return the two joints about places (n,) on a chain, 0 for the root, and their weights."""
    at = np.array([0, *FOLLOWED]) / (NODES - 1)
    upper = np.clip(np.searchsorted(at, along, side="right"), 1, len(at) - 1)
    share = np.clip((along - at[upper - 1]) / (at[upper] - at[upper - 1]), 0.0, 1.0)
    return np.stack([upper - 1, upper], axis=1), np.stack([1.0 - share, share], axis=1)


def share_motions(motions: Array, most: int) -> Ints:
    """Share motions (l, d) out to at most `most` groups of similar ones (k-means).

    The groups begin with the motions farthest from those chosen before.
    """
    if len(motions) <= most:
        return np.arange(len(motions))
    middles = motions[[int((motions**2).sum(axis=1).argmax())]]
    gap = _squares(motions, middles)[:, 0]
    while len(middles) < most:
        middles = np.concatenate([middles, motions[[int(gap.argmax())]]])
        gap = np.minimum(gap, _squares(motions, middles[-1:])[:, 0])
    for _ in range(ROUNDS):
        share = _squares(motions, middles).argmin(axis=1)
        kept = [share == k for k in range(len(middles)) if (share == k).any()]
        middles = np.array([motions[chosen].mean(axis=0) for chosen in kept])
    share = _squares(motions, middles).argmin(axis=1)
    return np.unique(share, return_inverse=True)[1]


def _squares(rows: Array, others: Array) -> Array:
    """Compute squared distances (m, k) of rows (m, d) and (k, d)."""
    square = (rows**2).sum(axis=1)[:, None] + (others**2).sum(axis=1) - 2.0 * rows @ others.T
    return np.maximum(square, 0.0)
