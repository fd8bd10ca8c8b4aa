"""Scenes as USD, read back by OpenUSD."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdLux, UsdShade, UsdSkel, UsdUtils, UsdValidation, Vt

from subsea.base.errors import UserError
from subsea.export import usd_scene
from subsea.export.conventions import WORLD_Y_UP, sheet_png, to_metres
from subsea.export.options import SceneOptions
from subsea.export.plant_motion import PlantMotion
from subsea.export.scene import Scene, SceneMesh
from subsea.export.usd_scene import WRITER, _representatives, bake_poses
from subsea.geometry.rotation import matrix
from subsea.habitat.stone import sun_at
from tests.export.conftest import extent_of, once
from tests.support.commands import full_disk

WHOLE = SceneOptions()


@pytest.fixture(scope="module", autouse=True)
def encoded_once() -> Iterator[None]:
    """Encode each texture once."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(usd_scene, "sheet_png", once(sheet_png))
        yield


@pytest.fixture(scope="module")
def file(dive: Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("scene") / "bare.usdc"
    WRITER.write(dive, out, WHOLE)
    return out


@pytest.fixture(scope="module")
def stage(file: Path) -> Any:
    return Usd.Stage.Open(str(file))


@pytest.fixture(scope="module")
def schools(dive: Scene, tmp_path_factory: pytest.TempPathFactory) -> Any:
    out = tmp_path_factory.mktemp("schools") / "bare.usdc"
    WRITER.write(replace(dive, statics=()), out, SceneOptions(poses=24))
    return Usd.Stage.Open(str(out))


def problems(stage: Any) -> list[str]:
    registry = UsdValidation.ValidationRegistry()
    context = UsdValidation.ValidationContext(registry.GetOrLoadAllValidators())
    return [error.GetMessage() for error in context.Validate(stage)]


def world_points(stage: Any, path: str, frame: int) -> np.ndarray:
    """Points (n, 3) of body and fins in the stage, m."""
    prim = stage.GetPrimAtPath(path)
    whole = np.array(UsdGeom.XformCache(frame).GetLocalToWorldTransform(prim))
    parts = [UsdGeom.Mesh(child).GetPointsAttr().Get(frame) for child in prim.GetChildren()]
    points = np.concatenate([np.array(part, float) for part in parts])
    return np.asarray(points @ whole[:3, :3] + whole[3, :3])


def test_every_fish_is_where_the_dive_has_it(dive: Scene, stage: Any) -> None:
    """All its vertices, in every frame: to 1e-5 of its length."""
    for column, fish in enumerate(dive.fishes):
        points, _ = dive.points(column)
        for frame in range(dive.frames):
            world = points[frame] @ matrix(dive.rotation[frame, column]).T
            expected = to_metres(world + dive.position[frame, column], WORLD_Y_UP)
            found = world_points(stage, f"/bare_sea/fishes/{fish.name}", frame)
            assert np.abs(found - expected).max() < 1e-5 * 0.01 * fish.length_cm


def test_normals_and_bounds_are_those_of_each_frame(stage: Any) -> None:
    cache = UsdGeom.BBoxCache(40, [UsdGeom.Tokens.default_])
    fish = stage.GetPrimAtPath("/bare_sea/fishes/clownfish_001")
    box = cache.ComputeWorldBound(fish).ComputeAlignedRange()
    points = world_points(stage, str(fish.GetPath()), 40)
    assert (np.array(box.GetMin()) <= points.min(axis=0) + 1e-5).all()
    assert (np.array(box.GetMax()) >= points.max(axis=0) - 1e-5).all()
    body = UsdGeom.Mesh(fish.GetChild("body"))
    normals = np.array(body.GetNormalsAttr().Get(40))
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-5)
    a, b, c = (np.array(body.GetPointsAttr().Get(40))[k] for k in _corners(body))
    outward = (np.cross(b - a, c - a) * normals[_corners(body)[0]]).sum(axis=1)
    assert (outward > 0.0).mean() > 0.97


