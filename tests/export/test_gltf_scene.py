"""Scenes in glTF, played by an independent reader, are the points that the dive shows."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.export import COMPRESSIONS, MESHOPT, PLAIN, QUANTISED
from subsea.export.conventions import METRES, WORLD_Y_UP, Y_UP, Z_UP, sheet_png, to_metres
from subsea.export.gltf_scene import WRITER
from subsea.export.options import SceneOptions
from subsea.export.plant_motion import PlantMotion
from subsea.export.scene import Scene, SceneMesh
from subsea.export.skinning import fit_skeleton
from subsea.geometry.rotation import matrix
from tests.export.conftest import extent_of, once
from tests.support.gltf_reader import NodeMoment, Reader

VARIANTS = {"skin": {}, "morph": {"morph": True}, "vat": {"vat": True}}
MADE = [
    *(("skin", kind) for kind in COMPRESSIONS),
    *(("morph", kind) for kind in (PLAIN, MESHOPT)),
    ("vat", QUANTISED),
]
FRAMES = 8
LATE = 1  # the fish that comes and goes
# Off, rms and at most, percent of the body length: with a skeleton, and with morph targets.
SKINNED, EXACT, ROUNDED = (0.5, 3.0), (1e-3, 1e-3), (0.004, 0.008)
Opened = Callable[[Path], Reader]


def _statics() -> tuple[SceneMesh, ...]:
    """A stone, and a coral in six places: stretched, and one of them sheared."""
    points = np.array([[0, 0, 0], [10, 0, 0], [0, 10, 0], [0, 0, 10.0]])
    triangles = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.int32)
    normals = np.tile([[0, 0, 1.0]], (4, 1))
    colors = np.linspace(0.2, 0.9, 12).reshape(4, 3)
    rng = np.random.default_rng(0)
    places = np.tile(np.eye(4), (6, 1, 1))
    for place in places:
        turn = matrix(rng.normal(size=4) / 2)
        place[:3, :3] = np.linalg.qr(turn)[0] * (1.0, 1.3, 0.8)
        place[:3, :3] *= np.sign(np.linalg.det(place[:3, :3]))
        place[:3, 3] = 100.0 * rng.normal(size=3)
    places[5, 0, 1] += 0.5
    tints = rng.uniform(0.5, 1.2, (6, 3))
    mesh = points, normals, colors, triangles
    once = np.eye(4)[None], np.ones((1, 3))
    sway = np.array([0.0, 0.1, 0.2, 0.3])
    return (
        SceneMesh("rock", "stone", "stone", *mesh, False, *once),
        SceneMesh("coral_0", "coral", "corals", *mesh, True, places[:4], tints[:4], sway),
        SceneMesh("coral_1", "coral", "corals", *mesh, True, places[4:], tints[4:], 2.0 * sway),
        SceneMesh("weed", "weed", "seaweed", *mesh, True, *once, motion=_motion(rng)),
    )


def _motion(rng: np.random.Generator) -> PlantMotion:
    """Two joints beside the ground; a vertex follows one, or half of two."""
    shifts = np.zeros((3, 3, 3))
    shifts[1:, 1:] = rng.uniform(-5.0, 5.0, (2, 2, 3))
    return PlantMotion(
        frames=np.array([0, 3, FRAMES - 1]),
        places=rng.uniform(0.0, 30.0, (3, 3)),
        shifts=shifts,
        joints=np.array([[0, 1], [1, 2], [1, 2], [0, 2]]),
        weights=np.array([[1.0, 0.0], [0.5, 0.5], [0.0, 1.0], [0.0, 1.0]]),
    )


@pytest.fixture(scope="module")
def scene(dive: Scene) -> Scene:
    """Eight frames of the short dive; one of its fishes is there in frames 2 to 5 only."""
    fishes = [one._replace(last=FRAMES - 1) for one in dive.fishes]
    fishes[LATE] = fishes[LATE]._replace(first=2, last=5)
    camera = dive.camera._replace(
        position=dive.camera.position[:FRAMES], rotation=dive.camera.rotation[:FRAMES], cuts=(3,)
    )
    return replace(
        dive,
        frames=FRAMES,
        fishes=tuple(fishes),
        position=dive.position[:FRAMES],
        rotation=dive.rotation[:FRAMES],
        statics=_statics(),
        camera=camera,
    )


@pytest.fixture(scope="module")
def files(scene: Scene, tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, str], Path]:
    """A file of each variant and compression."""
    out = {}
    with pytest.MonkeyPatch.context() as patch:  # each file would do the same again
        patch.setattr("subsea.export.gltf_scene.fit_skeleton", once(fit_skeleton))
        patch.setattr("subsea.export.gltf.sheet_png", once(sheet_png))
        for name, kind in MADE:
            path = tmp_path_factory.mktemp(name) / "scene.glb"
            chosen = SceneOptions(compress=kind, instances=kind == QUANTISED, **VARIANTS[name])
            WRITER.check(path, chosen)
            written = WRITER.write(scene, path, chosen)
            assert written[0] == path and all(one.is_file() for one in written)
            out[name, kind] = path
    return out


def _seen(scene: Scene, fish: int) -> tuple[np.ndarray, np.ndarray]:
    """Points and normals (t, n, 3) of a fish in the dive, metres, y up."""
    one = scene.fishes[fish]
    points, normals = scene.points(fish)
    there = slice(one.first, one.last + 1)
    turns = matrix(scene.rotation[there, fish]).swapaxes(1, 2)
    world = scene.position[there, fish][:, None] + points @ turns
    return to_metres(world, WORLD_Y_UP), normals @ turns @ WORLD_Y_UP.T


def _node(reader: Reader, name: str) -> int:
    return [node.get("name") for node in reader.content["nodes"]].index(name)


def _moment(reader: Reader, scene: Scene) -> NodeMoment:
    return reader.worlds(scene.name, np.arange(scene.frames) / scene.fps)


@pytest.mark.parametrize(
    ("variant", "kind", "most"),
    [
        ("skin", PLAIN, SKINNED),
        ("skin", QUANTISED, SKINNED),
        ("skin", MESHOPT, SKINNED),
        ("morph", PLAIN, EXACT),
        ("morph", MESHOPT, ROUNDED),
    ],
)
def test_what_is_exported_is_what_was_seen(
    scene: Scene,
    files: dict[tuple[str, str], Path],
    variant: str,
    kind: str,
    most: tuple[float, float],
    opened: Opened,
) -> None:
    """In every frame in which a fish is in the sea; beyond them it has no size."""
    reader = opened(files[variant, kind])
    moment = _moment(reader, scene)
    squares, largest = [], 0.0
    for fish, one in enumerate(scene.fishes):
        found, ways = reader.node_points(_node(reader, f"{one.name}_mesh"), moment)
        there = slice(one.first, one.last + 1)
        points, normals = _seen(scene, fish)
        off = np.linalg.norm(found[there] - points, axis=2) * 100.0 / (METRES * one.length_cm)
        squares.append((off**2).mean())
        largest = max(largest, off.max())
        ways = ways[there] / np.linalg.norm(ways[there], axis=2, keepdims=True)
        angle = np.degrees(np.arccos(np.clip((ways * normals).sum(axis=2), -1.0, 1.0)))
        assert np.sqrt((angle**2).mean()) < (8.0 if variant == "skin" else 0.5)
        for frame in {*range(scene.frames)} - {*range(one.first, one.last + 1)}:
            assert np.ptp(found[frame], axis=0).max() < 1e-5
    assert np.sqrt(np.mean(squares)) < most[0] and largest < most[1]
    if variant == "skin" and kind == PLAIN:
        said = reader.content["asset"]["extras"]
        assert said["maxErrorPercent"] == pytest.approx(largest, rel=0.01)


def test_textures_hold_the_points_of_each_fish(
    scene: Scene, files: dict[tuple[str, str], Path], opened: Opened
) -> None:
    """Decoded as OpenVAT does: an offset from rest for each row, in Blender's axes."""
    path = files["vat", QUANTISED]
    reader = opened(path)
    moment = _moment(reader, scene)
    for fish, one in enumerate(scene.fishes):
        number = _node(reader, one.name)
        own = reader.content["nodes"][number]["extras"]
        texels = cv2.imread(str(path.parent / own["texture"]), cv2.IMREAD_UNCHANGED)[..., ::-1]
        texels = texels / 65535.0
        remap = str(path.parent / own["texture"]).replace("_vat.png", "-remap_info.json")
        content = json.loads(Path(remap).read_text())
        ranges = content["os-remap"]
        assert len(texels) == 2 * ranges["Frames"]
        clip = content["animations"][one.name]
        assert clip["startFrame"] == own["firstRow"] + 1
        assert clip["endFrame"] - own["firstRow"] == one.last - one.first + 1
        low, high = np.array(ranges["Min"]), np.array(ranges["Max"])
        rows = own["firstRow"] + np.arange(one.last - one.first + 1)
        ways = (low + texels[rows] * (high - low)) @ Z_UP @ Y_UP.T
        points, _ = _seen(scene, fish)
        world = moment.world[number][one.first : one.last + 1]
        rest = to_metres(scene.models[one.model].rest, Y_UP)
        shown = np.pad(rest + ways, ((0, 0), (0, 0), (0, 1)), constant_values=1.0)
        found = (shown @ world.swapaxes(1, 2))[..., :3]
        off = np.linalg.norm(found - points, axis=2) / (METRES * one.length_cm)
        assert off.max() < 1e-4
        mesh = reader.content["meshes"][
            reader.content["nodes"][_node(reader, f"{one.name}_mesh")]["mesh"]
        ]
        texel = reader.array(mesh["primitives"][0]["attributes"]["TEXCOORD_1"])
        np.testing.assert_allclose(texel[:, 0] * len(rest), np.arange(len(rest)) + 0.5, atol=1e-3)
        np.testing.assert_allclose(texel[:, 1] * len(texels), 0.5, atol=1e-3)


