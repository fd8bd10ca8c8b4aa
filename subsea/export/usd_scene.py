"""Export a scene as a USD stage: fishes, camera, and what does not move.

    /SCENE/camera                     UsdGeomCamera
    /SCENE/fishes/fusilier_003        its path; body and fins with points in every frame
    /SCENE/schools/fusilier           with --poses: a point instancer instead of the fishes
    /SCENE/sand, stone, corals, seaweed   seaweed is a SkelRoot for each kind
    /SCENE/materials

Units are metres, y is up and the head of a fish along +z. Frame k is that of `subsea film` with the
same options. Fishes are written one after another, so memory does not grow with their number.
"""

from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdSkel, Vt

from subsea.base.arrays import Array, Ints
from subsea.base.errors import UserError
from subsea.base.file_kinds import USD, FileKind, check_result, signed
from subsea.base.files import replacing
from subsea.base.progress import progress, say
from subsea.export import usd
from subsea.export.conventions import (
    METRES,
    WORLD_Y_UP,
    Y_UP,
    sheet_png,
    to_metres,
    world_rotations,
)
from subsea.export.options import SceneOptions, check_options
from subsea.export.plant_motion import PlantMotion, key_frames
from subsea.export.scene import Scene, SceneCamera, SceneExtent, SceneMesh, SceneWriter, StillExtent
from subsea.export.usd_skeleton import bend
from subsea.geometry.rotation import from_matrix


def add_statics(stage: Any, at: Any, statics: tuple[SceneMesh, ...]) -> None:
    """Add sand, stone, corals and seaweed; a mesh at several places is instanced."""
    if not statics:
        return
    look = _colour_material(stage, at.AppendPath("materials/ground"))
    for name in dict.fromkeys(static.group for static in statics):
        usd.define(stage, at.AppendChild(name), "group")
    for static in statics:
        path = at.AppendPath(f"{static.group}/{usd.identifier(static.name)}")
        if static.motion is not None:
            prim = UsdSkel.Root.Define(stage, path)
            mesh = _coloured_mesh(stage, path.AppendChild("mesh"), static, static.tints[0])
            usd.bind(mesh, look)
            prim.CreateExtentAttr(_reach(static, static.motion))
            bend(stage, prim, mesh, static.motion, usd.identifier(static.name))
            continue
        if len(static.places) == 1:
            prim = usd.define(stage, path, "component")
            _place(prim, static.places[0])
            usd.bind(_coloured_mesh(stage, path.AppendChild("mesh"), static, static.tints[0]), look)
            continue
        kept = at.AppendPath(f"{static.group}/prototypes/{usd.identifier(static.name)}")
        folder = UsdGeom.Scope.Define(stage, kept.GetParentPath())
        folder.GetPrim().SetSpecifier(Sdf.SpecifierClass)  # not drawn itself
        prototype = usd.define(stage, kept, "component")
        mesh = _coloured_mesh(stage, kept.AppendChild("mesh"), static, static.tints.mean(axis=0))
        usd.bind(mesh, look)
        for k, place in enumerate(static.places):
            prim = UsdGeom.Xform.Define(stage, path.GetParentPath().AppendChild(f"{path.name}_{k}"))
            prim.GetPrim().GetInherits().AddInherit(prototype.GetPath())
            prim.GetPrim().SetInstanceable(True)
            _place(prim, place)


def _reach(static: SceneMesh, motion: PlantMotion) -> Any:
    """Return the bounds of a mesh in all its motion."""
    points = to_metres(static.points, WORLD_Y_UP)
    most = METRES * float(np.abs(motion.shifts).max())
    return usd.vectors(np.stack([points.min(axis=0) - most, points.max(axis=0) + most]))


def _place(prim: Any, place: Array) -> None:
    """Set the transformation (4, 4) from the axes of a mesh, in cm and z up, to the stage."""
    turn = np.eye(4)
    turn[:3, :3] = WORLD_Y_UP
    whole = turn @ place @ turn.T
    whole[:3, 3] *= METRES
    if not np.allclose(whole, np.eye(4)):
        prim.AddTransformOp().Set(Gf.Matrix4d(*map(float, whole.T.ravel())))


