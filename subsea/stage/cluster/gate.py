"""Limits on the connections to the master, enforced beside it in a thread.

ZeroMQ limits the size of a part of a message but not the number of parts, and delivers a message
only when it is complete. So the gate counts the bytes of each connection in the kernel, where the
kernel has such counts (Linux), and ends connections that exceed their limits.
"""

import os
import socket as sockets
import struct
import threading
import time
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import zmq
from zmq.utils.monitor import parse_monitor_message

PERIOD_MS = 10  # interval of checks
RATE = BURST = 1 << 16  # bytes a second that a node may send, and bytes at once
MAX_FAULTS = 3  # invalid messages of a connection
MAX_STRANGERS = 32  # open connections of no node
AT_ONCE = 50  # events between two checks
REFUSED_S = 1.0  # time to deliver the reason of a refusal

EVENTS = zmq.EVENT_ACCEPTED | zmq.EVENT_DISCONNECTED
FAILURES = (
    zmq.EVENT_HANDSHAKE_FAILED_AUTH
    | zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL
    | zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL
)
TCP_ESTABLISHED = 1
BYTES_RECEIVED = 128  # offset in `struct tcp_info`


@dataclass
class Connection:
    """One connection to the master; `socket` is a duplicate of ZeroMQ's."""

    socket: sockets.socket
    checked_s: float
    received: int = 0  # bytes in all
    level: float = 0.0  # bytes beyond RATE
    credit: int = 0  # bytes that do not count
    faults: int = 0
    of_node: bool = False
    end_s: float = float("inf")  # when to close it

    def end(self) -> None:
        """End the connection; ZeroMQ then forgets its messages."""
        with suppress(OSError):
            self.socket.shutdown(sockets.SHUT_RDWR)
        self.socket.close()


class Gate:
    """Watches the connections of a listening socket; `close` it before the socket."""

    def __init__(self, socket: Any, port: int) -> None:
        """Watch `socket`, which does not listen yet, and will at `port`."""
        self._watched, self._port = socket, port
        self._connections: dict[int, Connection] = {}  # by ZeroMQ's file descriptor, oldest first
        self._lock = threading.Lock()  # of the connections and reports
        self._reports: Counter[str] = Counter()
        self._monitor = socket.get_monitor_socket(EVENTS | FAILURES)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="gate", daemon=True)
        self._thread.start()

    def reports(self) -> Counter[str]:
        """Number of connections ended or refused since the last call, by reason."""
        with self._lock:
            reports, self._reports = self._reports, Counter()
        return reports

    def keep(self, descriptor: int) -> Connection | None:
        """Mark a connection as that of a node; None if it has gone."""
        with self._lock:
            if found := self._connections.get(descriptor):
                found.of_node = True
        return found

    def allow(self, connection: Connection, size: int) -> None:
        """Let a connection send `size` bytes that were asked for."""
        with self._lock:
            connection.credit += size

    def end(self, connection: Connection) -> None:
        """End a connection, after the time that a last message to it takes."""
        with self._lock:
            connection.end_s, connection.of_node = time.monotonic() + REFUSED_S, False

    def fault(self, descriptor: int) -> None:
        """Count an invalid message of a connection."""
        with self._lock:
            if found := self._connections.get(descriptor):
                found.faults += 1

    def close(self) -> None:
        """End the thread; the connections stay open."""
        self._ended.set()
        self._thread.join()
        self._watched.disable_monitor()
        self._monitor.close(0)
        for one in self._connections.values():
            one.socket.close()

    def _watch(self) -> None:
        while not self._ended.is_set():
            waiting = self._monitor.poll(PERIOD_MS)
            with self._lock:  # not for long, as the master needs it too
                for _ in range(AT_ONCE):
                    if not waiting:
                        break
                    self._note(parse_monitor_message(self._monitor.recv_multipart()))
                    waiting = self._monitor.poll(0)
                self._check(time.monotonic())

    def _note(self, event: Any) -> None:
        what, connection = event["event"], int(event["value"])
        if what & FAILURES:
            self._reports["a connection without a key that is known, or none of subsea's"] += 1
            return
        if known := self._connections.pop(connection, None):
            known.socket.close()
        if what != zmq.EVENT_ACCEPTED:
            return
        now = time.monotonic()
        with suppress(OSError):  # it has gone already
            socket = sockets.socket(fileno=os.dup(connection))
            if socket.getsockname()[1] != self._port:  # the descriptor is used again
                socket.close()
                return
            self._connections[connection] = Connection(socket, now)

    def _check(self, now: float) -> None:
        """End the connections that exceed a limit."""
        strangers = [key for key, one in self._connections.items() if not one.of_node]
        oldest = strangers[: max(len(strangers) - MAX_STRANGERS, 0)]
        for key, one in list(self._connections.items()):
            reason = "too many connections" if key in oldest else ""
            try:
                state, received = _tcp_info(one.socket)
            except OSError:
                state, received = 0, 0
            new = received - one.received
            free = min(new, one.credit)
            one.level = max(one.level - RATE * (now - one.checked_s), 0.0) + new - free
            one.received, one.checked_s, one.credit = received, now, one.credit - free
            if one.level > BURST:
                reason = "a connection that sent too much at once"
            elif one.faults >= MAX_FAULTS:
                reason = "a connection that sent several messages not of subsea"
            if reason or state != TCP_ESTABLISHED or now > one.end_s:
                if reason:
                    self._reports[reason] += 1
                self._connections.pop(key).end()


def _tcp_info(socket: sockets.socket) -> tuple[int, int]:
    """The state of a TCP connection, and the bytes it has received: 0 if the kernel has none."""
    if not hasattr(sockets, "TCP_INFO"):
        return TCP_ESTABLISHED, 0
    info = socket.getsockopt(sockets.IPPROTO_TCP, sockets.TCP_INFO, BYTES_RECEIVED + 8)
    if len(info) < BYTES_RECEIVED + 8:
        return TCP_ESTABLISHED, 0
    return info[0], struct.unpack_from("=Q", info, BYTES_RECEIVED)[0]
