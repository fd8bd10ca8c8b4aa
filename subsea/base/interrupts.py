"""Raise Ctrl-C and SIGTERM at safe points."""

import _thread
import atexit
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any

INTERRUPTED = 130  # exit code
SIGNALS = signal.SIGINT, signal.SIGTERM
RETRY_S = 0.02  # until the next attempt to raise
LIMIT_S = 2.0  # after which a process that has no safe point ends at once
# Modules whose functions are called by C code, which prints and loses a KeyboardInterrupt, or
# crashes: the compiler's callbacks, attributes that compiled code reads, the HDF5 library's files,
# imports of C modules, callbacks of weak references.
UNSAFE = (
    "numba", "llvmlite", "subsea.kernels", "h5py", "subsea.base.hdf5",
    "importlib", "_frozen_importlib", "weakref", "_weakrefset",
)  # fmt: skip
# The same for functions of any module: destructors, and what GLFW calls for events and errors.
UNSAFE_FUNCTIONS = "__del__", "callback_wrapper"


def run_program(program: str, main: Callable[[], int]) -> int:
    """Run `main` as the whole work of this process and return its exit code.

    Where `main` does not handle Ctrl-C and SIGTERM, while its modules are imported and while the
    interpreter shuts down, they end the process at once.
    """
    # Registered first, so called last: Python then removes handlers while it still has work to do.
    atexit.register(_handle, signal.SIG_IGN)
    _handle(lambda number, frame: _end_at_once(program))
    return main()


@contextmanager
def raised_interrupts(program: str) -> Iterator[None]:
    """Raise KeyboardInterrupt for the first Ctrl-C or SIGTERM as soon as that is safe.

    Later ones are ignored, so that the program can finish its files. After LIMIT_S without a safe
    point, or at a signal that comes later than that, the process ends at once.
    """
    first: float | None = None
    raised = closed = False

    def handle(number: int, frame: FrameType | None) -> None:
        nonlocal first, raised
        first = time.monotonic() if first is None else first
        if not raised and _is_safe(frame):
            raised = True
            raise KeyboardInterrupt
        if time.monotonic() - first >= LIMIT_S:
            _end_at_once(program)
        if not raised:
            _thread.start_new_thread(retry, (signal.Signals(number),))

    def retry(number: signal.Signals) -> None:
        time.sleep(RETRY_S)
        if raised or closed:
            return
        if hasattr(signal, "pthread_kill"):  # also ends a wait of the main thread
            signal.pthread_kill(threading.main_thread().ident or 0, number)
        else:
            _thread.interrupt_main(number)

    before = _handle(handle)
    try:
        yield
    finally:
        closed = True
        for number, handler in before.items():
            signal.signal(number, handler)


def _is_safe(frame: FrameType | None) -> bool:
    """True if no function on the stack is called by C code that loses exceptions."""
    while frame is not None:
        module = f"{frame.f_globals.get('__name__')}."
        if frame.f_code.co_name in UNSAFE_FUNCTIONS or any(
            module.startswith(f"{name}.") for name in UNSAFE
        ):
            return False
        frame = frame.f_back
    return True


def _handle(handler: Any) -> dict[int, Any]:
    """Set the handler of both signals and return the old ones; an ignored signal stays ignored."""
    before: dict[int, Any] = {number: signal.getsignal(number) for number in SIGNALS}
    before = {number: old for number, old in before.items() if old is not signal.SIG_IGN}
    for number in before:
        signal.signal(number, handler)
    return before


def _end_at_once(program: str) -> None:
    """End the process without the interpreter's shutdown, which could crash or wait."""
    with suppress(OSError):  # standard error may be closed
        os.write(2, f"{program}: interrupted\n".encode())
    os._exit(INTERRUPTED)


@contextmanager
def deferred_interrupts() -> Iterator[Callable[[], None]]:
    """Record Ctrl-C and SIGTERM; the yielded function raises KeyboardInterrupt for them.

    Python raises KeyboardInterrupt at once, which may be inside a destructor or a weak
    reference's callback (the HDF5 wrapper has many). There it is printed and lost, and the
    program goes on. Call the yielded function between two steps instead.
    """
    pending = False

    def record(number: int, frame: FrameType | None) -> None:
        nonlocal pending
        pending = True

    def check() -> None:
        nonlocal pending
        if pending:
            pending = False
            raise KeyboardInterrupt

    main = threading.current_thread() is threading.main_thread()  # signals reach no other thread
    before = {number: signal.signal(number, record) for number in SIGNALS if main}
    try:
        yield check
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
