"""A recorded part of a dive, which every format writes, and the interface of a format.

All lengths are in cm, in the world of the dive: x and y level, z up. `conventions.py` turns
positions and rotations to the axes of other programs.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.export.clips import Model, Surface
from subsea.export.conventions import METRES, WORLD_Y_UP, to_metres
from subsea.export.options import SceneOptions
from subsea.export.plant_motion import FOLLOWED, MOTIONS, BentLeaves, PlantMotion
from subsea.habitat.stone import sun_at
from subsea.scenario.schema import Grade, Water


class SceneFish(NamedTuple):
    """A fish of a scene. Its index in `Scene.fishes` is its column in positions and rotations."""

    number: int  # of the fish in the world
    name: str  # its species and its number in the species, such as "fusilier_003"
    model: int  # index of its mesh in `Scene.models`
    scale: float  # size of the fish over that of its model
    length_cm: float
    first: int  # first frame in which it is in the sea ...
    last: int  # ... and last frame
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
    """A mesh of n vertices that stays at its place, once or at k places."""

    name: str  # unique in a scene, such as "sand" or "brain_2_0"
    kind: str  # such as "stone" or "brain"
    group: str  # one of GROUPS
    points: Array  # (n, 3) cm
    normals: Array  # (n, 3)
    colors: Array  # (n, 3) linear red, green and blue, 0 to 1
    triangles: Ints  # (m, 3) int32, counter-clockwise from outside
    two_sided: bool
    # (k, 4, 4) from the mesh to the world, column vectors, also stretched; identity: once, as it is
    places: Array
    tints: Array  # (k, 3) linear factors of the colours at each place
    sway: Array | None = None  # (n,) how far it sways with the water, in the unit of its points
    bent: BentLeaves | None = None  # the leaves of seaweed that it follows ...
    motion: PlantMotion | None = None  # ... and their motion, once it is recorded


CHUNK = 64  # frames of a fish at a time
GROUPS = ("sand", "stone", "corals", "seaweed")


class ScenePoses(NamedTuple):
    """The data from which the shapes of N fishes in T frames are computed."""

    rows: Array  # (T, N, 27) float32, instances as in `frame.packet`; NaN while not in the sea
    table: Array  # (rows, 426, 3) float32 cm: control points of the library, of simulated fishes
    surfaces: tuple[Surface, ...]  # one of each model


@dataclass(frozen=True)
class Scene:
    """T frames of N fishes, a camera, and what does not move."""

    name: str
    title: str  # of the scenario
    seed: int  # of the dive, from which it can be recorded again
    fps: float  # frames per second
    start_s: float  # time of the first frame, seconds of the dive
    frames: int  # T, of the film and of the way back to its start
    filmed: int  # of the film alone
    seamless: bool  # the last frame is the first one, and no fish jumps there
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

    def light(self) -> dict[str, Any]:
        """Describe sun and water in constants, for shaders and volumes of other programs.

        `toSun` is a unit vector in the water, x, y up and z; `farWater` linear red, green and
        blue of what lies beyond sight. Contrast falls to 2% at `visibilityMetres`, and light to
        1/e at `lightDepthMetres`.
        """
        toward = to_metres(np.array(sun_at(self.water.hour)[0]), WORLD_Y_UP) / METRES
        return {
            "toSun": np.round(toward, 6).tolist(),
            "farWater": [float(part) for part in self.water.far],
            "visibilityMetres": METRES * self.water.visibility_cm,
            "lightDepthMetres": METRES * self.water.light_depth_cm,
        }

    def points(
        self, fish: int, first: int | None = None, last: int | None = None
    ) -> tuple[Array, Array]:
        """Compute points and normals (t, n, 3) of a fish, cm, in body axes, at the fish's own size.

        `fish` is its column. The frames are those from `first` to `last`, both included; None:
        those in which the fish is in the sea, beyond which nothing is known.
        """
        known = self.fishes[fish]
        begin, end = known.first if first is None else first, known.last if last is None else last
        if not known.first <= begin <= end <= known.last:
            raise IndexError(f"{known.name} is in frames {known.first} to {known.last}")
        instances = self.poses.rows[begin : end + 1, fish]
        return self.poses.surfaces[known.model].drawn(instances, self.poses.table)

    def parts(self, fish: int) -> Iterator[tuple[int, Array, Array]]:
        """Yield the first frame, points and normals of a fish, a few frames at a time.

        Points have the size of the model. So no writer holds the points of all fishes.
        """
        known = self.fishes[fish]
        for first in range(known.first, known.last + 1, CHUNK):
            points, normals = self.points(fish, first, min(first + CHUNK - 1, known.last))
            yield first, points / known.scale, normals


class StillExtent(NamedTuple):
    """The size of meshes that do not move."""

    vertices: int = 0
    triangles: int = 0
    copies: int = 0  # places of meshes that have several ...
    shapes: tuple[int, int] = (0, 0)  # ... and vertices and triangles if each is stored once
    bent: int = 0  # vertices that follow joints, and ...
    joints: int = 0  # ... how many there are


class SceneExtent(NamedTuple):
    """The size of a scene before its frames are recorded."""

    frames: int
    fps: float
    fishes: int
    species: int
    vertices: int  # of the mesh of each fish
    triangles: int  # likewise
    still: StillExtent | None = None  # not known yet


def extent_of_meshes(statics: Iterable[SceneMesh]) -> StillExtent:
    """Measure meshes that do not move."""
    statics = [*statics]
    sizes = [(len(one.places), len(one.points), len(one.triangles)) for one in statics]
    bent = [one.bent for one in statics if one.bent is not None]
    leaves = [min(len(np.unique(one.leaf)), MOTIONS) for one in bent]
    return StillExtent(
        vertices=sum(places * points for places, points, _ in sizes),
        triangles=sum(places * triangles for places, _, triangles in sizes),
        copies=sum(places for places, _, _ in sizes if places > 1),
        shapes=(sum(points for _, points, _ in sizes), sum(last for _, _, last in sizes)),
        bent=sum(len(one.leaf) for one in bent),
        joints=sum(1 + len(FOLLOWED) * number for number in leaves),
    )


class SceneWriter(NamedTuple):
    """A format of scenes. `out` is the path of `--out`: a file or a folder, as the format wants."""

    # (out, options) before any work: UserError for a wrong suffix, a missing extra, options of
    # other formats, and files that may not be replaced.
    check: Callable[[Path, SceneOptions], None]
    # (extent, options) -> bytes of all files, within a fifth beyond a few megabytes.
    estimate: Callable[[SceneExtent, SceneOptions], int]
    # (scene, out, options) -> the written files. Nothing is left half-written.
    write: Callable[[Scene, Path, SceneOptions], list[Path]]
