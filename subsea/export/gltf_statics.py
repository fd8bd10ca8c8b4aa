"""Write sand, stone, corals and bending seaweed into a glTF file.

Sand, stone and corals are a mesh of each kind, or instances of meshes. Seaweed is a skinned mesh of
each kind, whose joints only shift (`plant_motion.py`).
"""

from collections.abc import Sequence

import numpy as np

from subsea.base.arrays import Array
from subsea.export import QUANTISED, gltf
from subsea.export.conventions import METRES, WORLD_Y_UP, to_metres
from subsea.export.glb import FULL_SHORT, INDICES, VERTICES, Packing, PositionGrid, Stored
from subsea.export.plant_motion import PlantMotion
from subsea.export.scene import SceneMesh
from subsea.geometry.rotation import from_matrix

ROUGH = 0.9  # of what is not wet skin
SHEARED = 1e-3  # cosine of the angle between axes beyond which a copy has its own vertices
SMALL = Packing(QUANTISED)  # bytes for weights, which need no extension
STEP_M = 1e-4  # error of the place of a compressed joint, at most
SWAY = "_SWAY"  # attribute: how far a vertex sways with the water, in the unit of its position


def add_statics(
    file: gltf.GltfFile, statics: Sequence[SceneMesh], fps: float, instancing: bool
) -> list[gltf.KeyTrack]:
    """Add a mesh of each kind, or copies of meshes as instances of a node; return what moves.

    Instances cannot be sheared: copies that are become part of the mesh of their kind.
    """
    groups: dict[str, gltf.Json] = {}
    kinds: dict[str, list[SceneMesh]] = {}
    tracks: list[gltf.KeyTrack] = []
    for static in statics:
        if static.group not in groups:
            groups[static.group] = {"name": static.group, "children": []}
            file.node(groups[static.group], root=True)
        if static.motion is not None:
            tracks += _add_bending(file, static, static.motion, groups[static.group], fps)
            continue
        alike = np.array([_is_straight(place) for place in static.places], np.bool_)
        alike &= instancing and len(static.places) > 1
        if alike.any():
            placed = static._replace(places=static.places[alike], tints=static.tints[alike])
            groups[static.group]["children"].append(_add_instances(file, placed))
        moved = kinds.setdefault(static.kind, [])
        moved += [_moved(static, k) for k in np.flatnonzero(~alike).tolist()]
    for kind, pieces in kinds.items():
        if pieces:
            whole = _merged(kind, pieces)
            points = to_metres(whole.points, WORLD_Y_UP)
            grid = file.buffer.packing.grid(points)
            node = {"name": kind, "mesh": _add_mesh(file, whole, points, grid)} | grid.node()
            groups[whole.group]["children"].append(file.node(node))
    return tracks


def _add_bending(
    file: gltf.GltfFile, static: SceneMesh, motion: PlantMotion, group: gltf.Json, fps: float
) -> list[gltf.KeyTrack]:
    """Add a mesh that follows joints, which are children of its group; return their motion."""
    pack, buffer = file.buffer.packing, file.buffer
    points = to_metres(static.points, WORLD_Y_UP)
    grid = pack.grid(points)
    places = to_metres(motion.places, WORLD_Y_UP)
    first = len(file.nodes)
    for k, place in enumerate(places):
        number = file.node({"name": f"{static.kind}_{k}", "translation": place.tolist()})
        group["children"].append(number)
    bind = np.tile(np.eye(4), (len(places), 1, 1))
    bind[:, :3, 3] = -places
    joints = list(range(first, first + len(places)))
    matrices = buffer.add((bind @ grid.matrix).astype(np.float32))
    file.skins.append({"inverseBindMatrices": matrices, "joints": joints})
    four = ((0, 0), (0, 2))
    weights = SMALL.weights(np.pad(motion.weights, four).astype(np.float32))
    followed = np.where(weights.values > 0, np.pad(motion.joints, four), 0)
    more = {
        "JOINTS_0": buffer.add(followed.astype(np.uint8), VERTICES),
        "WEIGHTS_0": buffer.add(weights, VERTICES),
    }
    mesh = _add_mesh(file, static, points, grid, more)
    # A root of the scene: a skinned mesh moves with its joints alone.
    file.node({"name": static.name, "mesh": mesh, "skin": len(file.skins) - 1}, root=True)
    times = buffer.add((motion.frames / fps).astype(np.float32))
    ways = places + to_metres(motion.shifts, WORLD_Y_UP)
    return [
        gltf.KeyTrack(first + k, "translation", pack.lengths(ways[:, k], STEP_M), times)
        for k in range(1, len(places))
    ]