def _coloured_mesh(stage: Any, path: Any, static: SceneMesh, tint: Array) -> Any:
    """Define a mesh that does not move, with colours at its vertices times `tint` (3,)."""
    points, normals = to_metres(static.points, WORLD_Y_UP), static.normals @ WORLD_Y_UP.T
    mesh = usd.still_mesh(stage, path, points, normals, static.triangles, static.two_sided)
    colours = mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.vertex)
    colours.Set(usd.vectors(np.clip(static.colors * tint, 0.0, 1.0)))
    return mesh


def _colour_material(stage: Any, path: Any) -> Any:
    """Define a material with the display colours of a mesh."""
    material, surface = usd.preview_surface(stage, path, 1.0)
    colours = usd.primvar_reader(stage, path.AppendChild("colours"), "displayColor", 3)
    surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(colours)
    return material


SAMPLES = 6000  # poses among which those to bake are chosen
VERTICES = 80  # by which poses are compared
ROUNDS = 6  # of moving each chosen pose to the middle of those that it stands for
PACKAGE = signed("a USD package (.usdz)", b"PK\x03\x04")
KINDS: dict[str, FileKind] = {".usdc": USD, ".usdz": PACKAGE}
SAVED_BYTES = 200_000_000  # of time samples, after which they go to the disk
FRAME_BYTES = 24  # of a vertex: point and normal
SHEET_BYTES = 680_000  # of the textures of a species
STILL_BYTES, COPY_BYTES = (36, 12), 250  # of a vertex and a triangle at rest, and of a copy
BINDING, JOINT = 16, 12  # of a vertex that follows joints, and of a key of a joint
SUN_DEG, SUN_INTENSITY = 0.53, 3.0
SENSOR = 0.36, 0.01  # width of a film's frame of 36 mm, and 1 mm, in tenths of a metre


class BakedPoses(NamedTuple):
    """P poses, and which of them each of N fishes has in each of T frames."""

    fishes: Ints  # (N,) places in `Scene.fishes`
    points: Array  # (P, n, 3) cm, body axes, at the size of the model
    normals: Array  # (P, n, 3)
    pose: Ints  # (T, N) index, -1 while a fish is not in the sea
    rms_percent: float  # distance of vertices from where they should be, of the body length
    most_percent: float


def check(out: Path, options: SceneOptions) -> None:
    """Check the options and the output path before any work."""
    check_options(options, "usd")
    if out.suffix.lower() not in KINDS:
        raise UserError("expected a name that ends in .usdc or .usdz", file=out)
    check_result(out, KINDS[out.suffix.lower()], options.force)


def estimate(extent: SceneExtent, options: SceneOptions) -> int:
    """Estimate the bytes of the fishes, their textures, and what does not move."""
    if options.poses is None:
        moving = extent.fishes * extent.frames * extent.vertices * FRAME_BYTES
    else:
        moving = extent.species * options.poses * extent.vertices * FRAME_BYTES
        moving += extent.fishes * extent.frames * 56  # place, turn, size and pose
    known = extent.still or StillExtent()
    vertices, triangles = known.shapes
    still = STILL_BYTES[0] * vertices + STILL_BYTES[1] * triangles + COPY_BYTES * known.copies
    still += BINDING * known.bent + JOINT * known.joints * len(
        key_frames(extent.frames, extent.fps)
    )
    return moving + still + extent.species * SHEET_BYTES


