"""Messages between master and nodes: small structures with strict types and limits.

Every message begins with MAGIC and the protocol number, so that another version gets a clear
error and anything else is rejected at once. The rest is MessagePack, decoded into these structures
only.
"""

from collections.abc import Sequence
from typing import Annotated, TypeVar

import msgspec
import numpy as np

from subsea import __version__
from subsea.base.errors import UserError
from subsea.dive.presented import NOTHING, Presented
from subsea.stage.theatre.line_up import LineUpState
from subsea.submarine.vessel import Helm, Rail

PROTOCOL = 8
MAGIC = b"subsea\x00" + PROTOCOL.to_bytes(1, "little")
FLEET = b"subsea-fleet\x00"  # begins messages of `stage/fleet/messages.py`, which pass unread
SMALL = 4096  # bytes; all messages but the state of a dive and a line-up are smaller
LINE_UP = 1 << 20  # bytes of a picture with a line-up
PART = 3800  # bytes of a state in a message to the master: with all around them below SMALL
SLICE = 16 * PART  # bytes of a state that the master asks for at once
MAX_HELMS = 16  # ticks in a picture
MAX_PART = 60  # characters of a value of an identity
HASH = "#"  # begins a value that only shows that something differs

T = TypeVar("T")
Name = Annotated[str, msgspec.Meta(pattern=r"^[\w.+-]{1,64}\Z")]
Words = Annotated[str, msgspec.Meta(max_length=1000)]
Hash = Annotated[str, msgspec.Meta(max_length=64)]
PartName = Annotated[str, msgspec.Meta(pattern=r"^[\w./ -]{1,40}\Z")]
PartValue = Annotated[str, msgspec.Meta(pattern=r"^[\w .,:'()/+#?-]{0,60}\Z")]
Count = Annotated[int, msgspec.Meta(ge=0, le=2**48)]
Share = Annotated[float, msgspec.Meta(ge=0, le=1)]
Command = Annotated[float, msgspec.Meta(ge=-1, le=1)]
Amount = Annotated[float, msgspec.Meta(ge=-1e6, le=1e6)]  # cm, cm/s or rad
HelmRow = tuple[Command, Command, Command, Command, bool]
RailRow = tuple[Amount, Amount, Amount, Amount, Amount, Amount, Amount, Amount, bool]


class Message(msgspec.Struct, forbid_unknown_fields=True, tag=str.lower):
    """Base of all messages."""


