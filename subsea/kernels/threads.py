"""Run kernels side by side on all cores, over parts of the fishes.

A kernel writes only the rows that it is given, and reads nothing that other rows write in the same
pass. So the result is the same bit for bit for any parts and any number of threads.
"""

import itertools
import os
import threading
from collections.abc import Callable, Sequence
from functools import partial
from queue import SimpleQueue
from typing import Any

from subsea.base.arrays import Ints
from subsea.base.errors import UserError
from subsea.base.system import cores

VARIABLE = "SUBSEA_THREADS"
MOST_THREADS = 256
PARTS_EACH = 4  # parts for each thread: one that is done early takes over another's

Task = Callable[[], object]
"""A piece of work."""


def threads() -> int:
    """Number of threads of a tick: SUBSEA_THREADS, or one for each core."""
    return _the_pool().number


def use_threads(number: int | None = None) -> None:
    """Run ticks on this number of threads; None: as SUBSEA_THREADS says, or one for each core."""
    global _pool
    before, _pool = _pool, _Pool(_default() if number is None else number)
    if before:
        before.end()


def cut(work: Callable[..., None], who: Ints, least: int, *groups: Any) -> list[Task]:
    """Tasks that call `work(part, *groups)` for parts of `who`, of at least `least` rows each."""
    most = PARTS_EACH * threads() if threads() > 1 else 1
    number = max(min(most, len(who) // least), 1)
    bounds = [len(who) * k // number for k in range(number + 1)]
    return [partial(work, who[a:b], *groups) for a, b in itertools.pairwise(bounds)]


def share(work: Callable[..., None], who: Ints, least: int, *groups: Any) -> None:
    """Call `work(part, *groups)` for parts of `who`, of at least `least` rows, on all threads."""
    if len(who) < 2 * least:
        work(who, *groups)
    else:
        run_all(cut(work, who, least, *groups))


def run_all(tasks: Sequence[Task], shared: bool = True) -> None:
    """Run tasks side by side, in this thread and the helpers, and wait for all of them.

    Unless `shared`, where there is too little work: one after another in this thread.

    An exception is raised here, after the others have ended: of several, that of the first task.
    Tasks that run tasks themselves, or beside those of another thread, do so one after another.
    """
    if shared:
        _the_pool().run(tasks)
        return
    for task in tasks:
        task()


def side_by_side(calls: Sequence[Callable[[], Any]], shared: bool = True) -> list[Any]:
    """The results of all calls, in their order; made by all threads if `shared`."""
    found: list[Any] = [None] * len(calls)

    def task(number: int) -> Task:
        def call() -> None:
            found[number] = calls[number]()

        return call

    run_all([task(number) for number in range(len(calls))], shared)
    return found


class _Batch:
    """Tasks that threads take one by one, in order."""

    def __init__(self, tasks: Sequence[Task]) -> None:
        self.tasks = tasks
        self.next = itertools.count()
        self.faults: list[tuple[int, BaseException]] = []
        self.lock = threading.Lock()
        self.helping = 0  # helpers at work
        self.closed = False  # no more helpers may begin
        self.ended: SimpleQueue[None] = SimpleQueue()

    def work(self) -> None:
        """Run tasks until none is left or one has failed."""
        for number in self.next:
            # All tasks before a failed one are run, so that each run raises the same exception.
            failed = min((before for before, _ in self.faults), default=len(self.tasks))
            if number >= failed:
                return
            try:
                self.tasks[number]()
            except BaseException as fault:
                self.faults.append((number, fault))

    def help(self) -> None:
        """Work as a helper, unless the job is done."""
        with self.lock:
            if self.closed:
                return
            self.helping += 1
        self.work()
        with self.lock:
            self.helping -= 1
            if self.closed and not self.helping:
                self.ended.put(None)

    def close(self) -> None:
        """Wait for the helpers that have begun."""
        self.closed = True
        while True:
            with self.lock:
                if not self.helping:
                    return
            self.ended.get()


class _Pool:
    """This thread, and helpers that are started when they are first needed."""

    def __init__(self, number: int) -> None:
        self.number = number
        self.calls: list[SimpleQueue[_Batch | None]] = []
        self.busy = threading.Lock()

    def run(self, tasks: Sequence[Task]) -> None:
        if self.number < 2 or len(tasks) < 2 or not self.busy.acquire(blocking=False):
            for task in tasks:
                task()
            return
        try:
            self._run_together(_Batch(tasks))
        finally:
            self.busy.release()

    def _run_together(self, job: _Batch) -> None:
        helpers = min(self.number, len(job.tasks)) - 1
        while len(self.calls) < helpers:
            self._start()
        try:
            for call in self.calls[:helpers]:
                call.put(job)
            job.work()
        except BaseException as fault:  # Ctrl-C between two tasks
            job.faults.append((-1, fault))
        while True:
            try:
                job.close()
                break
            except BaseException as fault:  # Ctrl-C: no kernel may write once the caller goes on
                job.faults.append((-1, fault))
        if job.faults:
            raise min(job.faults, key=lambda pair: pair[0])[1]

    def _start(self) -> None:
        call: SimpleQueue[_Batch | None] = SimpleQueue()
        name = f"tick-{len(self.calls) + 1}"
        threading.Thread(target=_help, args=(call,), name=name, daemon=True).start()
        self.calls.append(call)

    def end(self) -> None:
        """End the helpers once they are idle."""
        for call in self.calls:
            call.put(None)


def _help(call: SimpleQueue[_Batch | None]) -> None:
    """Work on jobs until told to end."""
    while (job := call.get()) is not None:
        job.help()
        job = None  # frees the arrays of the tick


def _default() -> int:
    """SUBSEA_THREADS, or one thread for each core; a UserError for anything else."""
    text = os.environ.get(VARIABLE, "")
    if not text:
        return min(cores(), MOST_THREADS)
    if not text.isdecimal() or not 1 <= int(text) <= MOST_THREADS:
        raise UserError(f"{VARIABLE} is {text!r}, expected a whole number from 1 to {MOST_THREADS}")
    return int(text)


def _start_anew() -> None:
    """Forget the helpers of the parent in a forked process, which has none."""
    global _pool
    _pool = _Pool(_pool.number) if _pool else None


def _the_pool() -> _Pool:
    """The threads of this process."""
    global _pool
    if _pool is None:
        _pool = _Pool(_default())
    return _pool


_pool: _Pool | None = None
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_start_anew)
