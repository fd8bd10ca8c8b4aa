"""glTF 2.0 files of fishes: meshes, materials, skeletons and animations; and those of a species.

A fitted skeleton (`skinning.py`) moves the mesh of a species, or exactly but with a larger file a
morph target for each frame. Both interpolate linearly between frames.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bytes
from subsea.base.files import replacing
from subsea.export import MESHOPT, glb
from subsea.export.clips import Clip, Model, bake_root, transparent_triangles
from subsea.export.conventions import (
    METRES,
    Y_UP,
    continuous,
    rotate_quaternions,
    sheet_png,
    sheet_webp,
    to_metres,
)
from subsea.export.scale_relief import tangents
from subsea.export.skin_material import metal_image, roughness
from subsea.export.skinning import Joint, Skeleton, clip_motions, local_motion, strongest

Json = dict[str, Any]

WEBP = "EXT_texture_webp"
INSTANCING = "EXT_mesh_gpu_instancing"
LEVELS = "MSFT_lod"
THIN = "KHR_materials_diffuse_transmission"
SHEER = {THIN: {"diffuseTransmissionFactor": 0.6}}  # light that fins let through, as in the dive
COVERAGE = 0.2, 0.06, 0.02  # shares of a picture's height down to which a level is shown, and ...
LEAST_COVERAGE = 0.0  # ... the last one
LINEAR_MIPMAPS = 9987
STEP = 1e-6  # body lengths: what a joint's place may be off when it is compressed
SHEET_SAMPLER = {"minFilter": LINEAR_MIPMAPS, "wrapS": glb.CLAMPED, "wrapT": glb.CLAMPED}


class KeyTrack(NamedTuple):
    """Keys of a property of a node, one for each frame."""

    node: int
    path: str  # translation, rotation, scale or weights
    keys: glb.Stored
    times: int  # accessor of the keys' times
    steps: bool = False  # holds a key until the next one


class Parts(NamedTuple):
    """The parts of a model's mesh by material, without vertices: triangles of its own."""

    indices: list[int]  # accessors
    materials: list[Json]  # of the same number
    names: list[str]  # body, clear or fins