def write(scene: Scene, out: Path, options: SceneOptions) -> list[Path]:
    """Write the stage with its textures, or a package with all of it; return the files."""
    if out.suffix.lower() == ".usdz":
        usd.write_package(out, lambda folder: _fill_package(scene, folder, options))
        return [out]
    textures = f"{out.stem}_textures"
    files = []
    with ExitStack() as all_or_none:
        for model in scene.models:
            for name, pixels in usd.skin_pictures(model).items():
                files.append(out.parent / textures / name)
                picture = all_or_none.enter_context(replacing(files[-1]))
                picture.write_bytes(sheet_png(pixels))
        _write_stage(scene, all_or_none.enter_context(usd.stage_file(out)), textures, options)
    return [out, *files]


WRITER = SceneWriter(check, estimate, write)


def _fill_package(scene: Scene, folder: Path, options: SceneOptions) -> Path:
    """Write a stage and its textures into `folder`; return the stage."""
    for model in scene.models:
        for name, pixels in usd.skin_pictures(model).items():
            (folder / name).write_bytes(sheet_png(pixels))
    stage = folder / f"{usd.identifier(scene.name)}.usdc"
    _write_stage(scene, stage, ".", options)
    return stage


def _write_stage(scene: Scene, path: Path, textures: str, options: SceneOptions) -> None:
    """Write the stage `path`; `textures` is the folder of its textures, as seen from there."""
    stage = Usd.Stage.CreateNew(str(path))
    usd.set_up(
        stage, scene.fps, scene.frames - 1, [model.name for model in scene.models],
        title=scene.title, seed=scene.seed, start_s=scene.start_s, loop=scene.seamless,
        light={
            name: Vt.DoubleArray(value) if isinstance(value, list) else value
            for name, value in scene.light().items()
        },
    )  # fmt: skip
    root = usd.define(stage, f"/{usd.identifier(scene.name)}", "assembly")
    stage.SetDefaultPrim(root.GetPrim())
    at = root.GetPath()
    _add_camera(stage, at.AppendChild("camera"), scene.camera)
    looks = []
    UsdGeom.Scope.Define(stage, at.AppendChild("materials"))
    for model in scene.models:
        folder = UsdGeom.Scope.Define(
            stage, at.AppendPath(f"materials/{usd.identifier(model.name)}")
        )
        where = "." if textures == "." else f"./{textures}"
        looks.append(usd.skin_materials(stage, folder.GetPath(), model, where))
    add_statics(stage, at, scene.statics)
    _add_sun(stage, at.AppendChild("sun"), np.array(scene.light()["toSun"]))
    if options.poses is None:
        _add_fishes(stage, at.AppendChild("fishes"), scene, looks)
    else:
        _add_schools(stage, at.AppendChild("schools"), scene, looks, options.poses)
    stage.Save()


def _add_sun(stage: Any, path: Any, toward: Array) -> None:
    """Define the sun as it shines into the water; a light of USD shines along its -z axis."""
    sun = UsdLux.DistantLight.Define(stage, path)
    sun.CreateAngleAttr(SUN_DEG)
    sun.CreateIntensityAttr(SUN_INTENSITY)
    across = np.cross((0.0, 1.0, 0.0) if abs(toward[1]) < 0.999 else (1.0, 0.0, 0.0), toward)
    across /= np.linalg.norm(across)
    w, *axis = from_matrix(np.array([across, np.cross(toward, across), toward]).T)
    turn = sun.AddOrientOp(UsdGeom.XformOp.PrecisionDouble)
    turn.Set(Gf.Quatd(float(w), Gf.Vec3d(*map(float, axis))))


def _add_fishes(stage: Any, at: Any, scene: Scene, looks: list[dict[str, Any]]) -> None:
    """Add each fish with its path, and its meshes with points in every frame."""
    usd.define(stage, at, "group")
    pending = 0
    with progress(len(scene.fishes), "fish") as done:
        for number, fish in enumerate(scene.fishes):
            model = scene.models[fish.model]
            prim = usd.define(stage, at.AppendChild(usd.identifier(fish.name)), "component")
            inside = slice(fish.first, fish.last + 1)
            place = to_metres(scene.position[inside, number], WORLD_Y_UP)
            usd.move(prim, place, world_rotations(scene.rotation[inside, number], Y_UP), fish.first)
            _hide(prim, fish.first, fish.last, scene.frames)
            _describe(prim, fish.length_cm, fish.number, fish.tint)
            meshes = usd.skin_meshes(stage, prim.GetPath(), model, looks[fish.model])
            for first, points, normals in scene.parts(number):
                for mesh, part in meshes:
                    usd.animate(mesh, part, zip(fish.scale * points, normals, strict=True), first)
                pending += points.size // 3 * FRAME_BYTES
                if pending > SAVED_BYTES:
                    stage.Save()
                    pending = 0
            done()


