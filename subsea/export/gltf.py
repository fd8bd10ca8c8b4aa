"""Export a species and its clips as glTF 2.0 (.glb), with an animation for each clip.

The mesh is moved by a fitted skeleton (`skinning.py`) or, exactly but with a larger file, by a
morph target for each frame. Both interpolate linearly between frames.
"""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.core.arrays import Array
from subsea.core.atomic_io import replacing
from subsea.export.axes import METRES, Y_UP, rotate_quaternions, to_metres
from subsea.export.clips import Clip, Model, bake_root, transparent_triangles
from subsea.export.glb import CLAMPED, INDICES, VERTICES, GlbBuffer, glb, material
from subsea.export.png import sheet_png
from subsea.export.skinning import MAX_INFLUENCES, Skeleton
from subsea.geometry.rotation import from_matrix, matrix

Json = dict[str, Any]

LINEAR_MIPMAPS = 9987
ROOT = 0  # node


def gltf_files(folder: Path, name: str) -> list[Path]:
    """The file that `write_gltf` writes."""
    return [folder / f"{name}.glb"]


def write_gltf(
    folder: Path, model: Model, clips: list[Clip], baked: bool, rig: Skeleton | None
) -> Path:
    """Write NAME.glb into `folder`, with a skinned mesh or, without a rig, with morph targets.

    The path of the fish is the motion of the node `root`, or `baked` into joints or targets.
    UserError if the file cannot be written.
    """
    [path] = gltf_files(folder, model.name)
    data = _morphed(model, clips, baked) if rig is None else _skinned(model, clips, baked, rig)
    with replacing(path) as part:
        part.write_bytes(data)
    return path


def _skinned(model: Model, clips: list[Clip], baked: bool, rig: Skeleton) -> bytes:
    buffer = GlbBuffer()
    primitives, materials = _parts(buffer, model, _skin_attributes(buffer, rig), {})
    places = np.array([joint.place for joint in rig.joints])
    count = len(places)
    first = 1  # the joints are the nodes after the root
    parents = np.array(
        [first + joint.parent if joint.parent >= 0 else ROOT for joint in rig.joints]
    )
    held = np.vstack([np.zeros(3), places])[parents]  # positions of the parents
    nodes: list[Json] = [{"name": "root"}]
    nodes += [
        {"name": joint.name, "translation": to_metres(place - hold, Y_UP).tolist()}
        for joint, place, hold in zip(rig.joints, places, held, strict=True)
    ]
    for k, parent in enumerate(parents):
        nodes[parent].setdefault("children", []).append(first + k)
    nodes.append({"name": model.name, "mesh": 0, "skin": 0})
    bind = np.tile(np.eye(4), (1 + count, 1, 1))
    bind[1:, :3, 3] = -to_metres(places, Y_UP)
    skin = {
        "inverseBindMatrices": buffer.add(bind.astype(np.float32)),
        "joints": [*range(1 + count)],
        "skeleton": ROOT,
    }
    animations = []
    begin = 0
    for clip in clips:
        motion = rig.motion[begin : begin + len(clip.points)].copy()
        begin += len(clip.points)
        if clip.cyclic:
            motion[-1] = motion[0]
        turn, place = motion[..., :3], motion[..., :3] @ places[:, :, None] + motion[..., 3:]
        if baked:
            root = matrix(clip.rotation)[:, None]
            turn, place = root @ turn, root @ place + clip.position[:, None, :, None]
        # Relative to the parents; the parent of the first joints is the root.
        turns = np.concatenate([np.tile(np.eye(3), (len(turn), 1, 1, 1)), turn], axis=1)
        back = turns[:, parents].swapaxes(2, 3)
        origin = np.pad(place, ((0, 0), (1, 0), (0, 0), (0, 0)))[:, parents]
        turn, place = from_matrix(back @ turn), (back @ (place - origin))[..., 0]
        tracks: list[tuple[int, str, Array]] = []
        for k in range(count):
            tracks += [
                (first + k, "translation", to_metres(place[:, k], Y_UP)),
                (first + k, "rotation", _quaternions(turn[:, k])),
            ]
        animations.append(_animation(buffer, clip, [*_root_tracks(clip, baked), *tracks]))
    extras = {"rmsErrorPercent": rig.rms_percent, "maxErrorPercent": rig.most_percent}
    content = {
        "nodes": nodes,
        "skins": [skin],
        "meshes": [{"name": model.name, "primitives": primitives}],
        "materials": materials,
        "scenes": [{"nodes": [ROOT, len(nodes) - 1]}],  # a skinned mesh moves with its joints alone
    }
    return _file(buffer, model, clips, baked, animations, extras, content)


