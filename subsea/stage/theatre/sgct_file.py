"""The keys of an SGCT configuration that are used here.

JSON of ``sgct.schema.json``, version 1 (github.com/sgct/sgct). Lengths are metres, x right, y up,
z astern; angles are degrees unless said otherwise. Shares of windows are from the lower left.
"""

from pathlib import Path
from typing import Annotated, Any

import msgspec

from subsea.base.errors import UserError
from subsea.base.validation import convert
from subsea.stage.theatre.theatre_file import Coordinate

Metres = Annotated[float, msgspec.Meta(ge=-1000, le=1000)]
Degrees = Annotated[float, msgspec.Meta(ge=-3600, le=3600)]


class SgctPair(msgspec.Struct, frozen=True):
    """A size or place."""

    x: Coordinate
    y: Coordinate


class SgctPoint(msgspec.Struct, frozen=True):
    """A point or offset."""

    x: Metres
    y: Metres
    z: Metres


class SgctTurn(msgspec.Struct, frozen=True):
    """A rotation: three angles, or a quaternion."""

    yaw: Degrees = 0.0  # to the right
    pitch: Degrees = 0.0  # then up
    roll: Degrees = 0.0  # then clockwise
    x: Coordinate | None = None
    y: Coordinate | None = None
    z: Coordinate | None = None
    w: Coordinate | None = None


class SgctFov(msgspec.Struct, frozen=True):
    """The field of a planar view: whole angles, or those to each edge, outwards."""

    hfov: Degrees | None = None
    vfov: Degrees | None = None
    left: Degrees | None = None
    right: Degrees | None = None
    up: Degrees | None = None
    down: Degrees | None = None
    distance: Metres | None = None


class SgctCrop(msgspec.Struct, frozen=True):
    """Shares of a fisheye's square that are cut off."""

    left: float
    right: float
    bottom: float
    top: float


class SgctGeometry(msgspec.Struct, frozen=True):
    """The four meshes of a spherical mirror."""

    bottom: str
    left: str
    right: str
    top: str


class SgctProjection(msgspec.Struct, frozen=True):
    """A projection of any type."""

    type: str
    fov: Degrees | SgctFov | None = None
    distance: Metres | None = None
    orientation: SgctTurn | None = None
    offset: SgctPoint | None = None
    tilt: Degrees = 0.0
    diameter: Metres | None = None
    crop: SgctCrop | None = None
    keepaspectratio: bool = True
    lowerleft: SgctPoint | None = None
    upperleft: SgctPoint | None = None
    upperright: SgctPoint | None = None
    rotation: Degrees = 0.0  # radians
    heightoffset: Metres = 0.0
    radius: Metres = 5.0
    channels: dict[str, bool] = {}
    geometry: SgctGeometry | None = None
    mesh: SgctGeometry | None = None  # as `geometry` was called before


class SgctViewport(msgspec.Struct, frozen=True):
    """A part of a window."""

    pos: SgctPair | None = None
    size: SgctPair | None = None
    projection: SgctProjection | None = None
    mesh: str | None = None
    blendmask: str | None = None
    blacklevelmask: str | None = None
    overlay: str | None = None
    eye: str | None = None
    user: str | None = None


class SgctWindow(msgspec.Struct, frozen=True):
    """A window."""

    size: SgctPair | None = None
    name: str | None = None
    pos: SgctPair | None = None
    fullscreen: bool = False
    monitor: int | None = None
    stereo: str = "none"
    draw3d: bool = True
    mirrorx: bool = False
    mirrory: bool = False
    scalablemesh: str | None = None
    viewports: list[SgctViewport] = []


class SgctNode(msgspec.Struct, frozen=True):
    """A computer."""

    address: str
    windows: list[SgctWindow] = []


class SgctUser(msgspec.Struct, frozen=True):
    """A viewer."""

    name: str = ""
    eyeseparation: Metres | None = None
    pos: SgctPoint | None = None
    orientation: SgctTurn | None = None
    matrix: Any = None
    tracking: Any = None


class SgctConfig(msgspec.Struct, frozen=True):
    """A configuration."""

    version: int
    masteraddress: str
    nodes: list[SgctNode]
    users: list[SgctUser] = []
    meta: dict[str, Any] = {}
    scene: Any = None
    trackers: Any = None


VERSION = 1
# Keys with no meaning for what is shown where, which need no line.
QUIET = frozenset({"$schema", "id", "tags", "tracked", "draw2d", "port", "generator"})
RENAMED = {"heading": "yaw"}
VIEW = frozenset({"fov", "distance", "orientation", "offset"})
# Keys of each projection that are used here.
PROJECTIONS = {
    "PlanarProjection": VIEW,
    "TextureMappedProjection": VIEW,
    "ProjectionPlane": {"lowerleft", "upperleft", "upperright"},
    "FisheyeProjection": {"fov", "tilt", "diameter", "crop", "keepaspectratio", "offset"},
    "SphericalMirrorProjection": {"tilt", "geometry", "mesh"},
    "CylindricalProjection": {"rotation", "heightoffset", "radius"},
    "CubemapProjection": {"channels", "orientation"},
}


def lowered(content: Any) -> Any:
    """The content with keys in lower case, as older files have `masterAddress` or `hFov`."""
    if isinstance(content, list):
        return [lowered(inner) for inner in content]
    if not isinstance(content, dict):
        return content
    keys = {key: RENAMED.get(key.lower(), key.lower()) for key in content}
    return {keys[key]: lowered(inner) for key, inner in content.items()}


def foreign_keys(projection: SgctProjection) -> list[str]:
    """The keys of a projection that belong to other kinds."""
    plain, own = SgctProjection(projection.type), PROJECTIONS.get(projection.type, frozenset())
    fields = projection.__struct_fields__[1:]
    given = [key for key in fields if getattr(projection, key) != getattr(plain, key)]
    return sorted(set(given) - own)


def read_config(path: Path, content: Any) -> SgctConfig:
    """Check the content of a configuration; a UserError names the faulty key."""
    try:
        config = convert(content, SgctConfig)
    except UserError as fault:
        raise UserError(fault.message, file=path, key=fault.key) from fault
    if config.version != VERSION:
        raise UserError(f"`version` {config.version}, expected {VERSION}", file=path)
    return config
