"""A thread that opens an input device, watches it, and tells when it comes or goes."""

from queue import SimpleQueue
from threading import Event, Thread

AGAIN_S = 3.0  # between two looks for the device


class DeviceThread:
    """Base of the inputs of a show; `_run` looks for the device until `_ends` is set."""

    def __init__(self, name: str) -> None:
        """Start the thread, of this name, at the end of a subclass's own start."""
        self._lines: SimpleQueue[str] = SimpleQueue()
        self._ends = Event()
        self._thread = Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def check(self) -> str:
        """A line if the device was found or lost since the last call, else an empty one."""
        return "" if self._lines.empty() else self._lines.get_nowait()

    def close(self) -> None:
        """Hear nothing more."""
        self._ends.set()
        self._thread.join(2.0)

    def _run(self) -> None:
        raise NotImplementedError
