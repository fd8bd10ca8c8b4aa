"""Read SGCT configurations, as OpenSpace and other programs use them."""

from pathlib import Path
from typing import Any

import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError, nearest
from subsea.base.validation import convert
from subsea.stage.theatre import sgct_views as views
from subsea.stage.theatre.imported import (
    ImportedTheatre,
    TheatreBuilder,
    pixels_of,
    printable_word,
    unused_keys,
)
from subsea.stage.theatre.sgct_file import (
    KNOWN,
    WHOLE,
    SgctConfig,
    SgctNode,
    SgctProjection,
    SgctUser,
    SgctViewport,
    SgctWindow,
)
from subsea.stage.theatre.theatre_file import (
    MAIN,
    MOST_WINDOWS,
    Cluster,
    Window,
    parse_address,
)
from subsea.stage.theatre.warp_files import FORMATS, read_mesh

VERSION = 1
SIZE = (640, 480)  # of a window without one
MAX_EYES_CM = 20.0
MOST_TRIED = 2 * MOST_WINDOWS  # viewports, with those that are left out
DISPLAYS = {
    "none": "", "active": "stereo", "side_by_side": "side-by-side", "top_bottom": "top-bottom",
    "anaglyph_red_cyan": "anaglyph", "checkerboard": "checkerboard",
    "vertical_interlaced": "interlaced",
}  # fmt: skip
SURROUND = ("FisheyeProjection", "EquirectangularProjection", "SphericalMirrorProjection")
VIEWED = (".sgc", ".ol", ".skyskan")  # meshes whose view replaces that of their viewport


def read_sgct(path: Path, content: Any) -> ImportedTheatre:
    """The theatre of a configuration's content; a UserError if nothing of it can be shown."""
    try:
        config = convert(content, SgctConfig)
    except UserError as fault:
        raise UserError(fault.message, file=path, key=fault.key) from fault
    if config.version != VERSION:
        raise UserError(f"`version` {config.version}, expected {VERSION}", file=path)
    reader = _SgctReader(path, config)
    for number, node in enumerate(config.nodes, 1):
        reader.node(node, MAIN if len(config.nodes) == 1 else f"node{number}")
    if unused := unused_keys(content, KNOWN, WHOLE):
        words = ", ".join(f"`{printable_word(key)}`" for key in unused[:40])
        reader.builder.leave_out(f"keys with no counterpart here: {words}")
    return reader.builder.build()