class GltfFile:
    """A file in the making: its lists, to which fishes are added."""

    def __init__(self, packing: glb.Packing) -> None:
        """Begin an empty file whose arrays are stored in this way."""
        self.buffer = glb.GlbBuffer(packing)
        self.nodes: list[Json] = []
        self.roots: list[int] = []
        self.meshes: list[Json] = []
        self.materials: list[Json] = []
        self.skins: list[Json] = []
        self.animations: list[Json] = []
        self._images: list[Json] = []
        self._parts: dict[tuple[str, int], Parts] = {}  # by model and number of triangles
        self._sheets: dict[str, tuple[int, int | None, int | None]] = {}  # images of a skin

    def node(self, node: Json, root: bool = False) -> int:
        """Add a node; return its number."""
        self.nodes.append(node)
        if root:
            self.roots.append(len(self.nodes) - 1)
        return len(self.nodes) - 1

    def parts(self, model: Model) -> Parts:
        """Return the parts of a model's mesh; its colours are added the first time.

        There are up to three, which share vertices: the body, its transparent triangles such as
        those of the tail, and the fins.
        """
        key = model.name, len(model.triangles)
        if key not in self._parts:
            fin = np.arange(len(model.triangles)) >= model.body
            clear = transparent_triangles(model) & ~fin
            parts = Parts([], [], [])
            colours, metal, scales = self.sheet(model)
            for name, chosen, looks in (
                ("body", ~fin & ~clear, {}),
                ("clear", clear, {"alphaMode": "BLEND", "extensions": SHEER}),
                ("fins", fin, {"alphaMode": "BLEND", "doubleSided": True, "extensions": SHEER}),
            ):
                if chosen.any():
                    corners = model.triangles[chosen].astype(np.uint16).ravel()
                    parts.indices.append(self.buffer.add(corners, glb.INDICES))
                    look = glb.material(
                        f"{model.name}_{name}", looks, roughness(model), colours,
                        metal if name == "body" else None, scales if name == "body" else None,
                    )  # fmt: skip
                    parts.materials.append(look)
                    parts.names.append(name)
            self._parts[key] = parts
        return self._parts[key]

    def sheet(self, model: Model) -> tuple[int, int | None, int | None]:
        """Return the images of a model's colours, its metal and its scales, if it has these."""
        if model.name not in self._sheets:
            shine, relief = metal_image(model), model.scales
            self._sheets[model.name] = (
                self.image(f"{model.name}_basecolor", model.sheet),
                None if shine is None else self.image(f"{model.name}_metal", shine),
                None if relief is None else self.image(f"{model.name}_normal", relief, True),
            )
        return self._sheets[model.name]

    def image(self, name: str, pixels: Bytes, exact: bool = False) -> int:
        """Add an image (h, w, 3 or 4), bottom row first; return its number."""
        webp = self.buffer.packing.kind == MESHOPT
        data = sheet_webp(pixels, exact) if webp else sheet_png(pixels)
        kind = "image/webp" if webp else "image/png"
        self._images.append({"name": name, "bufferView": self.buffer.view(data), "mimeType": kind})
        return len(self._images) - 1

    def mesh(
        self, name: str, model: Model, attributes: Json, first: int, targets: Sequence[Json] = (),
        order: Sequence[str] = (),
    ) -> int:  # fmt: skip
        """Add a mesh of a model; return its number. `first` is the first of its materials.

        `order` are the parts that the materials are of; none: those of this model.
        """
        more = {"targets": list(targets)} if targets else {}
        parts = self.parts(model)
        known = list(order or parts.names)
        primitives = [
            {
                "attributes": attributes,
                "indices": indices,
                "material": first + (known.index(part) if part in known else 0),
            }
            | more
            for part, indices in zip(parts.names, parts.indices, strict=True)
        ]
        weights = {"weights": [0.0] * len(targets)} if targets else {}
        self.meshes.append({"name": name, "primitives": primitives} | weights)
        return len(self.meshes) - 1

    def skeleton(self, joints: list[Joint], root: int, bind: int) -> int:
        """Add the nodes of joints and a skin; return the number of the first joint.

        Joints without a parent become children of the node `root`. `bind` is the accessor of
        `add_bind`.
        """
        first = len(self.nodes)
        for joint in joints:
            parent = joints[joint.parent].place if joint.parent >= 0 else np.zeros(3)
            place = to_metres(joint.place - parent, Y_UP).tolist()
            self.node({"name": joint.name, "translation": place})
        for number, joint in enumerate(joints, first):
            parent_node = self.nodes[first + joint.parent if joint.parent >= 0 else root]
            parent_node.setdefault("children", []).append(number)
        names = [root, *range(first, first + len(joints))]
        self.skins.append({"inverseBindMatrices": bind, "joints": names, "skeleton": root})
        return first

    def contents(self, species: Iterable[str], extras: Json, scene: Json, **more: Any) -> bytes:
        """Return the whole file; `scene` holds properties of its scene, `more` other lists."""
        lists = {
            "nodes": self.nodes, "meshes": self.meshes, "materials": self.materials,
            "skins": self.skins, "animations": self.animations, "images": self._images,
        }  # fmt: skip
        scenes = [{"nodes": self.roots} | scene]
        content: Json = {"asset": glb.asset(species, extras), "scene": 0, "scenes": scenes}
        content |= {name: values for name, values in lists.items() if values} | more
        needed = []
        if self._images:
            webp = self.buffer.packing.kind == MESHOPT
            content["samplers"] = [SHEET_SAMPLER]
            content["textures"] = [
                {"sampler": 0} | ({"extensions": {WEBP: {"source": k}}} if webp else {"source": k})
                for k in range(len(self._images))
            ]
            needed += [WEBP] * webp
        if any(INSTANCING in node.get("extensions", {}) for node in self.nodes):
            needed.append(INSTANCING)
        uses = [LEVELS] if any(LEVELS in node.get("extensions", {}) for node in self.nodes) else []
        uses += [THIN] if any("extensions" in look for look in self.materials) else []
        return glb.glb(content, self.buffer, needed, uses)


def add_vertices(buffer: glb.GlbBuffer, model: Model, grid: glb.PositionGrid) -> Json:
    """Add the vertices of a model at rest; return the attributes of its primitives."""
    pack = buffer.packing
    sheet = np.clip(model.uv * (1, -1) + (0, 1), 0.0, 1.0)
    attributes = {
        "POSITION": buffer.add(pack.positions(to_metres(model.rest, Y_UP), grid), glb.VERTICES),
        "NORMAL": buffer.add(pack.normals(model.normals @ Y_UP.T), glb.VERTICES),
        "TEXCOORD_0": buffer.add(pack.coordinates(sheet), glb.VERTICES),
    }
    if model.scales is not None:
        ways = tangents(model.rest, model.normals, model.uv, model.triangles)
        ways[:, :3] = ways[:, :3] @ Y_UP.T
        attributes["TANGENT"] = buffer.add(pack.normals(ways), glb.VERTICES)
    return attributes


def add_weights(buffer: glb.GlbBuffer, rig: Skeleton) -> Json:
    """Add joints and weights of the vertices; joint 0 is the root and has no weight."""
    most, weights = strongest(rig.weights)
    stored = buffer.packing.weights(weights)
    joints = np.where(stored.values > 0, most + 1, 0).astype(np.uint8)
    return {
        "JOINTS_0": buffer.add(joints, glb.VERTICES),
        "WEIGHTS_0": buffer.add(stored, glb.VERTICES),
    }


