"""Poses that stand for all poses of a species."""

import numpy as np
import pytest

from subsea.export.scene import Scene, _representatives, bake_poses


@pytest.mark.parametrize("model", [0, 1])
def test_more_poses_are_nearer(dive: Scene, model: int) -> None:
    errors = []
    for number in (1, 8, 64):
        poses = bake_poses(dive, model, number)
        assert 1 <= len(poses.points) <= number
        assert poses.pose.shape == (dive.frames, len(poses.fishes))
        assert poses.pose.min() >= 0 and poses.pose.max() < len(poses.points)
        assert poses.most_percent >= poses.rms_percent > 0.0
        errors.append(poses.rms_percent)
    assert errors[2] < 0.5 * errors[1] < 0.5 * errors[0]


def test_the_printed_error_is_that_of_the_vertices(dive: Scene) -> None:
    poses = bake_poses(dive, 0, 8)
    far = []
    for k, fish in enumerate(poses.fishes.tolist()):
        points, _ = dive.points(fish)
        shown = dive.fishes[fish].scale * poses.points[poses.pose[:, k]]
        far.append(np.linalg.norm(shown - points, axis=2) / dive.fishes[fish].length_cm)
    assert 100.0 * np.sqrt(np.mean(np.square(far))) == pytest.approx(poses.rms_percent, rel=1e-6)
    assert 100.0 * np.max(far) == pytest.approx(poses.most_percent, rel=1e-6)


def test_representatives_find_separate_clusters() -> None:
    rng = np.random.default_rng(3)
    middles = np.array([[0.0, 0.0], [10.0, 0.0], [0.0, 10.0]])
    samples = np.repeat(middles, 40, axis=0) + rng.normal(0.0, 0.3, (120, 2))
    chosen = _representatives(samples, 3)
    assert sorted(chosen // 40) == [0, 1, 2]
    assert len(_representatives(np.zeros((9, 2)), 4)) == 1  # all alike: one is enough
