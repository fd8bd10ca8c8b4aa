"""A recorded part of a dive: what every writer of a scene reads.

All lengths are in cm, in the world of the dive: x and y level, z up. `axes.py` turns positions and
rotations to the axes of other programs.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
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
