"""Read SGCT configurations, as OpenSpace and other programs use them.

Screens of projections are checked against SGCT's sources (src/viewport.cpp, src/baseviewport.cpp,
src/projection/*.cpp).
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.base.errors import UserError, nearest
from subsea.base.files import read_input
from subsea.stage.theatre import mesh_formats, sgct_file
from subsea.stage.theatre.imported import ImportedTheatre, TheatreBuilder
from subsea.stage.theatre.measured_mesh import (
    MeasuredMesh,
    ViewAngles,
    dome_shares,
    flipped,
    quaternion_rotation,
    turned,
    turns,
)
from subsea.stage.theatre.pixel_files import parse_pfm
from subsea.stage.theatre.theatre_file import FEWEST_PIXELS, MAIN, Window
from subsea.stage.theatre.warp import mesh, validated
from subsea.view.meshes import grid_triangles
from subsea.view.rig import Rect

SIZE = (640, 480)  # of a window without one
MAX_EYES_CM = 20.0
DISPLAYS = {
    "none": "", "active": "stereo", "side_by_side": "side-by-side", "top_bottom": "top-bottom",
    "anaglyph_red_cyan": "anaglyph", "checkerboard": "checkerboard",
    "vertical_interlaced": "interlaced",
}  # fmt: skip
SURROUND = ("FisheyeProjection", "EquirectangularProjection", "SphericalMirrorProjection")
VIEWED = (".sgc", ".ol", ".skyskan")  # meshes whose view replaces that of their viewport
CM = 100.0  # of a metre
PLANAR_M = 10.0  # default distance of a planar view
DOME_M = 14.8  # default diameter of a fisheye's sphere
ROOTS = 4  # folders in which a file is sought: that of the configuration, and those above
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


def read_sgct(path: Path, content: Any) -> ImportedTheatre:
    """Build the theatre of a configuration's content; a UserError if nothing of it can be shown."""
    content = sgct_file.lowered(content)
    config = sgct_file.read_config(path, content)
    title = config.meta.get("name") or config.meta.get("description") or path.stem
    users = {user.name: user for user in config.users}
    default = users.get("", next(iter(users.values()), sgct_file.SgctUser()))
    reader = _SgctReader(TheatreBuilder(path, str(title)), users, _eye(default))
    builder = reader.builder
    if any(eye := centimetres(reader.eye_m)):
        builder.keys["eye_cm"] = tuple(eye)
    if default.eyeseparation is not None:
        apart = round(abs(CM * default.eyeseparation), 3)
        if apart > MAX_EYES_CM:
            builder.leave_out(f"`eyeseparation` of {apart:g} cm: {MAX_EYES_CM:g} cm at most")
        builder.keys["eye_distance_cm"] = min(apart, MAX_EYES_CM)
    for user in config.users:
        if user.tracking or (config.trackers and user is default):
            who = repr(user.name) if user.name else "the default user"
            builder.leave_out(f"tracking of {who}: the eye stays at its place")
        if user.matrix is not None:
            builder.leave_out(f"`matrix` of user {user.name!r}")
    if len(config.nodes) > 1:
        addresses = [node.address for node in config.nodes]
        master = config.masteraddress
        number = addresses.index(master) if master in addresses else 0
        builder.lead(f"node{number + 1}", master)
    if config.scene:
        builder.leave_out("`scene`: the scene's own place, turn and size")
    for number, node in enumerate(config.nodes, 1):
        name = MAIN if len(config.nodes) == 1 else f"node{number}"
        for k, window in enumerate(node.windows, 1):
            reader.window(window, name, window.name or f"window{k}")
    builder.leave_out_keys(content, sgct_file.SgctConfig, sgct_file.QUIET)
    return builder.build()


