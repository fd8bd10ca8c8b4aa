"""Export a scene as a USD stage: fishes, camera, and what does not move.

    /SCENE/camera                     UsdGeomCamera
    /SCENE/fishes/fusilier_003        its path; body and fins with points in every frame
    /SCENE/schools/fusilier           with --poses: a point instancer instead of the fishes
    /SCENE/sand, stone, corals, seaweed
    /SCENE/materials

Units are metres, y is up and the head of a fish along +z. Frame k is that of `subsea film` with the
same options. Fishes are written one after another, so memory does not grow with their number.

Sand, stone, corals and seaweed in a USD stage: coloured meshes, instanced where they repeat.
"""

from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.base.file_kinds import USD, FileKind, check_result, signed
from subsea.base.files import replacing
from subsea.base.progress import progress, say
from subsea.base.system import require
from subsea.export.axes import METRES, WORLD_Y_UP, Y_UP, to_metres, world_rotations
from subsea.export.png import sheet_png
from subsea.export.scene import (
    OF_USD,
    BakedPoses,
    Scene,
    SceneCamera,
    SceneExtent,
    SceneMesh,
    SceneOptions,
    SceneWriter,
    bake_poses,
    check_options,
)
from subsea.export.usd_parts import (
    animate,
    bind,
    component,
    group,
    identifier,
    move,
    set_up,
    skin_materials,
    skin_meshes,
    vectors,
    write_package,
)


def add_statics(stage: Any, at: Any, statics: tuple[SceneMesh, ...]) -> None:
    """Sand, stone, corals and seaweed; a mesh at several places is instanced."""
    from pxr import Sdf, UsdGeom

    if not statics:
        return
    look = colour_material(stage, at.AppendPath("materials/ground"))
    for name in dict.fromkeys(one.group for one in statics):
        group(stage, at.AppendChild(name))
    for one in statics:
        path = at.AppendPath(f"{one.group}/{identifier(one.name)}")
        if len(one.places) == 1:
            prim = component(stage, path)
            _place(prim, one.places[0])
            bind(coloured_mesh(stage, path.AppendChild("mesh"), one, one.tints[0]), look)
            continue
        kept = at.AppendPath(f"{one.group}/prototypes/{identifier(one.name)}")
        folder = UsdGeom.Scope.Define(stage, kept.GetParentPath())
        folder.GetPrim().SetSpecifier(Sdf.SpecifierClass)  # not drawn itself
        prototype = component(stage, kept)
        mesh = coloured_mesh(stage, kept.AppendChild("mesh"), one, one.tints.mean(axis=0))
        bind(mesh, look)
        for k, place in enumerate(one.places):
            prim = UsdGeom.Xform.Define(stage, path.GetParentPath().AppendChild(f"{path.name}_{k}"))
            prim.GetPrim().GetInherits().AddInherit(prototype.GetPath())
            prim.GetPrim().SetInstanceable(True)
            _place(prim, place)


def _place(prim: Any, place: Array) -> None:
    """The transformation (4, 4) from a mesh's own axes, in cm and z up, to the stage."""
    from pxr import Gf

    turn = np.eye(4)
    turn[:3, :3] = WORLD_Y_UP
    whole = turn @ place @ turn.T
    whole[:3, 3] *= METRES
    if not np.allclose(whole, np.eye(4)):
        prim.AddTransformOp().Set(Gf.Matrix4d(*map(float, whole.T.ravel())))


def coloured_mesh(stage: Any, path: Any, one: SceneMesh, tint: Array) -> Any:
    """A mesh that does not move, with colours at its vertices times `tint` (3,)."""
    from pxr import UsdGeom, Vt

    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(one.triangles), 3, np.int32)))
    corners = np.ascontiguousarray(one.triangles, np.int32).ravel()
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(corners))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDoubleSidedAttr(one.two_sided)
    mesh.CreatePointsAttr(vectors(to_metres(one.points, WORLD_Y_UP)))
    mesh.CreateNormalsAttr(vectors(one.normals @ WORLD_Y_UP.T))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    colours = mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.vertex)
    colours.Set(vectors(np.clip(one.colors * tint, 0.0, 1.0)))
    mesh.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(mesh.GetPointsAttr().Get()))
    return mesh


