"""Our stages, read by OpenUSD, compared with playback."""

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdShade, UsdSkel, UsdUtils, UsdValidation

import capture.cli.main
import subsea.cli.main
from subsea.export.clips import Clip, Model, all_points, make_clips, transform_points
from subsea.export.conventions import Y_UP, to_metres
from subsea.export.skinning import fit_skeleton
from subsea.export.usd import write_usd
from subsea.export.usd_skeleton import add_skinned
from subsea.geometry.rotation import matrix
from tests.support.daily import only


def written(folder: Path, model: Model, clips: list[Clip], baked: bool) -> Usd.Stage:
    file, sheet, *_ = write_usd(folder, model, clips, baked)
    assert file.is_file() and sheet.is_file()
    return Usd.Stage.Open(str(file))


def frames(stage: Usd.Stage, clips: list[Clip]) -> Iterator[tuple[Clip, int, float]]:
    """The first, a middle and the last frame of each clip, and their time codes."""
    ranges = stage.GetRootLayer().customLayerData["clips"]
    assert set(ranges) == {clip.name for clip in clips}
    for clip in clips:
        told = ranges[clip.name]
        assert told["end"] - told["start"] == len(clip.points) - 1
        assert told["cyclic"] == clip.cyclic
        for frame in (0, len(clip.points) // 3, len(clip.points) - 1):
            yield clip, frame, told["start"] + frame


def seen(stage: Usd.Stage, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Points and normals of all meshes in the world, metres."""
    cache = UsdGeom.XformCache(time)
    points, normals = [], []
    for prim in stage.Traverse():
        if prim.IsA(UsdGeom.Mesh):
            mesh = UsdGeom.Mesh(prim)
            way = np.array(cache.GetLocalToWorldTransform(prim))  # rows are multiplied
            points.append(np.array(mesh.GetPointsAttr().Get(time)) @ way[:3, :3] + way[3, :3])
            normals.append(np.array(mesh.GetNormalsAttr().Get(time)) @ way[:3, :3])
    return np.concatenate(points), np.concatenate(normals)


def check_frames(stage: Usd.Stage, model: Model, clips: list[Clip]) -> None:
    """Points and normals are those of playback, within 1e-6 body lengths."""
    for clip, frame, time in frames(stage, clips):
        points, normals = seen(stage, time)
        at = slice(frame, frame + 1)
        expected = transform_points(clip.points[at], clip.position[at], clip.rotation[at])[0]
        off = np.linalg.norm(points - to_metres(expected, Y_UP), axis=1)
        assert off.max() < 1e-6 * 0.01 * model.length_cm
        facing = clip.normals[frame] @ matrix(clip.rotation[frame]).T @ Y_UP.T
        assert np.abs(normals - facing).max() < 1e-6


def problems(stage: Usd.Stage) -> list[str]:
    """The objections of OpenUSD's own validators."""
    registry = UsdValidation.ValidationRegistry()
    context = UsdValidation.ValidationContext(registry.GetOrLoadAllValidators())
    return [error.GetMessage() for error in context.Validate(stage)]


def test_a_stage_read_back_equals_playback(
    known: str, model: Model, clips: list[Clip], tmp_path: Path
) -> None:
    stage = written(tmp_path, model, clips, baked=False)
    check_frames(stage, model, clips)
    np.testing.assert_allclose(
        seen(stage, Usd.TimeCode.Default())[0], to_metres(model.rest, Y_UP), atol=1e-6
    )


def test_the_root_may_be_baked(tmp_path: Path) -> None:
    model, clips = make_clips("moon_wrasse", detail=1)
    stage = written(tmp_path, model, clips, baked=True)
    assert not UsdGeom.Xformable(stage.GetDefaultPrim()).GetOrderedXformOps()
    check_frames(stage, model, clips)


@pytest.mark.parametrize(
    ("name", "prim"),
    only([("2nd-fish", "_nd_fish")], [("fusilier", "fusilier"), ("2nd-fish", "_nd_fish")]),
)
def test_the_stage_is_sound(name: str, prim: str, tmp_path: Path) -> None:
    """By OpenUSD's own validators, the parts of `usdchecker`; whatever its name."""
    model, clips = make_clips("fusilier", detail=2)
    model = model._replace(name=name)
    stage = written(tmp_path, model, clips, baked=False)
    assert not problems(stage)
    layers, assets, missing = UsdUtils.ComputeAllDependencies(stage.GetRootLayer().identifier)
    assert (len(layers), len(assets)) == (1, 2) and not missing  # colours and scales
    assert UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.y
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert stage.GetTimeCodesPerSecond() == pytest.approx(clips[0].fps)
    assert stage.GetStartTimeCode() == 0
    assert stage.GetEndTimeCode() == sum(len(clip.points) for clip in clips) - 1
    assert stage.GetDefaultPrim().GetName() == prim


@pytest.mark.nightly
@pytest.mark.parametrize("baked", [False, True])
def test_a_skeleton_moves_the_mesh_as_playback_does(baked: bool, tmp_path: Path) -> None:
    """To the errors of the fit, by OpenUSD's own skinning, in a fraction of the bytes."""
    model, clips = make_clips("fusilier", detail=2)
    chosen = [clip for clip in clips if clip.name in ("swim_slow", "turn_left_sharp")]
    rig = fit_skeleton(model, all_points(chosen))
    exact = write_usd(tmp_path / "exact", model, chosen, baked)[0].stat().st_size
    file, *_ = write_usd(tmp_path, model, chosen, baked, partial(add_skinned, rig=rig))
    assert file.stat().st_size < 0.3 * exact
    stage = Usd.Stage.Open(str(file))
    assert not problems(stage)
    root = UsdSkel.Root(stage.GetPrimAtPath("/fusilier/skin"))
    cache = UsdSkel.Cache()
    cache.Populate(root, Usd.PrimDefaultPredicate)
    [binding] = cache.ComputeSkelBindings(root, Usd.PrimDefaultPredicate)
    pose = cache.GetSkelQuery(binding.GetSkeleton())
    box = np.array(root.GetExtentAttr().Get())
    squares = []
    for clip, frame, time in frames(stage, chosen):
        points = []
        for target in binding.GetSkinningTargets():
            rest = UsdGeom.Mesh(target.GetPrim()).GetPointsAttr().Get()
            assert target.ComputeSkinnedPoints(pose.ComputeSkinningTransforms(time), rest, time)
            points.append(np.array(rest))
        found = np.concatenate(points)
        assert (found > box[0] - 0.01).all() and (found < box[1] + 0.01).all()
        way = np.array(UsdGeom.XformCache(time).GetLocalToWorldTransform(root.GetPrim()))
        at = slice(frame, frame + 1)
        goal = transform_points(clip.points[at], clip.position[at], clip.rotation[at])[0]
        off = np.linalg.norm(found @ way[:3, :3] + way[3, :3] - to_metres(goal, Y_UP), axis=1)
        off *= 1e4 / model.length_cm
        squares.append((off**2).mean())
        assert off.max() < 1.05 * rig.most_percent + 0.01
    assert np.sqrt(np.mean(squares)) < 1.5 * rig.rms_percent


def test_bounds_are_those_of_the_points(tmp_path: Path) -> None:
    """Of each frame: what a viewer frames and culls by."""
    model, clips = make_clips("spotted_eagle_ray", detail=2)
    stage = written(tmp_path, model, clips, baked=False)
    for _, _, time in frames(stage, clips):
        cache = UsdGeom.BBoxCache(time, [UsdGeom.Tokens.default_])
        box = cache.ComputeUntransformedBound(stage.GetDefaultPrim()).ComputeAlignedRange()
        points = np.concatenate(
            [
                np.array(
                    UsdGeom.Mesh(stage.GetPrimAtPath(f"/{model.name}/{part}"))
                    .GetPointsAttr()
                    .Get(time)
                )
                for part in ("body", "fins")
            ]
        )
        np.testing.assert_allclose(box.GetMin(), points.min(axis=0), atol=1e-6)
        np.testing.assert_allclose(box.GetMax(), points.max(axis=0), atol=1e-6)


def test_body_and_fins_have_the_texture(tmp_path: Path) -> None:
    """Fins, and what is clear of the body, with its opacity."""
    model, clips = make_clips("fusilier", detail=1)
    stage = written(tmp_path, model, clips, baked=False)
    body, fins = (UsdGeom.Mesh(stage.GetPrimAtPath(f"/fusilier/{p}")) for p in ("body", "fins"))
    corners = [np.array(mesh.GetFaceVertexIndicesAttr().Get()) for mesh in (body, fins)]
    corners[1] += model.solid
    np.testing.assert_array_equal(np.concatenate(corners).reshape(-1, 3), model.triangles)
    uv = [np.array(UsdGeom.PrimvarsAPI(m).GetPrimvar("st").Get()) for m in (body, fins)]
    np.testing.assert_allclose(np.concatenate(uv), model.uv, atol=1e-6)
    assert not body.GetDoubleSidedAttr().Get() and fins.GetDoubleSidedAttr().Get()
    flank, tail = UsdShade.MaterialBindingAPI(body).GetMaterialBindSubsets()
    for thing, clear in ((body, False), (flank, False), (tail, True), (fins, True)):
        material, _ = UsdShade.MaterialBindingAPI(thing).ComputeBoundMaterial()
        surface, _, _ = material.ComputeSurfaceSource()
        assert bool(surface.GetInput("opacity")) is clear
        source = surface.GetInput("diffuseColor").GetConnectedSources()[0][0].source
        file = UsdShade.Shader(source.GetPrim()).GetInput("file").Get()
        assert Path(file.resolvedPath) == tmp_path / "fusilier_basecolor.png"
    # By the middle of each face.
    faces = np.isin(np.arange(model.body), tail.GetIndicesAttr().Get())
    np.testing.assert_array_equal(flank.GetIndicesAttr().Get(), np.flatnonzero(~faces))
    middle = model.uv[model.triangles[: model.body]].mean(axis=1) * model.sheet.shape[1::-1]
    column, row = middle.astype(int).T
    opacity = model.sheet[row, column, 3]
    assert opacity[~faces].min() >= 250 > opacity[faces].min()
    assert model.rest[model.triangles[: model.body][faces], 0].max() < 0.0  # behind the middle


@pytest.mark.parametrize(
    ("main", "what"), [(capture.cli.main.main, "fusilier"), (subsea.cli.main.main, "peaceful")]
)
def test_without_usd_core_the_error_names_the_extra(
    main: Callable[[list[str]], int],
    what: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr("subsea.base.system.find_spec", lambda name: None)
    assert main(["export", what, "--to", "usd", "--out", str(tmp_path / "new")]) == 2
    assert "USD needs usd-core: run `make bench`" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
