"""Parts of USD stages that species and scenes share: units, meshes, motion and materials.

Units are metres, y is up and the head of a fish along +z, as in glTF.

Packages of a USD stage and its textures: .usdz.
"""

import os
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.base.files import replacing
from subsea.export.axes import Y_UP, to_metres
from subsea.export.clips import ROUGHNESS, Model, transparent_triangles
from subsea.export.licence import copyright_line

SOLID, CLEAR = "solid", "clear"  # materials


class MeshPart(NamedTuple):
    """A separate mesh of some vertices and their triangles."""

    name: str
    vertices: slice
    triangles: NDArray[np.integer[Any]]
    two_sided: bool


def set_up(stage: Any, fps: float, last: int, species: Iterable[str], **notes: Any) -> None:
    """Axes, units, time codes and licence of a stage with the frames 0 to `last`.

    `species` are those in it. `notes` go to its custom data.
    """
    from pxr import UsdGeom

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
    """Time samples of translation (T, 3), m, and orientation (T, 4), from the frame `first` on."""
    from pxr import Gf, UsdGeom

    # OpenUSD uses an arc cosine: single precision would be too coarse.
    way, turn = prim.AddTranslateOp(), prim.AddOrientOp(UsdGeom.XformOp.PrecisionDouble)
    for k, (there, (w, *axis)) in enumerate(zip(place, rotation, strict=True)):
        way.Set(Gf.Vec3d(*map(float, there)), first + k)
        turn.Set(Gf.Quatd(float(w), Gf.Vec3d(*map(float, axis))), first + k)


def skin_materials(stage: Any, folder: Any, sheet: str) -> dict[str, Any]:
    """The two materials of a species under the path `folder`; `sheet` is its texture's file."""
    return {
        name: skin_material(stage, folder.AppendChild(name), sheet, name == CLEAR)
        for name in (SOLID, CLEAR)
    }


def skin_meshes(
    stage: Any, root: Any, model: Model, looks: dict[str, Any]
) -> list[tuple[Any, MeshPart]]:
    """Body and fins at rest under the path `root`, with their materials."""
    body, fins = model.triangles[: model.body], model.triangles[model.body :] - model.solid
    found = []
    for part in (
        MeshPart("body", slice(0, model.solid), body, False),
        MeshPart("fins", slice(model.solid, None), fins, True),
    ):
        if len(part.triangles):
            mesh = rest_mesh(stage, root.AppendChild(part.name), model, part)
            bind(mesh, looks[CLEAR if part.two_sided else SOLID])
            if not part.two_sided:
                divide(mesh, transparent_triangles(model)[: model.body], looks)
            found.append((mesh, part))
    return found


def animate(
    mesh: Any, part: MeshPart, shapes: Iterable[tuple[Array, Array]], first: int = 0
) -> None:
    """Points, normals and extent in each frame of `shapes`: points, cm, and normals (n, 3)."""
    from pxr import UsdGeom

    points, normals, extent = mesh.GetPointsAttr(), mesh.GetNormalsAttr(), mesh.GetExtentAttr()
    for frame, (where, ways) in enumerate(shapes, first):
        values = vectors(to_metres(where[part.vertices], Y_UP))
        points.Set(values, frame)
        normals.Set(vectors(ways[part.vertices] @ Y_UP.T), frame)
        extent.Set(UsdGeom.PointBased.ComputeExtent(values), frame)


def rest_mesh(stage: Any, path: Any, model: Model, part: MeshPart) -> Any:
    """The mesh at rest: all attributes that are constant."""
    from pxr import Sdf, UsdGeom, Vt

    mesh = UsdGeom.Mesh.Define(stage, path)
    count = len(part.triangles)
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(count, 3, np.int32)))
    corners = np.ascontiguousarray(part.triangles, np.int32).ravel()
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(corners))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDoubleSidedAttr(part.two_sided)
    mesh.CreatePointsAttr(vectors(to_metres(model.rest[part.vertices], Y_UP)))
    mesh.CreateNormalsAttr(vectors(model.normals[part.vertices] @ Y_UP.T))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    places = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex
    )
    places.Set(Vt.Vec2fArray.FromNumpy(np.asarray(model.uv[part.vertices], np.float32)))
    mesh.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(mesh.GetPointsAttr().Get()))
    return mesh


def skin_material(stage: Any, path: Any, sheet: str, clear: bool) -> Any:
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


def bind(thing: Any, material: Any) -> None:
    """Bind a material to a mesh or a subset of its faces."""
    from pxr import UsdShade

    UsdShade.MaterialBindingAPI.Apply(thing.GetPrim()).Bind(material)


def divide(mesh: Any, clear: NDArray[np.bool_], looks: dict[str, Any]) -> None:
    """Bind materials to subsets of transparent and solid faces, if a mesh has both.

    Some importers ignore the material of a mesh with subsets, so all faces are in one.
    """
    from pxr import UsdGeom, UsdShade, Vt

    if not clear.any():
        return
    binding = UsdShade.MaterialBindingAPI(mesh)
    for name, those in ((SOLID, ~clear), (CLEAR, clear)):
        faces = Vt.IntArray.FromNumpy(np.flatnonzero(those).astype(np.int32))
        bind(binding.CreateMaterialBindSubset(name, faces), looks[name])
    binding.SetMaterialBindSubsetsFamilyType(UsdGeom.Tokens.partition)


def vectors(values: Array) -> Any:
    """Rows (n, 3) as a USD array."""
    from pxr import Vt

    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(values, np.float32))


def group(stage: Any, path: Any) -> Any:
    """A prim that holds models."""
    from pxr import Kind, Usd, UsdGeom

    prim = UsdGeom.Xform.Define(stage, path)
    Usd.ModelAPI(prim).SetKind(Kind.Tokens.group)
    return prim


def component(stage: Any, path: Any) -> Any:
    """A prim that is one model, such as a fish."""
    from pxr import Kind, Usd, UsdGeom

    prim = UsdGeom.Xform.Define(stage, path)
    Usd.ModelAPI(prim).SetKind(Kind.Tokens.component)
    return prim


def identifier(name: str) -> str:
    """A name that USD accepts."""
    from pxr import Tf

    return str(Tf.MakeValidIdentifier(name))


ZIP_EPOCH_S = 315_619_200  # 1980-01-02, after the first day that a package can hold


def write_package(out: Path, fill: Callable[[Path], Path]) -> None:
    """Write the package `out` of what `fill` writes into a folder; it returns the stage there.

    UserError if it cannot be written. The same content gives the same bytes.
    """
    from pxr import Sdf, UsdUtils

    with (
        replacing(out) as part,
        tempfile.TemporaryDirectory(prefix=part.name, dir=part.parent) as name,
    ):
        folder = Path(name)
        stage = fill(folder)
        for path in folder.iterdir():  # a package holds these times
            os.utime(path, (ZIP_EPOCH_S, ZIP_EPOCH_S))
        package = folder / "package.usdz"
        if not UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(stage)), str(package)):
            raise UserError("cannot write the package", file=out)
        package.replace(part)
