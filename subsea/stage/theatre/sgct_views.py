"""Screens of SGCT's projections, in the keys of a channel.

Checked against SGCT's sources (src/viewport.cpp, src/baseviewport.cpp, src/projection/*.cpp).
"""

from pathlib import Path
from typing import Any

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.base.errors import UserError
from subsea.base.files import read_input
from subsea.stage.theatre.measured_mesh import (
    MeasuredMesh,
    ViewAngles,
    flipped,
    grid_triangles,
    quaternion_rotation,
    turned,
    turns,
)
from subsea.stage.theatre.obj import obj_mesh
from subsea.stage.theatre.pfm import MAX_BYTES as MAX_PFM
from subsea.stage.theatre.pfm import parse_pfm
from subsea.stage.theatre.sgct_file import (
    SgctFov,
    SgctGeometry,
    SgctPoint,
    SgctProjection,
    SgctTurn,
)
from subsea.stage.theatre.simcad import regular_sources
from subsea.stage.theatre.warp import mesh, validated
from subsea.stage.theatre.warp_files import FORMATS, sources_of
from subsea.view.surround import Surround

CM = 100.0  # of a metre
PLANAR_M = 10.0  # default distance of a planar view
DOME_M = 14.8  # default diameter of a fisheye's sphere
NEAREST_CM = 50.0  # of surround screens
# Faces of a cubemap on its picture of three columns and two rows, and how a view ahead is turned to
# them: about x, then about y.
CUBE = {
    "zright": (0, 0, 0.0, 180.0), "top": (1, 0, 90.0, 0.0), "left": (2, 0, 0.0, 0.0),
    "zleft": (0, 1, 0.0, 90.0), "bottom": (1, 1, -90.0, 0.0), "right": (2, 1, 0.0, -90.0),
}  # fmt: skip
QUARTERS = 4  # of a cylinder: a screen must not span half a turn
MIRROR_FACES = {"bottom": (0, 0.0), "left": (1, 90.0), "right": (1, -90.0), "top": (0, 90.0)}
MIRROR_TILT = 45.0  # by which the front face is turned up


def point(one: SgctPoint | None) -> Array:
    """A point (3,) in metres."""
    return np.zeros(3) if one is None else np.array([one.x, one.y, one.z])


def rotation(turn: SgctTurn | None) -> Array:
    """The right-handed rotation (3, 3) of an orientation."""
    if turn is None:
        return np.eye(3)
    if None not in (turn.x, turn.y, turn.z, turn.w):
        return quaternion_rotation(np.array([turn.x, turn.y, turn.z, turn.w]))
    return turns(1, -turn.yaw) @ turns(0, turn.pitch) @ turns(2, -turn.roll)


def edges_deg(fov: SgctFov) -> tuple[float, float, float, float]:
    """Angles of the edges left, right, down, up; a UserError if they are incomplete."""
    found = []
    for whole, sides in (("hfov", ("left", "right")), ("vfov", ("down", "up"))):
        both = getattr(fov, whole)
        half = None if both is None else both / 2
        for side, sign in zip(sides, (-1, 1), strict=True):
            own = getattr(fov, side)
            angle = half if own is None else own
            if angle is None:
                raise UserError(f"`fov` has neither `{whole}` nor `{side}`")
            found.append(sign * float(angle))
    return found[0], found[1], found[2], found[3]


def planar(projection: SgctProjection, user_m: Array, eye_m: Array) -> dict[str, Any]:
    """The screen of a planar view for a user (3,); the theatre's eye is at `eye_m`."""
    if not isinstance(projection.fov, SgctFov):
        raise UserError("a planar view has no `fov`, expected `hfov` and `vfov`")
    edges = edges_deg(projection.fov)
    far = projection.distance or projection.fov.distance or PLANAR_M
    own = point(projection.offset) - user_m
    return flat_view(rotation(projection.orientation), edges, far, own, eye_m)


