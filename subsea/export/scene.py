"""A recorded part of a dive: what every writer of a scene reads.

All lengths are in cm, in the world of the dive: x and y level, z up. `axes.py` turns positions and
rotations to the axes of other programs.

The interface of a format of scenes: checks, an estimate of its bytes, and writing.

Poses of a species that stand for all poses of its fishes in a scene, for instances.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.base.errors import UserError
from subsea.export.clips import Model
from subsea.export.drawn_surface import Surface
from subsea.frame.packet import FINS, ROW_A, ROW_B, SCALE, WEIGHT
from subsea.scenario.schema import Grade, Water


class SceneFish(NamedTuple):
    """A fish of a scene. Its place in `Scene.fishes` is its column in positions and rotations."""

    number: int  # of the fish in the world
    name: str  # of its species and its number among those, such as "fusilier_003"
    model: int  # index of its mesh in `Scene.models`
    scale: float  # size of the fish over that of its model
    length_cm: float
    first: int  # first frame in which it is in the sea ...
    last: int  # ... and the last one
    tint: Array  # (3,) factors of red, green and blue (linear) that tell it from others


class SceneCamera(NamedTuple):
    """The camera in T frames. It looks along its -z axis, its y axis is up and x right."""

    position: Array  # (T, 3) cm
    rotation: Array  # (T, 4) unit quaternions (w, x, y, z) of continuous sign, camera to world
    height_rad: float  # vertical angle of view
    aspect: float  # width over height
    size: tuple[int, int]  # width and height of the film's picture, pixels
    near_cm: float
    far_cm: float
    cuts: tuple[int, ...]  # frames before which it jumped: nothing should be interpolated there


class SceneMesh(NamedTuple):
    """A mesh of n vertices that does not move, once or at k places."""

    name: str  # unique in a scene, such as "sand" or "coral_brain_2_0"
    group: str  # one of GROUPS
    points: Array  # (n, 3) cm
    normals: Array  # (n, 3)
    colors: Array  # (n, 3) linear red, green and blue, 0 to 1
    triangles: Ints  # (m, 3) int32, counter-clockwise from outside
    two_sided: bool
    # (k, 4, 4) from the mesh to the world, column vectors, also stretched; identity: once, as it is
    places: Array
    tints: Array  # (k, 3) linear factors of the colours at each place


GROUPS = ("sand", "stone", "corals", "seaweed")


class ScenePoses(NamedTuple):
    """The data from which the shapes of N fishes in T frames are computed."""

    rows: Array  # (T, N, 23) float32, instances as in `frame.packet`; NaN while not in the sea
    table: Array  # (rows, 426, 3) float32, the library's control points, cm
    # By column: control points (t, 426, 3) of a fish in each frame in which it is simulated, and
    # the numbers (t,) of those frames.
    live: Mapping[int, tuple[Ints, Array]]
    surfaces: tuple[Surface, ...]  # one of each model
    model_scale: tuple[float, ...]  # size of each model over that of its recorded fish


@dataclass(frozen=True)
class Scene:
    """T frames of N fishes, a camera, and what does not move."""

    name: str
    title: str  # of the scenario
    seed: int  # of the dive, from which it can be recorded again
    fps: float  # frames per second
    start_s: float  # time of the first frame, seconds of the dive
    frames: int  # T
    models: tuple[Model, ...]  # mesh at rest of each species that occurs
    fishes: tuple[SceneFish, ...]
    position: Array  # (T, N, 3) cm, of the body frame; NaN while a fish is not in the sea
    # (T, N, 4) unit quaternions (w, x, y, z) of continuous sign, body to world; NaN likewise
    rotation: Array
    camera: SceneCamera
    statics: tuple[SceneMesh, ...]
    poses: ScenePoses = field(repr=False)
    water: Water
    grade: Grade
    captions: tuple[str, ...]  # (T) of the scenario's directions, "" for none

    def points(
        self, fish: int, first: int | None = None, last: int | None = None
    ) -> tuple[Array, Array]:
        """Points and normals (t, n, 3) of a fish, cm, in body axes, at the fish's own size.

        `fish` is its place in `fishes`. The frames are those from `first` to `last`, both
        included; None: those in which the fish is in the sea, beyond which nothing is known.
        Computed when asked for, so that a scene need not hold the points of all fishes.
        """
        one = self.fishes[fish]
        begin, end = one.first if first is None else first, one.last if last is None else last
        if not one.first <= begin <= end <= one.last:
            raise IndexError(f"{one.name} is in frames {one.first} to {one.last}")
        poses = self.poses
        rows = poses.rows[begin : end + 1, fish].astype(np.float64)
        a, b = rows[:, ROW_A].astype(int), rows[:, ROW_B].astype(int)
        weight = rows[:, WEIGHT, None, None]
        known = len(poses.table) - 1
        control = (1.0 - weight) * poses.table[np.minimum(a, known)]
        control += weight * poses.table[np.minimum(b, known)]
        if fish in poses.live:
            numbers, shapes = poses.live[fish]
            inside = (numbers >= begin) & (numbers <= end)
            control[numbers[inside] - begin] = shapes[inside]
        places, normals = poses.surfaces[one.model].at(control, rows[:, FINS])
        return rows[:, SCALE, None, None] * places, normals


@dataclass(frozen=True)
class SceneOptions:
    """Options of a format; `SceneWriter.check` refuses those that it does not have."""

    force: bool = False  # replace files of other kinds
    morph: bool = False  # gltf: morph targets instead of skeletons
    vat: bool = False  # gltf: a vertex animation texture for each species
    compress: str = "none"  # gltf: a name of `packing.COMPRESSIONS`
    instances: bool = False  # gltf: copies of corals and seaweed by EXT_mesh_gpu_instancing
    poses: int | None = None  # usd: bake this many poses of each species, and place instances


OF_GLTF = "morph", "vat", "compress", "instances"
OF_USD = ("poses",)


def check_options(options: SceneOptions, target: str, own: Sequence[str]) -> None:
    """Refuse options of other formats than `target`; `own` are the names of those that it has."""
    for name in (*OF_GLTF, *OF_USD):
        if name not in own and getattr(options, name) != getattr(SceneOptions(), name):
            other = "gltf" if name in OF_GLTF else "usd"
            raise UserError(f"--{name} is for --to {other}, not {target}")


class SceneExtent(NamedTuple):
    """The size of a scene before it is recorded."""

    frames: int
    vertices: tuple[int, ...]  # of the mesh of each fish
    triangles: tuple[int, ...]  # likewise
    species: tuple[int, ...]  # a number for the species of each fish


class SceneWriter(NamedTuple):
    """A format of scenes. `out` is the path of `--out`: a file or a folder, as the format wants."""

    # (out, options) before any work: UserError for a wrong suffix, a missing extra, options of
    # other formats, and files that may not be replaced.
    check: Callable[[Path, SceneOptions], None]
    # (extent, options) -> bytes of all fishes and their textures, within a factor of 1.5.
    estimate: Callable[[SceneExtent, SceneOptions], int]
    # (scene, out, options) -> the written files. Nothing is left half-written.
    write: Callable[[Scene, Path, SceneOptions], list[Path]]


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
