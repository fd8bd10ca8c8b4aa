"""Run jobs on a Dask cluster instead of local processes (extra `cluster`)."""

import asyncio
import logging
from collections.abc import Mapping
from time import monotonic, sleep
from typing import Any

from subsea.base.errors import UserError
from subsea.base.system import require
from subsea.jobs.workers import POLL_S, Check, K, Pool, Results, Work

CONNECT_S = 4.0
FETCH_S = 5.0
NO_WORKER_S = 15.0  # longest time without any worker
LOST = object()  # the result of a job that is repeated


def dask_pool(address: str) -> Pool[Any]:
    """The workers of the Dask cluster with a scheduler at ``address``; lost jobs are repeated.

    UserError without the package `distributed`, without an answer or a worker, or for a worker that
    cannot do the work.
    """

    def run(work: Work, jobs: Mapping[K, Any], check: Check) -> Results[K]:
        if not jobs:
            return
        with _connect(address) as client:
            tasks = {
                client.submit(work, argument, pure=False): job for job, argument in jobs.items()
            }
            last_seen = monotonic()
            while tasks:
                check()
                for task in [task for task in tasks if task.done()]:
                    result = _result(task, address)
                    if result is not LOST:
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
