"""Export a species and its clips as glTF 2.0 (.glb), with an animation for each clip.

The mesh is moved by a fitted skeleton (`skinning.py`) or, exactly but with a larger file, by a
morph target for each frame. Both interpolate linearly between frames.
"""

from pathlib import Path

import numpy as np

from subsea.base.atomic_io import replacing
from subsea.export.axes import METRES, Y_UP, rotate_quaternions, to_metres
from subsea.export.clips import Clip, Model, bake_root
from subsea.export.glb import GlbBuffer, asset, glb
from subsea.export.gltf_parts import (
    Json,
    KeyTrack,
    Parts,
    add_bind,
    add_parts,
    add_sheet,
    add_targets,
    add_times,
    add_tracks,
    add_vertices,
    add_weights,
    animation,
    carried,
    joint_nodes,
    joint_tracks,
    path_tracks,
    primitives,
    sheets,
)
from subsea.export.packing import EXACT, Packing
from subsea.export.skinning import Skeleton

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
