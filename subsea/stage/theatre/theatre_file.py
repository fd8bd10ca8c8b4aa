"""Theatre files: windows, projectors and the screens that they light, from TOML.

Lengths are real centimetres in the axes of somebody who looks ahead: x right, y up, z ahead.
"""

import ipaddress
import re
from typing import Annotated, ClassVar, Literal

import msgspec

from subsea.view.adjustment import MOST_EDGES
from subsea.view.rig import Rect, overlap
from subsea.view.surround import ALL_ROUND

# ASCII, because files are named so; `\Z`, because `$` would accept a final line break.
NAME = r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}\Z"


def parse_address(address: str) -> tuple[ipaddress.IPv4Address | ipaddress.IPv6Address, int]:
    """Parse an IP address with a port, such as ``127.0.0.1:5560``; ValueError for host names."""
    host, _, port = address.rpartition(":")
    try:
        if not port.isascii() or not port.isdecimal() or not 1 <= int(port) <= 65535:
            raise ValueError
        return ipaddress.ip_address(host.strip("[]")), int(port)
    except ValueError:
        raise ValueError(
            f"address {address!r}: expected an IP address and a port, such as 127.0.0.1:5560"
        ) from None


def check_ip(address: str, example: str) -> None:
    """Raise a ValueError for anything but an IP address."""
    try:
        ipaddress.ip_address(address)
    except ValueError:
        message = f"address {address!r}: expected an IP address such as {example}"
        raise ValueError(message) from None


FOLDER = "assets/theatres"
MOST_WINDOWS, MOST_LOUDSPEAKERS, MOST_LAMPS = 64, 32, 256
MOST_POINTS = 17  # a side of a grid of points
MAIN = "main"  # the node of windows that name none

FEWEST_PIXELS = 16  # a side of a window or of a part of one
Pixels = Annotated[int, msgspec.Meta(ge=FEWEST_PIXELS, le=16384)]
Offset = Annotated[int, msgspec.Meta(ge=-100_000, le=100_000)]
Positive = Annotated[float, msgspec.Meta(ge=0.001, le=1e5)]
Away = Annotated[float, msgspec.Meta(ge=50, le=1e5)]  # of surround screens, which hold both eyes
Coordinate = Annotated[float, msgspec.Meta(ge=-1e5, le=1e5)]
Point = tuple[Coordinate, Coordinate, Coordinate]
Angle = Annotated[float, msgspec.Meta(ge=-360, le=360)]
Name = Annotated[str, msgspec.Meta(pattern=NAME)]
# Not //HOST/FILE: Windows would show a stranger's computer who the user is. No other key has this
# pattern: by it all names of files are found (`theatre_writer.moved_files`).
FILE = r"^(?![/\\]{2})"
File = Annotated[str, msgspec.Meta(pattern=FILE)]
Shift = Annotated[float, msgspec.Meta(ge=-16384, le=16384)]
PixelPair = tuple[Shift, Shift]  # right, down
PointRow = Annotated[list[PixelPair], msgspec.Meta(min_length=2, max_length=MOST_POINTS)]
Share = Annotated[float, msgspec.Meta(ge=0, le=1)]
Extent = Annotated[float, msgspec.Meta(ge=-10, le=10)]
Span = Annotated[float, msgspec.Meta(ge=0.001, le=10)]