class _SgctReader(NamedTuple):
    """Collects the windows and viewports of a configuration."""

    builder: TheatreBuilder
    users: dict[str, sgct_file.SgctUser]
    eye_m: Array  # (3,) of the default user

    def window(self, window: sgct_file.SgctWindow, node: str, words: str) -> None:
        """Add a window of a computer, with its viewports."""
        said = f"window {words!r}"
        if not window.draw3d:
            self.builder.leave_out(f"{said}: it shows no 3-D picture (`draw3d` is false)")
            return
        display = DISPLAYS.get(window.stereo)
        if display is None:
            self.builder.leave_out(f"`stereo` {window.stereo!r} of {said}")
        elif display:
            self.builder.leave_out(f"`stereo` of {said}: start with --display {display}")
        for key in ("mirrorx", "mirrory", "scalablemesh"):
            if getattr(window, key):
                self.builder.leave_out(f"`{key}` of {said}")
        size = SIZE if window.size is None else (round(window.size.x), round(window.size.y))
        keys: dict[str, Any] = {"size": size, "node": node}
        if window.fullscreen:
            keys["monitor"] = max(window.monitor or 0, 0) + 1  # SGCT counts from 0
        elif window.pos is not None:
            keys["position"] = (round(window.pos.x), round(window.pos.y))
        made = self.builder.window(words, **keys)
        if made is None:
            return
        for number, viewport in enumerate(window.viewports, 1):
            name = words if len(window.viewports) == 1 else f"{words}-{number}"
            try:
                self._viewport(viewport, made, name)
            except UserError as fault:
                self.builder.refuse(f"viewport {name!r}: {fault}")

    def _viewport(self, viewport: sgct_file.SgctViewport, window: Window, name: str) -> None:
        projection = viewport.projection
        if projection is None:
            raise UserError("it has no projection")
        x, y = (0.0, 0.0) if viewport.pos is None else (viewport.pos.x, viewport.pos.y)
        wide, high = (1.0, 1.0) if viewport.size is None else (viewport.size.x, viewport.size.y)
        place = pixels_of(window.size, x, y, wide, high)
        if place is None:
            raise UserError(f"{wide:g}×{high:g} of its window at {x:g}, {y:g}, expected shares "
                            "from 0 to 1 of 16 pixels or more")  # fmt: skip
        if foreign := sgct_file.foreign_keys(projection):
            words = ", ".join(f"`{key}`" for key in foreign)
            self.builder.leave_out(f"{words} of viewport {name!r}: not of a {projection.type}")
        if viewport.overlay or viewport.blacklevelmask:
            self.builder.leave_out(f"`overlay` or `blacklevelmask` of viewport {name!r}")
        if projection.type in ("CylindricalProjection", "CubemapProjection"):
            if viewport.mesh or viewport.blendmask:
                raise UserError("a mesh or mask over several screens")
            for key, rect, screen in pieces(projection, place):
                self.builder.channel(f"{name}-{key}", window, viewport=rect, **screen)
            return
        keys = self._screen(viewport, projection, window, place, name)
        if viewport.eye in ("left", "right"):
            keys["eye"] = viewport.eye
        if viewport.blendmask:
            keys["mask"] = sought(self.builder.path.parent, viewport.blendmask)
        if "warp" in keys and keys.get("part") == (0.0, 0.0, 1.0, 1.0):
            del keys["part"]
        place = keys.pop("place", place)
        if place != (0, 0, *window.size):
            keys["viewport"] = place
        self.builder.channel(name, window, **keys)

    def _screen(
        self,
        viewport: sgct_file.SgctViewport,
        projection: sgct_file.SgctProjection,
        window: Window,
        place: Rect,
        name: str,
    ) -> dict[str, Any]:
        """The keys of a channel for a projection that fills one viewport."""
        user = self.users.get(viewport.user or "")
        if viewport.user and user is None:
            raise UserError(f"user {viewport.user!r} is not there"
                            + nearest(viewport.user, list(self.users)))  # fmt: skip
        user_m = self.eye_m if user is None else _eye(user)
        mesh_file = sought(self.builder.path.parent, viewport.mesh) if viewport.mesh else None
        kind = projection.type
        if kind in ("PlanarProjection", "TextureMappedProjection"):
            keys = planar(projection, user_m, self.eye_m)
        elif kind == "ProjectionPlane":
            keys = projection_plane(projection, self.eye_m - user_m)
        elif kind == "EquirectangularProjection":
            keys = {"equirectangular": {}}
            self.builder.leave_out(
                f"turn of the equirectangular viewport {name!r}: SGCT's middle looks 45 degrees to "
                "the right, here it looks ahead"
            )
        elif kind == "SphericalMirrorProjection":
            warp = spherical_mirror(self.builder.path.parent, projection, window.size)
            return {"dome": {"tilt_deg": projection.tilt}, "warp": self._composed(name, warp)}
        elif kind == "FisheyeProjection":
            keys = fisheye(projection) | fisheye_part(projection, place, mesh_file)
            if point(projection.offset).any():
                self.builder.leave_out(f"`offset` of the fisheye {name!r}")
        else:
            raise UserError(f"projection {kind!r} is unknown")
        return keys if mesh_file is None else keys | self._mesh(mesh_file, kind, name)

    def _composed(self, name: str, warp: MeasuredMesh) -> str:
        """Keep a warp that is in no file; return its name."""
        key = f"{self.builder.name(name)}.obj"
        self.builder.meshes[key] = warp
        return key

    def _mesh(self, file: str, kind: str, name: str) -> dict[str, Any]:
        """The warp of a channel, and the view of the mesh if it brings one."""
        path = self.builder.path.parent / file
        suffix = path.suffix.lower()
        if suffix == ".txt":
            raise UserError(f"mesh {file!r}: rename it to .skyskan")
        if suffix not in mesh_formats.FORMATS:
            raise UserError(
                f"mesh {file!r} is of no known format, expected {', '.join(mesh_formats.FORMATS)}"
            )
        if suffix == ".pfm":
            warp = float_map(path, kind == "TextureMappedProjection")
            return {"warp": self._composed(name, warp)}
        if suffix in VIEWED and kind not in SURROUND:
            measured = mesh_formats.read_mesh(path, SIZE)
            self.builder.leave_out(*measured.notes)
            if measured.view is not None:
                return {"plane": None, **mesh_view(measured.view, self.eye_m), "warp": file}
        return {"warp": file}