def colour_material(stage: Any, path: Any) -> Any:
    """A UsdPreviewSurface with the display colours of a mesh."""
    from pxr import Sdf, UsdShade

    names = Sdf.ValueTypeNames
    material = UsdShade.Material.Define(stage, path)
    surface, colours = (
        UsdShade.Shader.Define(stage, path.AppendChild(name)) for name in ("surface", "colours")
    )
    colours.CreateIdAttr("UsdPrimvarReader_float3")
    colours.CreateInput("varname", names.String).Set("displayColor")
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("roughness", names.Float).Set(1.0)
    surface.CreateInput("diffuseColor", names.Color3f).ConnectToSource(
        colours.CreateOutput("result", names.Float3)
    )
    material.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", names.Token))
    return material


PACKAGE = signed("a USD package (.usdz)", b"PK\x03\x04")
KINDS: dict[str, FileKind] = {".usdc": USD, ".usdz": PACKAGE}
CHUNK = 64  # frames of a fish at a time
SAVED_BYTES = 200_000_000  # of time samples, after which they go to the disk
FRAME_BYTES = 24  # of a vertex: point and normal
SHEET_BYTES = 600_000  # of the texture of a species
SENSOR = 0.36, 0.01  # width of a film's frame of 36 mm, and 1 mm, in tenths of a metre


def check(out: Path, options: SceneOptions) -> None:
    """Check the options and the output path before any work."""
    check_options(options, "usd", OF_USD)
    if out.suffix.lower() not in KINDS:
        raise UserError("expected a name that ends in .usdc or .usdz", file=out)
    require("usd", "USD")
    check_result(out, KINDS[out.suffix.lower()], options.force)


def estimate(extent: SceneExtent, options: SceneOptions) -> int:
    """Bytes of the fishes and their textures."""
    species = len(set(extent.species))
    if options.poses is None:
        moving = sum(extent.vertices) * FRAME_BYTES * extent.frames
    else:
        each = dict(zip(extent.species, extent.vertices, strict=True))
        moving = sum(each.values()) * FRAME_BYTES * options.poses
        moving += len(extent.vertices) * extent.frames * 56  # place, turn, size and pose
    return moving + species * SHEET_BYTES


def write(scene: Scene, out: Path, options: SceneOptions) -> list[Path]:
    """Write the stage with its textures, or a package with all of it; return the files."""
    require("usd", "USD")
    from pxr import Tf

    textures = f"{out.stem}_textures"
    try:
        if out.suffix.lower() == ".usdz":
            write_package(out, lambda folder: _fill_package(scene, folder, options))
            return [out]
        with ExitStack() as stack:
            files = []
            for model in scene.models:
                files.append(out.parent / textures / f"{model.name}_basecolor.png")
                stack.enter_context(replacing(files[-1])).write_bytes(sheet_png(model.sheet))
            part = stack.enter_context(replacing(out))
            # The library needs the suffix, which an unfinished file does not have.
            plain = part.with_name(part.name + out.suffix)
            try:
                _write_stage(scene, plain, textures, options)
                plain.replace(part)
            finally:
                plain.unlink(missing_ok=True)
        return [out, *files]
    except Tf.ErrorException as fault:
        raise UserError(f"cannot write ({fault.args[0].commentary})", file=out) from fault


WRITER = SceneWriter(check, estimate, write)


def _fill_package(scene: Scene, folder: Path, options: SceneOptions) -> Path:
    """Write a stage and its textures into `folder`; return the stage."""
    for model in scene.models:
        (folder / f"{model.name}_basecolor.png").write_bytes(sheet_png(model.sheet))
    stage = folder / f"{identifier(scene.name)}.usdc"
    _write_stage(scene, stage, ".", options)
    return stage