def _corners(mesh: Any) -> np.ndarray:
    return np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3).T


@pytest.mark.parametrize("which", ["stage", "schools"])
def test_the_validators_have_no_objection(which: str, request: pytest.FixtureRequest) -> None:
    assert not problems(request.getfixturevalue(which))


def test_the_stage_is_as_artists_expect(dive: Scene, stage: Any, file: Path) -> None:
    assert UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.y
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert stage.GetTimeCodesPerSecond() == stage.GetFramesPerSecond() == dive.fps
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0, dive.frames - 1)
    layer = stage.GetRootLayer()
    assert "MIT licence" in layer.documentation
    assert layer.customLayerData["copyright"] == layer.documentation
    root = stage.GetDefaultPrim()
    names = {child.GetName() for child in root.GetChildren()}
    assert names == {"camera", "sun", "materials", "fishes", "sand", "stone"}
    textures = {path.name for path in (file.parent / "bare_textures").iterdir()}
    kinds = ("basecolor", "normal")
    assert textures == {f"{name}_{k}.png" for name in ("fusilier", "clownfish") for k in kinds}
    layers, assets, missing = UsdUtils.ComputeAllDependencies(str(file))
    assert len(layers) == 1 and len(assets) == 4 and not missing
    fins = stage.GetPrimAtPath("/bare_sea/fishes/fusilier_002/fins")
    material, _ = UsdShade.MaterialBindingAPI(fins).ComputeBoundMaterial()
    assert str(material.GetPath()) == "/bare_sea/materials/fusilier/clear"


def test_seaweed_bends_with_its_joints(tmp_path: Path, dive: Scene) -> None:
    """OpenUSD's own skinning finds the vertices where the joints of the motion have them."""
    points = np.array([[0, 0, 0], [10, 0, 0], [0, 10, 0], [0, 0, 30.0]])
    shifts = np.zeros((2, 2, 3))
    shifts[1, 1] = 3.0, -4.0, 1.0
    motion = PlantMotion(
        np.array([0, 10]), np.array([[1.0, 2, 3], [4, 5, 6]]), shifts,
        np.array([[0, 1]] * 4), np.array([[1.0, 0.0], [0.5, 0.5], [0.25, 0.75], [0.0, 1.0]]),
    )  # fmt: skip
    weed = SceneMesh(
        "weed", "weed", "seaweed", points, np.tile([0, 0, 1.0], (4, 1)), np.full((4, 3), 0.2),
        np.array([[0, 1, 2], [0, 1, 3]], np.int32), True, np.eye(4)[None], np.ones((1, 3)),
        motion=motion,
    )  # fmt: skip
    out = tmp_path / "weed.usdc"
    WRITER.write(replace(dive, statics=(weed,)), out, SceneOptions(poses=1))
    stage = Usd.Stage.Open(str(out))
    assert not problems(stage)
    cache = UsdSkel.Cache()
    root = UsdSkel.Root(stage.GetPrimAtPath("/bare_sea/seaweed/weed"))
    cache.Populate(root, Usd.PrimDefaultPredicate)
    [binding] = cache.ComputeSkelBindings(root, Usd.PrimDefaultPredicate)
    [target] = binding.GetSkinningTargets()
    query = cache.GetSkelQuery(binding.GetSkeleton())
    for frame in (0, 5, 10):
        moved = Vt.Vec3fArray.FromNumpy(to_metres(points, WORLD_Y_UP).astype(np.float32))
        assert target.ComputeSkinnedPoints(query.ComputeSkinningTransforms(frame), moved, frame)
        shown = points + motion.weights[:, 1:] * (frame / 10.0 * shifts[1, 1])
        np.testing.assert_allclose(np.array(moved), to_metres(shown, WORLD_Y_UP), atol=1e-6)


