"""Export a species and its clips as a USD stage with points and normals in every frame.

All clips follow one another on the time line; `customLayerData` holds their first and last frames.
Units are metres, y is up and the head along +z, as in glTF. Body and fins are separate meshes,
because only fins are two-sided; transparent faces of the body, such as the tail's, are a subset.
"""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.core.arrays import Array
from subsea.core.atomic_io import replacing
from subsea.core.errors import UserError
from subsea.core.extras import require
from subsea.export.axes import Y_UP, rotate_quaternions, to_metres
from subsea.export.clips import (
    ROUGHNESS,
    Clip,
    Model,
    bake_root,
    first_frames,
    transparent_triangles,
)
from subsea.export.png import sheet_png

SOLID, CLEAR = "solid", "clear"  # materials


class _MeshPart(NamedTuple):
    """A separate mesh of some vertices and their triangles."""

    name: str
    vertices: slice
    triangles: NDArray[np.integer[Any]]
    two_sided: bool


def usd_files(folder: Path, name: str) -> list[Path]:
    """The files that `write_usd` writes: the stage and its texture."""
    return [folder / f"{name}.usdc", folder / f"{name}_basecolor.png"]


def write_usd(folder: Path, model: Model, clips: list[Clip], baked: bool) -> list[Path]:
    """Write the stage NAME.usdc and its texture into `folder`; return both files.

    The motion of the root is that of the model's prim, or `baked` into the points. UserError
    without usd-core or if a file cannot be written.
    """
    require("usd", "USD")
    from pxr import Tf, Usd

    file, sheet = usd_files(folder, model.name)
    stage = Usd.Stage.CreateInMemory(file.name)
    _fill(stage, sheet.name, model, clips, baked)
    with replacing(sheet) as picture, replacing(file) as part:
        picture.write_bytes(sheet_png(model.sheet))
        # The library needs the suffix, which an unfinished file does not have.
        plain = part.with_name(part.name + file.suffix)
        try:
            stage.GetRootLayer().Export(str(plain))
            plain.replace(part)
        except Tf.ErrorException as fault:
            raise UserError(f"cannot write ({fault.args[0].commentary})", file=file) from fault
        finally:
            plain.unlink(missing_ok=True)
    return [file, sheet]


def _fill(stage: Any, sheet: str, model: Model, clips: list[Clip], baked: bool) -> None:
    """Author the whole stage."""
    from pxr import Kind, Tf, Usd, UsdGeom

    first = first_frames(clips)
    last = [start + len(clip.points) - 1 for start, clip in zip(first, clips, strict=True)]
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(clips[0].fps)
    stage.SetFramesPerSecond(clips[0].fps)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(last[-1])
    stage.GetRootLayer().customLayerData = {
        "clips": {
            clip.name: {"start": start, "end": end, "cyclic": clip.cyclic}
            for clip, start, end in zip(clips, first, last, strict=True)
        }
    }
    root = UsdGeom.Xform.Define(stage, f"/{Tf.MakeValidIdentifier(model.name)}")
    stage.SetDefaultPrim(root.GetPrim())
    Usd.ModelAPI(root).SetKind(Kind.Tokens.component)
    if baked:
        clips = [bake_root(clip) for clip in clips]
    else:
        _move(root, clips, first)
    looks = {
        name: _material(stage, root.GetPath().AppendPath(f"materials/{name}"), sheet, name == CLEAR)
        for name in (SOLID, CLEAR)
    }
    body, fins = model.triangles[: model.body], model.triangles[model.body :] - model.solid
    for part in (
        _MeshPart("body", slice(0, model.solid), body, False),
        _MeshPart("fins", slice(model.solid, None), fins, True),
    ):
        if len(part.triangles):
            mesh = _mesh(stage, root.GetPath().AppendChild(part.name), model, part)
            _animate(mesh, part, clips, first)
            _bind(mesh, looks[CLEAR if part.two_sided else SOLID])
            if not part.two_sided:
                _divide(mesh, transparent_triangles(model)[: model.body], looks)


def _move(root: Any, clips: list[Clip], first: list[int]) -> None:
    """The root's motion as time samples of its translation and orientation."""
    from pxr import Gf, UsdGeom

    # OpenUSD uses an arc cosine: single precision would be too coarse.
    way, turn = root.AddTranslateOp(), root.AddOrientOp(UsdGeom.XformOp.PrecisionDouble)
    for clip, start in zip(clips, first, strict=True):
        there, facing = to_metres(clip.position, Y_UP), rotate_quaternions(clip.rotation, Y_UP)
        for frame, (place, (w, *axis)) in enumerate(zip(there, facing, strict=True)):
            way.Set(Gf.Vec3d(*map(float, place)), start + frame)
            turn.Set(Gf.Quatd(float(w), Gf.Vec3d(*map(float, axis))), start + frame)


