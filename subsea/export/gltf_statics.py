"""Sand, stone, corals and seaweed of a scene in glTF."""

from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.export.axes import METRES, WORLD_Y_UP, to_metres
from subsea.export.glb import INDICES, VERTICES, GlbBuffer
from subsea.export.gltf_parts import Json, ordered
from subsea.export.packing import PositionGrid
from subsea.export.scene import SceneMesh
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
