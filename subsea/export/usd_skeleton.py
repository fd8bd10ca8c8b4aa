"""Skeletons in USD (UsdSkel): joints move the mesh of a species or of seaweed.

The file of a species has a fortieth of the bytes of one with points in every frame, and the errors
of the fit (`skinning.py`).
"""

from typing import Any

import numpy as np
from pxr import Gf, UsdSkel, Vt

from subsea.base.arrays import Array, Ints
from subsea.export.clips import Clip, Model, bake_root
from subsea.export.conventions import WORLD_Y_UP, Y_UP, rotate_quaternions, to_metres
from subsea.export.plant_motion import PlantMotion
from subsea.export.skinning import Joint, Skeleton, clip_motions, local_motion, strongest
from subsea.export.usd import skin_meshes, vectors


def add_skinned(
    stage: Any, prim: Any, model: Model, clips: list[Clip], looks: dict[str, Any], baked: bool,
    rig: Skeleton,
) -> None:  # fmt: skip
    """Define body and fins under the path `prim`, bound to a skeleton with all clips' motion."""
    path = prim.AppendChild("skin")
    root = UsdSkel.Root.Define(stage, path)
    moved = [bake_root(clip) for clip in clips] if baked else clips
    points = np.concatenate([clip.points.reshape(-1, 3) for clip in moved])
    bounds = np.array([points.min(axis=0), points.max(axis=0)])
    corners = to_metres(bounds, Y_UP)
    root.CreateExtentAttr(vectors(np.array([corners.min(axis=0), corners.max(axis=0)])))
    skeleton = UsdSkel.Skeleton.Define(stage, path.AppendChild("skeleton"))
    names, rest = joint_paths(rig.joints), np.array([joint.place for joint in rig.joints])
    parents = np.array([rest[one.parent] if one.parent >= 0 else np.zeros(3) for one in rig.joints])
    skeleton.CreateJointsAttr(names)
    skeleton.CreateBindTransformsAttr(matrices(to_metres(rest, Y_UP)))
    skeleton.CreateRestTransformsAttr(matrices(to_metres(rest - parents, Y_UP)))
    motion = UsdSkel.Animation.Define(stage, path.AppendPath("skeleton/motion"))
    motion.CreateJointsAttr(names)
    motion.CreateScalesAttr(Vt.Vec3hArray([Gf.Vec3h(1.0)] * len(names)))
    ways, turns = motion.CreateTranslationsAttr(), motion.CreateRotationsAttr()
    frame = 0
    for motions in clip_motions(rig, clips, baked):
        turn, place = local_motion(rig.joints, motions)
        for rotations, places in zip(rotate_quaternions(turn, Y_UP), place, strict=True):
            ways.Set(vectors(to_metres(places, Y_UP)), frame)
            turns.Set(Vt.QuatfArray([Gf.Quatf(*map(float, one)) for one in rotations]), frame)
            frame += 1
    binding = UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
    binding.CreateAnimationSourceRel().SetTargets([motion.GetPath()])
    for mesh, part in skin_meshes(stage, path, model, looks):
        _bind(mesh, *strongest(rig.weights[part.vertices]), skeleton.GetPath())


def bend(stage: Any, prim: Any, mesh: Any, motion: PlantMotion, kind: str) -> None:
    """Bind a mesh of seaweed below `prim`, a SkelRoot, to joints, which only shift at its keys."""
    places = to_metres(motion.places, WORLD_Y_UP)
    names = [f"{kind}_{k}" for k in range(len(places))]
    skeleton = UsdSkel.Skeleton.Define(stage, prim.GetPath().AppendChild("skeleton"))
    skeleton.CreateJointsAttr(names)
    for create in (skeleton.CreateBindTransformsAttr, skeleton.CreateRestTransformsAttr):
        create(matrices(places))
    moved = UsdSkel.Animation.Define(stage, skeleton.GetPath().AppendChild("motion"))
    moved.CreateJointsAttr(names)
    moved.CreateScalesAttr(Vt.Vec3hArray([Gf.Vec3h(1.0)] * len(names)))
    moved.CreateRotationsAttr(Vt.QuatfArray([Gf.Quatf(1.0)] * len(names)))
    ways = moved.CreateTranslationsAttr()
    for frame, shifts in zip(motion.frames.tolist(), motion.shifts, strict=True):
        ways.Set(vectors(places + to_metres(shifts, WORLD_Y_UP)), frame)
    binding = UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
    binding.CreateAnimationSourceRel().SetTargets([moved.GetPath()])
    _bind(mesh, motion.joints, motion.weights, skeleton.GetPath())


def joint_paths(joints: list[Joint]) -> list[str]:
    """Return the names of joints in USD, each with those of its parents before it."""
    names: list[str] = []
    for joint in joints:
        names.append(f"{names[joint.parent]}/{joint.name}" if joint.parent >= 0 else joint.name)
    return names


def matrices(places: Array) -> Any:
    """Return the matrices that move the origin to places (J, 3), metres."""
    return Vt.Matrix4dArray(
        [Gf.Matrix4d().SetTranslate(Gf.Vec3d(*map(float, place))) for place in places]
    )


def _bind(mesh: Any, joints: Ints, weights: Array, skeleton: Any) -> None:
    """Bind vertices (n) of a mesh to their joints (n, k), by weights (n, k)."""
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton])
    binding.CreateGeomBindTransformAttr().Set(Gf.Matrix4d(1.0))
    wide = joints.shape[1]
    binding.CreateJointIndicesPrimvar(False, wide).Set(
        Vt.IntArray.FromNumpy(joints.astype(np.int32).ravel())
    )
    binding.CreateJointWeightsPrimvar(False, wide).Set(
        Vt.FloatArray.FromNumpy(weights.astype(np.float32).ravel())
    )