def add_targets(
    buffer: glb.GlbBuffer, model: Model, points: Array, normals: Array, grid: glb.PositionGrid
) -> Json:
    """Add a morph target with these points and normals (n, 3), cm, body axes."""
    pack = buffer.packing
    ways, change = to_metres(points - model.rest, Y_UP), (normals - model.normals) @ Y_UP.T
    return {
        "POSITION": buffer.changes(pack.offsets(ways, grid)),
        "NORMAL": buffer.changes(pack.turned_normals(change)),
    }


def add_bind(buffer: glb.GlbBuffer, joints: list[Joint], grid: glb.PositionGrid) -> int:
    """Add the inverse bind matrices of root and joints."""
    bind = np.tile(np.eye(4), (1 + len(joints), 1, 1))
    bind[1:, :3, 3] = -to_metres(np.array([joint.place for joint in joints]), Y_UP)
    return buffer.add((bind @ grid.matrix).astype(np.float32))


def joint_tracks(
    pack: glb.Packing, joints: list[Joint], motion: Array, first: int, times: int
) -> list[KeyTrack]:
    """Make tracks of joints, the first of node `first`, for rigid motions (T, J, 3, 4).

    The motions are in cm and body axes.
    """
    turn, place = local_motion(joints, motion)
    step = STEP * float(np.ptp([joint.place[0] for joint in joints]) * 0.01)
    tracks = []
    for k in range(len(joints)):
        ways = pack.lengths(to_metres(place[:, k], Y_UP), step)
        turns_of = pack.rotations(ordered(rotate_quaternions(turn[:, k], Y_UP)))
        tracks.append(KeyTrack(first + k, "translation", ways, times))
        tracks.append(KeyTrack(first + k, "rotation", turns_of, times))
    return tracks


def path_tracks(node: int, places: Array, turns: Array, times: int) -> list[KeyTrack]:
    """Make tracks of a node along places (T, 3), metres, and turns (T, 4), w first: as floats."""
    return [
        KeyTrack(node, "translation", glb.Stored(places.astype(np.float32)), times),
        KeyTrack(node, "rotation", glb.Stored(ordered(turns).astype(np.float32)), times),
    ]


def ordered(rotation: Array) -> Array:
    """Order rotations (T, 4) for glTF: w last, of continuous sign for slerp."""
    return np.roll(continuous(rotation), -1, axis=1)


def add_tracks(buffer: glb.GlbBuffer, tracks: Sequence[KeyTrack]) -> list[int]:
    """Add the keys of tracks, one view for each kind of keys; return their accessors."""
    groups: dict[object, list[int]] = {}
    for k, track in enumerate(tracks):
        keys = track.keys
        groups.setdefault((keys.values.dtype, keys.values.shape[1:], keys.step), []).append(k)
    outputs: dict[int, int] = {}
    for group in groups.values():
        accessors = buffer.block([tracks[k].keys for k in group])
        outputs |= dict(zip(group, accessors, strict=True))
    return [outputs[k] for k in range(len(tracks))]


def animation(name: str, tracks: Sequence[KeyTrack], outputs: Sequence[int], extras: Json) -> Json:
    """Describe an animation of tracks, whose keys are in the file as the accessors `outputs`."""
    return {
        "name": name,
        "samplers": [
            {"input": track.times, "output": output}
            | ({"interpolation": "STEP"} if track.steps else {})
            for track, output in zip(tracks, outputs, strict=True)
        ],
        "channels": [
            {"sampler": k, "target": {"node": track.node, "path": track.path}}
            for k, track in enumerate(tracks)
        ],
        "extras": extras,
    }


def gltf_files(folder: Path, name: str) -> list[Path]:
    """Return the file that `write_gltf` writes."""
    return [folder / f"{name}.glb"]


def write_gltf(
    folder: Path,
    model: Model,
    clips: list[Clip],
    baked: bool,
    rig: Skeleton | None,
    packing: glb.Packing = glb.EXACT,
    levels: Sequence[tuple[Model, Skeleton]] = (),
) -> Path:
    """Write NAME.glb into `folder`, with a skinned mesh or, without a rig, with morph targets.

    `levels` are coarser meshes on the same joints, each with its weights.
    The path of the fish is the motion of the node `root`, or `baked` into joints or targets.
    UserError if the file cannot be written.
    """
    [path] = gltf_files(folder, model.name)
    file = GltfFile(packing)
    extras: Json = {
        "species": model.name,
        "bodyLength": METRES * model.length_cm,
        "root": "baked" if baked else "apart",
    }
    if rig is None:
        _add_morphed(file, model, clips, baked)
    else:
        _add_skinned(file, model, clips, baked, rig, levels)
        extras |= {"rmsErrorPercent": rig.rms_percent, "maxErrorPercent": rig.most_percent}
    with replacing(path) as part:
        part.write_bytes(file.contents([model.name], extras, {}))
    return path


