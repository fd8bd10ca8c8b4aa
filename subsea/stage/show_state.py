"""Keep what a power cut must not erase: the state of a show, and the number of dives of each day.

Both files are written whole, to the disk, and renamed. A damaged one is set aside by its reader.
"""

import os
from collections.abc import Callable
from contextlib import suppress
from datetime import date
from pathlib import Path
from threading import Thread
from typing import Literal

import msgspec
import platformdirs

from subsea.base.atomic_io import remove_abandoned, replacing
from subsea.base.errors import UserError
from subsea.base.input_files import MIB, read_input
from subsea.stage.show import Progress

Tell = Callable[[str], object]

MOST_BYTES = 64 * MIB  # of a state
MOST_DAYS = 1000  # in the list of dives
HEAD = "date,dives"


class SavedShow(msgspec.Struct, frozen=True, kw_only=True):
    """A show at a moment, with the sea of its item."""

    form: Literal[1] = 1
    show: str  # digest of its file
    progress: Progress
    shown: int  # the item that the sea is of
    sea: bytes  # a snapshot


def state_folder() -> Path:
    """The folder of the user's states, which may be missing."""
    return platformdirs.user_state_path("subsea", appauthor=False)


def write_whole(path: Path, data: bytes) -> None:
    """Write a file that a power cut leaves old or new; a UserError if the disk is full."""
    with replacing(path) as part, part.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


class ShowStore:
    """Saves the state of a show in the background."""

    def __init__(self, show: str, tell: Tell) -> None:
        """For the show of that digest; `tell` reports that the disk is full, once."""
        self._path, self._show, self._tell = state_folder() / "show.state", show, tell
        self._writer: Thread | None = None
        self._faults: list[str] = []
        self._told = False

    def load(self) -> SavedShow | None:
        """The saved state of this show; None without one."""
        remove_abandoned(self._path)
        try:
            data = read_input(self._path, MOST_BYTES)
            saved = msgspec.msgpack.decode(data, type=SavedShow)
        except UserError as fault:
            if not isinstance(fault.__cause__, FileNotFoundError):
                self._tell(f"{fault}; the show begins again")
            return None
        except (msgspec.DecodeError, RecursionError):
            self._tell(f"{self._path}: not the state of a show; the show begins again")
            return None
        return saved if saved.show == self._show else None

    def save(self, progress: Progress, shown: int, sea: Callable[[], bytes]) -> None:
        """Save a state, unless the last one is still being written."""
        if self._writer is not None and self._writer.is_alive():
            return
        self._report()
        saved = SavedShow(show=self._show, progress=progress, shown=shown, sea=sea())
        self._writer = Thread(target=self._write, args=(msgspec.msgpack.encode(saved),))
        self._writer.start()

    def forget(self) -> None:
        """Remove the saved state."""
        with suppress(OSError):
            self._path.unlink()

    def close(self) -> None:
        """Wait for the writer."""
        if self._writer is not None:
            self._writer.join()
        self._report()

    def _write(self, data: bytes) -> None:
        try:
            write_whole(self._path, data)
        except UserError as fault:
            self._faults.append(str(fault))

    def _report(self) -> None:
        faults, self._faults = self._faults, []
        if faults and not self._told:
            self._told = True
            self._tell(f"{faults[0]}; after a power cut the show would begin earlier")


class DiveCount:
    """Counts visitors' dives by day, in a table that a spreadsheet opens."""

    def __init__(self, tell: Tell) -> None:
        """`tell` reports once that the table cannot be read or written."""
        self._path, self._tell, self._told = state_folder() / "dives.csv", tell, False
        self.days: dict[str, int] = {}
        remove_abandoned(self._path)
        try:
            self.days = _counts(read_input(self._path).decode("utf-8", "replace"))
        except UserError as fault:
            if not isinstance(fault.__cause__, FileNotFoundError):
                self._report(str(fault))
        except ValueError:
            aside = self._path.with_name(f"{self._path.name}.damaged")
            self._report(f"{self._path}: not a table of dives; it is kept as {aside.name}")
            with suppress(OSError):
                self._path.replace(aside)

    def add(self, day: date) -> None:
        """Count a dive of a day."""
        name = day.isoformat()
        self.days[name] = self.days.get(name, 0) + 1
        kept = sorted(self.days.items())[-MOST_DAYS:]
        text = "".join(f"{one},{number}\n" for one, number in [*kept])
        try:
            write_whole(self._path, f"{HEAD}\n{text}".encode())
        except UserError as fault:
            self._report(f"{fault}; dives are counted until this one ends")

    def of(self, day: date) -> int:
        """The dives of a day."""
        return self.days.get(day.isoformat(), 0)

    def _report(self, line: str) -> None:
        if not self._told:
            self._told = True
            self._tell(line)


def _counts(text: str) -> dict[str, int]:
    """The dives by day; a ValueError for a table of something else."""
    head, *rows = text.splitlines() or [""]
    if head != HEAD:
        raise ValueError(head)
    found: dict[str, int] = {}
    for row in rows:
        day, _, number = row.partition(",")
        found[date.fromisoformat(day).isoformat()] = int(number[:12])
    return found