def _mesh(stage: Any, path: Any, model: Model, part: _MeshPart) -> Any:
    """The mesh at rest: all attributes that are constant."""
    from pxr import Sdf, UsdGeom, Vt

    mesh = UsdGeom.Mesh.Define(stage, path)
    count = len(part.triangles)
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(count, 3, np.int32)))
    corners = np.ascontiguousarray(part.triangles, np.int32).ravel()
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(corners))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDoubleSidedAttr(part.two_sided)
    mesh.CreatePointsAttr(_vectors(to_metres(model.rest[part.vertices], Y_UP)))
    mesh.CreateNormalsAttr(_vectors(model.normals[part.vertices] @ Y_UP.T))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    places = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex
    )
    places.Set(Vt.Vec2fArray.FromNumpy(np.asarray(model.uv[part.vertices], np.float32)))
    mesh.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(mesh.GetPointsAttr().Get()))
    return mesh


def _animate(mesh: Any, part: _MeshPart, clips: list[Clip], first: list[int]) -> None:
    """Points, normals and extent of every frame of every clip."""
    from pxr import UsdGeom

    points, normals, extent = mesh.GetPointsAttr(), mesh.GetNormalsAttr(), mesh.GetExtentAttr()
    for clip, start in zip(clips, first, strict=True):
        where, ways = clip.points[:, part.vertices], clip.normals[:, part.vertices]
        for frame in range(len(where)):
            values = _vectors(to_metres(where[frame], Y_UP))
            points.Set(values, start + frame)
            normals.Set(_vectors(ways[frame] @ Y_UP.T), start + frame)
            extent.Set(UsdGeom.PointBased.ComputeExtent(values), start + frame)


def _material(stage: Any, path: Any, sheet: str, clear: bool) -> Any:
    """A UsdPreviewSurface with the texture as colour and, if `clear`, as opacity."""
    from pxr import Sdf, UsdShade

    names = Sdf.ValueTypeNames
    material = UsdShade.Material.Define(stage, path)
    surface, texture, places = (
        UsdShade.Shader.Define(stage, path.AppendChild(name))
        for name in ("surface", "sheet", "places")
    )
    places.CreateIdAttr("UsdPrimvarReader_float2")
    places.CreateInput("varname", names.String).Set("st")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", names.Asset).Set(Sdf.AssetPath(f"./{sheet}"))
    texture.CreateInput("sourceColorSpace", names.Token).Set("sRGB")
    for side in ("wrapS", "wrapT"):
        texture.CreateInput(side, names.Token).Set("clamp")
    texture.CreateInput("st", names.Float2).ConnectToSource(
        places.CreateOutput("result", names.Float2)
    )
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("roughness", names.Float).Set(ROUGHNESS)
    surface.CreateInput("diffuseColor", names.Color3f).ConnectToSource(
        texture.CreateOutput("rgb", names.Float3)
    )
    if clear:
        surface.CreateInput("opacity", names.Float).ConnectToSource(
            texture.CreateOutput("a", names.Float)
        )
    material.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", names.Token))
    return material


def _bind(thing: Any, material: Any) -> None:
    from pxr import UsdShade

    UsdShade.MaterialBindingAPI.Apply(thing.GetPrim()).Bind(material)


def _divide(mesh: Any, clear: NDArray[np.bool_], looks: dict[str, Any]) -> None:
    """Bind materials to subsets of transparent and solid faces, if a mesh has both.

    Some importers ignore the material of a mesh with subsets, so all faces are in one.
    """
    from pxr import UsdGeom, UsdShade, Vt

    if not clear.any():
        return
    binding = UsdShade.MaterialBindingAPI(mesh)
    for name, those in ((SOLID, ~clear), (CLEAR, clear)):
        faces = Vt.IntArray.FromNumpy(np.flatnonzero(those).astype(np.int32))
        _bind(binding.CreateMaterialBindSubset(name, faces), looks[name])
    binding.SetMaterialBindSubsetsFamilyType(UsdGeom.Tokens.partition)


def _vectors(values: Array) -> Any:
    """Rows (n, 3) as a USD array."""
    from pxr import Vt

    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(values, np.float32))
