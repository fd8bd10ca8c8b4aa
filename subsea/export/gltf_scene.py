"""Write a scene as glTF 2.0: fishes with skeletons or morph targets, camera and what stands still.

A skeleton is fitted to each species as it moves in the scene, and its joints to the points of each
fish in each frame. Morph targets are exact: one for each frame of each fish. Both play in any
program. Vertex animation textures (`vat.py`) are for programs whose shader reads them.
"""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np
from tqdm import tqdm

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.base.file_kinds import GLTF, PICTURE, check_result
from subsea.base.files import replacing
from subsea.export import MESHOPT, PLAIN, QUANTISED, gltf, vat
from subsea.export.conventions import (
    METRES,
    WORLD_Y_UP,
    Y_UP,
    copyright_line,
    to_metres,
    world_rotations,
)
from subsea.export.glb import FULL_BYTE, VERTICES, Packing, PositionGrid, Stored, packing_of
from subsea.export.gltf_statics import add_statics
from subsea.export.options import SceneOptions, check_options
from subsea.export.plant_motion import key_frames
from subsea.export.scene import Scene, SceneExtent, SceneFish, SceneWriter, StillExtent
from subsea.export.skinning import fit_skeleton, follow, off_percent

SAMPLES = 120  # frames of a species that its skeleton is fitted to
# For estimates: joints of a fish, and bytes of a key of each, of what names a fish's nodes, of a
# vertex in a morph target, of a colour texture, of a vertex and a triangle at rest, and of both
# where nothing moves.
JOINTS, NAMES, VERTEX, TRIANGLE = 26, 14_000, 68, 6
SHEET = {PLAIN: 630_000, QUANTISED: 630_000, MESHOPT: 150_000}
KEY = {PLAIN: 28, QUANTISED: 20, MESHOPT: 12}
TARGET = {PLAIN: 24, QUANTISED: 12, MESHOPT: 8}
STILL = {PLAIN: (32, 11), QUANTISED: (20, 11), MESHOPT: (9, 2)}
INSTANCE = 52  # bytes of place, turn, size and tint
JOINT, KEY_BYTES, BINDING = 330, 12, 8  # of a joint, of a key of it, and of a vertex that follows
CUT_S = 1e-3  # before a cut of the camera, the picture before it still stands
ROWS = 4096  # poses in a texture: with normals 8192 rows, as engines read
PACKED = 0.75  # of the bytes of texels that PNG leaves


