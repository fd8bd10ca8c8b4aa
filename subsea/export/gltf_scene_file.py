"""The parts of a scene in glTF, as they are collected, and the file that they make."""

from collections.abc import Iterator

import numpy as np

from subsea.base.arrays import Array
from subsea.export.axes import METRES, WORLD_Y_UP, Y_UP, to_metres, world_rotations
from subsea.export.glb import GlbBuffer, asset, glb
from subsea.export.gltf_parts import (
    Json,
    KeyChannel,
    KeyTrack,
    Parts,
    add_parts,
    add_sheet,
    add_times,
    add_tracks,
    animation,
    path_tracks,
    primitives,
    sheets,
)
from subsea.export.gltf_statics import INSTANCING, Statics
from subsea.export.packing import Packing, Stored
from subsea.export.scene import Scene, SceneFish

CUT_S = 1e-3  # before a cut of the camera, the picture before it still stands


class SceneFile:
    """A file in the making."""

    def __init__(self, scene: Scene, packing: Packing) -> None:
        self.scene, self.buffer = scene, GlbBuffer(packing)
        self.nodes: list[Json] = []
        self.roots: list[int] = []
        self.meshes: list[Json] = []
        self.materials: list[Json] = []
        self.images: list[Json] = []
        self.skins: list[Json] = []
        self.channels: list[KeyChannel] = []
        self._times: dict[tuple[int, int], int] = {}
        self._parts: dict[int, Parts] = {}
        self._looks: dict[tuple[int, tuple[float, ...]], int] = {}
        self._instancing = False

    def node(self, node: Json, root: bool = False) -> int:
        """Add a node; return its number."""
        self.nodes.append(node)
        if root:
            self.roots.append(len(self.nodes) - 1)
        return len(self.nodes) - 1

    def times(self, first: int, last: int) -> int:
        """The accessor of the times of frames."""
        if (first, last) not in self._times:
            seconds = np.arange(first, last + 1) / self.scene.fps
            self._times[first, last] = add_times(self.buffer, seconds)
        return self._times[first, last]

    def add_path(self, fish: int) -> tuple[int, Json]:
        """Add the node that moves as a fish; return its number and the node."""
        one = self.scene.fishes[fish]
        species = self.scene.models[one.model].name
        extras = {"fish": one.number, "species": species, "lengthCm": one.length_cm}
        node: Json = {"name": one.name, "scale": [one.scale] * 3, "extras": extras}
        number = self.node(node, root=True)
        there = slice(one.first, one.last + 1)
        places = to_metres(self.scene.position[there, fish], WORLD_Y_UP)
        turns = world_rotations(self.scene.rotation[there, fish], Y_UP)
        tracks = path_tracks(number, places, turns, self.times(one.first, one.last))
        self.channels += add_tracks(self.buffer, [*tracks, *self._presence(one, number)])
        return number, node

    def _presence(self, one: SceneFish, number: int) -> Iterator[KeyTrack]:
        """A fish that comes or goes has no size while it is not in the sea.

        It does between frames, so that no rounding of times moves that to another frame.
        """
        keys = {0.0: one.scale}
        if one.first:
            keys = {0.0: 0.0, one.first - 0.5: one.scale}
        if one.last < self.scene.frames - 1:
            keys[one.last + 0.5] = 0.0
        if len(keys) > 1:
            times = add_times(self.buffer, np.array(list(keys)) / self.scene.fps)
            sizes = np.repeat(np.array(list(keys.values()), np.float32)[:, None], 3, axis=1)
            yield KeyTrack(number, "scale", Stored(sizes), times, steps=True)

    def parts(self, model: int) -> Parts:
        """The parts of a model's mesh; its colours are added the first time."""
        if model not in self._parts:
            one = self.scene.models[model]
            self._parts[model] = add_parts(self.buffer, one, len(self.images))
            self.images.append(add_sheet(self.buffer, one))
        return self._parts[model]

    def looks(self, model: int, tint: Array) -> int:
        """The number of the first of the materials of a model in a tint."""
        parts = self.parts(model)
        color = tuple(np.round(np.clip(tint, 0.0, 1.0), 3).tolist())
        if (model, color) not in self._looks:
            self._looks[model, color] = len(self.materials)
            for one in parts.materials:
                skin = one["pbrMetallicRoughness"] | {"baseColorFactor": [*color, 1.0]}
                name = f"{self.scene.models[model].name}_{one['name']}"
                self.materials.append(one | {"name": name, "pbrMetallicRoughness": skin})
        return self._looks[model, color]

    def add_mesh(self, fish: int, attributes: Json, targets: tuple[Json, ...] = ()) -> int:
        """Add the mesh of a fish in its tint; return its number."""
        one = self.scene.fishes[fish]
        first = self.looks(one.model, one.tint)
        parts = primitives(attributes, self.parts(one.model), first, targets)
        self.meshes.append({"name": one.name, "primitives": parts})
        return len(self.meshes) - 1

    def add_statics(self, instancing: bool) -> None:
        """Add what stands still, copies of a mesh as nodes or as instances of one node."""
        own = Statics(self.buffer, self.nodes, self.meshes, self.materials, instancing)
        self.roots += own.add_all(self.scene.statics)
        self._instancing = any(INSTANCING in node.get("extensions", {}) for node in self.nodes)

    def add_camera(self) -> None:
        """Add the camera with its motion; at a cut it jumps."""
        camera, fps = self.scene.camera, self.scene.fps
        number = self.node({"name": "camera", "camera": 0}, root=True)
        frames = np.arange(self.scene.frames)
        cuts = np.array([cut for cut in camera.cuts if 0 < cut < len(frames)], int)
        shown = np.insert(frames, cuts, cuts - 1)
        # The frame before a cut is repeated just before the cut.
        seconds = np.insert(frames / fps, cuts, cuts / fps - min(CUT_S, 0.1 / fps))
        places = to_metres(camera.position[shown], WORLD_Y_UP)
        turns = world_rotations(camera.rotation[shown])
        times = add_times(self.buffer, seconds)
        self.channels += add_tracks(self.buffer, path_tracks(number, places, turns, times))

    def bytes(self, extras: Json) -> bytes:
        """The whole file."""
        scene, camera = self.scene, self.scene.camera
        own = {
            "scenario": scene.name,
            "seed": scene.seed,
            "framesPerSecond": scene.fps,
            "frames": scene.frames,
            "seconds": (scene.frames - 1) / scene.fps,
            "startSeconds": scene.start_s,
        } | extras
        lens = {
            "aspectRatio": camera.aspect,
            "yfov": camera.height_rad,
            "znear": METRES * camera.near_cm,
            "zfar": METRES * camera.far_cm,
        }
        content: Json = {
            "asset": asset([model.name for model in scene.models], own),
            "scene": 0,
            "scenes": [{"name": scene.name, "nodes": self.roots, "extras": own}],
            "nodes": self.nodes,
            "cameras": [{"name": "camera", "type": "perspective", "perspective": lens}],
            "animations": [animation(scene.name, self.channels, {"framesPerSecond": scene.fps})],
        }
        content |= {"meshes": self.meshes} if self.meshes else {}
        content |= {"materials": self.materials} if self.materials else {}
        content |= {"skins": self.skins} if self.skins else {}
        if self.images:
            content |= sheets(self.images)
        if self._instancing:
            for key in ("extensionsUsed", "extensionsRequired"):
                content[key] = [*content.get(key, []), INSTANCING]
        return glb(content, self.buffer)