@pytest.mark.nightly
def test_the_validator_has_no_objection(
    files: dict[tuple[str, str], Path], khronos: Callable[[Path], dict[str, Any]]
) -> None:
    for path in files.values():
        issues = khronos(path)["issues"]
        assert issues["numErrors"] == issues["numWarnings"] == 0, issues["messages"][:3]


def test_the_camera_looks_where_the_film_did(
    scene: Scene, files: dict[tuple[str, str], Path], opened: Opened
) -> None:
    """Until just before a cut it stays, and then it jumps."""
    reader = opened(files["skin", PLAIN])
    number = _node(reader, "camera")
    world = _moment(reader, scene).world[number]
    camera = scene.camera
    np.testing.assert_allclose(world[:, :3, 3], to_metres(camera.position, WORLD_Y_UP), atol=1e-5)
    axes = WORLD_Y_UP @ matrix(camera.rotation)
    np.testing.assert_allclose(world[:, :3, :3], axes, atol=1e-5)
    before = reader.worlds(scene.name, np.array([3.0 / scene.fps - 2e-3])).world[number]
    np.testing.assert_allclose(before[0], world[2], atol=1e-5)
    lens = reader.content["cameras"][0]["perspective"]
    assert lens["yfov"] == camera.height_rad and lens["aspectRatio"] == camera.aspect
    assert 0.0 < lens["znear"] < lens["zfar"]


