"""The pictures of a set: their worlds, cameras and labels, each drawn from the number of a picture.

A scene is one world with values of its own. Several pictures are taken in it. The state of
a scene at a picture depends on the scene's number alone, so any process makes the same picture.
"""

import copy
import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.dive.ride import VALUES
from subsea.dive.tour import Tour
from subsea.geometry.solids import height_at
from subsea.geometry.vector import vector
from subsea.habitat.contact import clearance
from subsea.lab.dataset.labelling import Drawing, Labels, inside, labels_of
from subsea.lab.dataset.ranges import DrawnRange, change_of, drawn, picture_ranges, scene_ranges
from subsea.lab.dataset.sensor import (
    depth_map,
    flow_map,
    jpeg,
    masks_of,
    normal_map,
    png,
    sensed,
)
from subsea.library import World, load
from subsea.submarine.vessel import NEUTRAL
from subsea.view.optics import CameraLens, FlatPort, Optics
from subsea.view.rig import CameraPose, pose_from_angles
from subsea.world.step import Order, step
from subsea.world.world import TICK_S

MAPS = ("identity", "depth", "normal", "flow")
RANDOM, SUBMARINE = "random", "submarine"
TRIES = 60  # of a random camera
ROOM_CM = 8.0  # of a random camera from what is solid
SLOPES_DEG = (-35.0, 40.0)  # of the way from a fish to a random camera
SIGHT = 16  # places between a camera and its fish that must be free
# Purposes of random numbers.
SCENE, PICTURE, CAMERA, GRAIN, SPLIT = range(5)
MOST_SEED = 2**31


@dataclass(frozen=True)
class DatasetPlan:
    """Everything that the bytes of a picture depend on, beside its number."""

    scenario: str
    seed: int = 0
    fish: int | None = None
    size: tuple[int, int] = (640, 480)
    cameras: tuple[str, ...] = (RANDOM,)
    ranges: dict[str, DrawnRange] = field(default_factory=dict)
    per_scene: int = 20  # pictures of one world
    every: int = 15  # ticks between two of them
    settle_s: tuple[float, float] = (4.0, 20.0)  # before the first one
    sequence: bool = False  # one camera for all pictures of a scene
    maps: tuple[str, ...] = ()
    quality: str = "medium"
    val: float = 0.1  # share of the scenes that are kept for validation

    def random(self, purpose: int, number: int) -> np.random.Generator:
        """Return the random numbers of a scene or picture."""
        return np.random.default_rng([self.seed, purpose, number])

    def values(self, scene: int) -> dict[str, Any]:
        """Draw the values of the scenario of a scene."""
        return drawn(scene_ranges(self.ranges), (self.seed, SCENE, scene))

    def settings(self, number: int) -> dict[str, Any]:
        """Draw the values of a picture."""
        one = number // self.per_scene if self.sequence else number
        return drawn(picture_ranges(self.ranges), (self.seed, PICTURE, one))

    def is_val(self, scene: int) -> bool:
        """True for a scene that is kept for validation."""
        return bool(self.random(SPLIT, scene).random() < self.val)


class Shot(NamedTuple):
    """A picture of the set."""

    number: int
    files: dict[str, bytes]  # by the ending of the name
    about: dict[str, Any]  # the content of ``.json``


def changes_at_ends(ranges: dict[str, DrawnRange]) -> Iterator[list[str]]:
    """Changes of the scenario at the ends of each range, to check them."""
    for key, one in scene_ranges(ranges).items():
        for value in one.ends:
            yield [change_of(key, value)]