class SceneFile(gltf.GltfFile):
    """The file of a scene in the making."""

    def __init__(self, scene: Scene, packing: Packing) -> None:
        """Begin an empty file."""
        super().__init__(packing)
        self.scene = scene
        self.tracks: list[gltf.KeyTrack] = []
        self.outputs: list[int] = []  # accessors of the keys of tracks
        self._times: dict[tuple[int, int], int] = {}
        self._looks: dict[str, int] = {}
        self._tints: dict[tuple[int, ...], int] = {}

    def times(self, first: int, last: int) -> int:
        """Return the accessor of the times of frames."""
        if (first, last) not in self._times:
            seconds = np.arange(first, last + 1) / self.scene.fps
            self._times[first, last] = self.buffer.add(seconds.astype(np.float32))
        return self._times[first, last]

    def move(self, *tracks: gltf.KeyTrack) -> None:
        """Add tracks to the animation of the scene."""
        self.tracks += tracks
        self.outputs += gltf.add_tracks(self.buffer, tracks)

    def add_path(self, column: int) -> int:
        """Add the node that moves as a fish; return its number."""
        fish = self.scene.fishes[column]
        species = self.scene.models[fish.model].name
        extras = {"fish": fish.number, "species": species, "lengthCm": fish.length_cm}
        node = {"name": fish.name, "scale": [fish.scale] * 3, "extras": extras}
        number = self.node(node, root=True)
        there = slice(fish.first, fish.last + 1)
        places = to_metres(self.scene.position[there, column], WORLD_Y_UP)
        turns = world_rotations(self.scene.rotation[there, column], Y_UP)
        path = gltf.path_tracks(number, places, turns, self.times(fish.first, fish.last))
        self.move(*path, *self._presence(fish, number))
        return number

    def _presence(self, fish: SceneFish, number: int) -> Iterator[gltf.KeyTrack]:
        """Give a fish that comes or goes no size while it is not in the sea.

        The steps lie between frames, so that no rounding of times moves them to another frame.
        """
        keys = {0.0: fish.scale}
        if fish.first:
            keys = {0.0: 0.0, fish.first - 0.5: fish.scale}
        if fish.last < self.scene.frames - 1:
            keys[fish.last + 0.5] = 0.0
        if len(keys) > 1:
            times = self.buffer.add((np.array(list(keys)) / self.scene.fps).astype(np.float32))
            sizes = np.repeat(np.array(list(keys.values()), np.float32)[:, None], 3, axis=1)
            yield gltf.KeyTrack(number, "scale", Stored(sizes), times, steps=True)

    def add_shape(
        self, column: int, attributes: gltf.Json, targets: Sequence[gltf.Json] = ()
    ) -> int:
        """Add the mesh of a fish, with its tint at the vertices; return its number.

        So all fishes of a species have the same materials.
        """
        fish = self.scene.fishes[column]
        model, parts = self.scene.models[fish.model], self.parts(self.scene.models[fish.model])
        if model.name not in self._looks:
            self._looks[model.name] = len(self.materials)
            self.materials += parts.materials
        tint = np.round(FULL_BYTE * np.clip(fish.tint, 0.0, 1.0)).astype(np.uint8)
        key = (len(model.rest), *tint.tolist())
        if key not in self._tints:
            same = Stored(np.tile(tint, (len(model.rest), 1)), normalised=True)
            self._tints[key] = self.buffer.add(same, VERTICES)
        attributes = attributes | {"COLOR_0": self._tints[key]}
        return self.mesh(fish.name, model, attributes, self._looks[model.name], targets)

    def hang(self, root: int, mesh: int, grid: PositionGrid) -> int:
        """Add a node with a mesh below the one that moves as a fish; return its number."""
        name = f"{self.nodes[root]['name']}_mesh"
        number = self.node({"name": name, "mesh": mesh} | grid.node())
        self.nodes[root]["children"] = [number]
        return number

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
        times = self.buffer.add(seconds.astype(np.float32))
        self.move(*gltf.path_tracks(number, places, turns, times))

    def add_statics(self, instancing: bool) -> None:
        """Add what stays at its place, and the motion of what bends."""
        self.move(*add_statics(self, self.scene.statics, self.scene.fps, instancing))

    def whole(self, errors: gltf.Json) -> bytes:
        """Return the whole file."""
        scene, camera = self.scene, self.scene.camera
        extras = {
            "scenario": scene.name,
            "seed": scene.seed,
            "framesPerSecond": scene.fps,
            "frames": scene.frames,
            "filmedFrames": scene.filmed,
            "loop": scene.seamless,
            "seconds": (scene.frames - 1) / scene.fps,
            "startSeconds": scene.start_s,
            "light": scene.light(),
        } | errors
        lens = {
            "aspectRatio": camera.aspect,
            "yfov": camera.height_rad,
            "znear": METRES * camera.near_cm,
            "zfar": METRES * camera.far_cm,
        }
        rate = {"framesPerSecond": scene.fps}
        self.animations.append(gltf.animation(scene.name, self.tracks, self.outputs, rate))
        return self.contents(
            [model.name for model in scene.models],
            extras,
            {"name": scene.name, "extras": extras},
            cameras=[{"name": "camera", "type": "perspective", "perspective": lens}],
        )


class _FittedSpecies:
    """A species of the scene with its skeleton, and how far that is off."""

    def __init__(self, file: SceneFile, number: int) -> None:
        scene, self.model = file.scene, file.scene.models[number]
        self.rig = fit_skeleton(self.model, _samples(scene, number))
        grid = file.buffer.packing.grid(to_metres(self.model.rest, Y_UP))
        vertices = gltf.add_vertices(file.buffer, self.model, grid)
        self.attributes = vertices | gltf.add_weights(file.buffer, self.rig)
        self.bind = gltf.add_bind(file.buffer, self.rig.joints, grid)
        self.square, self.most, self.count = 0.0, 0.0, 0

    def follow(self, scene: Scene, fish: int) -> Array:
        """Fit the motion (t, J, 3, 4) of the joints to a fish; count the error."""
        out = []
        for _, points, _ in scene.parts(fish):
            motion = follow(self.model, self.rig, points)
            off = off_percent(self.model, self.rig.weights, motion, points)
            self.square += float((off**2).sum())
            self.most = max(self.most, float(off.max()))
            self.count += off.size
            out.append(motion)
        return np.concatenate(out)


