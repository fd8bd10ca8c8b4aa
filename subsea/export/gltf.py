"""Export a species and its clips as glTF 2.0 (.glb), with an animation for each clip.

The mesh is moved by a fitted skeleton (`skinning.py`) or, exactly but with a larger file, by a
morph target for each frame. Both interpolate linearly between frames.

Parts of glTF files of fishes: meshes, materials, skeletons and animations.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.base.files import replacing
from subsea.export import MESHOPT
from subsea.export.axes import METRES, Y_UP, rotate_quaternions, to_metres
from subsea.export.clips import Clip, Model, bake_root, transparent_triangles
from subsea.export.glb import (
    CLAMPED,
    EXACT,
    INDICES,
    VERTICES,
    GlbBuffer,
    Packing,
    PositionGrid,
    Stored,
    asset,
    glb,
    material,
)
from subsea.export.png import sheet_png, sheet_webp
from subsea.export.skinning import MAX_INFLUENCES, Joint, Skeleton
from subsea.geometry.rotation import from_matrix, matrix

Json = dict[str, Any]

WEBP = "EXT_texture_webp"
LINEAR_MIPMAPS = 9987
STEP = 1e-6  # body lengths: what a joint's place may be off when it is compressed
SHEET_SAMPLER = {"minFilter": LINEAR_MIPMAPS, "wrapS": CLAMPED, "wrapT": CLAMPED}


class KeyTrack(NamedTuple):
    """Keys of a property of a node, one for each frame."""

    node: int
    path: str  # translation, rotation, scale or weights
    keys: Stored
    times: int  # accessor of the keys' times
    steps: bool = False  # holds a key until the next one


class KeyChannel(NamedTuple):
    """A track whose keys are in the file."""

    track: KeyTrack
    output: int  # accessor


class Parts(NamedTuple):
    """The parts of a model's mesh by material, without vertices: triangles of its own."""

    indices: list[int]  # accessors
    materials: list[Json]  # of the same number, with the texture `texture`


def add_parts(buffer: GlbBuffer, model: Model, texture: int = 0) -> Parts:
    """Add the triangles of a model as up to three parts that share vertices."""
    fin = np.arange(len(model.triangles)) >= model.body
    clear = transparent_triangles(model) & ~fin
    out = Parts([], [])
    for name, those, looks in (
        ("body", ~fin & ~clear, {}),
        ("clear", clear, {"alphaMode": "BLEND"}),  # of the body, such as the tail
        ("fins", fin, {"alphaMode": "BLEND", "doubleSided": True}),
    ):
        if those.any():
            corners = model.triangles[those].astype(np.uint16).ravel()
            out.indices.append(buffer.add(corners, INDICES))
            out.materials.append(material(name, looks, texture))
    return out


def add_vertices(buffer: GlbBuffer, model: Model, grid: PositionGrid) -> Json:
    """Add the vertices of a model at rest; return the attributes of its primitives."""
    pack = buffer.packing
    sheet = np.clip(model.uv * (1, -1) + (0, 1), 0.0, 1.0)
    return {
        "POSITION": buffer.add(pack.positions(to_metres(model.rest, Y_UP), grid), VERTICES),
        "NORMAL": buffer.add(pack.normals(model.normals @ Y_UP.T), VERTICES),
        "TEXCOORD_0": buffer.add(pack.coordinates(sheet), VERTICES),
    }


def add_weights(buffer: GlbBuffer, rig: Skeleton) -> Json:
    """Add joints and weights of the vertices; joint 0 is the root and has no weight."""
    most = np.argsort(-rig.weights, axis=1)[:, :MAX_INFLUENCES]
    weights = np.take_along_axis(rig.weights, most, axis=1).astype(np.float32)
    weights /= weights.sum(axis=1, keepdims=True)
    stored = buffer.packing.weights(weights)
    joints = np.where(stored.values > 0, most + 1, 0).astype(np.uint8)
    return {
        "JOINTS_0": buffer.add(joints, VERTICES),
        "WEIGHTS_0": buffer.add(stored, VERTICES),
    }


