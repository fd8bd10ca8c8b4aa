"""Sockets of master and nodes, with keys and limits, and the keys that a theatre names.

Strangers do not pass the handshake: a connection without a known key ends within HANDSHAKE_MS, and
no part of a message to the master may be longer than a few kilobytes.
"""

import errno
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import zmq
from zmq.auth.thread import ThreadAuthenticator
from zmq.utils.monitor import parse_monitor_message

from subsea.base.errors import TransientError, UserError
from subsea.base.toml_files import error_at
from subsea.stage.cluster.keys import SECRET, Keys, read_keys
from subsea.stage.theatre.theatre_file import Cluster, parse_address

PROBE_S, PROBES = 1, 4  # to notice a pulled cable
LINGER_MS = 300  # for the last messages
HANDSHAKE_MS = 5000
UNREAD = 64  # messages of one node that the master has not read: it reads at each picture
BACKLOG = 1000  # unread messages of a node: four seconds at 120 pictures a second

AUTH = int(zmq.EVENT_HANDSHAKE_FAILED_AUTH)
PROTOCOL = int(zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL)
NO_DETAIL = int(zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL)


def endpoint(address: str, keys: Keys | None) -> str:
    """The ZeroMQ endpoint of an address such as ``127.0.0.1:5560``.

    Anything but an IP address with a port is a UserError, and so is an address that other
    computers can reach if there are no keys.
    """
    try:
        ip, port = parse_address(address)
    except ValueError as fault:
        raise UserError(str(fault)) from fault
    if ip.is_unspecified:
        raise UserError(f"address {address!r}: no node can call it; expected the master's own")
    if not ip.is_loopback and keys is None:
        raise UserError(
            f"address {address!r}: other computers reach it, so keys are needed; "
            '`subsea keys DIR NAME...` makes them, `keys = "DIR"` in the theatre file uses them'
        )
    return f"tcp://[{ip}]:{port}" if ip.version == 6 else f"tcp://{ip}:{port}"


def authenticator(context: "zmq.Context[Any]", keys: Keys) -> ThreadAuthenticator:
    """Start the thread that lets only the known keys of others pass; stop it at the end."""
    made = ThreadAuthenticator(context)
    made.start()
    known = set(keys.others.values())
    made.configure_curve_callback(
        credentials_provider=SimpleNamespace(callback=lambda _, key: key in known)
    )
    return made


def listening(
    context: "zmq.Context[Any]", address: str, keys: Keys | None, limit: int
) -> tuple[Any, Any]:
    """Listen as the master; return the socket, and one that reports `failed` handshakes.

    Parts of more than `limit` bytes end a connection.
    """
    where = endpoint(address, keys)
    socket = _socket(context, zmq.ROUTER, limit)
    socket.rcvhwm = UNREAD
    with _monitored(socket, f"address {address}: cannot listen there") as monitor:
        # Raise when sending to a node that has gone or no longer reads.
        socket.router_mandatory = True
        if keys:
            socket.curve_server = True
            socket.curve_publickey, socket.curve_secretkey = keys.public, keys.secret
        socket.bind(where)
    return socket, monitor


def calling(
    context: "zmq.Context[Any]", address: str, keys: Keys | None, master: str, limit: int
) -> tuple[Any, Any]:
    """Call as a node until the master answers; return the socket, and one as of `listening`."""
    where = endpoint(address, keys)
    socket = _socket(context, zmq.DEALER, limit)
    with _monitored(socket, f"address {address}: cannot call there") as monitor:
        socket.immediate = True  # drop messages while not connected
        socket.reconnect_ivl, socket.reconnect_ivl_max = 100, 1000
        if keys:
            socket.curve_serverkey = keys.others[master]
            socket.curve_publickey, socket.curve_secretkey = keys.public, keys.secret
        socket.connect(where)
    return socket, monitor


def failed(monitor: Any) -> int:
    """Why the next handshake failed: AUTH, PROTOCOL or NO_DETAIL; 0 if none did."""
    if not monitor.poll(0):
        return 0
    return int(parse_monitor_message(monitor.recv_multipart())["event"])


@contextmanager
def _monitored(socket: Any, fault: str) -> Iterator[Any]:
    """Give a socket that reports handshakes that `failed`, to make before the first of them.

    Turns a ZMQError into a UserError and closes both sockets, so that their context can end. At
    power-on the network may come later than the dive: that error is a TransientError.
    """
    monitor = socket.get_monitor_socket(AUTH | PROTOCOL | NO_DETAIL)
    try:
        yield monitor
    except zmq.ZMQError as reason:
        monitor.close(0)
        socket.disable_monitor()
        socket.close(0)
        late = reason.errno in (errno.EADDRNOTAVAIL, errno.ENODEV, errno.EADDRINUSE)
        kind = TransientError if late else UserError
        raise kind(f"{fault} ({reason.strerror})") from reason


def _socket(context: "zmq.Context[Any]", kind: int, limit: int) -> Any:
    socket: Any = context.socket(kind)
    socket.ipv6 = True
    socket.linger = LINGER_MS
    socket.maxmsgsize = limit
    socket.sndhwm = socket.rcvhwm = BACKLOG
    socket.handshake_ivl = HANDSHAKE_MS
    # Not ZeroMQ's heartbeats: one after the loss of a connection whose messages are not all read
    # ends the process (`!_io_error` in its stream_engine_base.cpp).
    socket.tcp_keepalive, socket.tcp_maxrt = 1, 1000 * PROBE_S * PROBES
    socket.tcp_keepalive_idle = socket.tcp_keepalive_intvl = PROBE_S
    socket.tcp_keepalive_cnt = PROBES
    return socket


def credentials(cluster: Cluster, nodes: Sequence[str], node: str, path: Path) -> Keys | None:
    """Read the keys of `node`, if the theatre file `path` names a folder of keys.

    Missing keys, and an address that needs keys where none are named, are UserErrors.
    """
    try:
        keys = None
        if cluster.keys is not None:
            others = [name for name in nodes if name != node]
            known = others if node == cluster.master else [cluster.master]
            keys = read_keys(path.parent / cluster.keys, node, known)
        endpoint(cluster.address, keys)
    except UserError as fault:
        raise error_at(path, "cluster", f"[cluster]: {fault}") from fault
    return keys


def cluster_faults(cluster: Cluster, nodes: Sequence[str], path: Path) -> tuple[UserError, ...]:
    """Errors of the nodes that have a secret key on this computer; of the master if none has.

    A computer needs no secret key but its own.
    """
    here = [cluster.master]
    if cluster.keys is not None:
        folder = path.parent / cluster.keys
        here = [node for node in nodes if (folder / f"{node}{SECRET}").exists()] or here
    faults = []
    for node in here:
        try:
            credentials(cluster, nodes, node, path)
        except UserError as fault:
            faults.append(fault)
    return tuple(faults)