def shots(plan: DatasetPlan, scenario: str, numbers: range) -> Iterator[Shot]:
    """Make pictures with these numbers of the scenario in a file."""
    last = (numbers.stop - 1) // plan.per_scene
    for scene in range(numbers.start // plan.per_scene, last + 1):
        first = scene * plan.per_scene
        stage = _Stage(plan, scenario, scene)
        for number in range(max(numbers.start, first), min(numbers.stop, first + plan.per_scene)):
            yield stage.take(number)


class _Stage:
    """A scene, which goes on from picture to picture."""

    def __init__(self, plan: DatasetPlan, path: str, scene: int) -> None:
        """Load the world of a scene."""
        self.plan, self.scene = plan, scene
        random = plan.random(SCENE, scene)
        self.values = plan.values(scene)
        self.seed = int(random.random() * MOST_SEED)
        changes = [change_of(key, value) for key, value in self.values.items()]
        self.world = load(path, seed=self.seed, fish=plan.fish, changes=changes)
        low, high = plan.settle_s
        self.begin = round((low + random.random() * (high - low)) / TICK_S)
        self.tour = Tour()
        self._go_to(self.begin)
        first = scene * plan.per_scene
        self._held = self._camera(first, plan.settings(first)) if plan.sequence else None

    def take(self, number: int) -> Shot:
        """Go on to a picture, and take it."""
        plan, world = self.plan, self.world
        self._go_to(self.begin + (number % plan.per_scene) * plan.every)
        settings = plan.settings(number)
        camera = self._held if plan.sequence else self._camera(number, settings)
        optics = _optics(plan.size, settings)
        tour = copy.deepcopy(self.tour)

        def advance(world: World) -> None:
            step(world.internal, self._order(tour))

        labels = labels_of(
            world, [camera], optics,
            Drawing(
                plan.quality, "flow" in plan.maps, bool(settings["camera.lamps"]) or None, advance
            ),
        )[0]  # fmt: skip
        picture = sensed(
            labels.picture, settings["sensor.blur_px"], settings["sensor.noise"],
            [plan.seed, GRAIN, number],
        )  # fmt: skip
        files = {"jpg": jpeg(picture, int(settings["jpeg.quality"]))} | _maps(labels, plan.maps)
        about = self._about(number, labels, settings)
        files["json"] = json.dumps(about).encode()
        return Shot(number, files, about)

    def _go_to(self, tick: int) -> None:
        while self.world.tick < tick:
            step(self.world.internal, self._order(self.tour))

    def _order(self, tour: Tour) -> Order:
        """Steer the submarine on a tour, if it takes pictures."""
        return tour.steer(self.world.internal) if SUBMARINE in self.plan.cameras else NEUTRAL

    def _camera(self, number: int, settings: dict[str, Any]) -> Any:
        random = self.plan.random(CAMERA, number)
        kind = self.plan.cameras[int(random.random() * len(self.plan.cameras))]
        if kind == SUBMARINE:
            return None
        if kind == RANDOM:
            return near_a_fish(self.world, random, settings)
        x, y, z, heading, pitch = (float(part) for part in kind.split(","))
        return pose_from_angles(np.array([x, y, z]), *np.radians([heading, pitch]).tolist())

    def _about(self, number: int, labels: Labels, settings: dict[str, Any]) -> dict[str, Any]:
        plan, fishes = self.plan, labels.fishes
        port = labels.optics.port
        masks = masks_of(labels.identity, VALUES["fish"])
        return {
            "image": number,
            "width": plan.size[0],
            "height": plan.size[1],
            "split": "val" if plan.is_val(self.scene) else "train",
            "scene": self.scene,
            "scene_seed": self.seed,
            "scene_values": self.values,
            "tick": labels.tick,
            "time_s": round(labels.tick * TICK_S, 6),
            "visibility_cm": self.world.internal.scenario.water.visibility_cm,
            "settings": settings,
            "camera": {
                "matrix": labels.matrix.tolist(),
                "intrinsics": labels.intrinsics.tolist(),
                "distortion": labels.distortion.tolist(),
                "port": port._asdict() if port else None,
            },
            "fishes": [
                {
                    "number": int(fishes.number[i]),
                    "species": labels.species[fishes.species[i]],
                    "box": _numbers(fishes.box[i]) if fishes.pixels[i] else None,
                    "whole": _numbers(fishes.whole[i]),
                    "pixels": int(fishes.pixels[i]),
                    "share": round(float(fishes.share[i]), 4),
                    "distance_cm": round(float(fishes.distance[i]), 2),
                    "keypoints": [
                        [*_numbers(place), int(state), *_numbers([z]), int(by)]
                        for place, state, z, by in zip(
                            fishes.keypoints[i], fishes.state[i], fishes.depth[i],
                            fishes.hidden_by[i], strict=True,
                        )
                    ],
                    "rle": masks.get(VALUES["fish"] + int(fishes.number[i])),
                }
                for i in range(len(fishes.number))
            ],
        }  # fmt: skip


def _numbers(values: Any) -> list[float | None]:
    """Round numbers for a file; None for NaN."""
    return [None if np.isnan(one) else round(float(one), 3) for one in values]


def _maps(labels: Labels, wanted: tuple[str, ...]) -> dict[str, bytes]:
    files: dict[str, bytes] = {}
    if "identity" in wanted:
        files["identity.png"] = png(labels.identity.astype(np.uint16))
    if "depth" in wanted:
        files["depth.png"] = png(depth_map(labels.depth))
    if "normal" in wanted:
        files["normal.png"] = png(normal_map(labels.normal))
    if "flow" in wanted:
        files["flow_forward.png"] = png(flow_map(labels.flow_forward))
        files["flow_backward.png"] = png(flow_map(labels.flow_backward))
    return files


def _optics(size: tuple[int, int], settings: dict[str, Any]) -> Optics:
    gap = settings.get("camera.port_gap_cm")
    port = None if gap is None else FlatPort(float(gap))
    lens = CameraLens(float(settings["camera.k1"]), float(settings["camera.k2"]))
    return Optics(size, float(settings["camera.field_deg"]), lens, port)


def near_a_fish(
    world: World, random: np.random.Generator, settings: dict[str, Any]
) -> CameraPose | None:
    """Find a place in free water from which a fish can be seen; None if there is none."""
    fishes, sea = world.fishes, world.internal.state.sea
    alive = np.flatnonzero(fishes.alive)
    for _ in range(TRIES if len(alive) else 0):
        pick, round_, up, turn, lift = random.random(5)
        fish = int(alive[int(pick * len(alive))])
        target = fishes.position[fish].astype(np.float64)
        angle = 2.0 * np.pi * round_
        slope = np.radians(SLOPES_DEG[0] + up * (SLOPES_DEG[1] - SLOPES_DEG[0]))
        way = np.array(
            [np.cos(angle) * np.cos(slope), np.sin(angle) * np.cos(slope), np.sin(slope)]
        )
        reach = float(settings["camera.distance"]) * float(fishes.length[fish])
        eye = target + reach * way
        sight = [target + share * (eye - target) for share in np.linspace(0.1, 1.0, SIGHT)]
        if any(inside(world.internal, place) for place in sight):
            continue
        floor = height_at(sea.floor, sea.half_width, eye[0], eye[1])
        room = min(clearance(sea.pillars, sea.rocks, vector(eye)), eye[2] - floor, -eye[2])
        if room < ROOM_CM:
            continue
        heading, pitch = np.arctan2(-way[1], -way[0]), -slope
        off = 0.5 * np.radians(settings["camera.field_deg"]) * float(settings["camera.aside"])
        heading += off * (2.0 * turn - 1.0)
        pitch += 0.6 * off * (2.0 * lift - 1.0)
        return pose_from_angles(eye, float(heading), float(pitch))
    return None


def check_cameras(plan: DatasetPlan, world: World) -> None:
    """Raise a UserError for a fixed camera that is not in free water."""
    for kind in plan.cameras:
        if kind in (RANDOM, SUBMARINE):
            continue
        try:
            x, y, z, _, _ = (float(part) for part in kind.split(","))
        except ValueError:
            raise UserError(
                f"--camera {kind}: expected random, submarine, or X,Y,Z,HEADING,PITCH in cm and "
                "degrees"
            ) from None
        place: Array = np.array([x, y, z])
        if not np.isfinite(place).all() or (fault := inside(world.internal, place)):
            raise UserError(f"--camera {kind}: is inside {fault}; move it into free water")