def add_targets(
    buffer: GlbBuffer, model: Model, points: Array, normals: Array, grid: PositionGrid
) -> Json:
    """Add a morph target with these points and normals (n, 3), cm, body axes."""
    pack = buffer.packing
    ways, change = to_metres(points - model.rest, Y_UP), (normals - model.normals) @ Y_UP.T
    return {
        "POSITION": buffer.changes(pack.offsets(ways, grid)),
        "NORMAL": buffer.changes(pack.turned_normals(change)),
    }


def add_sheet(buffer: GlbBuffer, model: Model) -> Json:
    """Add the colours of a model; return its image."""
    webp = buffer.packing.kind == MESHOPT
    data = sheet_webp(model.sheet) if webp else sheet_png(model.sheet)
    kind = "image/webp" if webp else "image/png"
    return {"bufferView": buffer.view(data), "mimeType": kind}


def sheets(images: list[Json]) -> Json:
    """The textures of a file with these images, and what readers need for them."""
    plain = [{"source": k, "sampler": 0} for k in range(len(images))]
    own: Json = {"images": images, "textures": plain, "samplers": [SHEET_SAMPLER]}
    if any(one["mimeType"] == "image/webp" for one in images):
        own["textures"] = [
            {"sampler": 0, "extensions": {WEBP: {"source": k}}} for k in range(len(images))
        ]
        own |= {"extensionsUsed": [WEBP], "extensionsRequired": [WEBP]}
    return own


def primitives(
    attributes: Json, parts: Parts, first: int = 0, targets: Sequence[Json] = ()
) -> list[Json]:
    """The primitives of a mesh; `first` is the number of the first material of its parts."""
    more = {"targets": list(targets)} if targets else {}
    return [
        {"attributes": attributes, "indices": indices, "material": first + k} | more
        for k, indices in enumerate(parts.indices)
    ]


def add_bind(buffer: GlbBuffer, joints: list[Joint], grid: PositionGrid) -> int:
    """Add the inverse bind matrices of root and joints."""
    bind = np.tile(np.eye(4), (1 + len(joints), 1, 1))
    bind[1:, :3, 3] = -to_metres(np.array([joint.place for joint in joints]), Y_UP)
    return buffer.add((bind @ grid.matrix).astype(np.float32))


def joint_nodes(joints: list[Joint], first: int, root: Json) -> list[Json]:
    """Nodes of joints, the first of number `first`; those without parent become `root`'s."""
    places = np.array([joint.place for joint in joints])
    nodes: list[Json] = []
    for joint, place in zip(joints, places, strict=True):
        held = places[joint.parent] if joint.parent >= 0 else np.zeros(3)
        nodes.append({"name": joint.name, "translation": to_metres(place - held, Y_UP).tolist()})
    for k, joint in enumerate(joints):
        parent = nodes[joint.parent] if joint.parent >= 0 else root
        parent.setdefault("children", []).append(first + k)
    return nodes


def joint_tracks(
    pack: Packing, joints: list[Joint], motion: Array, first: int, times: int
) -> list[KeyTrack]:
    """Tracks of joints, the first of node `first`, for rigid motions (T, J, 3, 4) of the model.

    Those are in cm and body axes.
    """
    places = np.array([joint.place for joint in joints])
    turn, place = motion[..., :3], motion[..., :3] @ places[:, :, None] + motion[..., 3:]
    # Relative to the parents; row 0 stands for the root.
    turns = np.concatenate([np.tile(np.eye(3), (len(turn), 1, 1, 1)), turn], axis=1)
    parents = np.array([joint.parent + 1 for joint in joints])
    back = turns[:, parents].swapaxes(2, 3)
    origin = np.pad(place, ((0, 0), (1, 0), (0, 0), (0, 0)))[:, parents]
    turn, place = from_matrix(back @ turn), (back @ (place - origin))[..., 0]
    step = STEP * float(np.ptp(places[:, 0]) * 0.01)
    tracks = []
    for k in range(len(joints)):
        ways = pack.lengths(to_metres(place[:, k], Y_UP), step)
        turns_of = pack.rotations(ordered(rotate_quaternions(turn[:, k], Y_UP)))
        tracks.append(KeyTrack(first + k, "translation", ways, times))
        tracks.append(KeyTrack(first + k, "rotation", turns_of, times))
    return tracks