def _describe(prim: Any, length_cm: float, number: int, tint: Array) -> None:
    prim.GetPrim().SetCustomDataByKey("length_cm", float(length_cm))
    prim.GetPrim().SetCustomDataByKey("number", int(number))
    primvar = UsdGeom.PrimvarsAPI(prim).CreatePrimvar("tint", Sdf.ValueTypeNames.Color3f)
    primvar.Set(Gf.Vec3f(*map(float, tint)))


def _hide(prim: Any, first: int, last: int, frames: int) -> None:
    """Show a fish only in the frames `first` to `last`."""
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
    """Add a point instancer for each species, with `number` poses baked as prototypes."""
    usd.define(stage, at, "group")
    for kind, model in enumerate(scene.models):
        poses = bake_poses(scene, kind, number)
        prim = at.AppendChild(usd.identifier(model.name))
        instancer = _instancer(stage, prim, scene, poses)
        for k, (points, normals) in enumerate(zip(poses.points, poses.normals, strict=True)):
            path = prim.AppendPath(f"poses/pose_{k:03}")
            usd.define(stage, path, "component")
            instancer.GetPrototypesRel().AddTarget(path)
            posed = model._replace(rest=points, normals=normals)
            usd.skin_meshes(stage, path, posed, looks[kind])
        say(
            f"{model.name}: {len(poses.points)} poses; vertices are off by "
            f"{poses.rms_percent:.2f}% of the body length (rms), {poses.most_percent:.2f}% at most"
        )


def _instancer(stage: Any, path: Any, scene: Scene, poses: BakedPoses) -> Any:
    """Add the point instancer of the fishes of a model, without its prototypes."""
    instancer = UsdGeom.PointInstancer.Define(stage, path)
    UsdGeom.Scope.Define(stage, path.AppendChild("poses"))
    fishes = [scene.fishes[k] for k in poses.fishes]
    instancer.CreateIdsAttr(Vt.Int64Array([fish.number for fish in fishes]))
    size = np.repeat(np.array([fish.scale for fish in fishes], np.float32)[:, None], 3, axis=1)
    instancer.CreateScalesAttr(usd.vectors(size))
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
        place.Set(usd.vectors(there), frame)
        imaginary_first = np.ascontiguousarray(facing[:, [1, 2, 3, 0]], np.float32)
        turn.Set(Vt.QuatfArray.FromNumpy(imaginary_first), frame)
        coarse.Set(Vt.QuathArray.FromNumpy(imaginary_first.astype(np.float16)), frame)
        which.Set(Vt.IntArray.FromNumpy(np.maximum(poses.pose[frame], 0).astype(np.int32)), frame)
        hidden.Set(
            Vt.Int64Array(
                [fish.number for fish, here in zip(fishes, inside, strict=True) if not here]
            ),
            frame,
        )
        shown = there[inside] if inside.any() else there[:1]
        extent.Set(
            usd.vectors(np.stack([shown.min(axis=0) - reach, shown.max(axis=0) + reach])), frame
        )
    return instancer


