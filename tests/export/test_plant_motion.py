"""Joints of seaweed against the leaves of the dive."""

import numpy as np
import pytest

from subsea.export.plant_motion import (
    FOLLOWED,
    MOTIONS,
    BentLeaves,
    key_frames,
    plant_motion,
    share_motions,
)
from subsea.habitat.seaweed import NODES


def test_keys_hold_the_first_and_the_last_frame() -> None:
    assert key_frames(8, 30.0).tolist() == [0, 3, 6, 7]
    assert key_frames(1, 30.0).tolist() == [0]
    assert key_frames(5, 8.0).tolist() == [0, 1, 2, 3, 4]


def waves(number: int, keys: int) -> np.ndarray:
    """Nodes (K, L, NODES, 3) of leaves that swing in one of three ways."""
    rng = np.random.default_rng(1)
    phase = rng.integers(3, size=number) * 2.1
    along = np.linspace(0.0, 1.0, NODES)
    roots = np.pad(rng.uniform(-100.0, 100.0, (number, 2)), ((0, 0), (0, 1)))
    nodes = np.zeros((keys, number, NODES, 3)) + roots[:, None]
    nodes[..., 2] += 80.0 * along
    swing = 9.0 * np.sin(0.7 * np.arange(keys)[:, None] + phase)
    nodes[..., 0] += swing[:, :, None] * along**2
    return nodes


@pytest.mark.parametrize("number", [5, 400])
def test_vertices_follow_their_leaves(number: int) -> None:
    """Exactly at joints, and nearly between them; leaves that swing alike share joints."""
    keys = np.arange(0, 30, 3)
    nodes = waves(number, len(keys))
    leaf = np.repeat(np.arange(number), NODES)
    motion = plant_motion(
        BentLeaves(leaf, np.tile(np.linspace(0.0, 1.0, NODES), number)), nodes, keys
    )
    assert motion.shifts.shape == (len(keys), len(motion.places), 3)
    assert len(motion.places) <= 1 + len(FOLLOWED) * min(number, MOTIONS)
    np.testing.assert_allclose(motion.weights.sum(axis=1), 1.0)
    assert not motion.shifts[0].any() and not motion.shifts[:, 0].any()
    moved = (motion.weights[..., None] * motion.shifts[:, motion.joints]).sum(axis=2)
    off = np.abs(moved - (nodes - nodes[0]).reshape(len(keys), -1, 3)).max(axis=(0, 2))
    off = off.reshape(number, NODES).max(axis=0)
    assert off[[0, *FOLLOWED]].max() < 1e-9
    assert 0.0 < off.max() < 0.4


def test_as_many_groups_as_wanted_hold_similar_motions() -> None:
    rng = np.random.default_rng(2)
    middles = 10.0 * rng.normal(size=(6, 12))
    motions = np.repeat(middles, 20, axis=0) + 0.1 * rng.normal(size=(120, 12))
    share = share_motions(motions, 6)
    assert {tuple(np.unique(share[k : k + 20])) for k in range(0, 120, 20)} == {
        (k,) for k in range(6)
    }
    assert len(np.unique(share_motions(motions, 3))) == 3
    assert share_motions(motions[:4], 6).tolist() == [0, 1, 2, 3]
