"""Run jobs on a Dask cluster instead of local processes (extra `cluster`).

Dask's own messages may hold pickled objects, which run code where they are read. So an unknown
address is asked in plain MessagePack whether it is a scheduler. A scheduler is trusted like the
user of this computer, so TLS tells the right one from others.
"""

import logging
import struct
import sys
from argparse import ArgumentParser
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any

from subsea.base.errors import UserError
from subsea.base.files import check_input
from subsea.base.system import require
from subsea.jobs.workers import POLL_S, Check, K, Pool, Results, Work

if TYPE_CHECKING:
    from asyncio import StreamReader

CONNECT_S = 4.0
FETCH_S = 5.0
NO_WORKER_S = 15.0  # longest time without any worker
QUEUE_S = 86_400.0  # the same for a cluster that a program started, whose queue may be long
LOST = object()  # the result of a job that is repeated
AHEAD = 1000  # jobs that a scheduler has at a time
MOST_BYTES = 2**24  # of a message of an unknown scheduler


def add_cluster(parser: ArgumentParser) -> None:
    """Add the options of a cluster to a command."""
    parser.add_argument(
        "--cluster",
        metavar="ADDRESS",
        help="address of a Dask scheduler, such as tcp://host:8786; needs the extra `cluster`",
    )
    parser.add_argument(
        "--cluster-tls",
        nargs=3,
        type=Path,
        metavar=("CA", "CERTIFICATE", "KEY"),
        help="PEM files for a scheduler at tls://host:8786: the authority that signed all "
        "certificates of the cluster, and the certificate and key of this computer",
    )


def dask_pool(cluster: Any, tls: Sequence[Path] | None = None) -> Pool[Any]:
    """The workers of a Dask cluster; jobs that are lost with a worker are repeated.

    `cluster` is the address of a scheduler, a Dask cluster such as `LocalCluster` or `SLURMCluster`
    of dask-jobqueue, or a Dask client, which stays open. `tls` are files of authority, certificate
    and key for an address. UserError without the package `distributed`, without an answer or a
    worker, or for a worker that cannot do the work.
    """

    def run(work: Work, jobs: Mapping[K, Any], check: Check) -> Results[K]:
        if not jobs:
            return
        with _client(cluster, tls) as client:
            address = client.scheduler.address
            waiting = deque(jobs)
            tasks: dict[Any, K] = {}
            last_seen = monotonic()
            while tasks or waiting:
                check()
                while waiting and len(tasks) < AHEAD:
                    job = waiting.popleft()
                    tasks[client.submit(work, jobs[job], pure=False)] = job
                for task in [task for task in tasks if task.done()]:
                    result = _result(task, address)
                    if result is not LOST:
                        yield tasks.pop(task), result
                if _has_workers(client, address):
                    last_seen = monotonic()
                elif monotonic() - last_seen > no_worker_s:
                    raise UserError(f"{address}: no worker for {no_worker_s:g} s; start some")
                sleep(POLL_S)

    # A queue of a cluster starts workers when it has room.
    no_worker_s = NO_WORKER_S if isinstance(cluster, str) else QUEUE_S
    return run


@contextmanager
def _client(cluster: Any, tls: Sequence[Path] | None) -> Iterator[Any]:
    """A client of the scheduler at an address, or of a cluster; a given client stays open."""
    if isinstance(cluster, str):
        with _connect(cluster, tls) as client:
            yield client
        return
    require("cluster", "a cluster")
    from distributed import Client

    if isinstance(cluster, Client):
        yield cluster
    elif hasattr(cluster, "scheduler_address"):
        with Client(cluster, set_as_default=False) as client:
            yield client
    else:
        raise TypeError(f"cluster: expected an address, a Dask cluster or client, got {cluster!r}")


