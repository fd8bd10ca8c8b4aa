"""Save the losses of finished evaluations, so that an interrupted search continues.

Searches are deterministic: a repeated one asks for the same points, and is answered from the file
until it comes to new ones. So its result is that of an uninterrupted one, and the state of the
optimiser need not be saved.
"""

import json
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

from subsea.base.files import replacing

Candidate = TypeVar("Candidate")
SAVE_S = 5.0  # least time between two writes


class Journal:
    """The losses of several searches, in the order of evaluation, and their file."""

    def __init__(self, path: Path, key: str) -> None:
        """Continue the file at ``path`` if it has this ``key``, else begin a new one."""
        self._path, self._key = path, key
        found = read_journal(path)
        self._searches: list[list[float]] = found["searches"] if found.get("key") == key else []
        self._started = 0
        self._saved_at = time.monotonic()

    def remembered(
        self, losses: Callable[[Sequence[Candidate]], list[float]]
    ) -> Callable[[Sequence[Candidate]], list[float]]:
        """Begin a search: ``losses`` of candidates, but values of the file where it has them."""
        if self._started == len(self._searches):
            self._searches.append([])
        known = self._searches[self._started]
        self._started += 1
        asked = 0

        def values(candidates: Sequence[Candidate]) -> list[float]:
            nonlocal asked
            begin, asked = asked, asked + len(candidates)
            if asked > len(known):
                known.extend(losses(candidates[len(known) - begin :]))
                if time.monotonic() - self._saved_at > SAVE_S:
                    self.save()
            return known[begin:asked]

        return values

    def save(self) -> None:
        """Write the file."""
        write_journal(self._path, {"key": self._key, "searches": self._searches})
        self._saved_at = time.monotonic()


def write_journal(path: Path, content: dict[str, Any]) -> None:
    """Write the content of a journal, whole or not at all."""
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(content), encoding="utf-8")


def read_journal(path: Path) -> dict[str, Any]:
    """The content of a journal: key and searches at least; empty if missing or damaged."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    if not isinstance(content, dict) or not isinstance(content.get("searches"), list):
        return {}
    numbers = (
        isinstance(losses, list) and all(isinstance(loss, float) for loss in losses)
        for losses in content["searches"]
    )
    return content if all(numbers) else {}


def evaluations(path: Path) -> int:
    """The number of evaluations in a journal."""
    return sum(map(len, read_journal(path).get("searches", [])))