@pytest.mark.parametrize("kind", COMPRESSIONS)
def test_what_stands_still_is_where_it_was(
    scene: Scene, files: dict[tuple[str, str], Path], kind: str, opened: Opened
) -> None:
    """A mesh of each kind, or instances; a sheared copy is in the mesh."""
    reader = opened(files["skin", kind])
    moment = _moment(reader, scene)
    found, tinted = [], []
    for number, node in enumerate(reader.content["nodes"]):
        if "mesh" not in node or not node["name"].startswith(("coral", "stone")):
            continue
        own = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
        points, _ = reader.node_points(number, moment)
        primitive = reader.content["meshes"][node["mesh"]]["primitives"][0]
        colors = reader.array(primitive["attributes"]["COLOR_0"])[:, :3]
        if own is None:
            found += list(points[0].reshape(-1, 4, 3))
            tinted += list(colors.reshape(-1, 4, 3))
            continue
        parts = {name: reader.array(value) for name, value in own["attributes"].items()}
        x, y, z, w = parts["ROTATION"].T
        turns = matrix(np.stack([w, x, y, z], axis=1).astype(float))
        stretched = parts["SCALE"][:, None] * points[0]
        found += list(stretched @ turns.swapaxes(1, 2) + parts["TRANSLATION"][:, None])
        assert (parts["_COLOR_0"] <= 1.0).all()
        tinted += list(colors * parts["_COLOR_0"][:, None])
    expected = [
        (
            to_metres(one.points @ place[:3, :3].T + place[:3, 3], WORLD_Y_UP),
            np.clip(one.colors * tint, 0.0, 1.0),
        )
        for one in scene.statics
        if one.motion is None
        for place, tint in zip(one.places, one.tints, strict=True)
    ]
    assert len(found) == len(expected)
    for points, colors in expected:
        off = [np.abs(points - other).max() for other in found]
        assert min(off) < METRES * 0.01
        assert np.abs(tinted[int(np.argmin(off))] - colors).max() < 0.1
    names = [mesh["name"] for mesh in reader.content["meshes"]]
    assert {"stone", "coral"} <= set(names), "a mesh of each kind"
    assert len([name for name in names if name == "stone" or name.startswith("coral")]) == (
        4 if kind == QUANTISED else 2
    )