def _connect(address: str, tls: Sequence[Path] | None = None) -> Any:
    """A client of the scheduler."""
    require("cluster", "--cluster")
    import asyncio  # a fifth of the time in which a program lists its commands

    from distributed import Client

    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # replaced by our own messages
    security = _security(address, tls)
    try:
        asyncio.run(asyncio.wait_for(_identify(address, security), CONNECT_S))
        given = {} if tls is None else {"security": security}
        return Client(address, timeout=CONNECT_S, set_as_default=False, **given)
    except Exception as fault:  # another program at that address may cause any
        raise UserError(f"{address}: no Dask scheduler answers there") from fault


def _security(address: str, tls: Sequence[Path] | None) -> Any:
    """The settings of TLS: those of the option, else Dask's own."""
    from distributed import Security

    if tls is None:
        return Security()
    if not address.startswith("tls://"):
        raise UserError(f"--cluster {address}: expected tls://HOST:PORT with --cluster-tls")
    for path in tls:
        check_input(path)
    names = "tls_ca_file", "tls_client_cert", "tls_client_key"
    files = dict(zip(names, map(str, tls), strict=True))
    security = Security(require_encryption=True, **files)
    try:
        security.get_connection_args("client")
    except OSError as fault:
        said = ", ".join(map(str, tls))
        raise UserError(f"{said}: expected authority, certificate and key in PEM") from fault
    return security


async def _identify(address: str, security: Any) -> None:
    """Raise unless a scheduler answers; a Client without one would hang also when removed.

    It speaks MessagePack only: the messages of Dask's own client would be unpickled.
    """
    import asyncio

    import msgspec  # programs list their options without it
    from distributed.comm.addressing import parse_address, parse_host_port

    kind: Any = msgspec.defstruct("Identity", [("type", str)])
    scheme, location = parse_address(address)
    if scheme not in ("tcp", "tls"):
        raise ValueError(scheme)
    host, port = parse_host_port(location)
    context = security.get_connection_args("client")["ssl_context"] if scheme == "tls" else None
    if (scheme == "tls") != (context is not None):
        raise ValueError("no certificate")
    reader, writer = await asyncio.open_connection(host, port, ssl=context)
    try:
        writer.write(
            _framed({"compression": None, "python": sys.version_info[:3], "pickle-protocol": 5})
        )
        await _received(reader)  # its own greeting
        writer.write(_framed({"op": "identity", "reply": True}))
        identity = msgspec.msgpack.decode(await _received(reader), type=kind)
    finally:
        writer.close()
    if identity.type != "Scheduler":
        raise ValueError(identity.type)


def _framed(message: Mapping[str, Any]) -> bytes:
    """A message of one frame, as Dask's comms have it."""
    import msgspec

    content = msgspec.msgpack.encode(message)
    return struct.pack("<QQQ", 16 + len(content), 1, len(content)) + content


async def _received(reader: "StreamReader") -> bytes:
    """The first frame of a message, which is plain MessagePack."""
    [size] = struct.unpack("<Q", await reader.readexactly(8))
    if not 16 <= size <= MOST_BYTES:
        raise ValueError(size)
    data = await reader.readexactly(size)
    frames, length = struct.unpack_from("<QQ", data)
    return data[8 * (1 + frames) :][:length]


def _has_workers(client: Any, address: str) -> bool:
    try:
        return bool(client.scheduler_info()["workers"])
    except Exception as fault:
        raise UserError(f"{address}: the scheduler has stopped") from fault


def _result(task: Any, address: str) -> Any:
    """The result of a finished task; LOST if it went with a worker; None if each worker crashed."""
    from distributed import CancelledError, KilledWorker

    try:
        return task.result(timeout=FETCH_S)
    except TimeoutError:
        return LOST
    except KilledWorker:
        return None
    except (CancelledError, OSError) as fault:
        raise UserError(f"{address}: the scheduler has stopped") from fault
    except ImportError as fault:
        raise UserError(f"{address}: a worker lacks a package: {fault}") from fault
    except UserError:
        raise
    except Exception as fault:  # another version may fail in any way
        reason = f"{type(fault).__name__}: {fault}".splitlines()[0]
        raise UserError(
            f"{address}: a worker fails ({reason}); install the same subsea there"
        ) from fault