def carried(motion: Array, position: Array, rotation: Array) -> Array:
    """Rigid motions (T, J, 3, 4) moved by those of a root, (T, 3) and (T, 4)."""
    whole = matrix(rotation)[:, None]
    out = whole @ motion
    out[..., 3] += position[:, None]
    return np.asarray(out)


def path_tracks(node: int, places: Array, turns: Array, times: int) -> list[KeyTrack]:
    """Tracks of a node along places (T, 3), metres, and turns (T, 4), w first: as floats."""
    return [
        KeyTrack(node, "translation", Stored(places.astype(np.float32)), times),
        KeyTrack(node, "rotation", Stored(ordered(turns).astype(np.float32)), times),
    ]


def ordered(rotation: Array) -> Array:
    """Rotations (T, 4) for glTF: w last, of continuous sign for slerp."""
    turns = np.sign((rotation[1:] * rotation[:-1]).sum(axis=1))
    signs = np.concatenate([[1.0], np.cumprod(turns)])
    return np.roll(signs[:, None] * rotation, -1, axis=1)


def add_tracks(buffer: GlbBuffer, tracks: Sequence[KeyTrack]) -> list[KeyChannel]:
    """Add the keys of tracks, those of one kind in one view."""
    groups: dict[object, list[int]] = {}
    for k, track in enumerate(tracks):
        keys = track.keys
        groups.setdefault((keys.values.dtype, keys.values.shape[1:], keys.step), []).append(k)
    outputs: dict[int, int] = {}
    for those in groups.values():
        numbers = buffer.block([tracks[k].keys for k in those])
        outputs |= dict(zip(those, numbers, strict=True))
    return [KeyChannel(track, outputs[k]) for k, track in enumerate(tracks)]


def animation(name: str, channels: Sequence[KeyChannel], extras: Json) -> Json:
    """An animation of channels."""
    return {
        "name": name,
        "samplers": [
            {"input": track.times, "output": output}
            | ({"interpolation": "STEP"} if track.steps else {})
            for track, output in channels
        ],
        "channels": [
            {"sampler": k, "target": {"node": track.node, "path": track.path}}
            for k, (track, _) in enumerate(channels)
        ],
        "extras": extras,
    }


def add_times(buffer: GlbBuffer, times: Array) -> int:
    """Add the times (T,) of keys, seconds."""
    return buffer.add(times.astype(np.float32))


ROOT = 0  # node


def gltf_files(folder: Path, name: str) -> list[Path]:
    """The file that `write_gltf` writes."""
    return [folder / f"{name}.glb"]


def write_gltf(
    folder: Path,
    model: Model,
    clips: list[Clip],
    baked: bool,
    rig: Skeleton | None,
    packing: Packing = EXACT,
) -> Path:
    """Write NAME.glb into `folder`, with a skinned mesh or, without a rig, with morph targets.

    The path of the fish is the motion of the node `root`, or `baked` into joints or targets.
    UserError if the file cannot be written.
    """
    [path] = gltf_files(folder, model.name)
    buffer = GlbBuffer(packing)
    if rig is None:
        data = _morphed(buffer, model, clips, baked)
    else:
        data = _skinned(buffer, model, clips, baked, rig)
    with replacing(path) as part:
        part.write_bytes(data)
    return path


def _skinned(
    buffer: GlbBuffer, model: Model, clips: list[Clip], baked: bool, rig: Skeleton
) -> bytes:
    grid = buffer.packing.grid(to_metres(model.rest, Y_UP))
    attributes = add_vertices(buffer, model, grid) | add_weights(buffer, rig)
    parts = add_parts(buffer, model)
    root: Json = {"name": "root"}
    nodes = [root, *joint_nodes(rig.joints, 1, root)]
    nodes.append({"name": model.name, "mesh": 0, "skin": 0})
    skin = {
        "inverseBindMatrices": add_bind(buffer, rig.joints, grid),
        "joints": [*range(1 + len(rig.joints))],
        "skeleton": ROOT,
    }
    animations = []
    begin = 0
    for clip in clips:
        motion = rig.motion[begin : begin + len(clip.points)].copy()
        begin += len(clip.points)
        if clip.cyclic:
            motion[-1] = motion[0]
        if baked:
            motion = carried(motion, clip.position, clip.rotation)
        times = _times(buffer, clip)
        tracks = joint_tracks(buffer.packing, rig.joints, motion, 1, times)
        tracks = [*_root_tracks(clip, baked, times), *tracks]
        animations.append(_animation(buffer, clip, tracks))
    extras = {"rmsErrorPercent": rig.rms_percent, "maxErrorPercent": rig.most_percent}
    content = {
        "nodes": nodes,
        "skins": [skin],
        "meshes": [{"name": model.name, "primitives": primitives(attributes, parts)}],
        "scenes": [{"nodes": [ROOT, len(nodes) - 1]}],  # a skinned mesh moves with its joints alone
        "animations": animations,
    }
    return _file(buffer, model, parts, {"root": _root(baked)} | extras, content)