class _SgctReader:
    """Collects the theatre of a configuration."""

    def __init__(self, path: Path, config: SgctConfig) -> None:
        self.config = config
        title = config.meta.get("name") or config.meta.get("description") or path.stem
        self.builder = TheatreBuilder(path, str(title))
        self.tried = 0  # viewports so far: each may have a large mesh
        self.users = {user.name: user for user in config.users}
        default = self.users.get("", next(iter(self.users.values()), SgctUser()))
        self.eye_m = self._eye(default)
        self._viewers(default)
        if len(config.nodes) > 1:
            self._cluster()
        if config.scene is not None and config.scene != {}:
            self.builder.leave_out("`scene`: the scene's own place, turn and size")

    def _eye(self, user: SgctUser) -> Array:
        """The place (3,) of a user in metres."""
        return np.asarray(views.rotation(user.orientation) @ views.point(user.pos))

    def _viewers(self, default: SgctUser) -> None:
        eye = views.centimetres(self.eye_m)
        keys: dict[str, Any] = {"eye_cm": tuple(eye)} if any(eye) else {}
        if default.eyeseparation is not None:
            apart = round(abs(views.CM * default.eyeseparation), 3)
            if apart > MAX_EYES_CM:
                self.builder.leave_out(
                    f"`eyeseparation` of {apart:g} cm: {MAX_EYES_CM:g} cm at most"
                )
            keys["eye_distance_cm"] = min(apart, MAX_EYES_CM)
        for user in self.config.users:
            if user.tracking or (self.config.trackers and user is default):
                who = printable_word(user.name) or "the default user"
                self.builder.leave_out(f"tracking of {who}: the eye stays at its place")
            if user.matrix is not None:
                self.builder.leave_out(f"`matrix` of user {printable_word(user.name)!r}")
        self.builder.keys = keys

    def _cluster(self) -> None:
        """The master: the node of the master's address, or the first."""
        address = self.config.masteraddress
        addresses = [node.address for node in self.config.nodes]
        number = addresses.index(address) if address in addresses else 0
        ip = "127.0.0.1" if address == "localhost" else address
        try:
            parse_address(f"{ip}:5560")
        except ValueError:
            self.builder.leave_out(
                f"master's address {printable_word(address)!r}: expected an IP address, so "
                "127.0.0.1 stands in the [cluster]"
            )
            ip = "127.0.0.1"
        self.builder.cluster = Cluster(master=f"node{number + 1}", address=f"{ip}:5560")
        if ip != "127.0.0.1":
            self.builder.leave_out("keys of the [cluster]: make them with `subsea keys`")

    def node(self, node: SgctNode, name: str) -> None:
        """Add the windows of a computer."""
        for number, window in enumerate(node.windows, 1):
            self._window(window, name, window.name or f"window{number}")

    def _window(self, window: SgctWindow, node: str, words: str) -> None:
        said = f"window {printable_word(words)!r}"
        if not window.draw3d:
            self.builder.leave_out(f"{said}: it shows no 3-D picture (`draw3d` is false)")
            return
        display = DISPLAYS.get(window.stereo)
        if display is None:
            self.builder.leave_out(f"`stereo` {printable_word(window.stereo)!r} of {said}")
        elif display:
            self.builder.leave_out(f"`stereo` of {said}: start with --display {display}")
        for key in ("mirrorx", "mirrory", "scalablemesh"):
            if getattr(window, key):
                self.builder.leave_out(f"`{key}` of {said}")
        size = SIZE if window.size is None else (round(window.size.x), round(window.size.y))
        keys: dict[str, Any] = {"size": size, "node": node}
        if window.fullscreen:
            keys["monitor"] = max(window.monitor or 0, 0) + 1  # they are counted from 0
        elif window.pos is not None:
            keys["position"] = (round(window.pos.x), round(window.pos.y))
        made = self.builder.window(words, **keys)
        if made is None:
            return
        for number, viewport in enumerate(window.viewports, 1):
            self.tried += 1
            if self.tried > MOST_TRIED:
                self.builder.leave_out(f"viewports beyond the first {MOST_TRIED}")
                return
            name = words if len(window.viewports) == 1 else f"{words}-{number}"
            try:
                self._viewport(viewport, made, name)
            except UserError as fault:
                self.builder.leave_out(f"viewport {printable_word(name)!r}: {fault}")

    def _viewport(self, viewport: SgctViewport, window: Window, name: str) -> None:
        projection = viewport.projection
        if projection is None:
            raise UserError("it has no projection")
        x, y = (0.0, 0.0) if viewport.pos is None else (viewport.pos.x, viewport.pos.y)
        wide, high = (1.0, 1.0) if viewport.size is None else (viewport.size.x, viewport.size.y)
        place = pixels_of(window.size, x, y, wide, high)
        if place is None:
            raise UserError(f"{wide:g}×{high:g} of its window at {x:g}, {y:g}, expected shares "
                            "from 0 to 1 of 16 pixels or more")  # fmt: skip
        if viewport.overlay or viewport.blacklevelmask:
            self.builder.leave_out(f"`overlay` or `blacklevelmask` of viewport {name!r}")
        keys: dict[str, Any] = {}
        if viewport.eye in ("left", "right"):
            keys["eye"] = viewport.eye
        if mask := self.builder.beside(viewport.blendmask, "blend mask"):
            keys["mask"] = mask
        if projection.type in ("CylindricalProjection", "CubemapProjection"):
            self._pieces(viewport, window, name, place)
            return
        mesh = self.builder.beside(viewport.mesh, "mesh")
        if viewport.mesh and mesh is None:
            raise UserError("its mesh is left out, so its picture would be wrong")
        keys |= self._screen(viewport, projection, window, place, mesh, name)
        if "part" in keys and keys["part"] == (0.0, 0.0, 1.0, 1.0) and "warp" in keys:
            del keys["part"]
        place = keys.pop("place", place)
        if place != (0, 0, *window.size):
            keys["viewport"] = place
        self.builder.channel(name, window, **keys)

    def _screen(
        self,
        viewport: SgctViewport,
        projection: SgctProjection,
        window: Window,
        place: tuple[int, int, int, int],
        mesh: str | None,
        name: str,
    ) -> dict[str, Any]:
        """The keys of a channel for a projection that fills one viewport."""
        user = self.users.get(viewport.user or "")
        if viewport.user and user is None:
            raise UserError(f"user {printable_word(viewport.user)!r} is not there"
                            + nearest(viewport.user, list(self.users)))  # fmt: skip
        own_m = self.eye_m if user is None else self._eye(user)
        kind = projection.type
        if kind in ("PlanarProjection", "TextureMappedProjection"):
            keys = views.planar(projection, own_m, self.eye_m)
        elif kind == "ProjectionPlane":
            keys = views.projection_plane(projection, self.eye_m - own_m)
        elif kind == "EquirectangularProjection":
            keys = {"equirectangular": {}}
            self.builder.leave_out(
                f"turn of the equirectangular viewport {name!r}: SGCT's middle looks 45 degrees to "
                "the right, here it looks ahead"
            )
        elif kind == "SphericalMirrorProjection":
            return self._mirror(projection, window, name)
        elif kind == "FisheyeProjection":
            keys = views.fisheye(projection)
            keys |= self._fisheye_part(projection, place, mesh)
            if projection.offset is not None and views.point(projection.offset).any():
                self.builder.leave_out(f"`offset` of the fisheye {name!r}")
        else:
            raise UserError(f"projection {printable_word(kind)!r} is unknown")
        return keys | self._mesh(mesh, kind, name)

    def _fisheye_part(
        self, projection: SgctProjection, place: tuple[int, int, int, int], mesh: str | None
    ) -> dict[str, Any]:
        """The part of the dome's square, and the pixels, that a fisheye without a mesh fills.

        A mesh, but for Paul Bourke's, bends the picture of the whole viewport instead.
        """
        x, y, width, height = place
        crop = projection.crop
        cut = (0.0, 0.0, 0.0, 0.0)
        if crop is not None:
            cut = (crop.left, crop.right, crop.bottom, crop.top)
        if not all(0 <= one < 1 for one in cut) or cut[0] + cut[1] >= 1 or cut[2] + cut[3] >= 1:
            raise UserError("`crop` leaves nothing of the fisheye")
        across, up = 1 - cut[0] - cut[1], 1 - cut[2] - cut[3]
        part = (cut[0], cut[2], across, up)
        bourke = mesh is not None and mesh.lower().endswith(".data")
        if bourke or not projection.keepaspectratio:
            return {} if bourke and not any(cut) else {"part": part}
        shown = min(width / across, height / up)  # pixels of the whole square
        if mesh is not None:
            wide, high = width / shown, height / shown
            middle = cut[0] + across / 2, cut[2] + up / 2
            return {"part": (middle[0] - wide / 2, middle[1] - high / 2, wide, high)}
        if not any(cut):
            return {}
        wide, high = round(shown * across), round(shown * up)
        return {"part": part, "place": (x + (width - wide) // 2, y + (height - high) // 2,
                                        wide, high)}  # fmt: skip

    def _mesh(self, mesh: str | None, kind: str, name: str) -> dict[str, Any]:
        """The warp of a channel, and the view of the mesh if it brings one."""
        if mesh is None:
            return {}
        path = self.builder.path.parent / mesh
        suffix = path.suffix.lower()
        if suffix == ".txt":
            raise UserError(f"mesh {printable_word(mesh)!r}: rename it to .skyskan")
        if suffix not in FORMATS:
            raise UserError(
                f"mesh {printable_word(mesh)!r} is of no known format, expected "
                f"{', '.join(FORMATS)}"
            )
        if suffix == ".pfm":
            key = f"{self.builder.name(name)}.obj"
            made = views.float_map(path, kind == "TextureMappedProjection")
            self.builder.meshes[key] = made
            return {"warp": key}
        if suffix in VIEWED and kind not in SURROUND:
            found = read_mesh(path, SIZE)
            for note in found.notes:
                self.builder.leave_out(note)
            if found.view is not None:
                view = views.mesh_view(found.view, self.eye_m)
                return {"plane": None, **view, "warp": mesh}
        return {"warp": mesh}

    def _mirror(self, projection: SgctProjection, window: Window, name: str) -> dict[str, Any]:
        geometry = projection.geometry or projection.mesh
        if geometry is None:
            raise UserError("a spherical mirror has no `geometry`, expected four meshes")
        files = [
            self.builder.beside(one, "mesh")
            for one in (geometry.bottom, geometry.left, geometry.right, geometry.top)
        ]
        if None in files:
            raise UserError("a mesh of its spherical mirror is left out")
        aspect = window.size[0] / window.size[1]
        key = f"{self.builder.name(name)}.obj"
        self.builder.meshes[key] = views.spherical_mirror(
            self.builder.path.parent, geometry, aspect, projection.tilt
        )
        return {"dome": {"tilt_deg": projection.tilt}, "warp": key}

    def _pieces(
        self,
        viewport: SgctViewport,
        window: Window,
        name: str,
        place: tuple[int, int, int, int],
    ) -> None:
        """Add the channels of a projection that several flat or curved screens make."""
        assert viewport.projection is not None
        if viewport.mesh or viewport.blendmask:
            raise UserError("a mesh or mask over several screens")
        x, y, width, height = place
        if viewport.projection.type == "CubemapProjection":
            faces = views.cube_faces(viewport.projection)
            found = [(key, column, 1 - row, 3, 2, screen)
                     for key, (column, row, screen) in faces.items()]  # fmt: skip
        else:
            quarters = views.cylinders(viewport.projection)
            found = [(f"{k + 1}", k, 0, len(quarters), 1, one) for k, one in enumerate(quarters)]
        for key, column, row, columns, rows, screen in found:
            left, right = (x + width * k // columns for k in (column, column + 1))
            top, bottom = (y + height * k // rows for k in (row, row + 1))
            rect = (left, top, right - left, bottom - top)
            self.builder.channel(f"{name}-{key}", window, viewport=rect, **screen)