def _morphed(model: Model, clips: list[Clip], baked: bool) -> bytes:
    buffer = GlbBuffer()
    ways = [bake_root(clip) if baked else clip for clip in clips]
    # The last frame of a cycle is its first one and needs no target.
    frames = [len(clip.points) - (clip.cyclic and not baked) for clip in clips]
    begins = np.cumsum([0, *frames])
    targets = [
        {
            "POSITION": buffer.add(_single(to_metres(points - model.rest, Y_UP)), VERTICES),
            "NORMAL": buffer.add(_single((normals - model.normals) @ Y_UP.T), VERTICES),
        }
        for clip, number in zip(ways, frames, strict=True)
        for points, normals in zip(clip.points[:number], clip.normals[:number], strict=True)
    ]
    primitives, materials = _parts(buffer, model, {}, {"targets": targets})
    animations = []
    for clip, begin, number in zip(clips, begins, frames, strict=False):
        shares = np.zeros((len(clip.points), len(targets)))
        shown = begin + np.arange(len(clip.points)) % number
        shares[np.arange(len(shares)), shown] = 1.0
        tracks = [*_root_tracks(clip, baked), (ROOT, "weights", shares.ravel())]
        animations.append(_animation(buffer, clip, tracks))
    mesh = {"name": model.name, "primitives": primitives, "weights": [0.0] * len(targets)}
    content = {
        "nodes": [{"name": model.name, "mesh": 0}],
        "meshes": [mesh],
        "materials": materials,
        "scenes": [{"nodes": [ROOT]}],
    }
    return _file(buffer, model, clips, baked, animations, {}, content)


def _parts(
    buffer: GlbBuffer, model: Model, attributes: Json, more: Json
) -> tuple[list[Json], list[Json]]:
    """The mesh at rest as up to three primitives with shared vertices, and their materials."""
    attributes = {
        "POSITION": buffer.add(_single(to_metres(model.rest, Y_UP)), VERTICES),
        "NORMAL": buffer.add(_single(model.normals @ Y_UP.T), VERTICES),
        "TEXCOORD_0": buffer.add(_single(model.uv * (1, -1) + (0, 1)), VERTICES),
        **attributes,
    }
    fin = np.arange(len(model.triangles)) >= model.body
    clear = transparent_triangles(model) & ~fin
    primitives: list[Json] = []
    materials: list[Json] = []
    for name, those, looks in (
        ("body", ~fin & ~clear, {}),
        ("clear", clear, {"alphaMode": "BLEND"}),  # of the body, such as the tail
        ("fins", fin, {"alphaMode": "BLEND", "doubleSided": True}),
    ):
        if not those.any():
            continue
        primitive = {
            "attributes": attributes,
            "indices": buffer.add(model.triangles[those].astype(np.uint16).ravel(), INDICES),
            "material": len(materials),
        }
        primitives.append(primitive | more)
        materials.append(material(name, looks))
    return primitives, materials


def _skin_attributes(buffer: GlbBuffer, rig: Skeleton) -> Json:
    """Joints and weights of the vertices; joint 0 is the root and has no weight."""
    most = np.argsort(-rig.weights, axis=1)[:, :MAX_INFLUENCES]
    weights = np.take_along_axis(rig.weights, most, axis=1).astype(np.float32)
    joints = np.where(weights > 0.0, most + 1, 0).astype(np.uint8)
    weights /= weights.sum(axis=1, keepdims=True)
    return {
        "JOINTS_0": buffer.add(joints, VERTICES),
        "WEIGHTS_0": buffer.add(weights, VERTICES),
    }


def _root_tracks(clip: Clip, baked: bool) -> list[tuple[int, str, Array]]:
    """The tracks of the root."""
    if baked:
        return []
    return [
        (ROOT, "translation", to_metres(clip.position, Y_UP)),
        (ROOT, "rotation", _quaternions(clip.rotation)),
    ]


def _quaternions(rotation: Array) -> Array:
    """Rotations (T, 4) for glTF: w last, of continuous sign for slerp."""
    turns = np.sign((rotation[1:] * rotation[:-1]).sum(axis=1))
    signs = np.concatenate([[1.0], np.cumprod(turns)])
    return np.roll(rotate_quaternions(signs[:, None] * rotation, Y_UP), -1, axis=1)


def _animation(buffer: GlbBuffer, clip: Clip, tracks: list[tuple[int, str, Array]]) -> Json:
    """An animation of tracks (node, property, keys), with a key for each frame."""
    times = buffer.add(_single(np.arange(len(clip.points)) / clip.fps))
    return {
        "name": clip.name,
        "samplers": [
            {"input": times, "output": buffer.add(_single(keys))} for _, _, keys in tracks
        ],
        "channels": [
            {"sampler": k, "target": {"node": node, "path": path}}
            for k, (node, path, _) in enumerate(tracks)
        ],
        "extras": {"framesPerSecond": float(clip.fps), "loop": clip.cyclic},
    }


def _file(
    buffer: GlbBuffer,
    model: Model,
    clips: list[Clip],
    baked: bool,
    animations: list[Json],
    extras: Json,
    content: Json,
) -> bytes:
    """The bytes of a file that contains its texture."""
    own = {"species": model.name, "bodyLength": METRES * model.length_cm} | extras
    own["root"] = "baked" if baked else "apart"
    content |= {
        "asset": {"version": "2.0", "generator": "subsea", "extras": own},
        "scene": 0,
        "animations": animations,
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"minFilter": LINEAR_MIPMAPS, "wrapS": CLAMPED, "wrapT": CLAMPED}],
        "images": [{"bufferView": buffer.view(sheet_png(model.sheet)), "mimeType": "image/png"}],
    }
    return glb(content, buffer)


def _single(values: Array) -> NDArray[np.float32]:
    return values.astype(np.float32)
