"""Record on a Dask cluster instead of local processes (extra `cluster`)."""

import asyncio
import logging
from collections.abc import Mapping
from time import monotonic, sleep
from typing import Any

from capture.recording.fingerprint import fingerprint
from capture.recording.record import Recorded
from capture.recording.workers import POLL_S, Check, Job, Results, Workers, record_job
from subsea.core.errors import UserError
from subsea.core.extras import require
from subsea.fish.species import Species

CONNECT_S = 4.0
FETCH_S = 5.0
NO_WORKER_S = 15.0  # longest time without any worker


def dask_workers(address: str) -> Workers:
    """Workers of the Dask cluster with a scheduler at ``address``; lost jobs are repeated.

    UserError without the package `distributed`, without an answer or a worker, or for a worker of
    another version.
    """

    def run(jobs: Mapping[Job, Species], check: Check) -> Results:
        if not jobs:
            return
        with _connect(address) as client:
            tasks = {
                client.submit(_record, job, species, fingerprint(species), pure=False): job
                for job, species in jobs.items()
            }
            last_seen = monotonic()
            while tasks:
                check()
                for task in [task for task in tasks if task.done()]:
                    result = _result(task, address)
                    if result is not None:
                        yield tasks.pop(task), result
                if _has_workers(client, address):
                    last_seen = monotonic()
                elif monotonic() - last_seen > NO_WORKER_S:
                    raise UserError(f"{address}: no worker for {NO_WORKER_S:g} s; start some")
                sleep(POLL_S)

    return run


def _connect(address: str) -> Any:
    """A client of the scheduler."""
    require("cluster", "--cluster")
    from distributed import Client

    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # replaced by our own messages
    try:
        asyncio.run(asyncio.wait_for(_identify(address), CONNECT_S))
        return Client(address, timeout=CONNECT_S, set_as_default=False)
    except Exception as fault:  # another program at that address may cause any
        raise UserError(f"{address}: no Dask scheduler answers there") from fault


async def _identify(address: str) -> None:
    """Raise unless a scheduler answers; a Client without one would hang also when removed."""
    from distributed import Security
    from distributed.core import rpc

    async with rpc(address, connection_args=Security().get_connection_args("client")) as peer:
        identity = await peer.identity()
    if identity["type"] != "Scheduler":
        raise ValueError(identity["type"])


def _record(job: Job, species: Species, expected: str) -> Recorded:
    """Record a segment on a worker; UserError if its version differs from the caller's."""
    if fingerprint(species) != expected:
        raise UserError("a worker has another version of subsea, numpy or numba; install the same")
    return record_job(job, species)


def _has_workers(client: Any, address: str) -> bool:
    try:
        return bool(client.scheduler_info()["workers"])
    except Exception as fault:
        raise UserError(f"{address}: the scheduler has stopped") from fault


def _result(task: Any, address: str) -> Recorded | None:
    """The result of a finished task; None if it was lost with a worker and is repeated."""
    from distributed import CancelledError, KilledWorker

    try:
        result: Recorded = task.result(timeout=FETCH_S)
    except TimeoutError:
        return None
    except KilledWorker as fault:
        raise UserError(f"{address}: workers keep crashing; is there enough memory?") from fault
    except (CancelledError, OSError) as fault:
        raise UserError(f"{address}: the scheduler has stopped") from fault
    except ImportError as fault:
        raise UserError(f"{address}: a worker lacks a package: {fault}") from fault
    except UserError:
        raise
    except Exception as fault:  # another version may fail in any way
        reason = f"{type(fault).__name__}: {fault}".splitlines()[0]
        raise UserError(
            f"{address}: a worker cannot record ({reason}); install the same subsea there"
        ) from fault
    return result
