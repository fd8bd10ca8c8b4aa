"""A skeleton and weights that move a mesh as its clips do: smooth skinning decomposition.

After Le and Deng, "Smooth Skinning Decomposition with Rigid Bones" (2012): the rigid motion of the
joints and the weights of the vertices are fitted in turn by least squares, to frames of all clips
at once. Weights are not negative and sum to one, and no vertex has more than four.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from capture.export.clips import Clip, Model
from subsea.core.arrays import Array, Ints
from subsea.core.kernels import kernel

MAX_INFLUENCES = 4  # joints that a vertex may hang on: what the formats and engines have room for
NEAR = 8  # joints that it may choose them from, so that none moves what is far
SPINE = 14  # joints from head to tail
FIN = 2  # along the free edge of the dorsal and of the ventral fin
WIDE = 0.15  # body lengths aside of the spine: a body as wide as this has wings
WINGS = (0.4, 0.7, 0.95)  # where along a wing it has joints, at both of its edges
TAIL = 0.15  # body lengths from the rear in which the tips of the tail are
ROUNDS = 5
LEAST = 24  # vertices about a joint that tell how it turns, or its share of all where that is more
STEADY = 0.01  # how heavily that counts beside what its vertices do
SWEEPS = 4  # times that all joints are fitted in a round


class Joint(NamedTuple):
    """Where a joint is at rest, cm, body axes, and the number of what it hangs on, -1: the root."""

    name: str
    parent: int
    place: Array  # (3,)


class Skeleton(NamedTuple):
    """J joints, and how they move in the F frames of all clips, one after another."""

    joints: list[Joint]
    weights: Array  # (n, J)
    motion: Array  # (F, J, 3, 4) rotation and shift, cm, in body axes: x at rest goes to R x + t
    rms_percent: float  # of the body length that vertices are from where the clips have them ...
    most_percent: float  # ... and the farthest one, in any frame


def fit_skeleton(
    model: Model,
    clips: list[Clip],
    progress: Callable[[Sequence[int]], Iterable[int]] = lambda rounds: rounds,
) -> Skeleton:
    """The skeleton of a model that follows its clips; `progress` watches the rounds."""
    joints = skeleton(model)
    rest = np.pad(model.rest, ((0, 0), (0, 1)), constant_values=1.0)  # (n, 4)
    goal = np.concatenate([clip.points for clip in clips])  # (F, n, 3)
    far = np.linalg.norm(model.rest[:, None] - [joint.place for joint in joints], axis=2)  # (n, J)
    near = far.argsort(axis=1)[:, :NEAR]
    around = far.argsort(axis=0)[: max(LEAST, len(rest) // len(joints))]
    # (F, 3, J, 4): what is about a joint, as one
    about = np.stack([_rigid(model.rest[those], goal[:, those]) for those in around.T], axis=2)
    motion = about.copy()
    for _ in progress(range(ROUNDS)):
        weights = _fit_weights(rest, goal, motion, near)
        _fit_motion(rest, goal, weights, motion, about, STEADY * (weights * far**2).sum(axis=0))
    motion = motion.swapaxes(1, 2)
    off = np.linalg.norm(posed(rest, weights, motion) - goal, axis=2) * 100.0 / model.length_cm
    return Skeleton(joints, weights, motion, float(np.sqrt((off**2).mean())), float(off.max()))


def posed(rest: Array, weights: Array, motion: Array) -> Array:
    """Where vertices (n, 4), the last number 1, are in each frame, (F, n, 3)."""
    parts = (weights[:, :, None] * rest[:, None]).reshape(len(rest), -1)
    rows = motion.swapaxes(1, 2).reshape(-1, parts.shape[1])
    return (rows @ parts.T).reshape(len(motion), 3, -1).swapaxes(1, 2)


def skeleton(model: Model) -> list[Joint]:
    """Joints along the spine, at the tips of the tail, in the fins and in wings."""
    body, length = model.rest[: model.solid], model.length_cm
    front, rear, wide = body[:, 0].max(), body[:, 0].min(), body[:, 2].max()
    joints = []
    for k, x in enumerate(np.linspace(front, rear, 2 * SPINE + 1)[1::2]):
        near = body[np.abs(body[:, 0] - x).argsort()[: len(body) // SPINE], 1]
        joints.append(
            Joint(f"spine_{k + 1}", k - 1, np.array([x, (near.min() + near.max()) / 2, 0]))
        )
    spine = np.array([joint.place[0] for joint in joints])

    def hang(name: str, place: Array) -> None:
        joints.append(Joint(name, int(np.abs(spine - place[0]).argmin()), place))

    tail = body[body[:, 0] < rear + TAIL * length]
    hang("tail_upper", tail[tail[:, 1].argmax()])
    hang("tail_lower", tail[tail[:, 1].argmin()])
    for name, vertices in model.fins.items():
        fin = model.rest[vertices]
        if name in ("dorsal", "ventral"):
            for k, part in enumerate(np.array_split(fin[fin[:, 0].argsort()[::-1]], FIN)):
                hang(f"{name}_{k + 1}", part[np.abs(part[:, 1]).argmax()])
        else:
            hang(name, fin.mean(axis=0))
    if wide > WIDE * length:
        for side, sign in (("left", -1.0), ("right", 1.0)):
            for edge, most in (("front", np.argmax), ("rear", np.argmin)):
                for k, share in enumerate(WINGS):
                    z = sign * share * wide
                    near = body[np.abs(body[:, 2] - z) < 0.1 * wide, 0]
                    place = np.array([near[most(near)], 0.0, z])
                    if k == 0:
                        hang(f"wing_{side}_{edge}_1", place)
                    else:  # on the one before it
                        joints.append(Joint(f"wing_{side}_{edge}_{k + 1}", len(joints) - 1, place))
    return joints


def _fit_motion(
    rest: Array, goal: Array, weights: Array, motion: Array, about: Array, firm: Array
) -> None:
    """Fit one joint after another, SWEEPS times, in place.

    Each gets the rigid motion that makes up best for what the others leave (Procrustes). Of the
    vertices that only needs sums over them, which are made once. As heavily as `firm` (J,) says its
    rotation is that of all `about` it: where its own vertices leave that open, as those on a line
    do, it does not leap from frame to frame.
    """
    frames, _, joints, _ = motion.shape
    parts = (weights[:, :, None] * rest[:, None]).reshape(len(rest), -1)  # (n, 4 J)
    aims = (goal.swapaxes(1, 2).reshape(-1, len(rest)) @ parts).reshape(motion.shape)
    sums = parts.T @ parts
    for _ in range(SWEEPS):
        for j in range(joints):
            own = sums[4 * j : 4 * j + 4, 4 * j : 4 * j + 4]
            if own[3, 3] <= 0.0:
                continue
            moved = motion.reshape(3 * frames, -1) @ sums[:, 4 * j : 4 * j + 4]
            left = aims[:, :, j] - moved.reshape(frames, 3, 4) + motion[:, :, j] @ own
            middle = own[3, :3] / own[3, 3]
            across = left[:, :, :3] - left[:, :, 3:] * middle
            motion[:, :, j, :3] = _turn(across + firm[j] * about[:, :, j, :3])
            motion[:, :, j, 3] = left[:, :, 3] / own[3, 3] - motion[:, :, j, :3] @ middle


def _rigid(rest: Array, goal: Array) -> Array:
    """The motion (F, 3, 4) that takes places (m, 3) nearest to goal (F, m, 3) (Procrustes).

    About a line that they lie on, such as a whip of a tail, it turns them no more than it must.
    """
    middle, there = rest.mean(axis=0), goal.mean(axis=1)
    arms = rest - middle
    across = (goal - there[:, None]).swapaxes(1, 2) @ arms
    turn = _turn(across + STEADY * (arms**2).sum() * np.eye(3))
    return np.concatenate([turn, (there - turn @ middle)[:, :, None]], axis=2)


def _turn(across: Array) -> Array:
    """The rotations (F, 3, 3) that are nearest to matrices."""
    u, _, v = np.linalg.svd(across)
    u[:, :, 2] *= np.linalg.det(u @ v)[:, None]
    return np.asarray(u @ v)


def _fit_weights(rest: Array, goal: Array, motion: Array, near: Ints) -> Array:
    """The weights (n, J) of the joints near each vertex that take rest nearest to goal."""
    frames, _, joints, _ = motion.shape
    rows = motion.reshape(3 * frames, -1)
    pairs = (rows.T @ rows).reshape(joints, 4, joints, 4).swapaxes(1, 2)
    flat = goal.swapaxes(1, 2).reshape(-1, len(rest))
    aims = (rows.T @ flat).reshape(joints, 4, -1)
    out = np.zeros((len(rest), joints))
    for k, (x, those) in enumerate(zip(rest, near, strict=True)):
        toward = aims[those, :, k] @ x
        # Of where two joints alone would take the vertex: how far both are off, multiplied.
        gram = x @ pairs[those[:, None], those] @ x - toward - toward[:, None]
        out[k, those] = best_shares(gram + flat[:, k] @ flat[:, k], MAX_INFLUENCES)
    return out


@kernel
def best_shares(gram: Array, most: int) -> Array:
    """Shares w ≥ 0 that sum to one, `most` of them not zero, with a small w·G·w.

    All that the least one needs are there first; then the one goes, again and again, without which
    the rest do best.
    """
    w = np.zeros(len(gram))
    w[np.argmin(np.diag(gram))] = 1.0
    allowed = np.ones(len(gram), np.bool_)
    w = _least(gram, allowed, w)
    while (w > 0.0).sum() > most:
        allowed = w > 0.0
        least, best, without = np.inf, w, -1
        for k in range(len(w)):
            if not allowed[k]:
                continue
            allowed[k] = False
            trial = w.copy()
            trial[k] = 0.0
            trial = _least(gram, allowed, trial / trial.sum())
            allowed[k] = True
            value = (trial * (gram * trial).sum(axis=1)).sum()  # @ would need SciPy
            if value < least:
                least, best, without = value, trial, k
        w = best
        w[without] = 0.0
    return w


@kernel
def _least(gram: Array, allowed: NDArray[np.bool_], w: Array) -> Array:
    """The least w·G·w of shares, from some on: what is best passed on from one to another."""
    w = w.copy()
    slope = (gram * w).sum(axis=1)
    tiny = 1e-7 * np.trace(gram) / len(gram)
    for _ in range(400):
        low, high = -1, -1
        for k in range(len(w)):
            if allowed[k] and (low < 0 or slope[k] < slope[low]):
                low = k
            if w[k] > 0.0 and (high < 0 or slope[k] > slope[high]):
                high = k
        if slope[high] - slope[low] <= tiny:
            break
        bend = gram[low, low] + gram[high, high] - 2.0 * gram[low, high]
        step = min(w[high], (slope[high] - slope[low]) / max(bend, 1e-300))
        w[low] += step
        w[high] = 0.0 if step == w[high] else w[high] - step
        for k in range(len(w)):
            slope[k] += step * (gram[k, low] - gram[k, high])
    return w