def flat_view(
    turn: Array,
    edges: tuple[float, float, float, float],
    far_m: float,
    middle_m: Array,
    eye_m: Array,
) -> dict[str, Any]:
    """The screen of a view with edges in degrees, at a distance from a point `middle_m` (3,).

    The point counts from the eye. If it is the eye itself, the screen is `angles`.
    """
    if not far_m > 0.005:
        raise UserError(f"distance {far_m:g} m of a planar view, expected a positive one")
    if not all(-89 < edge < 89 for edge in edges):
        raise UserError(f"{' '.join(f'{edge:g}' for edge in edges)} degrees to the edges of a "
                        "planar view, expected less than 89")  # fmt: skip
    if not middle_m.any():
        heading, pitch, roll = turned(turn)
        names = ("left_deg", "right_deg", "down_deg", "up_deg")
        view = dict(zip(names, map(_short, edges), strict=True))
        for name, angle in (("heading_deg", heading), ("pitch_deg", pitch), ("roll_deg", roll)):
            if abs(angle) > 1e-6:
                view[name] = _short(angle)
        return {"angles": view | {"distance_cm": _short(CM * far_m)}}
    left, right, down, up = far_m * np.tan(np.radians(edges))
    corners = np.array([[left, down, -far_m], [left, up, -far_m], [right, up, -far_m]])
    return plane_through(*(corners @ turn.T + middle_m + eye_m))


def plane_through(lower_left: Array, upper_left: Array, upper_right: Array) -> dict[str, Any]:
    """The `plane` through three corners (3,), metres."""
    corners = {
        "lower_left": lower_left,
        "lower_right": lower_left + upper_right - upper_left,
        "upper_left": upper_left,
    }
    return {"plane": {name: centimetres(corner) for name, corner in corners.items()}}


def projection_plane(projection: SgctProjection, shift_m: Array) -> dict[str, Any]:
    """The screen through the three corners of a projection plane."""
    corners = projection.lowerleft, projection.upperleft, projection.upperright
    if None in corners:
        raise UserError("a projection plane has fewer than three corners")
    return plane_through(*(point(corner) + shift_m for corner in corners))


def centimetres(point_m: Array) -> list[float]:
    """A point in our axes and centimetres, to a micrometre."""
    return [_short(x) for x in flipped(CM * point_m)]


def fisheye(projection: SgctProjection) -> dict[str, Any]:
    """The dome of a fisheye."""
    angle = 180.0 if projection.fov is None else projection.fov
    if isinstance(angle, SgctFov):
        raise UserError("`fov` of a fisheye, expected a number")
    radius = CM * (projection.diameter or DOME_M) / 2
    dome = {"tilt_deg": projection.tilt, "angle_deg": angle}
    return {"dome": dome | {"distance_cm": _short(max(radius, NEAREST_CM))}}


def cylinders(projection: SgctProjection) -> list[dict[str, Any]]:
    """Screens for the quarters of a cylindrical picture, from the left.

    It spans a whole turn, from the height of the eye up by the radius. Its left edge looks 135
    degrees to the right, as SGCT's cube is turned by half a right angle.
    """
    radius = CM * abs(projection.radius)
    low = radius * projection.heightoffset
    begin = 135.0 - np.degrees(projection.rotation)
    begin = (begin + 180.0) % 360.0 - 180.0
    begin -= 360.0 if begin > 0 else 0.0
    step = 360.0 / QUARTERS
    return [
        {
            "cylinder": {
                "radius_cm": _short(radius), "left_deg": _short(begin + k * step),
                "right_deg": _short(begin + (k + 1) * step), "bottom_cm": _short(low),
                "top_cm": _short(low + radius),
            }
        }
        for k in range(QUARTERS)
    ]  # fmt: skip


def cube_faces(projection: SgctProjection) -> dict[str, tuple[int, int, dict[str, Any]]]:
    """Column, row (from below) and screen of each face of a cubemap's picture that is on."""
    turn = projection.orientation or SgctTurn()
    whole = turns(1, -turn.pitch) @ turns(0, turn.yaw) @ turns(2, -turn.roll)
    edges = (-45.0, 45.0, -45.0, 45.0)
    return {
        name: (column, row, flat_view(
            whole @ (turns(0, up) if up else turns(1, about)), edges, 3.0, np.zeros(3), np.zeros(3)
        ))
        for name, (column, row, up, about) in CUBE.items()
        if projection.channels.get(name, True)
    }  # fmt: skip