def _check(out: Path, options: SceneOptions) -> None:
    """Refuse options of other formats, a wrong suffix, and files that may not be replaced."""
    check_options(options, "gltf")
    if options.morph and options.vat:
        raise UserError("--morph and --vat exclude each other")
    if out.suffix != ".glb":
        raise UserError("expected a name that ends in .glb", file=out)
    packing_of(options.compress)
    check_result(out, GLTF, options.force)
    if options.vat:
        for path in sorted(_textures(out).glob("*")):
            check_result(path, PICTURE if path.suffix == ".png" else vat.REMAP, options.force)


def _estimate(extent: SceneExtent, options: SceneOptions) -> int:
    """Estimate the bytes of fishes, their textures, and what does not move."""
    frames, fishes, kind = extent.frames, extent.fishes, options.compress
    mesh = VERTEX * extent.vertices + TRIANGLE * extent.triangles
    fixed, moved = extent.species * (SHEET[kind] + mesh), fishes * frames * extent.vertices
    still, (vertex, triangle) = extent.still or StillExtent(), STILL[kind]
    vertices, triangles = still.vertices, still.triangles
    if options.instances:
        vertices, triangles = still.shapes
        fixed += INSTANCE * still.copies
    fixed += vertex * vertices + triangle * triangles + BINDING * still.bent
    fixed += still.joints * (JOINT + KEY_BYTES * len(key_frames(frames, extent.fps)))
    if options.vat:
        return fixed + int(PACKED * 12 * moved)
    if options.morph:
        share = 4 if kind == PLAIN else 1
        return fixed + TARGET[kind] * moved + fishes * frames * (300 + share * frames)
    return fixed + fishes * (NAMES + frames * JOINTS * KEY[kind])


def _write(scene: Scene, out: Path, options: SceneOptions) -> list[Path]:
    """Write a scene; return its files."""
    file = SceneFile(scene, packing_of(options.compress))
    errors: gltf.Json = {}
    textures: dict[Path, bytes] = {}
    if options.vat:
        textures = _add_textured(file, _textures(out))
    elif options.morph:
        _add_morphed(file)
    else:
        errors = _add_skinned(file)
    file.add_camera()
    file.add_statics(options.instances)
    data = file.whole(errors)
    with ExitStack() as all_or_none:
        for path, content in {out: data, **textures}.items():
            all_or_none.enter_context(replacing(path)).write_bytes(content)
    return [out, *textures]


def _add_skinned(file: SceneFile) -> gltf.Json:
    """Add all fishes with skeletons; return what the file says of their error."""
    scene = file.scene
    used = sorted({fish.model for fish in scene.fishes})
    fitted = {
        number: _FittedSpecies(file, number)
        for number in tqdm(used, "fitting skeletons", unit="species", leave=False, disable=None)
    }
    for column in _each(scene):
        fish = scene.fishes[column]
        species = fitted[fish.model]
        joints, motion = species.rig.joints, species.follow(scene, column)
        root = file.add_path(column)
        first = file.skeleton(joints, root, species.bind)
        times = file.times(fish.first, fish.last)
        file.move(*gltf.joint_tracks(file.buffer.packing, joints, motion, first, times))
        mesh = file.add_shape(column, species.attributes)
        # Not below the fish: a skinned mesh moves with its joints alone.
        name = f"{fish.name}_mesh"
        file.node({"name": name, "mesh": mesh, "skin": len(file.skins) - 1}, root=True)
    square = sum(species.square for species in fitted.values())
    count = sum(species.count for species in fitted.values()) or 1
    most = max((species.most for species in fitted.values()), default=0.0)
    return {"rmsErrorPercent": float(np.sqrt(square / count)), "maxErrorPercent": most}


