"""Record segments in this process, in other processes or on a Dask cluster, with the same result.

A job is one segment of one species. Workers are functions that take jobs and yield each with its
result, in any order.
"""

from collections.abc import Callable, Generator, Mapping

from capture.recording.fingerprint import fingerprint
from capture.recording.record import Recorded, record_segment
from subsea.base.errors import UserError
from subsea.fish.species import Species
from subsea.jobs import workers
from subsea.jobs.dask_cluster import dask_pool
from subsea.jobs.workers import Check

Job = tuple[str, str]  # names of species and segment
Results = Generator[tuple[Job, Recorded], None, None]
Workers = Callable[[Mapping[Job, Species], Check], Results]


def record_job(job: Job, species: Species) -> Recorded:
    """Record the segment of a job; UserError with its names if the fish cannot swim."""
    try:
        return record_segment(species, job[1])
    except UserError as fault:
        raise UserError(f"{job[0]}, {job[1]}: {fault}") from fault


def record_equally(given: tuple[Job, Species, str]) -> Recorded:
    """Record a segment if the worker has the version of the caller, by the fingerprint."""
    job, species, expected = given
    if fingerprint(species) != expected:
        raise UserError("a worker has another version of subsea, numpy or numba; install the same")
    return record_job(job, species)


def serial(jobs: Mapping[Job, Species], check: Check) -> Results:
    """Run the jobs in this process, one after another."""
    return _run(workers.serial, jobs, check)


def process_pool(number: int) -> Workers:
    """Workers in ``number`` processes of this computer.

    The job of a crashed process is repeated; UserError if it crashes each time.
    """
    pool = workers.process_pool(number)
    return lambda jobs, check: _run(pool, jobs, check)


def dask_workers(address: str) -> Workers:
    """Workers of the Dask cluster with a scheduler at ``address``; see `dask_pool`."""
    pool = dask_pool(address)
    return lambda jobs, check: _run(pool, jobs, check)


def _run(pool: workers.Pool[Job], jobs: Mapping[Job, Species], check: Check) -> Results:
    given = {job: (job, species, fingerprint(species)) for job, species in jobs.items()}
    for job, result in pool(record_equally, given, check):
        if result is None:
            raise UserError(
                f"worker processes crashed {workers.MAX_ATTEMPTS} times; is there enough memory? "
                f"Not recorded: {' '.join(job)}"
            )
        yield job, result
