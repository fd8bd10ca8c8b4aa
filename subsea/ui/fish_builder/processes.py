"""Commands of the capture tool as processes: their progress as it is told, and how they ended."""

import re
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from typing import IO

PROGRESS = re.compile(r"(\d+)/(\d+)\D")
PATIENCE_S = 10.0  # for one that was asked to stop
KEPT = 200  # lines


class Run:
    """A command that runs by itself; what it says is read by threads of its own."""

    def __init__(self, arguments: list[str], wake: Callable[[], object] = lambda: None) -> None:
        """Begin ``python -m MODULE …``; `wake` is called whenever there is something new."""
        self.arguments = arguments
        self.lines: list[str] = []  # that it has printed, the last ones
        self.doing, self.share = "", 0.0  # what it is at, and how far that is
        self.stopped = False  # whether it was asked to
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
        """Its exit code, None while it runs."""
        if any(reader.is_alive() for reader in self._readers):
            return None
        return self._process.poll()

    @property
    def last(self) -> str:
        """What it said last."""
        return self.lines[-1] if self.lines else ""

    def stop(self) -> None:
        """Ask it to stop, as Ctrl-C does."""
        self.stopped = True
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)

    def close(self) -> None:
        """Stop it, and wait until it has: it may be in the midst of writing."""
        self.stop()
        try:
            self._process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        for reader in self._readers:
            reader.join()

    def _read(self, pipe: IO[bytes]) -> None:
        """Lines, and what a bar of progress writes over and over into one line."""
        with pipe:
            part = b""
            while piece := pipe.read1(4096):  # type: ignore[attr-defined]
                *whole, part = re.split(rb"[\r\n]", part + piece)
                for line in filter(None, (one.decode("utf-8", "replace").strip() for one in whole)):
                    self._heard(line)
            if part.strip():
                self._heard(part.decode("utf-8", "replace").strip())
        self._wake()

    def _heard(self, line: str) -> None:
        found = PROGRESS.search(line)
        if found and "%|" in line:
            done, total = map(int, found.groups())
            best = re.search(r"best [\d.]+", line)
            self.doing = line.partition(":  ")[0].partition("%|")[0].rstrip("0123456789 :")
            self.doing += f" · {best[0]}" if best else ""
            self.share = done / max(total, 1)
        else:
            self.lines = [*self.lines, line][-KEPT:]
        self._wake()