class Identity(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Data that must be equal on computers that show one dive: see `stage/cluster/identity.py`."""

    version: Name  # of subsea, for messages
    parts: Annotated[dict[PartName, PartValue], msgspec.Meta(max_length=64)]


class Hello(Message):
    """From a node: a request for the state, unless it is already in this `dive`."""

    node: Name
    identity: Identity
    dive: Hash = ""
    tick: Count = 0  # of its world, if that is of a dive


class PictureDrawn(Message, tag="drawn"):
    """From a node: this picture is ready to be shown."""

    number: Count


class Diverged(Message):
    """From a node: its world differs from the master's, so it needs the state."""

    tick: Count


class StatePart(Message, tag="part"):
    """From a node: bytes of a snapshot of its world, as `Resume` asked for."""

    size: Count  # of the snapshot, bytes
    offset: Count  # of this part
    data: Annotated[bytes, msgspec.Meta(min_length=1, max_length=PART)]


class NodeReport(Message, tag="report"):
    """From a node: a line for the presenter, such as why its theatre file was not saved."""

    words: Words


class NodeRequest(Message, tag="ask"):
    """From a node: a command of its keyboard, as JSON, which the master checks."""

    command: Annotated[bytes, msgspec.Meta(max_length=1000)]


class WorldState(Message, tag="state"):
    """To a node: the world after the picture of this number; see `subsea/world/snapshot.py`."""

    dive: Hash
    number: Count
    snapshot: bytes


class Picture(Message):
    """To all nodes: the ticks to step, with the pilot's input, and the point to draw at."""

    number: Count
    tick: Count  # before them
    alpha: Share  # the point between the last two ticks at which to draw
    helms: Annotated[list[HelmRow], msgspec.Meta(max_length=MAX_HELMS)]
    # Of a tour: position, velocity, heading, pitch and cut after each tick; come first.
    rails: Annotated[list[RailRow], msgspec.Meta(max_length=MAX_HELMS)] = []
    checksum: Hash = ""  # of the world before them, or empty
    lights: bool = False  # whether the submarine's lights are on
    presented: Presented = NOTHING  # over the sea, or instead of it
    line_up: LineUpState | None = None  # of the theatre from now on; None: as before


class Swap(Message):
    """To all nodes: show this picture. Repeated while other nodes are waited for."""

    number: Count


class Resume(Message):
    """To a node: a request for SLICE bytes of its state, with which a new master goes on."""

    offset: Count


class OpenSea(Message, tag="open"):
    """To a node: the master's scenario, by its name, and its seed; the node is to open it."""

    name: Name
    seed: Count


class Refused(Message):
    """To a node: why it is refused."""

    reason: Words


FromNode = Hello | PictureDrawn | Diverged | StatePart | NodeReport | NodeRequest
FromMaster = WorldState | Picture | Swap | Resume | OpenSea | Refused

_from_node: msgspec.msgpack.Decoder[FromNode] = msgspec.msgpack.Decoder(FromNode)
_from_master: msgspec.msgpack.Decoder[FromMaster] = msgspec.msgpack.Decoder(FromMaster)


def encode(message: FromNode | FromMaster) -> bytes:
    """Encode a message."""
    return MAGIC + msgspec.msgpack.encode(message)


def from_node(data: bytes) -> FromNode:
    """Decode a message of a node; anything else is a UserError."""
    return _decode(data, _from_node)


def from_master(data: bytes) -> FromMaster:
    """Decode a message of the master; anything else is a UserError."""
    return _decode(data, _from_master)


def ticks_of(picture: Picture) -> list[Helm | Rail]:
    """The input or rail of the submarine in each tick of a picture."""
    carried = [
        Rail(np.array(row[:3]), np.array(row[3:6]), row[6:8], row[8]) for row in picture.rails
    ]
    return [*carried, *(Helm(*row) for row in picture.helms)]


def picture_of(
    number: int, tick: int, alpha: float, ticks: Sequence[Helm | Rail], checksum: str,
    lights: bool = False, presented: Presented = NOTHING, line_up: LineUpState | None = None,
) -> Picture:  # fmt: skip
    """The message of a picture; its rails must come before its helms."""
    rails = [_rail_row(steered) for steered in ticks if isinstance(steered, Rail)]
    helms = [_helm_row(steered) for steered in ticks if isinstance(steered, Helm)]
    return Picture(number, tick, float(alpha), helms, rails, checksum, lights, presented, line_up)


def _helm_row(helm: Helm) -> HelmRow:
    surge, yaw, pitch, heave = (min(max(float(share), -1.0), 1.0) for share in helm[:4])
    return surge, yaw, pitch, heave, bool(helm.full_stop)


def _rail_row(rail: Rail) -> RailRow:
    (x, y, z), (u, v, w) = map(float, rail.position), map(float, rail.velocity)
    return x, y, z, u, v, w, float(rail.angles[0]), float(rail.angles[1]), bool(rail.cut)


def _decode(data: bytes, decoder: msgspec.msgpack.Decoder[T]) -> T:
    if data[: len(MAGIC) - 1] != MAGIC[:-1] or len(data) < len(MAGIC):
        raise UserError("the message received is not one of subsea")
    if data[len(MAGIC) - 1] != PROTOCOL:
        raise UserError(
            f"speaks protocol {data[len(MAGIC) - 1]}, expected {PROTOCOL}: it has another version "
            f"of subsea than {__version__}"
        )
    return content_of(data, MAGIC, decoder)


def content_of(data: bytes, magic: bytes, decoder: msgspec.msgpack.Decoder[T]) -> T:
    """Decode a message that begins with `magic`; anything else is a UserError."""
    try:
        if not data.startswith(magic):
            raise msgspec.DecodeError("another beginning")
        return decoder.decode(data[len(magic) :])
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as fault:
        raise UserError(f"the message received is not one of subsea ({fault})") from fault