def sought(folder: Path, name: str) -> str:
    """The path of a file from `folder`, or from a folder above where only that one has it.

    Programs such as OpenSpace keep meshes below the root of all configurations.
    """
    plain = name.replace("\\", "/")
    if plain.startswith("//"):
        raise UserError(f"file {name!r} is on another computer, expected one of this")
    ways = ["../" * up + plain for up in range(ROOTS)]
    return next((way for way in ways if (folder / way).is_file()), plain)


def pixels_of(
    size: tuple[int, int], x: float, y: float, width: float, height: float
) -> Rect | None:
    """Turn shares from the lower left into pixels x, y (from the upper left), width, height.

    Edges that neighbours share stay shared. None if a side is too short.
    """
    left, right = (round(size[0] * edge) for edge in (x, x + width))
    top, bottom = (round(size[1] * (1 - edge)) for edge in (y + height, y))
    if min(right - left, bottom - top) < FEWEST_PIXELS:
        return None
    return left, top, right - left, bottom - top


def fisheye_part(
    projection: sgct_file.SgctProjection, place: Rect, mesh_file: str | None
) -> dict[str, Any]:
    """The part of the dome's square, and the pixels, that a fisheye without a mesh fills.

    A mesh, but for Paul Bourke's, bends the picture of the whole viewport instead.
    """
    x, y, width, height = place
    crop = projection.crop
    cut = (0.0,) * 4 if crop is None else (crop.left, crop.right, crop.bottom, crop.top)
    if not all(0 <= share < 1 for share in cut) or cut[0] + cut[1] >= 1 or cut[2] + cut[3] >= 1:
        raise UserError("`crop` leaves nothing of the fisheye")
    across, up = 1 - cut[0] - cut[1], 1 - cut[2] - cut[3]
    part = (cut[0], cut[2], across, up)
    bourke = mesh_file is not None and mesh_file.lower().endswith(".data")
    if bourke or not projection.keepaspectratio:
        return {} if bourke and not any(cut) else {"part": part}
    shown = min(width / across, height / up)  # pixels of the whole square
    if mesh_file is not None:
        wide, high = width / shown, height / shown
        middle = cut[0] + across / 2, cut[2] + up / 2
        return {"part": (middle[0] - wide / 2, middle[1] - high / 2, wide, high)}
    if not any(cut):
        return {}
    wide, high = round(shown * across), round(shown * up)
    corner = x + (width - wide) // 2, y + (height - high) // 2
    return {"part": part, "place": (*corner, wide, high)}


