"""Record segments in this process or in a pool of processes, with the same result.

A job is one segment of one species. Workers are functions that take jobs and yield each with its
result, in any order.
"""

import signal
from collections.abc import Callable, Generator, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context

from capture.recording.record import Recorded, record_segment
from subsea.core.errors import UserError
from subsea.fish.species import Species

Job = tuple[str, str]  # names of species and segment
Check = Callable[[], object]
"""Called between jobs and while waiting; raises KeyboardInterrupt to cancel."""
Results = Generator[tuple[Job, Recorded], None, None]
Workers = Callable[[Mapping[Job, Species], Check], Results]

POLL_S = 0.2
MAX_CRASHES = 3  # crashes of worker processes after which recording stops


def record_job(job: Job, species: Species) -> Recorded:
    """Record the segment of a job; UserError with its names if the fish cannot swim."""
    try:
        return record_segment(species, job[1])
    except UserError as fault:
        raise UserError(f"{job[0]}, {job[1]}: {fault}") from fault


def serial(jobs: Mapping[Job, Species], check: Check) -> Results:
    """Run the jobs in this process, one after another."""
    for job, species in jobs.items():
        check()
        yield job, record_job(job, species)


def process_pool(number: int) -> Workers:
    """Workers in ``number`` processes of this computer.

    The jobs of a crashed process are repeated; UserError after MAX_CRASHES crashes.
    """

    def run(jobs: Mapping[Job, Species], check: Check) -> Results:
        left = dict(jobs)
        for _ in range(MAX_CRASHES):
            try:
                for job, result in _in_pool(number, left, check):
                    del left[job]
                    yield job, result
            except BrokenProcessPool:
                continue
            return
        raise UserError(
            f"worker processes crashed {MAX_CRASHES} times; is there enough memory? "
            f"Not recorded: {', '.join(' '.join(job) for job in left)}"
        )

    return run


def _in_pool(number: int, jobs: Mapping[Job, Species], check: Check) -> Results:
    pool = ProcessPoolExecutor(number, get_context("spawn"))
    try:
        with _ctrl_c_blocked():
            tasks = {pool.submit(record_job, job, species): job for job, species in jobs.items()}
        waiting = set(tasks)
        while waiting:
            check()
            done, waiting = wait(waiting, POLL_S, FIRST_COMPLETED)
            for task in done:
                yield tasks[task], task.result()
    finally:
        pool.shutdown(cancel_futures=True)


@contextmanager
def _ctrl_c_blocked() -> Iterator[None]:
    """Block Ctrl-C in processes that are started inside, which inherit the signal mask.

    A terminal sends Ctrl-C to all processes of a group; only the main one reacts, after this block.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
