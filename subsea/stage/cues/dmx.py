"""Send levels of lamps to a light desk or its nodes: Art-Net 4 and sACN (ANSI E1.31-2018).

Both carry a universe, up to 512 levels from 0 to 255, in a UDP packet. A thread sends: a desk that
hears nothing for some seconds would let go of its lamps, also while the dive opens a scenario.
"""

import ipaddress
import socket
import time
import uuid
from collections.abc import Mapping
from threading import Event, Lock, Thread

from subsea.stage.theatre.theatre_file import SLOTS, Lights

ARTNET_PORT, SACN_PORT = 6454, 5568
KEEP_S = 0.8  # between two packets of levels that stay; E1.31 calls a source lost after 2.5 s
LAST_PACKETS = 3  # by which a source of sACN says that it ends
BACK_S = 3.0  # without a fault, after which a desk counts as back
SOURCE = "subsea"
# The same for each start on a computer, so that a receiver knows the source again.
SENDER = uuid.uuid5(uuid.NAMESPACE_DNS, f"subsea.{uuid.getnode():x}").bytes


def artnet_packet(universe: int, sequence: int, levels: bytes) -> bytes:
    """Make an ArtDmx packet; `sequence` is 1 to 255."""
    levels += bytes(len(levels) % 2)  # an even number
    head = b"Art-Net\0" + (0x5000).to_bytes(2, "little") + (14).to_bytes(2, "big")
    place = bytes([sequence, 0]) + universe.to_bytes(2, "little")
    return head + place + len(levels).to_bytes(2, "big") + levels


def sacn_packet(
    universe: int, sequence: int, levels: bytes, priority: int = 100, last: bool = False
) -> bytes:
    """Make an E1.31 data packet; `sequence` is 0 to 255, and `last` says that the source ends."""

    def layer(vector: bytes, content: bytes) -> bytes:
        """Flags and length, which counts itself, before a layer of the protocol."""
        size = 2 + len(vector) + len(content)
        return (0x7000 | size).to_bytes(2, "big") + vector + content

    values = b"\0" + levels.ljust(SLOTS, b"\0")  # a start code of 0: plain levels
    first, step = (0).to_bytes(2, "big"), (1).to_bytes(2, "big")
    dmp = layer(b"\x02", b"\xa1" + first + step + len(values).to_bytes(2, "big") + values)
    about = SOURCE.encode().ljust(64, b"\0") + bytes([priority, 0, 0, sequence, 0x40 * last])
    framing = layer((2).to_bytes(4, "big"), about + universe.to_bytes(2, "big") + dmp)
    root = layer((4).to_bytes(4, "big"), SENDER + framing)
    return (0x0010).to_bytes(2, "big") + bytes(2) + b"ASC-E1.17\0\0\0" + root


def place_of(lights: Lights, universe: int) -> tuple[str, int]:
    """Find the address and port for a universe; sACN without an address is multicast."""
    if lights.protocol == "artnet":
        return lights.address or "127.0.0.1", lights.port or ARTNET_PORT
    multicast = f"239.255.{universe >> 8}.{universe & 255}"
    return lights.address or multicast, lights.port or SACN_PORT


class LightSender:
    """Sends the universes that it was given last, in a thread of its own."""

    def __init__(self, lights: Lights) -> None:
        """Begin to send; nothing until the first levels."""
        self._lights = lights
        self._universes: dict[int, bytes] = {}
        self._sent: dict[int, tuple[float, bytes]] = {}  # when, and what
        self._sequences: dict[int, int] = {}
        self._sockets: dict[int, socket.socket] = {}
        self._lock, self._ends = Lock(), Event()
        self._fault, self._fault_s = "", 0.0  # of the last try; when it was
        self._told = False
        self._thread = Thread(target=self._run, name="lights", daemon=True)
        self._thread.start()

    def set(self, universes: Mapping[int, bytes]) -> None:
        """Send these levels by universe from now on."""
        with self._lock:
            self._universes = dict(universes)

    def check(self) -> str:
        """A line if the desk is gone or back since the last call, else an empty one."""
        gone = bool(self._fault) and time.monotonic() - self._fault_s < BACK_S
        if gone == self._told:
            return ""
        self._told = gone
        if gone:
            return f"the lights do not answer: {self._fault}; the show goes on"
        self._fault = ""
        return "the lights answer again"

    def close(self) -> None:
        """Send the last levels, say that the source ends, and stop."""
        self._ends.set()
        self._thread.join(2.0)

    def _run(self) -> None:
        period_s = 1.0 / self._lights.rate
        while not self._ends.wait(period_s):
            self._send_all(KEEP_S)
        self._send_all(0.0)
        if self._lights.protocol == "sacn":
            for _ in range(LAST_PACKETS):
                self._send_all(0.0, last=True)
        for one in self._sockets.values():
            one.close()

    def _send_all(self, keep_s: float, last: bool = False) -> None:
        """Send each universe that has changed, or that was sent `keep_s` ago."""
        now = time.monotonic()
        with self._lock:
            universes = list(self._universes.items())
        for universe, levels in universes:
            sent_s, before = self._sent.get(universe, (-KEEP_S, b""))
            if levels == before and now - sent_s < keep_s:
                continue
            self._sent[universe] = now, levels
            try:
                self._send(universe, levels, last)
            except OSError as fault:
                address, port = place_of(self._lights, universe)
                reason = fault.strerror or str(fault)
                self._fault, self._fault_s = f"{address}:{port} ({reason})", now

    def _send(self, universe: int, levels: bytes, last: bool) -> None:
        if universe not in self._sockets:
            self._sockets[universe] = _connected(place_of(self._lights, universe))
        number = self._sequences[universe] = self._sequences.get(universe, -1) + 1
        if self._lights.protocol == "artnet":
            packet = artnet_packet(universe, number % 255 + 1, levels)
        else:
            packet = sacn_packet(universe, number % 256, levels, self._lights.priority, last)
        self._sockets[universe].send(packet)


def _connected(place: tuple[str, int]) -> socket.socket:
    """A UDP socket to a place; connected, so that a computer without the port is noticed."""
    ip = ipaddress.ip_address(place[0])
    made = socket.socket(socket.AF_INET6 if ip.version == 6 else socket.AF_INET, socket.SOCK_DGRAM)
    try:
        made.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        made.setblocking(False)
        made.connect(place)
    except OSError:
        made.close()
        raise
    return made