@pytest.mark.parametrize("kind", COMPRESSIONS)
def test_seaweed_bends_with_its_joints(
    scene: Scene, files: dict[tuple[str, str], Path], kind: str, opened: Opened
) -> None:
    reader = opened(files["skin", kind])
    [weed] = [one for one in scene.statics if one.name == "weed"]
    motion = weed.motion
    assert motion is not None
    found, _ = reader.node_points(_node(reader, "weed"), _moment(reader, scene))
    for frame in range(FRAMES):
        shifts = np.array(
            [
                [np.interp(frame, motion.frames, motion.shifts[:, joint, k]) for k in range(3)]
                for joint in range(3)
            ]
        )
        moved = (motion.weights[..., None] * shifts[motion.joints]).sum(axis=1)
        expected = to_metres(weed.points + moved, WORLD_Y_UP)
        assert np.abs(found[frame] - expected).max() < 5e-4  # weights are bytes
    assert np.abs(found[3] - found[0]).max() > 0.01


def test_what_is_soft_says_how_far_it_sways(
    scene: Scene, files: dict[tuple[str, str], Path], opened: Opened
) -> None:
    """In the unit of the positions: merged copies sway as far as they are large."""
    reader = opened(files["skin", PLAIN])
    meshes = {
        mesh["name"]: mesh["primitives"][0]["attributes"] for mesh in reader.content["meshes"]
    }
    assert "_SWAY" not in meshes["stone"]
    sway = reader.array(meshes["coral"]["_SWAY"]).reshape(-1, 4)
    sizes = [
        abs(np.linalg.det(place[:3, :3])) ** (1 / 3) * factor
        for one, factor in zip(scene.statics[1:3], (1.0, 2.0), strict=True)
        for place in one.places
    ]
    expected = METRES * np.outer(sizes, [0.0, 0.1, 0.2, 0.3])
    np.testing.assert_allclose(np.sort(sway, axis=0), np.sort(expected, axis=0), rtol=1e-5)