def _morphed(buffer: GlbBuffer, model: Model, clips: list[Clip], baked: bool) -> bytes:
    ways = [bake_root(clip) if baked else clip for clip in clips]
    reach = max(float(np.abs(clip.points - model.rest).max()) for clip in ways) * METRES
    grid = buffer.packing.grid(to_metres(model.rest, Y_UP), reach)
    attributes, parts = add_vertices(buffer, model, grid), add_parts(buffer, model)
    # The last frame of a cycle is its first one and needs no target.
    frames = [len(clip.points) - (clip.cyclic and not baked) for clip in clips]
    begins = np.cumsum([0, *frames])
    targets = [
        add_targets(buffer, model, points, normals, grid)
        for clip, number in zip(ways, frames, strict=True)
        for points, normals in zip(clip.points[:number], clip.normals[:number], strict=True)
    ]
    root: Json = {"name": model.name}
    mesh_node = {"mesh": 0} | grid.node()
    # A mesh of integers has a scale of its own, which the fish's motion must not touch.
    nodes = [root | {"children": [1]}, mesh_node] if grid.half else [root | mesh_node]
    animations = []
    for clip, begin, number in zip(clips, begins, frames, strict=False):
        shares = np.zeros((len(clip.points), len(targets)))
        shown = begin + np.arange(len(clip.points)) % number
        shares[np.arange(len(shares)), shown] = 1.0
        keys, times = buffer.packing.shares(shares.ravel()), _times(buffer, clip)
        tracks = [
            *_root_tracks(clip, baked, times),
            KeyTrack(len(nodes) - 1, "weights", keys, times),
        ]
        animations.append(_animation(buffer, clip, tracks))
    mesh = {
        "name": model.name,
        "primitives": primitives(attributes, parts, targets=targets),
        "weights": [0.0] * len(targets),
    }
    content = {
        "nodes": nodes,
        "meshes": [mesh],
        "scenes": [{"nodes": [ROOT]}],
        "animations": animations,
    }
    return _file(buffer, model, parts, {"root": _root(baked)}, content)


def _root(baked: bool) -> str:
    return "baked" if baked else "apart"


def _root_tracks(clip: Clip, baked: bool, times: int) -> list[KeyTrack]:
    if baked:
        return []
    turns = rotate_quaternions(clip.rotation, Y_UP)
    return path_tracks(ROOT, to_metres(clip.position, Y_UP), turns, times)


def _times(buffer: GlbBuffer, clip: Clip) -> int:
    return add_times(buffer, np.arange(len(clip.points)) / clip.fps)


def _animation(buffer: GlbBuffer, clip: Clip, tracks: list[KeyTrack]) -> Json:
    """An animation with a key for each frame of a clip."""
    extras = {"framesPerSecond": float(clip.fps), "loop": clip.cyclic}
    return animation(clip.name, add_tracks(buffer, tracks), extras)


def _file(buffer: GlbBuffer, model: Model, parts: Parts, extras: Json, content: Json) -> bytes:
    """The bytes of a file that contains its texture."""
    own = {"species": model.name, "bodyLength": METRES * model.length_cm} | extras
    content |= {
        "asset": asset([model.name], own),
        "scene": 0,
        "materials": parts.materials,
    } | sheets([add_sheet(buffer, model)])
    return glb(content, buffer)
