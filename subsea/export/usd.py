"""USD stages of fishes: units, meshes, motion, materials and files; and the stage of a species.

Units are metres, y is up and the head of a fish along +z, as in glTF. Body and fins are separate
meshes, because only fins are two-sided; transparent faces of the body, such as those of the tail,
are a subset.

The stage of a species has points and normals in every frame. All clips follow one another on the
time line; `customLayerData` holds their first and last frames. Needs the extra `usd`.
"""

import errno
import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdShade, UsdUtils, Vt

from subsea.base.arrays import Array, Bytes
from subsea.base.errors import TransientError, UserError
from subsea.base.files import partial_folder, replacing
from subsea.export.clips import (
    Clip,
    Model,
    bake_root,
    first_frames,
    transparent_triangles,
)
from subsea.export.conventions import Y_UP, copyright_line, rotate_quaternions, sheet_png, to_metres
from subsea.export.skin_material import roughness

SOLID, CLEAR = "solid", "clear"  # materials
ZIP_EPOCH_S = 315_619_200  # 1980-01-02, after the first day that a package can hold


class MeshPart(NamedTuple):
    """A separate mesh of some vertices and their triangles."""

    name: str
    vertices: slice
    triangles: NDArray[np.integer[Any]]
    two_sided: bool


def set_up(stage: Any, fps: float, last: int, species: Iterable[str], **notes: Any) -> None:
    """Set axes, units, time codes and licence of a stage with the frames 0 to `last`.

    `species` names the species in it. `notes` go to its custom data.
    """
    layer = stage.GetRootLayer()
    layer.documentation = copyright_line(species)
    layer.customLayerData = {"copyright": layer.documentation} | notes

    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(fps)
    stage.SetFramesPerSecond(fps)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(last)


def move(prim: Any, place: Array, rotation: Array, first: int = 0) -> None:
    """Set translation (T, 3), m, and orientation (T, 4) of frames from `first` on."""
    # OpenUSD uses an arc cosine: single precision would be too coarse.
    way, turn = prim.AddTranslateOp(), prim.AddOrientOp(UsdGeom.XformOp.PrecisionDouble)
    for k, (there, (w, *axis)) in enumerate(zip(place, rotation, strict=True)):
        way.Set(Gf.Vec3d(*map(float, there)), first + k)
        turn.Set(Gf.Quatd(float(w), Gf.Vec3d(*map(float, axis))), first + k)


def skin_pictures(model: Model) -> dict[str, Bytes]:
    """Return the textures of a species by their file names: its colours first, then its scales."""
    scales = {} if model.scales is None else {f"{model.name}_normal.png": model.scales}
    return {f"{model.name}_basecolor.png": model.sheet} | scales


def skin_materials(stage: Any, folder: Any, model: Model, textures: str = ".") -> dict[str, Any]:
    """Define both materials of a species under the path `folder`; `textures` is their folder."""
    files, rough = [f"{textures}/{name}" for name in skin_pictures(model)], roughness(model)
    return {
        name: _skin_material(stage, folder.AppendChild(name), files, rough, name == CLEAR)
        for name in (SOLID, CLEAR)
    }


def skin_meshes(
    stage: Any, root: Any, model: Model, looks: dict[str, Any]
) -> list[tuple[Any, MeshPart]]:
    """Define body and fins at rest under the path `root`, with their materials."""
    body, fins = model.triangles[: model.body], model.triangles[model.body :] - model.solid
    meshes = []
    for part in (
        MeshPart("body", slice(0, model.solid), body, False),
        MeshPart("fins", slice(model.solid, None), fins, True),
    ):
        if len(part.triangles):
            mesh = _rest_mesh(stage, root.AppendChild(part.name), model, part)
            bind(mesh, looks[CLEAR if part.two_sided else SOLID])
            if not part.two_sided:
                divide(mesh, transparent_triangles(model)[: model.body], looks)
            meshes.append((mesh, part))
    return meshes


def animate(
    mesh: Any, part: MeshPart, shapes: Iterable[tuple[Array, Array]], first: int = 0
) -> None:
    """Set points, normals and extent in each frame of `shapes`: points, cm, and normals (n, 3)."""
    points, normals, extent = mesh.GetPointsAttr(), mesh.GetNormalsAttr(), mesh.GetExtentAttr()
    for frame, (where, ways) in enumerate(shapes, first):
        values = vectors(to_metres(where[part.vertices], Y_UP))
        points.Set(values, frame)
        normals.Set(vectors(ways[part.vertices] @ Y_UP.T), frame)
        extent.Set(UsdGeom.PointBased.ComputeExtent(values), frame)


