"""Messages of the fleet between master and nodes, which ride on the connection of their dive.

They have a number of their own, and receivers pass over keys that they do not know: the code of a
wing may differ between computers that show one dive.
"""

from typing import Annotated, TypeVar

import msgspec

from subsea.base.errors import UserError
from subsea.stage.cluster.messages import FLEET, PART, Count, Name

NUMBER = 1
MAGIC = FLEET + NUMBER.to_bytes(1, "little")
MOST_PICTURE = 32_000  # bytes of a JPEG

T = TypeVar("T")
Line = Annotated[str, msgspec.Meta(max_length=200)]
Positive = Annotated[float, msgspec.Meta(ge=0, le=1e12)]
Degrees = Annotated[float, msgspec.Meta(ge=-100, le=1000)]


class FleetMessage(msgspec.Struct, tag=str.lower):
    """Base of all messages of the fleet."""


class NodeFacts(FleetMessage, tag="facts"):
    """From a node, every two seconds: the state of its computer and of its dive."""

    version: Name  # of subsea
    protocol: Count  # number of the dive's messages
    system: Line = ""
    renderer: Line = ""
    temperature_c: Degrees | None = None  # None: unknown
    free_disk_gb: Positive | None = None
    frame_ms: Positive = 0.0  # mean time from picture to picture since the last report ...
    longest_ms: Positive = 0.0  # ... and the longest
    up_s: Positive = 0.0  # since the start of the dive
    fault: Line = ""  # the last one; empty: none yet
    fault_ago_s: Positive = 0.0


class PicturePart(FleetMessage, tag="picture"):
    """From a node: bytes of a JPEG of its front window, as `PictureWanted` asked for."""

    size: Annotated[int, msgspec.Meta(ge=1, le=MOST_PICTURE)]  # of the JPEG
    offset: Count  # of this part
    data: Annotated[bytes, msgspec.Meta(min_length=1, max_length=PART)]


class PictureWanted(FleetMessage, tag="wanted"):
    """To a node: a request for a picture."""


class Restart(FleetMessage):
    """To a node: end the dive and start the same command again."""


FromNode = NodeFacts | PicturePart
FromMaster = PictureWanted | Restart

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


def _decode(data: bytes, decoder: msgspec.msgpack.Decoder[T]) -> T:
    if data[: len(MAGIC)] != MAGIC:
        raise UserError("the message received is not one of this version's fleet")
    try:
        return decoder.decode(data[len(MAGIC) :])
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as fault:
        raise UserError(f"the message received is not one of the fleet ({fault})") from fault
