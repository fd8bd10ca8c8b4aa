"""Messages of the fleet between master and nodes, which ride on the connection of their dive.

They have a number of their own, which rises less often than that of the dive's messages, and
receivers pass over keys that they do not know: computers with different versions of subsea still
know each other's, and can be updated.
"""

from typing import Annotated

import msgspec

from subsea.stage.cluster.messages import FLEET, PART, Count, Name, Words, content_of

NUMBER = 1
MAGIC = FLEET + NUMBER.to_bytes(1, "little")
MOST_PICTURE = 32_000  # bytes of a JPEG
MOST_WHEEL = 1 << 29  # bytes
WHEEL_PART = 1 << 18  # bytes of a wheel in a message

Line = Annotated[str, msgspec.Meta(max_length=200)]
Positive = Annotated[float, msgspec.Meta(ge=0, le=1e12)]
Digest = Annotated[str, msgspec.Meta(pattern=r"^[0-9a-f]{64}\Z")]
WheelName = Annotated[str, msgspec.Meta(pattern=r"^subsea-[\w.+!]{1,80}(-[\w.]{1,60}){3,4}\.whl\Z")]
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


class WheelOffer(FleetMessage, tag="offer"):
    """To a node: a wheel of subsea that it is to take, if it can install it."""

    wheel: WheelName
    version: Name
    size: Annotated[int, msgspec.Meta(ge=1, le=MOST_WHEEL)]  # bytes
    digest: Digest  # SHA-256
    requires: list[Words]  # the packages that it needs, as its metadata list them


class WheelPart(FleetMessage, tag="wheel"):
    """To a node: bytes of the wheel."""

    offset: Count
    data: Annotated[bytes, msgspec.Meta(min_length=1, max_length=WHEEL_PART)]


class Install(FleetMessage):
    """To a node: install the wheel that it has, beside the running version, and try it."""


class Switch(FleetMessage):
    """To a node: start with the installed version from now on, and restart."""


class Rollback(FleetMessage):
    """To a node: start with the version before from now on, and restart."""

    only_check: bool = False  # True: only say which version that is


class Answer(FleetMessage):
    """From a node: the result of an order of an update."""

    order: Annotated[str, msgspec.Meta(max_length=20)]  # the tag of its message
    done: bool
    words: Words = ""  # the version that it is about, or the reason of a refusal
    offset: Count = 0  # bytes of the wheel that it has


UpdateOrder = WheelOffer | WheelPart | Install | Switch | Rollback
FromNode = NodeFacts | PicturePart | Answer
FromMaster = PictureWanted | Restart | UpdateOrder

_from_node: msgspec.msgpack.Decoder[FromNode] = msgspec.msgpack.Decoder(FromNode)
_from_master: msgspec.msgpack.Decoder[FromMaster] = msgspec.msgpack.Decoder(FromMaster)


def encode(message: FromNode | FromMaster) -> bytes:
    """Encode a message."""
    return MAGIC + msgspec.msgpack.encode(message)


def from_node(data: bytes) -> FromNode:
    """Decode a message of a node; anything else is a UserError."""
    return content_of(data, MAGIC, _from_node)


def from_master(data: bytes) -> FromMaster:
    """Decode a message of the master; anything else is a UserError."""
    return content_of(data, MAGIC, _from_master)
