"""Run jobs in this process, in processes of this computer or on a cluster, with the same results.

A `Pool` takes a function, which other processes can import, and its argument for each job. It
yields each job with its result, in any order; None for a job whose process crashes each time.
"""

import os
import signal
import sys
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import contextmanager, suppress
from multiprocessing import connection, get_context, parent_process, resource_tracker
from threading import Thread
from types import ModuleType
from typing import Any, TypeVar

K = TypeVar("K")
Check = Callable[[], object]
"""Called between jobs and while waiting; raises KeyboardInterrupt to cancel."""
Results = Generator[tuple[K, Any], None, None]
Work = Callable[[Any], Any]
Pool = Callable[[Work, Mapping[K, Any], Check], Results[K]]

POLL_S = 0.2
# One thread for matrices, a tick, and a picture without a GPU; and no code of the current folder,
# where spawned processes would look first.
ENVIRONMENT = {
    "OPENBLAS_NUM_THREADS": "1", "SUBSEA_THREADS": "1", "LP_NUM_THREADS": "1",
    "PYTHONSAFEPATH": "1",
}  # fmt: skip
MAX_ATTEMPTS = 3  # crashes of processes with the same job


def serial(work: Work, jobs: Mapping[K, Any], check: Check) -> Results[K]:
    """Run the jobs in this process, one after another."""
    for job, argument in jobs.items():
        check()
        yield job, work(argument)


def process_pool(number: int) -> Pool[Any]:
    """A pool of up to `number` processes. A crash costs only the job of its process."""

    def run(work: Work, jobs: Mapping[K, Any], check: Check) -> Results[K]:
        waiting, crashes = deque(jobs), Counter[K]()
        running: dict[Any, tuple[Any, K]] = {}  # process and job by the parent's end of its pipe
        idle: list[tuple[Any, Any]] = []
        started: list[Any] = []
        try:
            while waiting or running:
                while waiting and len(running) < number:
                    ours, process = idle.pop() if idle else _start(work, started)
                    running[ours] = process, waiting[0]
                    with suppress(OSError):  # has crashed; the next wait finds out
                        ours.send(jobs[waiting.popleft()])
                check()
                ready: list[Any] = connection.wait([*running], POLL_S)
                for ours in ready:
                    process, job = running.pop(ours)
                    try:
                        done, result = ours.recv()
                    except (EOFError, OSError):
                        process.join()
                        crashes[job] += 1
                        if crashes[job] < MAX_ATTEMPTS:
                            waiting.append(job)
                        else:
                            yield job, None
                        continue
                    if not done:
                        raise result
                    idle.append((ours, process))
                    yield job, result
        finally:
            for process in started:
                process.kill()
            for process in started:
                process.join()

    return run


def _start(work: Work, started: list[Any]) -> tuple[Any, Any]:
    """Start a process that runs jobs; return the parent's end of its pipe, and the process."""
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_serve, args=(work, theirs), daemon=True)
    with _environment(), _ctrl_c_blocked(), _main_hidden():
        process.start()
    started.append(process)
    theirs.close()  # so that a crash ends the pipe
    return ours, process


def _serve(work: Work, pipe: Any) -> None:
    """Run jobs until the parent ends; then end at once."""
    Thread(target=_end_with_parent, daemon=True).start()
    with suppress(EOFError, OSError):
        while True:
            argument = pipe.recv()
            try:
                answer = True, work(argument)
            except Exception as fault:
                answer = False, fault
            pipe.send(answer)


@contextmanager
def _ctrl_c_blocked() -> Iterator[None]:
    """Block Ctrl-C in processes that are started inside, which inherit the signal mask.

    A terminal sends Ctrl-C to all processes of a group; only the main one reacts, after this block.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    resource_tracker.ensure_running()  # later, its start would let Ctrl-C through
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _end_with_parent() -> None:
    parent = parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


@contextmanager
def _main_hidden() -> Iterator[None]:
    """Let processes that are started inside not import the program: a script may lack a guard."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


@contextmanager
def _environment() -> Iterator[None]:
    """Set `ENVIRONMENT` for processes that are started inside, unless set otherwise."""
    added = ENVIRONMENT.keys() - os.environ.keys()
    os.environ.update({name: ENVIRONMENT[name] for name in added})
    try:
        yield
    finally:
        for name in added:
            del os.environ[name]
