"""Sand, stone, corals and seaweed in a USD stage: coloured meshes, instanced where they repeat."""

from typing import Any

import numpy as np

from subsea.base.arrays import Array
from subsea.export.axes import METRES, WORLD_Y_UP, to_metres
from subsea.export.scene import SceneMesh
from subsea.export.usd_parts import bind, component, group, identifier, vectors


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
