"""Where segments are recorded: in this process or in several; the result is the same.

A job is one segment of one species. *Workers* are a function that takes jobs and gives each with
its result, in any order, as soon as it is done.
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
"""Called between two jobs and while waiting; it raises KeyboardInterrupt to call all off."""
Results = Generator[tuple[Job, Recorded], None, None]
Workers = Callable[[Mapping[Job, Species], Check], Results]

POLL_S = 0.2
LOST_PROCESSES = 3
"""How many times processes may die before the recording is given up."""


def record_job(job: Job, species: Species) -> Recorded:
    """The segment of a job; a fish that cannot swim is a UserError that names it."""
    try:
        return record_segment(species, job[1])
    except UserError as fault:
        raise UserError(f"{job[0]}, {job[1]}: {fault}") from fault


def serial(jobs: Mapping[Job, Species], check: Check) -> Results:
    """Record in this process, one job after another."""
    for job, species in jobs.items():
        check()
        yield job, record_job(job, species)


def process_pool(number: int) -> Workers:
    """Workers that record in ``number`` processes of this machine.

    The jobs of a process that dies are done again by others; a UserError if that goes on.
    """

    def run(jobs: Mapping[Job, Species], check: Check) -> Results:
        left = dict(jobs)
        for _ in range(LOST_PROCESSES):
            try:
                for job, result in _in_pool(number, left, check):
                    del left[job]
                    yield job, result
            except BrokenProcessPool:
                continue
            return
        raise UserError(
            f"processes that record keep dying, {LOST_PROCESSES} so far; is memory short? "
            f"Not recorded: {', '.join(' '.join(job) for job in left)}"
        )

    return run


def _in_pool(number: int, jobs: Mapping[Job, Species], check: Check) -> Results:
    pool = ProcessPoolExecutor(number, get_context("spawn"))
    try:
        with _inherited_deafness():
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
def _inherited_deafness() -> Iterator[None]:
    """Processes started within never hear Ctrl-C: the main process does, and calls them off.

    A terminal sends it to all of them. The main process hears it when this is over. Processes
    that would make themselves deaf could be struck while they start.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