class _Table(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A table of a theatre file."""


class Plane(_Table, frozen=True, kw_only=True):
    """A flat screen by three of its corners."""

    lower_left: Point
    lower_right: Point
    upper_left: Point


class Cylinder(_Table, frozen=True, kw_only=True):
    """A part of an upright cylinder about the point `axis_cm` (x, z), seen from within."""

    radius_cm: Positive
    left_deg: Angle  # from straight ahead, right positive
    right_deg: Angle
    bottom_cm: Coordinate
    top_cm: Coordinate
    axis_cm: tuple[Coordinate, Coordinate] = (0.0, 0.0)


class Angles(_Table, frozen=True, kw_only=True):
    """A flat screen by the angles under which the eye sees it."""

    left_deg: Annotated[float, msgspec.Meta(gt=-89, lt=89)]
    right_deg: Annotated[float, msgspec.Meta(gt=-89, lt=89)]
    down_deg: Annotated[float, msgspec.Meta(gt=-89, lt=89)]
    up_deg: Annotated[float, msgspec.Meta(gt=-89, lt=89)]
    heading_deg: Angle = 0.0  # right positive
    pitch_deg: Angle = 0.0  # up positive
    roll_deg: Angle = 0.0  # clockwise positive
    distance_cm: Positive = 300.0  # only matters for two eyes


class Panorama(_Table, frozen=True, kw_only=True):
    """An uncalibrated cylinder: every column of pixels is an equal angle."""

    angle_deg: Annotated[float, msgspec.Meta(ge=30, lt=360)] = ALL_ROUND.angle_deg
    distance_cm: Away = 300.0


class Dome(_Table, frozen=True, kw_only=True):
    """An equidistant fisheye, tilted to the front, which is below."""

    tilt_deg: Annotated[float, msgspec.Meta(ge=0, le=90)] = ALL_ROUND.tilt_deg
    angle_deg: Annotated[float, msgspec.Meta(ge=30, le=360)] = ALL_ROUND.dome_deg
    distance_cm: Away = 500.0


class Equirectangular(_Table, frozen=True, kw_only=True):
    """All directions, the front in the middle."""

    distance_cm: Away = 300.0


SCREENS = ("plane", "cylinder", "angles", "panorama", "dome", "equirectangular")


class Corners(_Table, frozen=True, kw_only=True):
    """Shifts of the corners of a picture, pixels right and down."""

    upper_left: PixelPair = (0.0, 0.0)
    upper_right: PixelPair = (0.0, 0.0)
    lower_left: PixelPair = (0.0, 0.0)
    lower_right: PixelPair = (0.0, 0.0)


GAMMAS = 0.5, 4.0  # least and largest


class Adjustment(_Table, frozen=True, kw_only=True):
    """Turn, shifts, mask and colours of a projector's picture, as line-up on the wall sets them.

    Pixels count right and down in the picture as the audience sees it.
    """

    flip: Literal["horizontal", "vertical"] | None = None  # first; as for rear projection
    rotate: Literal[0, 90, 180, 270] = 0  # then clockwise; 180: the projector hangs upside down
    corners_px: Corners | None = None
    # Further shifts of the points of a regular grid over the picture, the upper row first.
    points_px: Annotated[
        list[PointRow], msgspec.Meta(min_length=2, max_length=MOST_POINTS)
    ] | None = None  # fmt: skip
    # A polygon in pixels from the picture's upper left corner; it is dark outside.
    edge_mask: Annotated[
        list[PixelPair], msgspec.Meta(min_length=3, max_length=MOST_EDGES)
    ] | None = None  # fmt: skip
    edge_soft_px: Annotated[float, msgspec.Meta(ge=1, le=500)] = 2.0
    gain: tuple[Share, Share, Share] = (1.0, 1.0, 1.0)  # factors on red, green and blue light
    # Of the projector: light is the value that it gets to this power. Three: red, green and blue,
    # and the picture is changed to look as with 2.2.
    gamma: float | tuple[float, float, float] = 2.2
    # The share of its white that the projector shines when it should be dark.
    black: Annotated[float, msgspec.Meta(ge=0, le=0.05)] = 0.0
    # Of the fade across an overlap, over the usual width.
    blend_width: Annotated[float, msgspec.Meta(ge=0.1, le=2)] = 1.0

    def __post_init__(self) -> None:
        """Require plausible gammas.

        msgspec 0.22 mixes up the limits of a number and of those in a tuple in one union.
        """
        gammas = self.gamma if isinstance(self.gamma, tuple) else (self.gamma,)
        if not all(GAMMAS[0] <= gamma <= GAMMAS[1] for gamma in gammas):
            raise ValueError(f"`gamma`: expected {GAMMAS[0]:g} to {GAMMAS[1]:g}")


class ScreenTable(Adjustment, frozen=True, kw_only=True):
    """Keys of channels and archives: one of six kinds of screen, and its adjustment."""

    plane: Plane | None = None
    cylinder: Cylinder | None = None
    angles: Angles | None = None
    panorama: Panorama | None = None
    dome: Dome | None = None
    equirectangular: Equirectangular | None = None

    _needs_screen: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Require exactly one screen."""
        super().__post_init__()
        given = [name for name in SCREENS if getattr(self, name) is not None]
        if len(given) > 1 or (not given and self._needs_screen):
            what = " and ".join(f"`{name}`" for name in given) or "none"
            raise ValueError(f"expected one of {', '.join(SCREENS)}, got {what}")


class Window(_Table, frozen=True, kw_only=True):
    """A window at a position of the desktop, or on a whole monitor."""

    name: Name
    size: tuple[Pixels, Pixels]
    position: tuple[Offset, Offset] | None = None  # of its upper left corner, in pixels
    monitor: str | Annotated[int, msgspec.Meta(ge=1, le=64)] | None = None  # by name, or 1, 2, …
    node: Name = MAIN  # the computer that it is on


class Channel(ScreenTable, frozen=True, kw_only=True):
    """The part of a window for one projector or screen."""

    name: Name
    window: Name
    # x, y, width, height in pixels from the window's upper left corner; None: all of it
    viewport: tuple[Annotated[int, msgspec.Meta(ge=0)], Annotated[int, msgspec.Meta(ge=0)],
                    Pixels, Pixels] | None = None  # fmt: skip
    blend: bool = False  # with all others that light the same part of the screen
    warp: File | None = None  # a mesh of `mesh_formats.FORMATS`, relative to the theatre file
    mask: File | None = None  # a PNG picture of factors, relative to the theatre file
    # A PNG picture of light to add, 1 for the projector's white, relative to the theatre file.
    black_mask: File | None = None
    # x, y, width, height of the part that is shown, in shares of the screen from the lower left
    part: tuple[Extent, Extent, Span, Span] | None = None
    eye: Literal["left", "right"] | None = None  # of a projector for one eye; None: the mode's


class Archive(ScreenTable, frozen=True, kw_only=True):
    """Channels from a calibration tool's MPCDI archive.

    The screen is that of a whole buffer; regions that have a frustum of their own need none.
    """

    _needs_screen: ClassVar[bool] = False

    file: File
    # Window of each region; None: the window of the same name.
    windows: dict[str, Name] | None = None
    buffer: str | None = None  # None: all of them
    adjust: dict[str, Adjustment] = {}  # of single regions, instead of the archive's own keys


class Cluster(_Table, frozen=True, kw_only=True):
    """Several computers: the master and its address."""

    master: Name
    address: str = "127.0.0.1:5560"
    timeout_s: Annotated[float, msgspec.Meta(ge=0.05, le=60)] = 2.0
    keys: File | None = None  # a folder made by `subsea keys`

    def __post_init__(self) -> None:
        """Refuse an invalid address."""
        parse_address(self.address)


class Loudspeaker(_Table, frozen=True, kw_only=True):
    """A loudspeaker as the best seat sees it: a channel of the sound device of a computer."""

    azimuth_deg: Angle  # from straight ahead, right positive
    elevation_deg: Annotated[float, msgspec.Meta(ge=-90, le=90)] = 0.0  # up positive
    node: Name = MAIN  # the computer that it is connected to


class Lights(_Table, frozen=True, kw_only=True):
    """The desk that gets the levels of the room's lamps."""

    protocol: Literal["artnet", "sacn"]
    address: str | None = None  # None: of sACN multicast, of Art-Net this computer
    port: Annotated[int, msgspec.Meta(ge=1, le=65535)] | None = None  # None: the protocol's
    rate: Annotated[float, msgspec.Meta(ge=1, le=44)] = 30.0  # most packets a second
    priority: Annotated[int, msgspec.Meta(ge=0, le=200)] = 100  # among sources of sACN
    gain: Annotated[float, msgspec.Meta(ge=0.1, le=20)] = 2.0  # of the sea's light
    dark: Annotated[float, msgspec.Meta(ge=0, le=1)] = 0.0  # level while the screens are black

    def __post_init__(self) -> None:
        """Refuse host names: to look one up could take long."""
        if self.address is not None:
            check_ip(self.address, "192.168.1.30")


SLOTS = 512  # levels in a universe
LAMP_COLOURS = {"rgb": 3, "rgbw": 4, "white": 1}  # numbers of levels


class Lamp(_Table, frozen=True, kw_only=True):
    """A lamp of the room, which shines with the sea's light from its direction."""

    name: Name
    channel: Annotated[int, msgspec.Meta(ge=1, le=SLOTS)]  # its first one
    universe: Annotated[int, msgspec.Meta(ge=0, le=63999)] = 1
    colours: Literal["rgb", "rgbw", "white"] = "rgb"
    fine: bool = False  # two channels for each colour: coarse, then fine
    azimuth_deg: Angle = 0.0  # from straight ahead, right positive
    elevation_deg: Annotated[float, msgspec.Meta(ge=-90, le=90)] = 0.0  # up positive
    level: Annotated[float, msgspec.Meta(ge=0, le=1)] = 1.0  # at full light
    gamma: Annotated[float, msgspec.Meta(ge=0.5, le=4)] = 1.0  # light is its level to this power

    @property
    def channels(self) -> range:
        """The channels that it takes, from 1."""
        number = LAMP_COLOURS[self.colours] * (2 if self.fine else 1)
        return range(self.channel, self.channel + number)


MAC = r"[0-9A-Fa-f]{2}([:-][0-9A-Fa-f]{2}){5}\Z"


class NodeTable(_Table, frozen=True, kw_only=True):
    """A computer that the network can switch on."""

    name: Name
    mac: str  # of its network card
    wake: str = "255.255.255.255:9"  # where the packet that wakes it goes

    def __post_init__(self) -> None:
        """Refuse other hardware addresses, and host names."""
        try:
            parse_address(self.wake)
        except ValueError as fault:
            raise ValueError(f"`wake`: {fault}") from None
        if not re.match(MAC, self.mac):
            message = f"mac {self.mac!r}: expected six pairs of digits such as 00:1a:2b:3c:4d:5e"
            raise ValueError(message)


class ProjectorTable(_Table, frozen=True, kw_only=True):
    """A projector that is controlled by PJLink."""

    name: Name
    address: str
    port: Annotated[int, msgspec.Meta(ge=1, le=65535)] = 4352
    password: File | None = None  # a file that holds it, relative to the theatre file

    def __post_init__(self) -> None:
        """Refuse host names: to look one up could take long."""
        check_ip(self.address, "192.168.10.41")


class VesselTable(_Table, frozen=True, kw_only=True):
    """The vessel drawn around the audience, at rest on the hull."""

    spring_deg: Annotated[float, msgspec.Meta(ge=-80, le=60)] = 0.0  # elevation of the lower edge
    rim_deg: Annotated[float, msgspec.Meta(ge=0.5, le=30)] = 4.0  # height of the rim
    tilt_deg: Annotated[float, msgspec.Meta(ge=0, le=90)] = 0.0  # to the front, as that of a dome
    instruments: bool = True  # text and instruments on a panel that stands on the rim
    panel_deg: Annotated[float, msgspec.Meta(ge=10, le=90)] = 50.0  # width of the panel


class SphericalMirror(_Table, frozen=True, kw_only=True):
    """A convex mirror that a projector shines on."""

    centre_cm: Point
    radius_cm: Positive


class Room(_Table, frozen=True, kw_only=True):
    """Things that only the picture of the room shows."""

    floor_cm: Coordinate | None = None
    dome: Dome | None = None  # that `angles` are projected on
    projectors: dict[str, Point] = {}  # lenses, by channel
    mirror: SphericalMirror | None = None


class Theatre(_Table, frozen=True, kw_only=True):
    """A whole theatre."""

    title: str = ""
    scale: Annotated[float, msgspec.Meta(ge=0.01, le=100)] = 1.0  # cm of the sea per real cm
    eye_cm: Point = (0.0, 0.0, 0.0)  # between the eyes at the best seat
    eye_distance_cm: Annotated[float, msgspec.Meta(ge=0, le=20)] = 6.4
    level: bool = False  # the horizon stays level, whatever the submarine's pitch
    window: Annotated[list[Window], msgspec.Meta(min_length=1, max_length=MOST_WINDOWS)]
    channel: Annotated[list[Channel], msgspec.Meta(max_length=MOST_WINDOWS)] = []
    mpcdi: Annotated[list[Archive], msgspec.Meta(max_length=MOST_WINDOWS)] = []
    loudspeaker: Annotated[list[Loudspeaker], msgspec.Meta(max_length=MOST_LOUDSPEAKERS)] = []
    lights: Lights | None = None
    lamp: Annotated[list[Lamp], msgspec.Meta(max_length=MOST_LAMPS)] = []
    cluster: Cluster | None = None
    node: Annotated[list[NodeTable], msgspec.Meta(max_length=MOST_WINDOWS)] = []
    projector: Annotated[list[ProjectorTable], msgspec.Meta(max_length=MOST_WINDOWS)] = []
    room: Room | None = None
    vessel: VesselTable | None = None

    @property
    def nodes(self) -> tuple[str, ...]:
        """The computers, in the order in which windows name them."""
        return tuple(dict.fromkeys(window.node for window in self.window))


def viewport(channel: Channel, window: Window) -> Rect:
    """The rectangle of a channel in its window: x, y from the upper left, width, height."""
    return channel.viewport or (0, 0, *window.size)


def adjustment_of(table: Adjustment) -> Adjustment:
    """Take the adjustment out of a channel or an archive."""
    return Adjustment(**{key: getattr(table, key) for key in Adjustment.__struct_fields__})


def covers(window: Window, other: Window) -> str:
    """The key, `monitor` or `position`, by which two windows of a computer lie on one another."""
    if window.node != other.node:
        return ""
    if window.monitor is not None and window.monitor == other.monitor:
        return "monitor"
    if window.position is None or other.position is None:
        return ""
    return "position" * overlap((*window.position, *window.size), (*other.position, *other.size))