def _write_stage(scene: Scene, path: Path, textures: str, options: SceneOptions) -> None:
    """Write the stage `path`; `textures` is the folder of its textures, as seen from there."""
    from pxr import Kind, Usd, UsdGeom

    stage = Usd.Stage.CreateNew(str(path))
    set_up(
        stage, scene.fps, scene.frames - 1, [model.name for model in scene.models],
        title=scene.title, seed=scene.seed, start_s=scene.start_s,
    )  # fmt: skip
    root = UsdGeom.Xform.Define(stage, f"/{identifier(scene.name)}")
    stage.SetDefaultPrim(root.GetPrim())
    Usd.ModelAPI(root).SetKind(Kind.Tokens.assembly)
    at = root.GetPath()
    _add_camera(stage, at.AppendChild("camera"), scene.camera)
    looks = []
    UsdGeom.Scope.Define(stage, at.AppendChild("materials"))
    for model in scene.models:
        folder = UsdGeom.Scope.Define(stage, at.AppendPath(f"materials/{identifier(model.name)}"))
        sheet = f"{textures}/{model.name}_basecolor.png"
        looks.append(skin_materials(stage, folder.GetPath(), sheet.removeprefix("./")))
    add_statics(stage, at, scene.statics)
    if options.poses is None:
        _add_fishes(stage, at.AppendChild("fishes"), scene, looks)
    else:
        _add_schools(stage, at.AppendChild("schools"), scene, looks, options.poses)
    stage.Save()


def _add_fishes(stage: Any, at: Any, scene: Scene, looks: list[dict[str, Any]]) -> None:
    """Each fish with its path, and its meshes with points in every frame."""
    group(stage, at)
    pending = 0
    with progress(len(scene.fishes), "fish") as done:
        for number, fish in enumerate(scene.fishes):
            model = scene.models[fish.model]
            prim = component(stage, at.AppendChild(identifier(fish.name)))
            inside = slice(fish.first, fish.last + 1)
            place = to_metres(scene.position[inside, number], WORLD_Y_UP)
            move(prim, place, world_rotations(scene.rotation[inside, number], Y_UP), fish.first)
            _hide(prim, fish.first, fish.last, scene.frames)
            _describe(prim, fish.length_cm, fish.number, fish.tint)
            meshes = skin_meshes(stage, prim.GetPath(), model, looks[fish.model])
            for first in range(fish.first, fish.last + 1, CHUNK):
                last = min(first + CHUNK - 1, fish.last)
                points, normals = scene.points(number, first, last)
                for mesh, part in meshes:
                    animate(mesh, part, zip(points, normals, strict=True), first)
                pending += points.size // 3 * FRAME_BYTES
                if pending > SAVED_BYTES:
                    stage.Save()
                    pending = 0
            done()


def _describe(prim: Any, length_cm: float, number: int, tint: Array) -> None:
    from pxr import Gf, Sdf, UsdGeom

    prim.GetPrim().SetCustomDataByKey("length_cm", float(length_cm))
    prim.GetPrim().SetCustomDataByKey("number", int(number))
    primvar = UsdGeom.PrimvarsAPI(prim).CreatePrimvar("tint", Sdf.ValueTypeNames.Color3f)
    primvar.Set(Gf.Vec3f(*map(float, tint)))


def _hide(prim: Any, first: int, last: int, frames: int) -> None:
    """Show a fish only in the frames `first` to `last`."""
    from pxr import UsdGeom

    if first == 0 and last == frames - 1:
        return
    visible = prim.CreateVisibilityAttr()
    if first:
        visible.Set(UsdGeom.Tokens.invisible, 0)
    visible.Set(UsdGeom.Tokens.inherited, first)
    if last < frames - 1:
        visible.Set(UsdGeom.Tokens.invisible, last + 1)


