"""Write a scene as glTF 2.0: fishes with skeletons or morph targets, camera and what stands still.

A skeleton is fitted to each species as it moves in the scene, and its joints to the points of each
fish in each frame. Morph targets are exact: one for each frame of each fish. Both play in any
program. `scene_vat.py` writes vertex animation textures.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from tqdm import tqdm

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.base.file_kinds import GLTF, check_result
from subsea.base.files import replacing
from subsea.export import MESHOPT, PLAIN, QUANTISED
from subsea.export.axes import METRES, Y_UP, to_metres
from subsea.export.glb import packing_of
from subsea.export.gltf import (
    Json,
    KeyTrack,
    add_bind,
    add_targets,
    add_tracks,
    add_vertices,
    add_weights,
    joint_nodes,
    joint_tracks,
)
from subsea.export.gltf_scene_file import SceneFile
from subsea.export.scene import (
    OF_GLTF,
    Scene,
    SceneExtent,
    SceneOptions,
    SceneWriter,
    check_options,
)
from subsea.export.skinning import fit_to_points, follow, off_percent
from subsea.export.vat import add_textures, check_textures, texture_bytes

SAMPLES = 120  # frames of a species that its skeleton is fitted to
CHUNK = 64  # frames of a fish at once
# For estimates: joints of a fish, and bytes of a key of each, of what names a fish's nodes, of a
# vertex in a morph target, of a colour texture, and of a vertex and a triangle at rest.
JOINTS, NAMES, VERTEX, TRIANGLE = 26, 14_000, 52, 6
SHEET = {PLAIN: 550_000, QUANTISED: 550_000, MESHOPT: 90_000}
KEY = {PLAIN: 28, QUANTISED: 20, MESHOPT: 12}
TARGET = {PLAIN: 24, QUANTISED: 12, MESHOPT: 8}


class _FittedSpecies:
    """A species of the scene with its skeleton, and how far that is off."""

    def __init__(self, file: SceneFile, number: int) -> None:
        scene, self.model = file.scene, file.scene.models[number]
        self.rig = fit_to_points(self.model, _samples(scene, number))
        grid = file.buffer.packing.grid(to_metres(self.model.rest, Y_UP))
        vertices = add_vertices(file.buffer, self.model, grid)
        self.attributes = vertices | add_weights(file.buffer, self.rig)
        self.bind = add_bind(file.buffer, self.rig.joints, grid)
        self.square, self.most, self.count = 0.0, 0.0, 0

    def follow(self, scene: Scene, fish: int) -> Array:
        """Motion (t, J, 3, 4) of the joints for a fish; counts the error."""
        out = []
        for points, _ in _chunks(scene, fish):
            motion = follow(self.model, self.rig, points)
            off = off_percent(self.model, self.rig.weights, motion, points)
            self.square += float((off**2).sum())
            self.most = max(self.most, float(off.max()))
            self.count += off.size
            out.append(motion)
        return np.concatenate(out)


def _check(out: Path, options: SceneOptions) -> None:
    """Refuse options of other formats, a wrong suffix, and files that may not be replaced."""
    check_options(options, "gltf", OF_GLTF)
    if options.morph and options.vat:
        raise UserError("--morph and --vat exclude each other")
    if out.suffix != ".glb":
        raise UserError("expected a name that ends in .glb", file=out)
    packing_of(options.compress)
    check_result(out, GLTF, options.force)
    if options.vat:
        check_textures(out, options.force)


def _estimate(extent: SceneExtent, options: SceneOptions) -> int:
    """Bytes of fishes and their textures."""
    frames, kind = extent.frames, options.compress
    vertices = np.array(extent.vertices, np.int64)
    known = dict(zip(extent.species, zip(vertices, extent.triangles, strict=True), strict=True))
    fixed = sum(int(SHEET[kind] + VERTEX * n + TRIANGLE * m) for n, m in known.values())
    if options.vat:
        return fixed + texture_bytes(frames, vertices)
    if options.morph:
        share = 4 if kind == PLAIN else 1
        targets = frames * int((TARGET[kind] * vertices).sum())
        return fixed + targets + len(vertices) * frames * (300 + share * frames)
    return fixed + len(vertices) * (NAMES + frames * JOINTS * KEY[kind])


def _write(scene: Scene, out: Path, options: SceneOptions) -> list[Path]:
    """Write a scene; return its files."""
    file = SceneFile(scene, packing_of(options.compress))
    extras: Json = {}
    textures: dict[Path, bytes] = {}
    if options.vat:
        textures = add_textures(file, out)
    elif options.morph:
        _add_morphed(file)
    else:
        extras = _add_skinned(file)
    file.add_camera()
    file.add_statics(options.instances)
    data = file.bytes(extras)
    with replacing(out) as part:
        for path, content in textures.items():
            path.parent.mkdir(exist_ok=True)
            with replacing(path) as picture:
                picture.write_bytes(content)
        part.write_bytes(data)
    return [out, *textures]


def _add_skinned(file: SceneFile) -> Json:
    """Add all fishes with skeletons; return what the file says of their error."""
    scene = file.scene
    used = sorted({one.model for one in scene.fishes})
    fitted = {
        number: _FittedSpecies(file, number)
        for number in tqdm(used, "fitting skeletons", unit="species", leave=False, disable=None)
    }
    for fish in _each(scene):
        one = scene.fishes[fish]
        species = fitted[one.model]
        joints, motion = species.rig.joints, species.follow(scene, fish)
        root, node = file.add_path(fish)
        first = len(file.nodes)
        file.nodes += joint_nodes(joints, first, node)
        times = file.times(one.first, one.last)
        tracks = joint_tracks(file.buffer.packing, joints, motion, first, times)
        file.channels += add_tracks(file.buffer, tracks)
        skin = {
            "joints": [root, *range(first, first + len(joints))],
            "inverseBindMatrices": species.bind,
            "skeleton": root,
        }
        file.skins.append(skin)
        mesh = file.add_mesh(fish, species.attributes)
        # Not below the fish: a skinned mesh moves with its joints alone.
        name = f"{one.name}_mesh"
        file.node({"name": name, "mesh": mesh, "skin": len(file.skins) - 1}, root=True)
    square = sum(one.square for one in fitted.values())
    count = sum(one.count for one in fitted.values()) or 1
    most = max((one.most for one in fitted.values()), default=0.0)
    return {"rmsErrorPercent": float(np.sqrt(square / count)), "maxErrorPercent": most}


def _add_morphed(file: SceneFile) -> None:
    """Add all fishes with a morph target for each frame."""
    scene, pack = file.scene, file.buffer.packing
    for fish in _each(scene):
        one = scene.fishes[fish]
        model, count = scene.models[one.model], one.last - one.first + 1
        reach = max(float(np.abs(points - model.rest).max()) for points, _ in _chunks(scene, fish))
        grid = pack.grid(to_metres(model.rest, Y_UP), METRES * reach)
        targets = [
            add_targets(file.buffer, model, places, ways, grid)
            for points, normals in _chunks(scene, fish)
            for places, ways in zip(points, normals, strict=True)
        ]
        _, node = file.add_path(fish)
        mesh = file.add_mesh(fish, add_vertices(file.buffer, model, grid), tuple(targets))
        file.meshes[mesh]["weights"] = [0.0] * count
        shown = file.node({"name": f"{one.name}_mesh", "mesh": mesh} | grid.node())
        node["children"] = [shown]
        keys = pack.shares(np.eye(count).ravel())
        track = KeyTrack(shown, "weights", keys, file.times(one.first, one.last))
        file.channels += add_tracks(file.buffer, [track])


def _each(scene: Scene) -> Iterator[int]:
    """The fishes, with progress."""
    yield from tqdm(range(len(scene.fishes)), "writing", unit="fish", leave=False, disable=None)


def _chunks(scene: Scene, fish: int) -> Iterator[tuple[Array, Array]]:
    """Points, cm, at the size of the model, and normals (t, n, 3) of a fish, part by part."""
    one = scene.fishes[fish]
    for first in range(one.first, one.last + 1, CHUNK):
        points, normals = scene.points(fish, first, min(first + CHUNK - 1, one.last))
        yield points / one.scale, normals


def _samples(scene: Scene, model: int) -> Array:
    """Points (F, n, 3), cm, at the size of the model, of frames from all its fishes."""
    own = [(k, one) for k, one in enumerate(scene.fishes) if one.model == model]
    ends = np.cumsum([one.last - one.first + 1 for _, one in own])
    frames = np.linspace(0, ends[-1] - 1, min(SAMPLES, int(ends[-1]))).astype(int)
    out = []
    for frame in frames:
        place = int(np.searchsorted(ends, frame, side="right"))
        fish, one = own[place]
        at = one.last - int(ends[place] - 1 - frame)
        out.append(scene.points(fish, at, at)[0][0] / one.scale)
    return np.array(out)


WRITER = SceneWriter(_check, _estimate, _write)
