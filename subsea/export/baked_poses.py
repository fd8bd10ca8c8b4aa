"""Poses of a species that stand for all poses of its fishes in a scene, for instances."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.export.scene import Scene

CHUNK = 64  # frames of a fish at a time
SAMPLES = 6000  # poses among which those to bake are chosen
VERTICES = 80  # by which poses are compared
ROUNDS = 6  # of moving each chosen pose to the middle of those that it stands for


class BakedPoses(NamedTuple):
    """P poses, and which of them each of N fishes has in each of T frames."""

    fishes: Ints  # (N,) places in `Scene.fishes`
    points: Array  # (P, n, 3) cm, body axes, at the size of the model
    normals: Array  # (P, n, 3)
    pose: Ints  # (T, N) index, -1 while a fish is not in the sea
    rms_percent: float  # distance of vertices from where they should be, of the body length
    most_percent: float


def bake_poses(scene: Scene, model: int, number: int) -> BakedPoses:
    """Choose at most `number` poses of the fishes of a model, and the nearest one in each frame."""
    fishes = np.array([k for k, one in enumerate(scene.fishes) if one.model == model])
    among = len(scene.models[model].rest)
    compared = np.unique(np.linspace(0, among - 1, VERTICES).astype(int))
    frames = sum(scene.fishes[k].last - scene.fishes[k].first + 1 for k in fishes)
    stride = max(frames // SAMPLES, 1)
    samples, where = [], []
    seen = 0
    for fish, first, points, _ in _shapes(scene, fishes):
        chosen = np.flatnonzero((seen + np.arange(len(points))) % stride == 0)
        samples.append(points[chosen][:, compared].reshape(len(chosen), -1))
        where += [(fish, first + int(k)) for k in chosen]
        seen += len(points)
    picked = _representatives(np.concatenate(samples), number)
    whole = [scene.points(fish, frame, frame) for fish, frame in (where[k] for k in picked)]
    sizes = [scene.fishes[where[k][0]].scale for k in picked]
    points = np.array([one[0][0] / size for one, size in zip(whole, sizes, strict=True)])
    normals = np.array([one[1][0] for one in whole])
    known = points[:, compared].reshape(len(points), -1)
    pose = np.full((scene.frames, len(fishes)), -1, np.int64)
    square, most, count = 0.0, 0.0, 0
    column = {int(fish): k for k, fish in enumerate(fishes)}
    for fish, first, shapes, _ in _shapes(scene, fishes):
        nearest = _nearest(shapes[:, compared].reshape(len(shapes), -1), known)
        pose[first : first + len(shapes), column[fish]] = nearest
        off = ((shapes - points[nearest]) ** 2).sum(axis=2)
        square, most, count = square + off.sum(), max(most, float(off.max())), count + off.size
    percent = 100.0 / scene.models[model].length_cm
    rms = float(np.sqrt(square / count))
    return BakedPoses(fishes, points, normals, pose, percent * rms, percent * most**0.5)


def _shapes(scene: Scene, fishes: Ints) -> Iterator[tuple[int, int, Array, Array]]:
    """Fish, first frame, points and normals at the size of the model, a few frames at a time."""
    for fish in fishes.tolist():
        one = scene.fishes[fish]
        for first in range(one.first, one.last + 1, CHUNK):
            last = min(first + CHUNK - 1, one.last)
            points, normals = scene.points(fish, first, last)
            yield fish, first, points / one.scale, normals


def _representatives(samples: Array, number: int) -> Ints:
    """Indices of at most `number` of the samples (m, d), spread over all of them.

    The farthest from those chosen before comes next; then each moves to the middle of its part.
    """
    chosen = [int(_squares(samples, samples.mean(axis=0)[None]).argmin())]
    gap = _squares(samples, samples[chosen])[:, 0]
    while len(chosen) < number and gap.max() > 0.0:
        chosen.append(int(gap.argmax()))
        gap = np.minimum(gap, _squares(samples, samples[chosen[-1:]])[:, 0])
    for _ in range(ROUNDS):
        nearest = _nearest(samples, samples[chosen])
        for k in range(len(chosen)):
            if not len(mine := np.flatnonzero(nearest == k)):  # equal to another to rounding
                continue
            middle = samples[mine].mean(axis=0)
            chosen[k] = int(mine[_squares(samples[mine], middle[None])[:, 0].argmin()])
    return np.array(chosen)


def _squares(rows: Array, others: Array) -> Array:
    """Squared distances (m, k) of rows (m, d) and (k, d)."""
    square = (rows**2).sum(axis=1)[:, None] + (others**2).sum(axis=1) - 2.0 * rows @ others.T
    return np.maximum(square, 0.0)


def _nearest(rows: Array, others: Array) -> Ints:
    return np.asarray(_squares(rows, others).argmin(axis=1))