def _add_morphed(file: SceneFile) -> None:
    """Add all fishes with a morph target for each frame."""
    scene, pack = file.scene, file.buffer.packing
    for column in _each(scene):
        fish = scene.fishes[column]
        model, count = scene.models[fish.model], fish.last - fish.first + 1
        reach = max(float(np.abs(part[1] - model.rest).max()) for part in scene.parts(column))
        grid = pack.grid(to_metres(model.rest, Y_UP), METRES * reach)
        targets = [
            gltf.add_targets(file.buffer, model, places, ways, grid)
            for _, points, normals in scene.parts(column)
            for places, ways in zip(points, normals, strict=True)
        ]
        root = file.add_path(column)
        mesh = file.add_shape(column, gltf.add_vertices(file.buffer, model, grid), targets)
        shown = file.hang(root, mesh, grid)
        keys = pack.shares(np.eye(count).ravel())
        file.move(gltf.KeyTrack(shown, "weights", keys, file.times(fish.first, fish.last)))


def _add_textured(file: SceneFile, folder: Path) -> dict[Path, bytes]:
    """Add all fishes as meshes at rest; return vertex animation textures of their poses to write.

    A row of a texture is a pose: those of a fish follow one another, a row for each frame.
    """
    scene = file.scene
    files: dict[Path, bytes] = {}
    for name, number, columns in _pages(scene):
        model = scene.models[number]
        shapes = [part for column in columns for part in scene.parts(column)]
        points, normals = (np.concatenate([part[k] for part in shapes]) for k in (1, 2))
        texture = vat.encode_points(model, points, normals)
        grid = file.buffer.packing.grid(to_metres(model.rest, Y_UP))
        texels = vat.texel_coordinates(len(model.rest), len(texture.texels)).astype(np.float32)
        attributes = gltf.add_vertices(file.buffer, model, grid)
        attributes["TEXCOORD_1"] = file.buffer.add(texels, VERTICES)
        row = 0
        tracks = {}
        for column in columns:
            fish = scene.fishes[column]
            root = file.add_path(column)
            file.hang(root, file.add_shape(column, attributes), grid)
            file.nodes[root]["extras"] |= {
                "texture": f"{folder.name}/{name}_vat.png",
                "firstRow": row,
                "firstFrame": fish.first,
                "lastFrame": fish.last,
            }
            count = fish.last - fish.first + 1
            tracks[fish.name] = vat.animation_track(row, count, scene.fps, False)
            row += count
        files[folder / f"{name}_vat.png"] = vat.png16(texture.texels)
        extras = {"framesPerSecond": scene.fps, "copyright": copyright_line([model.name])}
        files[folder / f"{name}-remap_info.json"] = vat.remap_info(texture, tracks, extras)
    return files


def _pages(scene: Scene) -> list[tuple[str, int, list[int]]]:
    """Share fishes out to textures: name, model and columns of each; as many as fit in one."""
    pages: list[tuple[str, int, list[int]]] = []
    for number, model in enumerate(scene.models):
        free, page = 0, 0
        for column, fish in enumerate(scene.fishes):
            if fish.model != number:
                continue
            count = fish.last - fish.first + 1
            if count > ROWS:
                raise UserError(
                    f"{count} frames do not fit into a texture, expected at most {ROWS}; "
                    "use fewer seconds or frames per second"
                )
            if count > free:
                free, page = ROWS, page + 1
                pages.append((f"{model.name}_{page}", number, []))
            pages[-1][2].append(column)
            free -= count
    return pages


def _textures(out: Path) -> Path:
    """Return the folder of the textures of a file."""
    return out.with_name(f"{out.stem}_vat")


def _each(scene: Scene) -> Iterator[int]:
    """Yield the columns of fishes, with progress."""
    yield from tqdm(range(len(scene.fishes)), "writing", unit="fish", leave=False, disable=None)


def _samples(scene: Scene, model: int) -> Array:
    """Sample points (F, n, 3), cm, at the size of the model, of frames of all its fishes."""
    frames = [
        (column, frame, fish.scale)
        for column, fish in enumerate(scene.fishes)
        if fish.model == model
        for frame in range(fish.first, fish.last + 1)
    ]
    chosen = np.linspace(0, len(frames) - 1, min(SAMPLES, len(frames))).astype(int)
    places = (frames[k] for k in chosen)
    return np.array([scene.points(fish, at, at)[0][0] / scale for fish, at, scale in places])


WRITER = SceneWriter(_check, _estimate, _write)