def spherical_mirror(
    folder: Path, geometry: SgctGeometry, aspect: float, tilt_deg: float
) -> MeasuredMesh:
    """One warp of a dome's picture from the meshes of four faces of a cube.

    Each shows a face of 90 degrees. x runs from minus to plus the aspect ratio of the window.
    """
    places, sources, triangles, count = [], [], [], 0
    for name, (axis, degrees) in MIRROR_FACES.items():
        path = folder / getattr(geometry, name)
        if path.suffix.lower() != ".obj":
            raise UserError("expected a mesh in an .obj file", file=path)
        one = obj_mesh(read_input(path, FORMATS[".obj"].max_bytes), str(path), True)
        x, y, u, v = one.vertices[:, :4].astype(np.float64).T
        places.append(np.column_stack([((2 * x - 1) / aspect + 1) / 2, y]))
        rays = np.column_stack([2 * u - 1, 2 * v - 1, -np.ones_like(u)])
        turn = turns(0, MIRROR_TILT - tilt_deg) @ turns(axis, degrees)
        sources.append(dome_shares(flipped(rays @ turn.T), tilt_deg))
        triangles.append(_unfolded(one.vertices, one.triangles) + count)
        count += len(one.vertices)
    whole = mesh(np.concatenate(places), np.concatenate(sources), np.concatenate(triangles))
    return MeasuredMesh(validated(whole, f"{folder}: the meshes of a spherical mirror"))


def _unfolded(vertices: Array, triangles: Ints) -> Ints:
    """The triangles without the few that are folded over, as some are in SGCT's own example."""
    places, sources = (
        vertices[triangles][..., k : k + 2].astype(np.float64).transpose(1, 0, 2) for k in (0, 2)
    )
    turn = np.ones(len(triangles))
    for a, b, c in (places, sources):
        turn *= np.sign((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    return np.asarray(triangles[turn * np.sign(turn.sum()) >= 0])


def dome_shares(rays: Array, tilt_deg: float, dome_deg: float = 180.0) -> Array:
    """Places (n, 2) of rays (n, 3) in a dome's square; `surround.directions` backwards."""
    tilt = np.radians(tilt_deg)
    middle = np.array([0.0, np.cos(tilt), np.sin(tilt)])
    behind = np.array([0.0, np.sin(tilt), -np.cos(tilt)])
    unit = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    aside = np.column_stack([unit[:, 0], unit @ behind])
    away = np.arctan2(np.linalg.norm(aside, axis=1), unit @ middle)
    length = np.maximum(np.linalg.norm(aside, axis=1), 1e-12)
    reach = away / np.radians(Surround(dome_deg=dome_deg).dome_deg / 2)
    return np.asarray(0.5 + 0.5 * aside * (reach / length)[:, None])


def float_map(path: Path, textured: bool) -> MeasuredMesh:
    """A PFM file as SGCT reads it: its first row is the upper one.

    On a texture-mapped view the numbers are sources of a grid over the projector; else they are
    places of a grid over the picture, and the left half of the file is for both eyes.
    """
    numbers = parse_pfm(read_input(path, MAX_PFM), str(path))[::-1]
    shown = sources_of(numbers, str(path)).astype(np.float64)
    rows, columns = shown.shape[:2]
    if not textured:
        columns //= 2
        if columns < 2:
            raise UserError(f"{shown.shape[1]} columns for two eyes, expected 4", file=path)
        shown = shown[:, :columns]
    shown = np.where(np.abs(shown) < 100, shown, np.nan).reshape(-1, 2)
    used = np.asarray(np.isfinite(shown).all(axis=1))
    grid = regular_sources(columns, rows)
    if not textured:
        grid = (grid * [columns - 1, rows - 1] + 0.5) / [columns, rows]
    triangles = grid_triangles(columns, rows)
    triangles = triangles[used[triangles].all(axis=1)]
    measured = np.nan_to_num(shown)
    places, sources = (grid, measured) if textured else (measured, grid)
    return MeasuredMesh(validated(mesh(places, sources, triangles), str(path)))


def mesh_view(view: ViewAngles, eye_m: Array) -> dict[str, Any]:
    """The screen of the view that a mesh bends, which replaces the viewport's own."""
    turn = turns(1, -view.yaw_deg) @ turns(0, view.pitch_deg) @ turns(2, -view.roll_deg)
    edges = view.left_deg, view.right_deg, view.down_deg, view.up_deg
    return flat_view(turn, edges, PLANAR_M, np.zeros(3), eye_m)


def _short(number: float) -> float:
    """A number as written: to 1e-5."""
    return round(float(number), 5) + 0.0
