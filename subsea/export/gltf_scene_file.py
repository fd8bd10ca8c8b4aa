"""The parts of a scene in glTF, as they are collected, and the file that they make.

Sand, stone, corals and seaweed of a scene in glTF.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.export.axes import METRES, WORLD_Y_UP, Y_UP, to_metres, world_rotations
from subsea.export.glb import (
    INDICES,
    VERTICES,
    GlbBuffer,
    Packing,
    PositionGrid,
    Stored,
    asset,
    glb,
)
from subsea.export.gltf import (
    Json,
    KeyChannel,
    KeyTrack,
    Parts,
    add_parts,
    add_sheet,
    add_times,
    add_tracks,
    animation,
    ordered,
    path_tracks,
    primitives,
    sheets,
)
from subsea.export.scene import Scene, SceneFish, SceneMesh
from subsea.geometry.rotation import from_matrix

INSTANCING = "EXT_mesh_gpu_instancing"
ROUGH = 0.9  # of what is not wet skin
TINTS = 8  # steps of the colours of copies that are nodes: each has its own material
SHEARED = 1e-3  # cosine of the angle between axes beyond which a copy has its own vertices


class Statics(NamedTuple):
    """Lists of a file, to which meshes that do not move are added."""

    buffer: GlbBuffer
    nodes: list[Json]
    meshes: list[Json]
    materials: list[Json]
    instancing: bool  # one node for all copies, with an extension of glTF

    def add_all(self, statics: tuple[SceneMesh, ...]) -> list[int]:
        """Add meshes; return the numbers of the nodes of their groups."""
        groups: dict[str, Json] = {}
        out = []
        for one in statics:
            if one.group not in groups:
                groups[one.group] = {"name": one.group, "children": []}
                out.append(len(self.nodes))
                self.nodes.append(groups[one.group])
            groups[one.group]["children"] += self._add(one)
        return out

    def _add(self, one: SceneMesh) -> list[int]:
        """Add a mesh at all its places; return the numbers of the nodes."""
        straight = np.array([_is_straight(place) for place in one.places], np.bool_)
        out = []
        for k in np.flatnonzero(~straight):
            out += self._copies(_moved(one, one.places[k]), np.eye(4)[None], one.tints[k : k + 1])
        if straight.any():
            out += self._copies(one, one.places[straight], one.tints[straight])
        return out

    def _copies(self, one: SceneMesh, places: Array, tints: Array) -> list[int]:
        points = to_metres(one.points, WORLD_Y_UP)
        grid = self.buffer.packing.grid(points)
        brightest = max(1.0, float(tints.max()))
        primitive = self._primitive(one, points, grid, brightest)
        tints = np.clip(tints / brightest, 0.0, 1.0)
        way, turn, size = _parted(places, grid)
        if self.instancing and len(places) > 1:
            mesh = self._mesh(one, primitive, np.ones(3))
            floats = {"TRANSLATION": way, "ROTATION": turn, "SCALE": size, "_COLOR_0": tints}
            own = {
                name: self.buffer.add(value.astype(np.float32)) for name, value in floats.items()
            }
            node = {"name": one.name, "mesh": mesh}
            self.nodes.append(node | {"extensions": {INSTANCING: {"attributes": own}}})
            return [len(self.nodes) - 1]
        first = len(self.nodes)
        meshes: dict[tuple[float, ...], int] = {}
        steps = np.maximum(np.round(tints * TINTS), 1) / TINTS if len(tints) > 1 else tints
        for k, tint in enumerate(map(tuple, steps.tolist())):
            if tint not in meshes:
                meshes[tint] = self._mesh(one, primitive, np.array(tint))
            name = one.name if len(places) == 1 else f"{one.name}_{k + 1:03d}"
            self.nodes.append({"name": name, "mesh": meshes[tint]} | _place(way, turn, size, k))
        return list(range(first, len(self.nodes)))

    def _primitive(
        self, one: SceneMesh, points: Array, grid: PositionGrid, brightest: float
    ) -> Json:
        pack, buffer = self.buffer.packing, self.buffer
        wide = np.uint16 if len(points) <= 65535 else np.uint32
        colors = np.clip(one.colors * brightest, 0.0, 1.0)
        return {
            "attributes": {
                "POSITION": buffer.add(pack.positions(points, grid), VERTICES),
                "NORMAL": buffer.add(pack.normals(one.normals @ WORLD_Y_UP.T), VERTICES),
                "COLOR_0": buffer.add(pack.coordinates(colors), VERTICES),
            },
            "indices": buffer.add(one.triangles.astype(wide).ravel(), INDICES),
        }

    def _mesh(self, one: SceneMesh, primitive: Json, tint: Array) -> int:
        """Add a mesh of a colour; return its number."""
        looks: Json = {"metallicFactor": 0.0, "roughnessFactor": ROUGH}
        if (tint != 1.0).any():
            looks["baseColorFactor"] = [*tint.tolist(), 1.0]
        look: Json = {"name": one.group, "pbrMetallicRoughness": looks}
        look |= {"doubleSided": True} if one.two_sided else {}
        if look not in self.materials:
            self.materials.append(look)
        primitive = primitive | {"material": self.materials.index(look)}
        self.meshes.append({"name": one.name, "primitives": [primitive]})
        return len(self.meshes) - 1


def _is_straight(place: Array) -> bool:
    """True if a transform is a rotation of something stretched along its own axes."""
    axes = place[:3, :3] / np.linalg.norm(place[:3, :3], axis=0)
    across = np.abs(axes.T @ axes - np.eye(3)).max()
    return bool(across < SHEARED and np.linalg.det(axes) > 0.0)


def _moved(one: SceneMesh, place: Array) -> SceneMesh:
    """A mesh at a place, as vertices."""
    normals = one.normals @ np.linalg.inv(place[:3, :3])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    turned = np.linalg.det(place[:3, :3]) < 0.0
    return one._replace(
        points=one.points @ place[:3, :3].T + place[:3, 3],
        normals=normals,
        triangles=one.triangles[:, ::-1] if turned else one.triangles,
    )


def _parted(places: Array, grid: PositionGrid) -> tuple[Array, Array, Array]:
    """Translation, metres, rotation (k, 4), w last, and scale (k, 3) of copies of stored vertices.

    Transforms and vertices are those of the dive, in cm with z up; the results are for y up.
    """
    turned = WORLD_Y_UP @ places[:, :3, :3] @ WORLD_Y_UP.T
    way = METRES * places[:, :3, 3] @ WORLD_Y_UP.T
    size = np.linalg.norm(turned, axis=1)
    turn = from_matrix(turned / size[:, None])
    way = way + turned @ grid.middle
    return way, ordered(np.asarray(turn)), size * (grid.half or 1.0)


def _place(way: Array, turn: Array, size: Array, k: int) -> dict[str, Any]:
    """The properties of a node at place k, but those that say nothing."""
    own = {"translation": (way, 0.0), "scale": (size, 1.0), "rotation": (turn, (0, 0, 0, 1))}
    return {
        name: value[k].tolist() for name, (value, idle) in own.items() if (value[k] != idle).any()
    }


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