def _add_instances(file: gltf.GltfFile, static: SceneMesh) -> int:
    """Add a mesh at its places as instances of one node; return the number of the node."""
    points = to_metres(static.points, WORLD_Y_UP)
    grid = file.buffer.packing.grid(points)
    brightest = max(1.0, float(static.tints.max()))
    mesh = _add_mesh(file, static._replace(colors=static.colors * brightest), points, grid)
    way, turn, size = _parted(static.places, grid)
    tints = static.tints / brightest
    floats = {"TRANSLATION": way, "ROTATION": turn, "SCALE": size, "_COLOR_0": tints}
    attributes = {name: file.buffer.add(value.astype(np.float32)) for name, value in floats.items()}
    extensions = {gltf.INSTANCING: {"attributes": attributes}}
    return file.node({"name": static.name, "mesh": mesh, "extensions": extensions})


def _add_mesh(
    file: gltf.GltfFile, static: SceneMesh, points: Array, grid: PositionGrid,
    more: gltf.Json | None = None,
) -> int:  # fmt: skip
    """Add a mesh of `points`, metres, with `more` attributes; return its number."""
    pack, buffer = file.buffer.packing, file.buffer
    wide = np.uint16 if len(points) <= 65535 else np.uint32
    look: gltf.Json = {
        "name": static.group,
        "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": ROUGH},
    } | ({"doubleSided": True} if static.two_sided else {})
    if look not in file.materials:
        file.materials.append(look)
    colors = np.round(FULL_SHORT * np.clip(static.colors, 0.0, 1.0)).astype(np.uint16)
    attributes = {
        "POSITION": buffer.add(pack.positions(points, grid), VERTICES),
        "NORMAL": buffer.add(pack.normals(static.normals @ WORLD_Y_UP.T), VERTICES),
        "COLOR_0": buffer.add(Stored(colors, normalised=True), VERTICES),
    }
    if static.sway is not None:
        sway = METRES * static.sway / (grid.half or 1.0)
        attributes[SWAY] = buffer.add(sway.astype(np.float32), VERTICES)
    primitive = {
        "attributes": attributes | (more or {}),
        "indices": buffer.add(static.triangles.astype(wide).ravel(), INDICES),
        "material": file.materials.index(look),
    }
    file.meshes.append({"name": static.name, "primitives": [primitive]})
    return len(file.meshes) - 1


def _is_straight(place: Array) -> bool:
    """Tell if a transform is a rotation of something stretched along its axes."""
    axes = place[:3, :3] / np.linalg.norm(place[:3, :3], axis=0)
    across = np.abs(axes.T @ axes - np.eye(3)).max()
    return bool(across < SHEARED and np.linalg.det(axes) > 0.0)


def _moved(static: SceneMesh, k: int) -> SceneMesh:
    """Move the vertices of a mesh to its place k, in the colours that it has there."""
    place, colors = static.places[k], static.colors * static.tints[k]
    if (place == np.eye(4)).all():
        return static._replace(colors=colors)
    normals = static.normals @ np.linalg.inv(place[:3, :3])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    size = np.linalg.det(place[:3, :3])
    return static._replace(
        points=static.points @ place[:3, :3].T + place[:3, 3],
        normals=normals,
        colors=colors,
        triangles=static.triangles[:, ::-1] if size < 0.0 else static.triangles,
        sway=None if static.sway is None else static.sway * abs(size) ** (1 / 3),
    )


def _merged(kind: str, pieces: Sequence[SceneMesh]) -> SceneMesh:
    """Make one mesh of pieces that are in their places."""
    first = np.cumsum([0, *(len(piece.points) for piece in pieces[:-1])])
    triangles = [piece.triangles + k for piece, k in zip(pieces, first, strict=True)]
    sways = [piece.sway for piece in pieces if piece.sway is not None]
    return pieces[0]._replace(
        name=kind,
        points=np.concatenate([piece.points for piece in pieces]),
        normals=np.concatenate([piece.normals for piece in pieces]),
        colors=np.concatenate([piece.colors for piece in pieces]),
        triangles=np.concatenate(triangles),
        sway=np.concatenate(sways) if sways else None,
    )


def _parted(places: Array, grid: PositionGrid) -> tuple[Array, Array, Array]:
    """Split places into translation, metres, rotation (k, 4), w last, and scale (k, 3).

    Transforms and vertices are those of the dive, in cm with z up; the results are for y up.
    """
    turned = WORLD_Y_UP @ places[:, :3, :3] @ WORLD_Y_UP.T
    way = METRES * places[:, :3, 3] @ WORLD_Y_UP.T
    size = np.linalg.norm(turned, axis=1)
    turn = from_matrix(turned / size[:, None])
    way = way + turned @ grid.middle
    return way, gltf.ordered(np.asarray(turn)), size * (grid.half or 1.0)
