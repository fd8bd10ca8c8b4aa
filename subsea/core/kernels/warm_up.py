"""The kernels that a dive needs are compiled before it, by several processes side by side.

Compiling is numba's own Python, which one process can only do one kernel after another. But a dive
needs some hundreds, and few wait for many others: on a machine with four cores four processes take
little more than a quarter of the time. What they compile is kept on the disk, where the one that
asked finds it.

Which kernels these are, for which types, and which of them call which, stands in
`assets/kernels.json`, written by `tools/list_kernels.py`. What is missing there, or no longer
called, costs time and nothing else: what was not compiled before is when it is called.
"""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from importlib import import_module
from typing import Any, NamedTuple

from numba import types

from subsea.core.disk_cache import folder
from subsea.core.kernels.cache import is_kept
from subsea.core.kernels.struct_ref import Kind
from subsea.core.resources import resource_path
from subsea.core.source_stamp import ROOT

LIST = resource_path("assets/kernels.json")
MOST = 8  # processes: each takes 200 to 400 MB, the more the fewer there are
FEW = 20  # kernels: so many are compiled before another process has begun

Worker = subprocess.Popen[str]


class Kernel(NamedTuple):
    """A kernel, for certain types of what it is given."""

    name: str  # with its module's
    signature: tuple[Any, ...]  # numba's types
    inner: bool  # only kernels call it
    calls: list[int]  # numbers of others of the list, all before this one

    @property
    def module(self) -> str:
        """The name of its module."""
        return self.name.rpartition(".")[0]

    @property
    def function(self) -> Any:
        """It itself; its module is imported for that."""
        return _named(self.name)

    @property
    def is_kept(self) -> bool:
        """Whether it is on the disk, compiled from today's source."""
        return is_kept(self.function, self.signature, self.inner)


def precompile(
    tell: Callable[[str], None] = lambda message: None, processes: int | None = None
) -> None:
    """Compile the listed kernels that are not kept on the disk, in so many processes.

    None: as many as there are cores to run on. One alone gains nothing, and compiles nothing; nor
    do several where few kernels are missing, or where none can be kept. `tell` hears how far it is.
    """
    try:
        known = kernels()
        # Those that Python calls are enough to know, of the modules that this program has.
        outer = [kernel for kernel in known if not kernel.inner and kernel.module in sys.modules]
        if all(kernel.is_kept for kernel in outer) or len(_missing(known)) <= FEW:
            return
    except (AttributeError, ImportError):  # the list is not of today's code
        return
    processes = min(_cores() if processes is None else processes, MOST)
    if processes > 1:
        with _one_at_a_time(tell), suppress(OSError):  # no more processes may begin
            left = _missing(known)
            if len(left) <= FEW or _share_out(known, left, processes, tell):
                return
    tell("compiling the fishes' code (a minute or more)")


def _missing(known: list[Kernel]) -> list[int]:
    return [number for number, kernel in enumerate(known) if not kernel.is_kept]


@contextmanager
def _one_at_a_time(tell: Callable[[str], None]) -> Iterator[None]:
    """Wait while another start compiles, and go on with what it has left.

    Where a system or a folder has no locks nobody waits. Whoever ends gives its lock back.
    """
    with ExitStack() as stack:
        with suppress(ImportError, OSError):
            from fcntl import LOCK_EX, LOCK_NB, flock

            place = folder().parent
            place.mkdir(parents=True, exist_ok=True)
            lock = stack.enter_context((place / "compiling").open("w"))
            try:
                flock(lock, LOCK_EX | LOCK_NB)
            except BlockingIOError:
                tell("waiting for another dive, which compiles the fishes' code")
                flock(lock, LOCK_EX)
        yield


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@cache
def kernels() -> list[Kernel]:
    """The kernels of the list, each after those that it calls."""
    told = json.loads(LIST.read_text(encoding="utf-8"))
    kinds: list[Any] = []
    for spelled in told["types"]:
        kinds.append(_type(spelled, kinds))
    return [
        Kernel(name, tuple(kinds[k] for k in given), inner, calls)
        for name, given, inner, calls in told["kernels"]
    ]