def _add_skinned(
    file: GltfFile, model: Model, clips: list[Clip], baked: bool, rig: Skeleton,
    levels: Sequence[tuple[Model, Skeleton]] = (),
) -> None:  # fmt: skip
    """Add a mesh with a skeleton, and an animation of its joints for each clip.

    Coarser levels are nodes beside the scene, which only readers of MSFT_lod find.
    """
    grid = file.buffer.packing.grid(to_metres(model.rest, Y_UP))
    attributes = add_vertices(file.buffer, model, grid) | add_weights(file.buffer, rig)
    file.materials += file.parts(model).materials
    root = file.node({"name": "root"}, root=True)
    first = file.skeleton(rig.joints, root, add_bind(file.buffer, rig.joints, grid))
    mesh = file.mesh(model.name, model, attributes, 0)
    # A root of the scene: a skinned mesh moves with its joints alone.
    finest: Json = {"name": model.name, "mesh": mesh, "skin": 0}
    file.node(finest, root=True)
    coarser = []
    for number, (level, weights) in enumerate(levels, 1):
        name = f"{model.name}_LOD{number}"
        skinned = add_vertices(file.buffer, level, grid) | add_weights(file.buffer, weights)
        coarse = file.mesh(name, level, skinned, 0, order=file.parts(model).names)
        coarser.append(file.node({"name": name, "mesh": coarse, "skin": 0}))
    if coarser:
        finest |= {
            "name": f"{model.name}_LOD0",
            "extensions": {LEVELS: {"ids": coarser}},
            "extras": {"MSFT_screencoverage": [*COVERAGE[: len(coarser)], LEAST_COVERAGE]},
        }
    for clip, motion in zip(clips, clip_motions(rig, clips, baked), strict=True):
        times = _times(file.buffer, clip)
        tracks = joint_tracks(file.buffer.packing, rig.joints, motion, first, times)
        _animate(file, clip, [*_root_tracks(clip, root, baked, times), *tracks])


def _add_morphed(file: GltfFile, model: Model, clips: list[Clip], baked: bool) -> None:
    """Add a mesh with a morph target for each frame, and an animation of them for each clip."""
    buffer = file.buffer
    shapes = [bake_root(clip) if baked else clip for clip in clips]
    reach = max(float(np.abs(clip.points - model.rest).max()) for clip in shapes) * METRES
    grid = buffer.packing.grid(to_metres(model.rest, Y_UP), reach)
    attributes = add_vertices(buffer, model, grid)
    file.materials += file.parts(model).materials
    # The last frame of a cycle is its first one and needs no target.
    frames = [len(clip.points) - (clip.cyclic and not baked) for clip in clips]
    begins = np.cumsum([0, *frames])
    targets = [
        add_targets(buffer, model, points, normals, grid)
        for clip, number in zip(shapes, frames, strict=True)
        for points, normals in zip(clip.points[:number], clip.normals[:number], strict=True)
    ]
    mesh = {"mesh": file.mesh(model.name, model, attributes, 0, targets)} | grid.node()
    root = shown = file.node({"name": model.name} | ({} if grid.half else mesh), root=True)
    if grid.half:
        # A mesh of integers has a scale of its own, which the fish's motion must not touch.
        shown = file.node(mesh)
        file.nodes[root]["children"] = [shown]
    for clip, begin, number in zip(clips, begins, frames, strict=False):
        shares = np.zeros((len(clip.points), len(targets)))
        target = begin + np.arange(len(clip.points)) % number
        shares[np.arange(len(shares)), target] = 1.0
        keys, times = buffer.packing.shares(shares.ravel()), _times(buffer, clip)
        tracks = _root_tracks(clip, root, baked, times)
        _animate(file, clip, [*tracks, KeyTrack(shown, "weights", keys, times)])


def _root_tracks(clip: Clip, root: int, baked: bool, times: int) -> list[KeyTrack]:
    if baked:
        return []
    turns = rotate_quaternions(clip.rotation, Y_UP)
    return path_tracks(root, to_metres(clip.position, Y_UP), turns, times)


def _times(buffer: glb.GlbBuffer, clip: Clip) -> int:
    return buffer.add((np.arange(len(clip.points)) / clip.fps).astype(np.float32))


def _animate(file: GltfFile, clip: Clip, tracks: list[KeyTrack]) -> None:
    """Add an animation with a key for each frame of a clip."""
    extras = {"framesPerSecond": float(clip.fps), "loop": clip.cyclic}
    outputs = add_tracks(file.buffer, tracks)
    file.animations.append(animation(clip.name, tracks, outputs, extras))
