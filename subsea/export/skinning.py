"""Fit a skeleton and skin weights to the clips of a mesh: smooth skinning decomposition.

After Le and Deng, "Smooth Skinning Decomposition with Rigid Bones" (2012): rigid motions of joints
and weights of vertices are fitted alternately by least squares, to all frames of all clips. Weights
are not negative and sum to one; a vertex has at most four.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Ints
from subsea.export.clips import Clip, Model
from subsea.geometry.rotation import from_matrix, matrix
from subsea.kernels import kernel

MAX_INFLUENCES = 4  # joints of a vertex, the limit of formats and engines
NEAR = 8  # nearest joints to choose them from
SPINE = 14  # joints from head to tail
FIN = 2, 4  # along the free edge of a short and of a long dorsal or ventral fin, which waves
LONG = 0.15  # body lengths of such a fin
WIDE = 0.15  # body lengths from the spine: a wider body has wings
WINGS = (0.4, 0.7, 0.95)  # positions of joints along both edges of a wing
TAIL = 0.15  # body lengths from the rear that contain the tips of the tail
ROUNDS = 5
MIN_VERTICES = 24  # around a joint, for its regularisation (or its fraction of all, if more)
REGULARISATION = 0.01  # weight of that relative to the joint's own vertices
SWEEPS = 4  # fits of all joints in a round
FOLLOWING = 3  # rounds with given weights


class Joint(NamedTuple):
    """A joint at rest, cm, body axes, and the number of its parent, -1 for the root."""

    name: str
    parent: int
    place: Array  # (3,)


class Skeleton(NamedTuple):
    """J joints and their motion in F frames, such as those of all clips."""

    joints: list[Joint]
    weights: Array  # (n, J)
    motion: Array  # (F, J, 3, 4) rotation and translation, cm, body axes: x at rest to R x + t
    rms_percent: float  # error of the vertices, of the body length: root mean square ...
    most_percent: float  # ... and largest


def fit_skeleton(
    model: Model,
    goal: Array,
    progress: Callable[[Sequence[int]], Iterable[int]] = lambda rounds: rounds,
) -> Skeleton:
    """Fit a skeleton to vertices (F, n, 3), cm, body axes, at the size of the model.

    `progress` wraps the rounds.
    """
    joints = place_joints(model)
    rest, far = _homogeneous(model), _distances(model, joints)
    near = far.argsort(axis=1)[:, :NEAR]
    about = _surroundings(model, far, goal)
    motion = about.copy()
    for _ in progress(range(ROUNDS)):
        weights = _fit_weights(rest, goal, motion, near)
        firm = REGULARISATION * (weights * far**2).sum(axis=0)
        _fit_motion(rest, goal, weights, motion, about, firm)
    motion = motion.swapaxes(1, 2)
    off = off_percent(model, weights, motion, goal)
    return Skeleton(joints, weights, motion, float(np.sqrt((off**2).mean())), float(off.max()))


def strongest(weights: Array) -> tuple[Ints, Array]:
    """Return the joints (n, 4) with the greatest weights of vertices, and these, of sum 1."""
    most = np.argsort(-weights, axis=1)[:, :MAX_INFLUENCES]
    kept = np.take_along_axis(weights, most, axis=1).astype(np.float32)
    kept /= kept.sum(axis=1, keepdims=True)
    return most, kept


def local_motion(joints: Sequence[Joint], motion: Array) -> tuple[Array, Array]:
    """Compute rotations (T, J, 4) and places (T, J, 3), cm, of joints relative to their parents.

    `motion` (T, J, 3, 4) is rigid, in body axes, as in `Skeleton`.
    """
    places = np.array([joint.place for joint in joints])
    turn, place = motion[..., :3], motion[..., :3] @ places[:, :, None] + motion[..., 3:]
    # Row 0 stands for the root.
    turns = np.concatenate([np.tile(np.eye(3), (len(turn), 1, 1, 1)), turn], axis=1)
    parents = np.array([joint.parent + 1 for joint in joints])
    back = turns[:, parents].swapaxes(2, 3)
    origin = np.pad(place, ((0, 0), (1, 0), (0, 0), (0, 0)))[:, parents]
    return from_matrix(back @ turn), (back @ (place - origin))[..., 0]


def clip_motions(rig: Skeleton, clips: Sequence[Clip], baked: bool) -> Iterator[Array]:
    """Yield the motion (T, J, 3, 4) of the joints in each of the clips that `rig` is fitted to.

    A cycle ends as it begins. The path of the root is left out, or `baked` into the joints.
    """
    begin = 0
    for clip in clips:
        motion = rig.motion[begin : begin + len(clip.points)].copy()
        begin += len(clip.points)
        if clip.cyclic:
            motion[-1] = motion[0]
        if baked:
            motion = matrix(clip.rotation)[:, None] @ motion
            motion[..., 3] += clip.position[:, None]
        yield motion


def follow(model: Model, rig: Skeleton, goal: Array) -> Array:
    """Compute the motion (F, J, 3, 4) of joints that comes nearest to vertices (F, n, 3)."""
    far = _distances(model, rig.joints)
    about = _surroundings(model, far, goal)
    motion = about.copy()
    firm = REGULARISATION * (rig.weights * far**2).sum(axis=0)
    for _ in range(FOLLOWING):
        _fit_motion(_homogeneous(model), goal, rig.weights, motion, about, firm)
    return motion.swapaxes(1, 2)


def refit(model: Model, rig: Skeleton, goal: Array) -> Skeleton:
    """Bind another mesh of the same fish to the joints of `rig`; `goal` (F, n, 3) as there."""
    near = _distances(model, rig.joints).argsort(axis=1)[:, :NEAR]
    weights = _fit_weights(_homogeneous(model), goal, rig.motion.swapaxes(1, 2), near)
    off = off_percent(model, weights, rig.motion, goal)
    rms, most = float(np.sqrt((off**2).mean())), float(off.max())
    return rig._replace(weights=weights, rms_percent=rms, most_percent=most)


def off_percent(model: Model, weights: Array, motion: Array, goal: Array) -> Array:
    """Measure distances (F, n) of vertices from a goal (F, n, 3), percent of the body length."""
    off = posed(_homogeneous(model), weights, motion) - goal
    return np.asarray(np.linalg.norm(off, axis=2) * 100.0 / model.length_cm)


def _homogeneous(model: Model) -> Array:
    return np.pad(model.rest, ((0, 0), (0, 1)), constant_values=1.0)  # (n, 4)


def _distances(model: Model, joints: list[Joint]) -> Array:
    """Measure the distance (n, J) from each vertex to each joint at rest."""
    places = np.array([joint.place for joint in joints])
    return np.asarray(np.linalg.norm(model.rest[:, None] - places, axis=2))


def _surroundings(model: Model, far: Array, goal: Array) -> Array:
    """Fit the rigid motion (F, 3, J, 4) of the vertices around each joint."""
    around = far.argsort(axis=0)[: max(MIN_VERTICES, len(far) // far.shape[1])]
    return np.stack([_rigid(model.rest[mine], goal[:, mine]) for mine in around.T], axis=2)


def posed(rest: Array, weights: Array, motion: Array) -> Array:
    """Compute positions (F, n, 3) of vertices (n, 4), homogeneous, in each frame."""
    parts = (weights[:, :, None] * rest[:, None]).reshape(len(rest), -1)
    rows = motion.swapaxes(1, 2).reshape(-1, parts.shape[1])
    return (rows @ parts.T).reshape(len(motion), 3, -1).swapaxes(1, 2)


def place_joints(model: Model) -> list[Joint]:
    """Place joints along the spine, at the tips of the tail, in the fins and in wings."""
    body, length = model.rest[: model.solid], model.length_cm
    front, rear, wide = body[:, 0].max(), body[:, 0].min(), body[:, 2].max()
    joints = []
    for k, x in enumerate(np.linspace(front, rear, 2 * SPINE + 1)[1::2]):
        near = body[np.abs(body[:, 0] - x).argsort()[: len(body) // SPINE], 1]
        joints.append(
            Joint(f"spine_{k + 1}", k - 1, np.array([x, (near.min() + near.max()) / 2, 0]))
        )
    spine = np.array([joint.place[0] for joint in joints])

    def attach(name: str, place: Array) -> None:
        joints.append(Joint(name, int(np.abs(spine - place[0]).argmin()), place))

    tail = body[body[:, 0] < rear + TAIL * length]
    attach("tail_upper", tail[tail[:, 1].argmax()])
    attach("tail_lower", tail[tail[:, 1].argmin()])
    for name, vertices in model.fins.items():
        fin = model.rest[vertices]
        if name in ("dorsal", "ventral"):
            count = FIN[int(np.ptp(fin[:, 0]) > LONG * length)]
            for k, part in enumerate(np.array_split(fin[fin[:, 0].argsort()[::-1]], count)):
                attach(f"{name}_{k + 1}", part[np.abs(part[:, 1]).argmax()])
        else:
            attach(name, fin.mean(axis=0))
    if wide > WIDE * length:
        for side, sign in (("left", -1.0), ("right", 1.0)):
            for edge, most in (("front", np.argmax), ("rear", np.argmin)):
                for k, share in enumerate(WINGS):
                    z = sign * share * wide
                    near = body[np.abs(body[:, 2] - z) < 0.1 * wide, 0]
                    place = np.array([near[most(near)], 0.0, z])
                    if k == 0:
                        attach(f"wing_{side}_{edge}_1", place)
                    else:  # on the joint before it
                        joints.append(Joint(f"wing_{side}_{edge}_{k + 1}", len(joints) - 1, place))
    return joints


def _fit_motion(
    rest: Array, goal: Array, weights: Array, motion: Array, about: Array, firm: Array
) -> None:
    """Fit the joints in turn, SWEEPS times, in place.

    Each joint gets the rigid motion that best compensates the error of the others (Procrustes).
    `firm` (J,) weighs the motion `about` it, or joints with vertices on a line would jump.
    """
    frames, _, joints, _ = motion.shape
    parts = (weights[:, :, None] * rest[:, None]).reshape(len(rest), -1)  # (n, 4 J)
    aims = (goal.swapaxes(1, 2).reshape(-1, len(rest)) @ parts).reshape(motion.shape)
    sums = parts.T @ parts
    for _ in range(SWEEPS):
        for j in range(joints):
            square = sums[4 * j : 4 * j + 4, 4 * j : 4 * j + 4]
            if square[3, 3] <= 0.0:
                continue
            moved = motion.reshape(3 * frames, -1) @ sums[:, 4 * j : 4 * j + 4]
            left = aims[:, :, j] - moved.reshape(frames, 3, 4) + motion[:, :, j] @ square
            middle = square[3, :3] / square[3, 3]
            across = left[:, :, :3] - left[:, :, 3:] * middle
            motion[:, :, j, :3] = _turn(across + firm[j] * about[:, :, j, :3])
            motion[:, :, j, 3] = left[:, :, 3] / square[3, 3] - motion[:, :, j, :3] @ middle


def _rigid(rest: Array, goal: Array) -> Array:
    """Fit the regularised rigid motion (F, 3, 4) of points (m, 3) to a goal (F, m, 3)."""
    middle, there = rest.mean(axis=0), goal.mean(axis=1)
    arms = rest - middle
    across = (goal - there[:, None]).swapaxes(1, 2) @ arms
    turn = _turn(across + REGULARISATION * (arms**2).sum() * np.eye(3))
    return np.concatenate([turn, (there - turn @ middle)[:, :, None]], axis=2)


def _turn(across: Array) -> Array:
    """Find the rotations (F, 3, 3) nearest to matrices."""
    u, _, v = np.linalg.svd(across)
    u[:, :, 2] *= np.linalg.det(u @ v)[:, None]
    return np.asarray(u @ v)


def _fit_weights(rest: Array, goal: Array, motion: Array, near: Ints) -> Array:
    """Fit weights (n, J) of near joints, which move `rest` nearest to `goal`."""
    frames, _, joints, _ = motion.shape
    rows = motion.reshape(3 * frames, -1)
    pairs = (rows.T @ rows).reshape(joints, 4, joints, 4).swapaxes(1, 2)
    flat = goal.swapaxes(1, 2).reshape(-1, len(rest))
    aims = (rows.T @ flat).reshape(joints, 4, -1)
    out = np.zeros((len(rest), joints))
    for k, (x, mine) in enumerate(zip(rest, near, strict=True)):
        toward = aims[mine, :, k] @ x
        # Scalar products of the errors of each two joints.
        gram = x @ pairs[mine[:, None], mine] @ x - toward - toward[:, None]
        out[k, mine] = best_shares(gram + flat[:, k] @ flat[:, k], MAX_INFLUENCES)
    return out


@kernel
def best_shares(gram: Array, most: int) -> Array:
    """Choose weights w ≥ 0 with sum 1 and at most `most` not 0, that make w·G·w small.

    Backward elimination from the optimum of all.
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
            value = (trial * _slope(gram, trial)).sum()
            if value < least:
                least, best, without = value, trial, k
        w = best
        w[without] = 0.0
    return w


@kernel
def _least(gram: Array, allowed: NDArray[np.bool_], w: Array) -> Array:
    """Minimise w·G·w over weights from a start: pairwise exchange."""
    w = w.copy()
    slope = _slope(gram, w)
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


@kernel
def _slope(gram: Array, w: Array) -> Array:
    """Multiply a matrix by a vector: @ would need SciPy, a sum along an axis 4 s to compile."""
    slope = np.zeros(len(w))
    for row in range(len(w)):
        for column in range(len(w)):
            slope[row] += gram[row, column] * w[column]
    return slope