def still_mesh(
    stage: Any, path: Any, points: Array, normals: Array, triangles: NDArray[Any], two_sided: bool
) -> Any:
    """Define a mesh of points (n, 3), metres, normals (n, 3) and triangles (m, 3)."""
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(triangles), 3, np.int32)))
    corners = np.ascontiguousarray(triangles, np.int32).ravel()
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(corners))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDoubleSidedAttr(two_sided)
    mesh.CreatePointsAttr(vectors(points))
    mesh.CreateNormalsAttr(vectors(normals))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    mesh.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(mesh.GetPointsAttr().Get()))
    return mesh


def _rest_mesh(stage: Any, path: Any, model: Model, part: MeshPart) -> Any:
    """Define a part of a model at rest, with its texture coordinates."""
    points = to_metres(model.rest[part.vertices], Y_UP)
    normals = model.normals[part.vertices] @ Y_UP.T
    mesh = still_mesh(stage, path, points, normals, part.triangles, part.two_sided)
    places = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex
    )
    places.Set(Vt.Vec2fArray.FromNumpy(np.asarray(model.uv[part.vertices], np.float32)))
    return mesh


def preview_surface(stage: Any, path: Any, roughness: float) -> tuple[Any, Any]:
    """Define a material; return it and its UsdPreviewSurface."""
    material = UsdShade.Material.Define(stage, path)
    surface = UsdShade.Shader.Define(stage, path.AppendChild("surface"))
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(roughness)
    output = surface.CreateOutput("surface", Sdf.ValueTypeNames.Token)
    material.CreateSurfaceOutput().ConnectToSource(output)
    return material, surface


def primvar_reader(stage: Any, path: Any, name: str, size: int) -> Any:
    """Define a shader that reads vectors of a primvar of a mesh; return its output."""
    names = Sdf.ValueTypeNames
    reader = UsdShade.Shader.Define(stage, path)
    reader.CreateIdAttr(f"UsdPrimvarReader_float{size}")
    reader.CreateInput("varname", names.String).Set(name)
    return reader.CreateOutput("result", names.Float2 if size == 2 else names.Float3)


def _texture(stage: Any, path: Any, file: str, space: str, places: Any) -> Any:
    """Define a shader that reads a texture file of a colour space at `places`."""
    names = Sdf.ValueTypeNames
    texture = UsdShade.Shader.Define(stage, path)
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", names.Asset).Set(Sdf.AssetPath(file))
    texture.CreateInput("sourceColorSpace", names.Token).Set(space)
    for side in ("wrapS", "wrapT"):
        texture.CreateInput(side, names.Token).Set("clamp")
    texture.CreateInput("st", names.Float2).ConnectToSource(places)
    return texture


def _skin_material(stage: Any, path: Any, files: list[str], rough: float, clear: bool) -> Any:
    """Define a material with the first texture as colour and, if `clear`, as opacity.

    The second texture, if there is one, is the normal map of what is not clear.
    """
    names = Sdf.ValueTypeNames
    material, surface = preview_surface(stage, path, rough)
    places = primvar_reader(stage, path.AppendChild("places"), "st", 2)
    texture = _texture(stage, path.AppendChild("sheet"), files[0], "sRGB", places)
    if len(files) > 1 and not clear:
        relief = _texture(stage, path.AppendChild("scales"), files[1], "raw", places)
        relief.CreateInput("scale", names.Float4).Set(Gf.Vec4f(2.0, 2.0, 2.0, 1.0))
        relief.CreateInput("bias", names.Float4).Set(Gf.Vec4f(-1.0, -1.0, -1.0, 0.0))
        turned = relief.CreateOutput("rgb", names.Float3)
        surface.CreateInput("normal", names.Normal3f).ConnectToSource(turned)
    colour = texture.CreateOutput("rgb", names.Float3)
    surface.CreateInput("diffuseColor", names.Color3f).ConnectToSource(colour)
    if clear:
        opacity = texture.CreateOutput("a", names.Float)
        surface.CreateInput("opacity", names.Float).ConnectToSource(opacity)
    return material


def bind(thing: Any, material: Any) -> None:
    """Bind a material to a mesh or a subset of its faces."""
    UsdShade.MaterialBindingAPI.Apply(thing.GetPrim()).Bind(material)


def divide(mesh: Any, clear: NDArray[np.bool_], looks: dict[str, Any]) -> None:
    """Bind materials to subsets of transparent and solid faces, if a mesh has both.

    Some importers ignore the material of a mesh with subsets, so all faces are in one.
    """
    if not clear.any():
        return
    binding = UsdShade.MaterialBindingAPI(mesh)
    for name, chosen in ((SOLID, ~clear), (CLEAR, clear)):
        faces = Vt.IntArray.FromNumpy(np.flatnonzero(chosen).astype(np.int32))
        bind(binding.CreateMaterialBindSubset(name, faces), looks[name])
    binding.SetMaterialBindSubsetsFamilyType(UsdGeom.Tokens.partition)


