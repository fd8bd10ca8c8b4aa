"""Plays a .glb file: an independent reader that follows the specification word for word."""

import json
import struct
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

KINDS = {
    5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32,
    5126: np.float32,
}  # fmt: skip
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Reader:
    """Plays a .glb file; sections are those of the specification of glTF 2.0."""

    def __init__(self, path: Path, unpacked: bytes = b"") -> None:
        """`unpacked` is the buffer that EXT_meshopt_compression stands for, decompressed."""
        data = path.read_bytes()
        length = struct.unpack_from("<I", data, 12)[0]  # 4.4: header, JSON, binary
        self.content: dict[str, Any] = json.loads(data[20 : 20 + length])
        self.binary, self.unpacked = data[28 + length :], unpacked
        self.animations = {one["name"]: one for one in self.content.get("animations", [])}
        self.array = cache(self._array)
        self.view = cache(self._view)

    def _view(self, number: int) -> bytes:
        """The bytes of a view."""
        view = self.content["bufferViews"][number]
        assert ("extensions" in view) == (view["buffer"] == 1)
        whole = self.unpacked if view["buffer"] else self.binary
        return whole[view.get("byteOffset", 0) :][: view["byteLength"]]

    def _array(self, accessor: int) -> np.ndarray:
        """3.6.2, as floats where integers are normalised."""
        one = self.content["accessors"][accessor]
        kind, width = np.dtype(KINDS[one["componentType"]]), WIDTHS[one["type"]]
        out = np.zeros((one["count"], width), kind)
        if "bufferView" in one:
            stride = self.content["bufferViews"][one["bufferView"]].get("byteStride")
            stride = stride or kind.itemsize * width
            raw = self.view(one["bufferView"])[one.get("byteOffset", 0) :]
            strides = stride, kind.itemsize
            out = np.ndarray(out.shape, kind, raw, strides=strides)
        if "sparse" in one:  # 3.6.2.3
            out, sparse = out.copy(), one["sparse"]
            index = sparse["indices"]
            rows = np.frombuffer(
                self.view(index["bufferView"]), KINDS[index["componentType"]], sparse["count"]
            )
            out[rows] = np.frombuffer(
                self.view(sparse["values"]["bufferView"]), kind, sparse["count"] * width
            ).reshape(-1, width)
        for bound, most in (("min", out.min(axis=0)), ("max", out.max(axis=0))):
            assert bound not in one or (most == one[bound]).all()
        if one.get("normalized"):
            out = np.maximum(out / float(np.iinfo(kind).max), -1.0)
        return out if width > 1 else out[:, 0]

    def times(self, name: str) -> np.ndarray:
        return self.array(self.animations[name]["samplers"][0]["input"])

    def points(self, name: str, at: np.ndarray) -> np.ndarray:
        """Vertices (T, n, 3) of the only mesh at times (T,) of an animation: `node_points`."""
        [number] = [k for k, node in enumerate(self.content["nodes"]) if "mesh" in node]
        return self.node_points(number, self.worlds(name, at))[0]

    def worlds(self, name: str, at: np.ndarray) -> "NodeMoment":
        """All nodes at times (T,) of an animation."""
        nodes = [dict(node) for node in self.content["nodes"]]
        one = self.animations[name]
        for channel in one["channels"]:
            sampler = one["samplers"][channel["sampler"]]
            node, path = channel["target"]["node"], channel["target"]["path"]
            nodes[node][path] = self._sampled(sampler, path, at)
        return NodeMoment(nodes, len(at))

    def node_points(self, number: int, moment: "NodeMoment") -> tuple[np.ndarray, np.ndarray]:
        """Vertices and normals, of no unit length, (T, n, 3) of the mesh of a node."""
        node, world = moment.nodes[number], moment.world
        mesh = self.content["meshes"][node["mesh"]]
        primitive = mesh["primitives"][0]
        targets = primitive.get("targets", [])
        attributes = {k: self.array(v) for k, v in primitive["attributes"].items()}
        shares = np.asarray(node.get("weights", ()))
        shares = np.broadcast_to(
            shares.reshape(moment.count, -1) if shares.size else shares,
            (moment.count, len(targets)),
        )
        place, normal = (
            np.repeat(attributes[name].astype(float)[None], moment.count, axis=0)
            for name in ("POSITION", "NORMAL")
        )
        for share, target in zip(shares.T, targets, strict=True):
            there = share != 0.0
            if there.any():  # 3.7.2.2
                place[there] += share[there, None, None] * self.array(target["POSITION"])
                normal[there] += share[there, None, None] * self.array(target["NORMAL"])
        place = np.pad(place, ((0, 0), (0, 0), (0, 1)), constant_values=1.0)
        if "skin" not in node:
            transform = world[number]
            return (
                (place @ transform.swapaxes(-1, -2))[..., :3],
                normal @ transform[..., :3, :3].swapaxes(-1, -2),
            )
        skin = self.content["skins"][node["skin"]]  # 3.7.3.3
        bind = self.array(skin["inverseBindMatrices"]).reshape(-1, 4, 4).swapaxes(1, 2)
        joints = np.stack([world[joint] for joint in skin["joints"]], axis=1) @ bind
        out, facing = np.zeros_like(place), np.zeros_like(normal)
        for joint, weight in zip(attributes["JOINTS_0"].T, attributes["WEIGHTS_0"].T, strict=True):
            out += weight[:, None] * np.einsum("tnij,tnj->tni", joints[:, joint], place)
            turns = joints[:, joint, :3, :3]
            facing += weight[:, None] * np.einsum("tnij,tnj->tni", turns, normal)
        return out[..., :3], facing

    def _sampled(self, sampler: dict[str, Any], path: str, at: np.ndarray) -> np.ndarray:
        """A step, linear or, for rotations, spherical: appendix C."""
        times, keys = self.array(sampler["input"]), self.array(sampler["output"])
        keys = keys.reshape(len(times), -1).astype(float)
        after = np.clip(np.searchsorted(times, at), 1, len(times) - 1)
        if sampler.get("interpolation") == "STEP":
            return keys[np.clip(np.searchsorted(times, at, side="right") - 1, 0, None)]
        assert sampler.get("interpolation", "LINEAR") == "LINEAR"
        share = (at - times[after - 1]) / (times[after] - times[after - 1])
        share = np.clip(share, 0.0, 1.0)[:, None]
        a, b = keys[after - 1], keys[after]
        mixed = (1.0 - share) * a + share * b
        if path != "rotation":
            return mixed
        dot = (a * b).sum(axis=1, keepdims=True)
        b, dot = np.where(dot < 0.0, -b, b), abs(dot)
        mixed = (1.0 - share) * a + share * b
        mixed /= np.linalg.norm(mixed, axis=1, keepdims=True)
        angle = np.arccos(np.minimum(dot, 0.9999))
        turned = np.sin(angle * (1 - share)) * a + np.sin(angle * share) * b
        # For small angles linear, as the specification advises.
        return np.where(dot > 0.9999, mixed, turned / np.sin(angle))


class NodeMoment:
    """All nodes at T times, and their transforms to the scene (T, 4, 4)."""

    def __init__(self, nodes: list[dict[str, Any]], count: int) -> None:
        self.nodes, self.count = nodes, count
        self.world = [np.eye(4)] * len(nodes)
        children = {child for node in nodes for child in node.get("children", [])}
        for number in set(range(len(nodes))) - children:
            self._descend(number, np.eye(4))

    def _descend(self, number: int, above: np.ndarray) -> None:
        self.world[number] = above @ _matrix(self.nodes[number], self.count)
        for child in self.nodes[number].get("children", []):
            self._descend(child, self.world[number])


def _matrix(node: dict[str, Any], count: int) -> np.ndarray:
    """3.5.2 and 3.5.3, at each time."""
    x, y, z, w = np.asarray(node.get("rotation", (0.0, 0.0, 0.0, 1.0))).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    out = np.tile(np.eye(4), (count, 1, 1))
    scale = np.broadcast_to(np.asarray(node.get("scale", (1.0, 1.0, 1.0))), (count, 3))
    for i in range(3):
        for j in range(3):
            out[:, i, j] = rows[i][j] * scale[:, j]
    out[:, :3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return out