def test_the_camera_sees_what_the_film_shows(dive: Scene, stage: Any) -> None:
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/bare_sea/camera"))
    for frame in (0, 37):
        frustum = camera.GetCamera(frame).frustum
        place = to_metres(dive.camera.position[frame], WORLD_Y_UP)
        np.testing.assert_allclose(np.array(frustum.position), place, atol=1e-6)
        ahead = -matrix(dive.camera.rotation[frame])[:, 2] @ WORLD_Y_UP.T
        np.testing.assert_allclose(np.array(frustum.ComputeViewDirection()), ahead, atol=1e-6)
        window = frustum.GetWindow()
        assert window.GetMax()[1] == pytest.approx(np.tan(0.5 * dive.camera.height_rad), rel=1e-5)
        assert frustum.ComputeAspectRatio() == pytest.approx(1280 / 720)


def test_the_sun_shines_as_in_the_dive(dive: Scene, stage: Any) -> None:
    light = stage.GetRootLayer().customLayerData["light"]
    toward = np.array(sun_at(dive.water.hour)[0])
    np.testing.assert_allclose(light["toSun"], toward @ WORLD_Y_UP.T, atol=1e-5)
    assert light["visibilityMetres"] == pytest.approx(0.01 * dive.water.visibility_cm)
    sun = UsdLux.DistantLight(stage.GetPrimAtPath("/bare_sea/sun"))
    whole = UsdGeom.XformCache(0).GetLocalToWorldTransform(sun.GetPrim())
    np.testing.assert_allclose(whole.TransformDir(Gf.Vec3d(0, 0, 1)), light["toSun"], atol=1e-5)


def test_a_fish_that_dies_leaves_the_stage(dive: Scene, tmp_path: Path) -> None:
    """In the middle of the scene, and one that comes late is not seen before."""
    gone = dive.fishes[0]._replace(last=20)
    late = dive.fishes[3]._replace(first=30)
    few = replace(dive, fishes=(gone, *dive.fishes[1:3], late), statics=())
    WRITER.write(few, tmp_path / "a.usdc", WHOLE)
    stage = Usd.Stage.Open(str(tmp_path / "a.usdc"))
    for name, inside in ((gone.name, (0, 20)), (late.name, (30, 59)), ("fusilier_001", (0, 59))):
        prim = UsdGeom.Imageable(stage.GetPrimAtPath(f"/bare_sea/fishes/{name}"))
        seen = [prim.ComputeVisibility(k) != UsdGeom.Tokens.invisible for k in range(60)]
        assert [k for k in range(60) if seen[k]] == list(range(inside[0], inside[1] + 1))


def test_a_school_of_instances_is_near_the_exact_fishes(dive: Scene, schools: Any) -> None:
    for frame in (0, 33):
        for kind, model in enumerate(dive.models):
            path = f"/bare_sea/schools/{model.name}"
            instancer = UsdGeom.PointInstancer(schools.GetPrimAtPath(path))
            whole = instancer.ComputeInstanceTransformsAtTime(frame, frame)
            poses = instancer.GetPrototypesRel().GetTargets()
            which = instancer.GetProtoIndicesAttr().Get(frame)
            mine = [k for k, fish in enumerate(dive.fishes) if fish.model == kind]
            assert len(whole) == len(mine) and len(poses) <= 24
            for k, column in enumerate(mine):
                turn = np.array(whole[k])
                points = world_points(schools, str(poses[which[k]]), 0)
                found = points @ turn[:3, :3] + turn[3, :3]
                exact, _ = dive.points(column, frame, frame)
                exact = exact[0] @ matrix(dive.rotation[frame, column]).T
                exact = to_metres(exact + dive.position[frame, column], WORLD_Y_UP)
                off = np.linalg.norm(found - exact, axis=1) / (0.01 * dive.fishes[column].length_cm)
                assert np.sqrt((off**2).mean()) < 0.03


