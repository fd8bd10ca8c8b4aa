"""The eyes of a fish, and their camera rig (Tu §6.7, §9.3).

Both eyes lie on the drawn skin, where `fish.paint` paints them, and look along the x axis of the
body frame with the y axis up. They turn together (pan, tilt). A retina is a flat perspective
picture.

A fish does not see its own body (`View.without`): the picture would show the inside of its head.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.fish.skinning import Coupling, place
from subsea.fish.surface import LEFT, RIGHT, SurfacePlan, U, V, rest_control_points
from subsea.geometry.curves import basis_at, dense
from subsea.geometry.rotation import matrix
from subsea.motor.pose import pose_at
from subsea.view.camera import View, axes_of, off_axis
from subsea.view.rig import CameraPose, CameraRig, DisplayPatch, Eye, Rect, views
from subsea.world.world import World

FIELD_DEG = 90.0  # from left to right
NEAR_CM = 0.5  # other fishes may come close
OPENCV = np.diag([1.0, -1.0, -1.0, 1.0])  # from OpenGL's axes of an eye: y up, z backward
SAMPLES = 161  # along and across a flank, to locate the eye


class Gaze(NamedTuple):
    """Direction of both eyes relative to the heading of the fish (Tu §9.3)."""

    pan_deg: float = 0.0  # to its right
    tilt_deg: float = 0.0  # toward its back


AHEAD = Gaze()


class FishEyes(NamedTuple):
    """The eyes of one fish: what is constant about them."""

    fish: int  # index in the world
    weights: Array  # (189,) see `eye_weights`
    half_cm: float  # half the distance between the eyes at rest


def fish_eyes(world: World, fish: int) -> FishEyes:
    """The eyes of a fish of the world."""
    plan = world.species[world.state.fishes.species[fish]].surface
    weights = eye_weights(plan)
    points = rest_control_points(plan, float(world.state.fishes.length[fish]), 0.0)
    return FishEyes(fish, weights, float((weights @ points[RIGHT])[2]))


def eyes_pose(world: World, by: FishEyes, alpha: float) -> CameraPose:
    """The pose midway between the eyes, `alpha` of the way from the last tick to this one."""
    origin, turn = bodies_at(world, by.fish, alpha)
    axes = matrix(turn)
    control = control_points_at(world, by.fish, alpha)
    scale = float(world.state.fishes.scale[by.fish])
    middle = scale * by.weights @ (control[LEFT] + control[RIGHT]) / 2
    return CameraPose(origin + axes @ middle, axes[:, 0], axes[:, 1])


def bodies_at(world: World, who: int | Ints, alpha: float) -> tuple[Array, Array]:
    """Origins (…, 3), cm, and orientations (…, 4) of the bodies of fishes, interpolated."""
    fishes = world.state.fishes
    before = fishes.previous_orientation[who].astype(np.float64)
    after = fishes.orientation[who].astype(np.float64)
    before *= np.where((before * after).sum(axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    turn = (1.0 - alpha) * before + alpha * after
    place = fishes.previous_position[who].astype(np.float64)
    place += alpha * (fishes.position[who] - place)
    return place, turn / np.linalg.norm(turn, axis=-1, keepdims=True)


def eye_weights(plan: SurfacePlan) -> Array:
    """Weights (189,) of the control points of a flank in the centre of its eye."""
    u, v = (np.array([t]) for t in eye_place(plan))
    return np.outer(dense(basis_at(U, u), U)[0], dense(basis_at(V, v), V)[0]).ravel()


def eye_place(plan: SurfacePlan) -> tuple[float, float]:
    """Parameters u and v of a flank at the centre of its eye."""
    t = np.linspace(0.0, 1.0, SAMPLES)
    across, along = dense(basis_at(U, t), U), dense(basis_at(V, t), V)
    half = rest_control_points(plan, 1.0, 0.0)[RIGHT].reshape(U, V, 3)
    surface = np.einsum("au,bv,uvx->abx", across, along, half)
    behind, up, aside = -surface[..., 0], surface[..., 1], surface[..., 2]
    # On a body with wings the eye's height is its distance from the spine, on the upper side.
    off = np.where(up > 0.0, aside - plan.eye.height, np.inf) if plan.wing else up - plan.eye.height
    a, b = np.unravel_index(np.argmin((behind - plan.eye.at) ** 2 + off**2), behind.shape)
    return float(t[a]), float(t[b])


def retina_rig(
    size: tuple[int, int], half_cm: float, gaze: Gaze = AHEAD, field_deg: float = FIELD_DEG
) -> CameraRig:
    """A rig with a picture of `size` for each eye, `half_cm` left and right of the observer."""
    width, height = size
    edge = NEAR_CM * np.tan(np.radians(field_deg) / 2)
    top = edge * height / width
    projection = off_axis(-edge, edge, -top, top, NEAR_CM)
    axes = gaze_axes(gaze)
    eyes, patches = [], []
    for output, side in enumerate((-half_cm, half_cm)):
        viewport: Rect = (output * width, 0, width, height)
        eyes.append(Eye(viewport, np.array([side, 0.0, 0.0]), axes, projection))
        patches.append(DisplayPatch((0, 0, width, height), viewport, viewport, output=output))
    return CameraRig((2 * width, height), (size, size), tuple(eyes), tuple(patches))


def gaze_axes(gaze: Gaze) -> Array:
    """Rows right, up, ahead (3, 3) of the eyes, in the axes of the observer."""
    pan, tilt = np.radians(gaze)
    return axes_of(pan, tilt)


def retinal_views(world: World, by: FishEyes, rig: CameraRig, alpha: float) -> tuple[View, ...]:
    """The views of a fish's eyes, without its own body."""
    return tuple(replace(view, without=by.fish) for view in views(rig, eyes_pose(world, by, alpha)))


def control_points_at(world: World, fish: int, alpha: float) -> Array:
    """Control points (426, 3) of a fish's pose, in body axes at the recorded size."""
    library = world.library
    a, b, weight = pose_at(world.state.fishes, library, fish, alpha)
    # Simulated fishes are skinned only when in sight; this one may be out of sight.
    if max(a, b) >= len(library.entry):
        kind = world.state.fishes.species[fish]
        coupling = Coupling(*(part[kind] for part in library.coupling))
        return place(coupling, (1.0 - weight) * library.nodes[a] + weight * library.nodes[b])
    return np.asarray(
        (1.0 - weight) * library.control_points[a] + weight * library.control_points[b]
    )