def _add_schools(
    stage: Any, at: Any, scene: Scene, looks: list[dict[str, Any]], number: int
) -> None:
    """A point instancer for each species, with `number` poses baked as prototypes."""
    group(stage, at)
    for kind, model in enumerate(scene.models):
        poses = bake_poses(scene, kind, number)
        prim = at.AppendChild(identifier(model.name))
        instancer = _instancer(stage, prim, scene, poses)
        for k, (points, normals) in enumerate(zip(poses.points, poses.normals, strict=True)):
            path = prim.AppendPath(f"poses/pose_{k:03}")
            component(stage, path)
            instancer.GetPrototypesRel().AddTarget(path)
            posed = model._replace(rest=points, normals=normals)
            skin_meshes(stage, path, posed, looks[kind])
        say(
            f"{model.name}: {len(poses.points)} poses; vertices are off by "
            f"{poses.rms_percent:.2f}% of the body length (rms), {poses.most_percent:.2f}% at most"
        )


def _instancer(stage: Any, path: Any, scene: Scene, poses: BakedPoses) -> Any:
    """The point instancer of the fishes of one model, without its prototypes."""
    from pxr import UsdGeom, Vt

    instancer = UsdGeom.PointInstancer.Define(stage, path)
    UsdGeom.Scope.Define(stage, path.AppendChild("poses"))
    fishes = [scene.fishes[k] for k in poses.fishes]
    instancer.CreateIdsAttr(Vt.Int64Array([one.number for one in fishes]))
    size = np.repeat(np.array([one.scale for one in fishes], np.float32)[:, None], 3, axis=1)
    instancer.CreateScalesAttr(vectors(size))
    place, turn = instancer.CreatePositionsAttr(), instancer.CreateOrientationsfAttr()
    coarse, which = instancer.CreateOrientationsAttr(), instancer.CreateProtoIndicesAttr()
    hidden, extent = instancer.CreateInvisibleIdsAttr(), instancer.CreateExtentAttr()
    reach = max(float(np.linalg.norm(poses.points, axis=2).max()) * METRES * size.max(), 1e-3)
    rotation = world_rotations(scene.rotation[:, poses.fishes], Y_UP)
    position = to_metres(scene.position[:, poses.fishes], WORLD_Y_UP)
    for frame in range(scene.frames):
        inside = poses.pose[frame] >= 0
        there = np.where(inside[:, None], position[frame], 0.0)
        facing = np.where(inside[:, None], rotation[frame], (1.0, 0.0, 0.0, 0.0))
        place.Set(vectors(there), frame)
        imaginary_first = np.ascontiguousarray(facing[:, [1, 2, 3, 0]], np.float32)
        turn.Set(Vt.QuatfArray.FromNumpy(imaginary_first), frame)
        coarse.Set(Vt.QuathArray.FromNumpy(imaginary_first.astype(np.float16)), frame)
        which.Set(Vt.IntArray.FromNumpy(np.maximum(poses.pose[frame], 0).astype(np.int32)), frame)
        hidden.Set(
            Vt.Int64Array(
                [one.number for one, here in zip(fishes, inside, strict=True) if not here]
            ),
            frame,
        )
        shown = there[inside] if inside.any() else there[:1]
        extent.Set(vectors(np.stack([shown.min(axis=0) - reach, shown.max(axis=0) + reach])), frame)
    return instancer


def _add_camera(stage: Any, path: Any, camera: SceneCamera) -> None:
    """The camera of the dive, as of a film of 36 mm."""
    from pxr import Gf, UsdGeom

    prim = UsdGeom.Camera.Define(stage, path)
    wide = SENSOR[0]
    prim.CreateHorizontalApertureAttr(wide)
    prim.CreateVerticalApertureAttr(wide / camera.aspect)
    prim.CreateFocalLengthAttr(0.5 * wide / camera.aspect / np.tan(0.5 * camera.height_rad))
    near, far = METRES * camera.near_cm, METRES * camera.far_cm
    prim.CreateClippingRangeAttr(Gf.Vec2f(near, far))
    move(prim, to_metres(camera.position, WORLD_Y_UP), world_rotations(camera.rotation))