def test_the_same_scene_is_the_same_bytes(dive: Scene, tmp_path: Path) -> None:
    few = replace(dive, fishes=dive.fishes[:1], statics=dive.statics[1:3])
    for folder in "ab":
        WRITER.write(few, tmp_path / folder / "bare.usdz", WHOLE)
    one, other = ((tmp_path / folder / "bare.usdz").read_bytes() for folder in "ab")
    assert one == other
    stage = Usd.Stage.Open(str(tmp_path / "a" / "bare.usdz"))
    assert not problems(stage)
    assert len(world_points(stage, "/bare_sea/fishes/fusilier_000", 30)) > 100
    assert [path.name for path in (tmp_path / "a").iterdir()] == ["bare.usdz"]


def test_the_estimate_is_near_the_bytes(dive: Scene, file: Path) -> None:
    extent = extent_of(dive)
    pictures = sum(path.stat().st_size for path in (file.parent / "bare_textures").iterdir())
    written = file.stat().st_size + pictures
    assert 0.8 < WRITER.estimate(extent, WHOLE) / written < 1.25


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("a.obj", WHOLE, "expected a name that ends in .usdc or .usdz"),
        ("a.usdc", SceneOptions(morph=True), "--morph is for --to gltf, not usd"),
        ("a.usdz", SceneOptions(vat=True), "--vat is for --to gltf, not usd"),
        ("taken.usdc", WHOLE, "exists and is not a USD stage"),
        ("taken.usdc/a.usdc", WHOLE, "cannot write there"),
    ],
)
def test_faults_are_found_before_any_work(
    name: str, options: SceneOptions, message: str, tmp_path: Path
) -> None:
    (tmp_path / "taken.usdc").write_text("a letter")
    with pytest.raises(UserError, match=message):
        WRITER.check(tmp_path / name, options)


@pytest.mark.parametrize("suffix", ["usdc", "usdz"])
def test_a_full_disk_is_one_line_and_leaves_nothing(
    suffix: str, dive: Scene, tmp_path: Path
) -> None:
    few = replace(dive, statics=())
    # Less than the stage, more than the textures.
    with full_disk(2_000_000), pytest.raises(UserError, match="cannot write") as fault:
        WRITER.write(few, tmp_path / "out" / f"full.{suffix}", WHOLE)
    assert "\n" not in str(fault.value)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("model", [0, 1])
def test_more_poses_are_nearer(dive: Scene, model: int) -> None:
    errors = []
    for number in (1, 8, 64):
        poses = bake_poses(dive, model, number)
        assert 1 <= len(poses.points) <= number
        assert poses.pose.shape == (dive.frames, len(poses.fishes))
        assert poses.pose.min() >= 0 and poses.pose.max() < len(poses.points)
        assert poses.most_percent >= poses.rms_percent > 0.0
        errors.append(poses.rms_percent)
    assert errors[2] < 0.5 * errors[1] < 0.5 * errors[0]


def test_the_printed_error_is_that_of_the_vertices(dive: Scene) -> None:
    poses = bake_poses(dive, 0, 8)
    far = []
    for k, fish in enumerate(poses.fishes.tolist()):
        points, _ = dive.points(fish)
        shown = dive.fishes[fish].scale * poses.points[poses.pose[:, k]]
        far.append(np.linalg.norm(shown - points, axis=2) / dive.fishes[fish].length_cm)
    assert 100.0 * np.sqrt(np.mean(np.square(far))) == pytest.approx(poses.rms_percent, rel=1e-6)
    assert 100.0 * np.max(far) == pytest.approx(poses.most_percent, rel=1e-6)


def test_representatives_find_separate_clusters() -> None:
    rng = np.random.default_rng(3)
    middles = np.array([[0.0, 0.0], [10.0, 0.0], [0.0, 10.0]])
    samples = np.repeat(middles, 40, axis=0) + rng.normal(0.0, 0.3, (120, 2))
    chosen = _representatives(samples, 3)
    assert sorted(chosen // 40) == [0, 1, 2]
    assert len(_representatives(np.zeros((9, 2)), 4)) == 1  # all alike: one is enough
