"""Watch and switch the projectors of a theatre, each in a thread of its own."""

import time
from collections.abc import Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, Full, Queue, SimpleQueue
from threading import Event, Thread
from typing import Any

from subsea.base.errors import UserError, unknown
from subsea.stage.fleet.pjlink import PjlinkConnection, ProjectorStatus, read_password
from subsea.stage.theatre.theatre_file import ProjectorTable

LIMIT_S = 5.0  # longest time of a connection
POLL_S, SOON_S = 15.0, 2.0  # between two looks: usually, and while the power changes
CHANGE_S = 120.0  # in which a projector that was switched is looked at more often
END_S = 1.0  # longest time to stop all
MOST_WAITING = 4  # switches that wait for one projector
ALL = "all"


@dataclass
class _Look:
    """The state of a projector after the last attempt to ask it; replaced as a whole."""

    status: ProjectorStatus | None = None  # None: it did not answer
    fault: str = ""
    seen: float = 0.0  # when it last answered, s since 1970; 0: never


class ProjectorThread:
    """Asks one projector in turn, and switches it."""

    def __init__(self, table: ProjectorTable, password: str, poll_s: float) -> None:
        """Begin to ask, every `poll_s`."""
        self.name, self.look = table.name, _Look()
        self._place, self._password, self._poll_s = (table.address, table.port), password, poll_s
        self._wanted: Queue[bool] = Queue(MOST_WAITING)
        self._lines: SimpleQueue[str] = SimpleQueue()
        self._told, self._changes_until_s = "", 0.0
        self._called, self._ends = Event(), Event()
        self._thread = Thread(target=self._run, name=f"projector {self.name}", daemon=True)
        self._thread.start()

    def switch(self, on: bool) -> None:
        """Switch it as soon as it answers; a UserError if it is busy with earlier switches."""
        try:
            self._wanted.put_nowait(on)
        except Full:
            raise UserError(f"projector {self.name}: busy, try again") from None
        self._called.set()

    def check(self) -> str:
        """A line if the projector is gone, back or refuses since the last call, else empty."""
        return "" if self._lines.empty() else self._lines.get_nowait()

    def describe(self) -> dict[str, Any]:
        """Its state for console and metrics: docs/reference/console-interface.md."""
        look = self.look
        status = look.status or ProjectorStatus("unknown")
        return {
            "name": self.name,
            "power": status.power,
            "lamps": [{"hours": hours, "on": lit} for hours, lit in status.lamps],
            "errors": [{"part": part, "severity": severity} for part, severity in status.errors],
            "fault": look.fault,
            "seen": round(look.seen) or None,
        }

    def end(self) -> None:
        """Stop asking soon; the projector stays as it is."""
        self._ends.set()
        self._called.set()

    def join(self, limit_s: float) -> None:
        """Wait until it has stopped; a thread that waits for a projector ends with the process."""
        self._thread.join(limit_s)

    def _run(self) -> None:
        while not self._ends.is_set():
            self._called.clear()
            self._ask()
            soon = time.monotonic() < self._changes_until_s
            if self._wanted.empty():
                self._called.wait(min(SOON_S, self._poll_s) if soon else self._poll_s)

    def _ask(self) -> None:
        """Give the next switch, if one waits, and look. A switch that fails is not repeated."""
        last, switch = self.look, None
        with suppress(Empty):
            switch = self._wanted.get_nowait()
        try:
            with closing(PjlinkConnection(self._place, self._password, LIMIT_S)) as connection:
                if switch is not None:
                    connection.switch(switch)
                    self._changes_until_s = time.monotonic() + CHANGE_S
                self.look = _Look(connection.status(), "", time.time())
        except UserError as fault:
            self.look = _Look(None, str(fault), last.seen)
        if switch is not None and self.look.fault:
            way = "on" if switch else "off"
            self._lines.put(f"projector {self.name}: not switched {way}, it {self.look.fault}")
            self._told = self.look.fault
        elif self.look.fault != self._told:
            self._told = self.look.fault
            words = f"{self._told}; the show goes on" if self._told else "answers again"
            self._lines.put(f"projector {self.name}: {words}")


class Projectors:
    """All projectors of a theatre."""

    def __init__(
        self, tables: Sequence[ProjectorTable], passwords: Sequence[str], poll_s: float = POLL_S
    ) -> None:
        """Begin to ask them every `poll_s`, each with its password of `read_passwords`."""
        self._threads = {
            table.name: ProjectorThread(table, password, poll_s)
            for table, password in zip(tables, passwords, strict=True)
        }

    def switch(self, name: str, on: bool) -> str:
        """Switch a projector, or `all`; returns what was done, or raises a UserError."""
        if not self._threads:
            raise UserError("the theatre file has no [[projector]] to switch")
        if name != ALL and name not in self._threads:
            raise unknown("projector", name, [*self._threads, ALL])
        for thread in self._threads.values():
            if name in (ALL, thread.name):
                thread.switch(on)
        what = "all projectors" if name == ALL else f"projector {name}"
        return f"switches {what} {'on' if on else 'off'}"

    def check(self) -> list[str]:
        """Lines about projectors that are gone, back, or refuse, since the last call."""
        return [line for thread in self._threads.values() if (line := thread.check())]

    def describe(self) -> list[dict[str, Any]]:
        """The state of each projector."""
        return [thread.describe() for thread in self._threads.values()]

    def close(self) -> None:
        """Stop asking."""
        end = time.monotonic() + END_S
        for thread in self._threads.values():
            thread.end()
        for thread in self._threads.values():
            thread.join(max(end - time.monotonic(), 0.0))


def read_passwords(tables: Sequence[ProjectorTable], path: Path) -> list[str]:
    """Read the passwords that the theatre file `path` names, empty for none; or a UserError."""
    return [
        "" if one.password is None else read_password(path.parent / one.password) for one in tables
    ]