def _type(spelled: Any, known: list[Any]) -> Any:
    """A type of numba, which the list spells by the numbers of those before it."""
    match spelled:
        case str():
            return getattr(types, spelled)
        case ["array", item, dimensions, layout, mutable]:
            return types.Array(known[item], dimensions, layout, readonly=not mutable)
        case ["literal", value]:
            return types.literal(value)
        case ["tuple", *items]:
            return types.BaseTuple.from_types([known[k] for k in items])
        case [name, *items]:
            group = _named(name)
            if issubclass(group, Kind):
                return group([(field, known[k]) for field, k in items])
            return types.BaseTuple.from_types([known[k] for k in items], group)
    raise ValueError(f"{LIST}: {spelled}")


def _named(name: str) -> Any:
    module, _, attribute = name.rpartition(".")
    return getattr(import_module(module), attribute)


def _share_out(
    known: list[Kernel], missing: list[int], processes: int, tell: Callable[[str], None]
) -> bool:
    """Have processes compile the missing kernels, none before those that it calls.

    Whether they did: False if one of them was ended, or its kernel could not be kept. Whatever ends
    this early ends them, too.
    """
    waiting, open_ = list(missing), set(missing)
    at_it: dict[Future[bool], tuple[int, Worker]] = {}
    told = -1
    with ThreadPoolExecutor(processes) as pool, ExitStack() as stack:
        free = [_begun(stack) for _ in range(processes)]
        while open_:
            done = len(missing) - len(open_)
            if 10 * done // len(missing) > told:
                told = 10 * done // len(missing)
                tell(f"compiling the fishes' code, once: {done} of {len(missing)} parts")
            # Two of one function at once would overwrite each other's index.
            busy = {known[number].name for number, _ in at_it.values()}
            for number in [number for number in waiting if open_.isdisjoint(known[number].calls)]:
                if free and known[number].name not in busy:
                    busy.add(known[number].name)
                    waiting.remove(number)
                    worker = free.pop()
                    at_it[pool.submit(_ask, worker, number)] = number, worker
            for answer in wait(at_it, return_when=FIRST_COMPLETED).done:
                number, worker = at_it.pop(answer)
                if not answer.result():
                    return False
                open_.remove(number)
                free.append(worker)
    return True


def _begun(stack: ExitStack) -> Worker:
    """Another process, at the end of this file; it ends with this one, or with the stack.

    -P: it loads nothing from the folder that the visitor happens to be in.
    """
    paths = [str(ROOT), os.environ.get("PYTHONPATH", "")]
    worker = subprocess.Popen(
        [sys.executable, "-P", "-m", "subsea.core.kernels.warm_up"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))},
    )  # fmt: skip
    stack.enter_context(worker)
    stack.callback(worker.kill)
    return worker


def _ask(worker: Worker, number: int) -> bool:
    """Have a process compile a kernel; whether it could, and others may follow."""
    assert worker.stdin is not None and worker.stdout is not None
    try:
        worker.stdin.write(f"{number}\n")
        worker.stdin.flush()
    except OSError:
        return False
    return worker.stdout.readline() == "kept\n"


def _serve() -> None:
    """Compile the kernels whose numbers come in."""
    for line in sys.stdin:
        kernel = kernels()[int(line)]
        try:
            if kernel.inner:
                # Where Python's form is there, it would do for them, and none be kept.
                kernel.function.overloads.pop(kernel.signature, None)
                kernel.function.get_call_template(kernel.signature, {})
            else:
                kernel.function.compile(kernel.signature)
            kept = kernel.is_kept
        except Exception:  # who calls it is told
            kept = True
        print("kept" if kept else "not kept", flush=True)


if __name__ == "__main__":
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # who began it gets Ctrl-C, too, and ends it
    _serve()