def _add_camera(stage: Any, path: Any, camera: SceneCamera) -> None:
    """Add the camera of the dive, as that of a film of 36 mm."""
    prim = UsdGeom.Camera.Define(stage, path)
    wide = SENSOR[0]
    prim.CreateHorizontalApertureAttr(wide)
    prim.CreateVerticalApertureAttr(wide / camera.aspect)
    prim.CreateFocalLengthAttr(0.5 * wide / camera.aspect / np.tan(0.5 * camera.height_rad))
    near, far = METRES * camera.near_cm, METRES * camera.far_cm
    prim.CreateClippingRangeAttr(Gf.Vec2f(near, far))
    usd.move(prim, to_metres(camera.position, WORLD_Y_UP), world_rotations(camera.rotation))


def bake_poses(scene: Scene, model: int, number: int) -> BakedPoses:
    """Choose at most `number` poses of the fishes of a model, and the nearest for each frame."""
    fishes = np.array([k for k, fish in enumerate(scene.fishes) if fish.model == model])
    among = len(scene.models[model].rest)
    compared = np.unique(np.linspace(0, among - 1, VERTICES).astype(int))
    frames = sum(scene.fishes[k].last - scene.fishes[k].first + 1 for k in fishes)
    stride = max(frames // SAMPLES, 1)
    samples, where = [], []
    seen = 0
    for fish in fishes.tolist():
        for first, points, _ in scene.parts(fish):
            chosen = np.flatnonzero((seen + np.arange(len(points))) % stride == 0)
            samples.append(points[chosen][:, compared].reshape(len(chosen), -1))
            where += [(fish, first + int(k)) for k in chosen]
            seen += len(points)
    picked = _representatives(np.concatenate(samples), number)
    whole = [scene.points(fish, frame, frame) for fish, frame in (where[k] for k in picked)]
    sizes = [scene.fishes[where[k][0]].scale for k in picked]
    points = np.array([shape[0][0] / size for shape, size in zip(whole, sizes, strict=True)])
    normals = np.array([shape[1][0] for shape in whole])
    known = points[:, compared].reshape(len(points), -1)
    pose = np.full((scene.frames, len(fishes)), -1, np.int64)
    square, most, count = 0.0, 0.0, 0
    for column, fish in enumerate(fishes.tolist()):
        for first, shapes, _ in scene.parts(fish):
            nearest = _nearest(shapes[:, compared].reshape(len(shapes), -1), known)
            pose[first : first + len(shapes), column] = nearest
            off = ((shapes - points[nearest]) ** 2).sum(axis=2)
            square, most, count = square + off.sum(), max(most, float(off.max())), count + off.size
    percent = 100.0 / scene.models[model].length_cm
    rms = float(np.sqrt(square / count))
    return BakedPoses(fishes, points, normals, pose, percent * rms, percent * most**0.5)


def _representatives(samples: Array, number: int) -> Ints:
    """Choose at most `number` of the samples (m, d), spread over all of them; return indices.

    The sample farthest from the chosen ones comes next. Then each moves to the middle of its part.
    """
    chosen = [int(_squares(samples, samples.mean(axis=0)[None]).argmin())]
    gap = _squares(samples, samples[chosen])[:, 0]
    while len(chosen) < number and gap.max() > 0.0:
        chosen.append(int(gap.argmax()))
        gap = np.minimum(gap, _squares(samples, samples[chosen[-1:]])[:, 0])
    for _ in range(ROUNDS):
        nearest = _nearest(samples, samples[chosen])
        for k in range(len(chosen)):
            if not len(mine := np.flatnonzero(nearest == k)):  # equal to another to rounding
                continue
            middle = samples[mine].mean(axis=0)
            chosen[k] = int(mine[_squares(samples[mine], middle[None])[:, 0].argmin()])
    return np.array(chosen)


def _squares(rows: Array, others: Array) -> Array:
    """Compute squared distances (m, k) of rows (m, d) and (k, d)."""
    square = (rows**2).sum(axis=1)[:, None] + (others**2).sum(axis=1) - 2.0 * rows @ others.T
    return np.maximum(square, 0.0)


def _nearest(rows: Array, others: Array) -> Ints:
    return np.asarray(_squares(rows, others).argmin(axis=1))
