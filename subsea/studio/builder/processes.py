"""Commands as processes: their progress and their exit codes."""

import re
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from typing import IO

PROGRESS = re.compile(r"(\d+)/(\d+)\D")
PATIENCE_S = 10.0  # until a process that should stop is killed
KEPT_LINES = 200


class CommandProcess:
    """A command whose output is read by threads."""

    def __init__(self, arguments: list[str], wake: Callable[[], object] = lambda: None) -> None:
        """Start ``python -m MODULE …``; `wake` is called, in a thread, on every news."""
        self.arguments = arguments
        self.lines: list[str] = []  # the last ones
        self.doing, self.progress = "", 0.0  # the present stage, and its share done
        self.stopped = False  # on request
        self._wake = wake
        self._process = subprocess.Popen(
            [sys.executable, "-m", *arguments],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip
        assert self._process.stdout and self._process.stderr
        self._readers = [
            threading.Thread(target=self._read, args=(pipe,), daemon=True)
            for pipe in (self._process.stdout, self._process.stderr)
        ]
        for reader in self._readers:
            reader.start()

    @property
    def code(self) -> int | None:
        """The exit code, None while it runs."""
        if any(reader.is_alive() for reader in self._readers):
            return None
        return self._process.poll()

    @property
    def last(self) -> str:
        """The last line."""
        return self.lines[-1] if self.lines else ""

    def stop(self) -> None:
        """Ask it to stop, as Ctrl-C does."""
        self.stopped = True
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)

    def close(self) -> None:
        """Stop it, and wait: it may be writing."""
        self.stop()
        try:
            self._process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        for reader in self._readers:
            reader.join()

    def _read(self, pipe: IO[bytes]) -> None:
        """Read lines and the updates of a progress bar."""
        with pipe:
            part = b""
            while piece := pipe.read1(4096):  # type: ignore[attr-defined]
                *whole, part = re.split(rb"[\r\n]", part + piece)
                for line in filter(None, (one.decode("utf-8", "replace").strip() for one in whole)):
                    self.parse(line)
            if part.strip():
                self.parse(part.decode("utf-8", "replace").strip())
        self._wake()

    def parse(self, line: str) -> None:
        """Take progress from a line of a progress bar, else keep the line."""
        found = PROGRESS.search(line)
        if found and "%|" in line:
            done, total = map(int, found.groups())
            best = re.search(r"best [\d.]+", line)
            self.doing = line.partition(":  ")[0].partition("%|")[0].rstrip("0123456789 :")
            self.doing += f" · {best[0]}" if best else ""
            self.progress = done / max(total, 1)
        else:
            self.lines = [*self.lines, line][-KEPT_LINES:]
        self._wake()