def pieces(
    projection: sgct_file.SgctProjection, place: Rect
) -> Iterator[tuple[str, Rect, dict[str, Any]]]:
    """Cut a projection that several screens make: name, pixels and screen of each."""
    x, y, width, height = place
    if projection.type == "CubemapProjection":
        cells = [(key, column, 1 - row, 3, 2, screen)
                 for key, (column, row, screen) in cube_faces(projection).items()]  # fmt: skip
    else:
        quarters = cylinders(projection)
        cells = [(f"{k + 1}", k, 0, QUARTERS, 1, screen) for k, screen in enumerate(quarters)]
    for key, column, row, columns, rows, screen in cells:
        left, right = (x + width * k // columns for k in (column, column + 1))
        top, bottom = (y + height * k // rows for k in (row, row + 1))
        yield key, (left, top, right - left, bottom - top), screen


def _eye(user: sgct_file.SgctUser) -> Array:
    """The place (3,) of a user in metres."""
    return np.asarray(rotation(user.orientation) @ point(user.pos))


def point(given: sgct_file.SgctPoint | None) -> Array:
    """A point (3,) in metres."""
    return np.zeros(3) if given is None else np.array([given.x, given.y, given.z])


def rotation(turn: sgct_file.SgctTurn | None) -> Array:
    """The right-handed rotation (3, 3) of an orientation."""
    if turn is None:
        return np.eye(3)
    if None not in (turn.x, turn.y, turn.z, turn.w):
        return quaternion_rotation(np.array([turn.x, turn.y, turn.z, turn.w]))
    return turns(1, -turn.yaw) @ turns(0, turn.pitch) @ turns(2, -turn.roll)


def edges_deg(fov: sgct_file.SgctFov) -> tuple[float, ...]:
    """Angles of the edges left, right, down, up; a UserError if they are incomplete."""
    edges = []
    for side, whole, sign in (
        ("left", "hfov", -1), ("right", "hfov", 1), ("down", "vfov", -1), ("up", "vfov", 1),
    ):  # fmt: skip
        angle, both = getattr(fov, side), getattr(fov, whole)
        if angle is None and both is None:
            raise UserError(f"`fov` has neither `{whole}` nor `{side}`")
        edges.append(sign * float(both / 2 if angle is None else angle))
    return tuple(edges)


def planar(projection: sgct_file.SgctProjection, user_m: Array, eye_m: Array) -> dict[str, Any]:
    """The screen of a planar view for a user (3,); the theatre's eye is at `eye_m`."""
    if not isinstance(projection.fov, sgct_file.SgctFov):
        raise UserError("a planar view has no `fov`, expected `hfov` and `vfov`")
    edges = edges_deg(projection.fov)
    far = projection.distance or projection.fov.distance or PLANAR_M
    middle = point(projection.offset) - user_m
    return flat_view(rotation(projection.orientation), edges, far, middle, eye_m)


def flat_view(
    turn: Array,
    edges: Sequence[float],
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


def projection_plane(projection: sgct_file.SgctProjection, shift_m: Array) -> dict[str, Any]:
    """The screen through the three corners of a projection plane."""
    corners = projection.lowerleft, projection.upperleft, projection.upperright
    if None in corners:
        raise UserError("a projection plane has fewer than three corners")
    return plane_through(*(point(corner) + shift_m for corner in corners))


def centimetres(point_m: Array) -> list[float]:
    """A point in our axes and centimetres, to a micrometre."""
    return [_short(x) for x in flipped(CM * point_m)]


def fisheye(projection: sgct_file.SgctProjection) -> dict[str, Any]:
    """The dome of a fisheye."""
    angle = 180.0 if projection.fov is None else projection.fov
    if isinstance(angle, sgct_file.SgctFov):
        raise UserError("`fov` of a fisheye, expected a number")
    radius = CM * (projection.diameter or DOME_M) / 2
    dome = {"tilt_deg": projection.tilt, "angle_deg": angle}
    return {"dome": dome | {"distance_cm": _short(max(radius, NEAREST_CM))}}


def cylinders(projection: sgct_file.SgctProjection) -> list[dict[str, Any]]:
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


def cube_faces(projection: sgct_file.SgctProjection) -> dict[str, tuple[int, int, dict[str, Any]]]:
    """Column, row (from below) and screen of each face of a cubemap's picture that is on."""
    turn = projection.orientation or sgct_file.SgctTurn()
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
    folder: Path, projection: sgct_file.SgctProjection, size: tuple[int, int]
) -> MeasuredMesh:
    """Make one warp of a dome's picture from the meshes of four faces of a cube.

    Each shows a face of 90 degrees. x runs from minus to plus the aspect ratio of the window.
    """
    geometry = projection.geometry or projection.mesh
    if geometry is None:
        raise UserError("a spherical mirror has no `geometry`, expected four meshes")
    places, sources, triangles, count = [], [], [], 0
    for name, (axis, degrees) in MIRROR_FACES.items():
        path = folder / sought(folder, getattr(geometry, name))
        if path.suffix.lower() != ".obj":
            raise UserError("expected a mesh in an .obj file", file=path)
        face = mesh_formats.obj_mesh(read_input(path, mesh_formats.MAX_TEXT), str(path), True)
        x, y, u, v = face.vertices[:, :4].astype(np.float64).T
        places.append(np.column_stack([((2 * x - 1) / (size[0] / size[1]) + 1) / 2, y]))
        rays = np.column_stack([2 * u - 1, 2 * v - 1, -np.ones_like(u)])
        turn = turns(0, MIRROR_TILT - projection.tilt) @ turns(axis, degrees)
        sources.append(dome_shares(flipped(rays @ turn.T), projection.tilt))
        triangles.append(_unfolded(face.vertices, face.triangles) + count)
        count += len(face.vertices)
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


def float_map(path: Path, textured: bool) -> MeasuredMesh:
    """A PFM file as SGCT reads it: its first row is the upper one.

    On a texture-mapped view the numbers are sources of a grid over the projector; else they are
    places of a grid over the picture, and the left half of the file is for both eyes.
    """
    numbers = parse_pfm(read_input(path, mesh_formats.MAX_BYTES), str(path))[::-1]
    shown = mesh_formats.sources_of(numbers, str(path)).astype(np.float64)
    rows, columns = shown.shape[:2]
    if not textured:
        columns //= 2
        if columns < 2:
            raise UserError(f"{shown.shape[1]} columns for two eyes, expected 4", file=path)
        shown = shown[:, :columns]
    shown = np.where(np.abs(shown) < 100, shown, np.nan).reshape(-1, 2)
    used = np.asarray(np.isfinite(shown).all(axis=1))
    grid = mesh_formats.regular_sources(columns, rows)
    if not textured:
        grid = (grid * [columns - 1, rows - 1] + 0.5) / [columns, rows]
    triangles = grid_triangles(columns, rows)
    triangles = triangles[used[triangles].all(axis=1)]
    measured = np.nan_to_num(shown)
    places, sources = (grid, measured) if textured else (measured, grid)
    return MeasuredMesh(validated(mesh(places, sources, triangles), str(path)))


def mesh_view(view: ViewAngles, eye_m: Array) -> dict[str, Any]:
    """The screen of the view that a mesh bends, which replaces the viewport's own."""
    turn = turns(1, -view.heading_deg) @ turns(0, view.pitch_deg) @ turns(2, -view.roll_deg)
    edges = view.left_deg, view.right_deg, view.down_deg, view.up_deg
    return flat_view(turn, edges, PLANAR_M, np.zeros(3), eye_m)


def _short(number: float) -> float:
    """A number as written: to 1e-5."""
    return round(float(number), 5) + 0.0