def vectors(values: Array) -> Any:
    """Convert rows (n, 3) to a USD array."""
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(values, np.float32))


def define(stage: Any, path: Any, kind: str) -> Any:
    """Define a prim of a kind: `assembly`, `group`, or `component` for one model such as a fish."""
    prim = UsdGeom.Xform.Define(stage, path)
    Usd.ModelAPI(prim).SetKind(kind)
    return prim


def identifier(name: str) -> str:
    """Return a name that USD accepts."""
    return str(Tf.MakeValidIdentifier(name))


@contextmanager
def stage_file(path: Path) -> Iterator[Path]:
    """Give a place for a stage, which replaces `path` once it is whole.

    UserError if the library cannot write it.
    """
    with replacing(path) as part, partial_folder(part) as folder:
        plain = folder / path.name  # the library needs the suffix
        try:
            yield plain
            plain.replace(part)
        except Tf.ErrorException as fault:
            reason = fault.args[0].commentary
            kind = TransientError if os.strerror(errno.ENOSPC) in reason else UserError
            raise kind(f"cannot write ({reason})", file=path) from fault


def write_package(out: Path, fill: Callable[[Path], Path]) -> None:
    """Write the package `out` of the files that `fill` writes into a folder.

    `fill` returns the stage there. UserError if the package cannot be written. Equal content gives
    equal bytes.
    """
    with stage_file(out) as part:
        folder = part.with_name("content")
        folder.mkdir()
        stage = fill(folder)
        for path in folder.iterdir():  # a package holds these times
            os.utime(path, (ZIP_EPOCH_S, ZIP_EPOCH_S))
        if not UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(stage)), str(part)):
            raise UserError("cannot write the package", file=out)


def usd_files(folder: Path, name: str) -> list[Path]:
    """Return the files that `write_usd` may write: the stage and its textures."""
    return [folder / f"{name}{end}" for end in (".usdc", "_basecolor.png", "_normal.png")]


def add_points(
    stage: Any, path: Any, model: Model, clips: list[Clip], looks: dict[str, Any], baked: bool
) -> None:
    """Define body and fins under `path`, with points and normals in every frame of all clips."""
    clips = [bake_root(clip) for clip in clips] if baked else clips
    for mesh, part in skin_meshes(stage, path, model, looks):
        for clip, start in zip(clips, first_frames(clips), strict=True):
            animate(mesh, part, zip(clip.points, clip.normals, strict=True), start)


def write_usd(
    folder: Path, model: Model, clips: list[Clip], baked: bool,
    add_meshes: Callable[[Any, Any, Model, list[Clip], dict[str, Any], bool], None] = add_points,
) -> list[Path]:  # fmt: skip
    """Write the stage NAME.usdc and its textures into `folder`; return the files.

    `add_meshes` gives the model's prim its meshes and their motion. The motion of the root is that
    of the prim, or `baked` into theirs. UserError if a file cannot be written.
    """
    file = folder / f"{model.name}.usdc"
    stage = Usd.Stage.CreateInMemory(file.name)
    first = first_frames(clips)
    last = [start + len(clip.points) - 1 for start, clip in zip(first, clips, strict=True)]
    spans = {
        clip.name: {"start": start, "end": end, "cyclic": clip.cyclic}
        for clip, start, end in zip(clips, first, last, strict=True)
    }
    set_up(stage, clips[0].fps, last[-1], [model.name], clips=spans)
    root = define(stage, f"/{identifier(model.name)}", "component")
    stage.SetDefaultPrim(root.GetPrim())
    if not baked:
        place = np.concatenate([clip.position for clip in clips])
        turn = np.concatenate([clip.rotation for clip in clips])
        move(root, to_metres(place, Y_UP), rotate_quaternions(turn, Y_UP))
    folder_of_looks = root.GetPath().AppendChild("materials")
    looks = skin_materials(stage, folder_of_looks, model)
    add_meshes(stage, root.GetPath(), model, clips, looks, baked)
    pictures = {folder / name: pixels for name, pixels in skin_pictures(model).items()}
    with ExitStack() as all_or_none:
        for path, pixels in pictures.items():
            all_or_none.enter_context(replacing(path)).write_bytes(sheet_png(pixels))
        stage.GetRootLayer().Export(str(all_or_none.enter_context(stage_file(file))))
    return [file, *pictures]