def test_the_file_says_what_it_is(
    scene: Scene, files: dict[tuple[str, str], Path], opened: Opened
) -> None:
    for (variant, kind), path in files.items():
        content = opened(path).content
        assert content["asset"]["copyright"].startswith("Copyright (c) 2026 The subsea authors")
        assert "MIT licence" in content["asset"]["copyright"]
        own = content["asset"]["extras"]
        assert own["scenario"] == scene.name and own["seed"] == scene.seed
        assert own["framesPerSecond"] == scene.fps
        assert own["startSeconds"] == 0.0 and own["frames"] == FRAMES
        names = [node.get("name") for node in content["nodes"]]
        for one in scene.fishes:
            node = content["nodes"][names.index(one.name)]
            assert node["extras"]["species"] == scene.models[one.model].name
        used = {one.model for one in scene.fishes}
        looks = [look["name"] for look in content["materials"]]
        assert len(set(looks)) == len(looks) <= 3 * len(used) + 3, (variant, kind)
        assert {look.rpartition("_")[0] for look in looks} - {""} == {
            scene.models[number].name for number in used
        }
        assert all(image["name"] for image in content["images"])


def test_a_fish_has_its_tint_at_its_vertices(
    scene: Scene, files: dict[tuple[str, str], Path], opened: Opened
) -> None:
    for path in files.values():
        reader = opened(path)
        for one in scene.fishes:
            node = reader.content["nodes"][_node(reader, f"{one.name}_mesh")]
            for part in reader.content["meshes"][node["mesh"]]["primitives"]:
                found = reader.array(part["attributes"]["COLOR_0"])
                assert np.abs(found - np.clip(one.tint, 0.0, 1.0)).max() < 0.5 / 255 + 1e-6


def test_compression_and_an_estimate(scene: Scene, files: dict[tuple[str, str], Path]) -> None:
    """Each kind is smaller than the one before it; sizes are known beforehand."""
    extent = extent_of(scene)
    sizes = {}
    for (variant, kind), path in files.items():
        folder = path.with_name("scene_vat")
        size = path.stat().st_size + sum(one.stat().st_size for one in folder.glob("*"))
        chosen = SceneOptions(compress=kind, instances=kind == QUANTISED, **VARIANTS[variant])
        estimate = WRITER.estimate(extent, chosen)
        assert size / 1.3 < estimate < 1.3 * size, (variant, kind, size, estimate)
        sizes[variant, kind] = size
    assert sizes["skin", PLAIN] > sizes["skin", QUANTISED] > 2 * sizes["skin", MESHOPT]
    assert sizes["morph", PLAIN] > 2 * sizes["morph", MESHOPT]


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("scene.usd", {}, "expected a name that ends in .glb"),
        ("scene.glb", {"morph": True, "vat": True}, "exclude each other"),
        ("scene.glb", {"poses": 3}, "--poses is for --to usd"),
        ("scene.glb", {"compress": "zip"}, "unknown compression 'zip'"),
    ],
)
def test_wrong_options_are_one_line(
    tmp_path: Path, name: str, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(UserError, match=message):
        WRITER.check(tmp_path / name, SceneOptions(**options))


def test_a_texture_has_no_room_for_too_many_frames(scene: Scene, tmp_path: Path) -> None:
    long = [one._replace(last=one.first + 5000) for one in scene.fishes]
    with pytest.raises(UserError, match="5001 frames do not fit into a texture"):
        WRITER.write(replace(scene, fishes=tuple(long)), tmp_path / "a.glb", SceneOptions(vat=True))
    assert not [*tmp_path.iterdir()]


def test_a_full_disk_leaves_nothing(
    scene: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(self: Path, data: bytes) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(UserError, match="No space left"):
        WRITER.write(scene, tmp_path / "a.glb", SceneOptions(morph=True, compress=MESHOPT))
    assert not [*tmp_path.rglob("*.*")]
