"""Theatres that another program's file describes."""

import re
from collections.abc import Iterable
from itertools import combinations
from pathlib import Path, PurePosixPath
from typing import Any

import msgspec

from subsea.base.errors import UserError
from subsea.base.files import MIB, read_input
from subsea.base.validation import convert
from subsea.stage.theatre.measured_mesh import MeasuredMesh
from subsea.stage.theatre.theatre_file import (
    FEWEST_PIXELS,
    MOST_WINDOWS,
    Archive,
    Channel,
    Cluster,
    Theatre,
    Window,
    viewport,
)
from subsea.view.rig import overlap

MAX_JSON = 4 * MIB
MAX_LINES = 100  # of what is left out
MAX_WORD = 80  # characters of a name in a line


class ImportedTheatre(Theatre, frozen=True, kw_only=True):
    """A theatre from a file of another program."""

    left_out: tuple[str, ...] = ()  # a line for each thing that is not in this theatre
    # Warps that are in no file of their own, by the name that `Channel.warp` has for them.
    meshes: dict[str, MeasuredMesh] = msgspec.field(default_factory=dict)


class TheatreBuilder:
    """Collects the windows and channels of a theatre; what does not fit is left out with a line."""

    def __init__(self, path: Path, title: str = "") -> None:
        """Begin with an empty theatre for the file `path`."""
        self.path, self.title = path, printable_word(title)
        self.windows: list[Window] = []
        self.channels: list[Channel] = []
        self.archives: list[Archive] = []
        self.meshes: dict[str, MeasuredMesh] = {}
        self.cluster: Cluster | None = None
        self.keys: dict[str, Any] = {}  # of the theatre
        self._lines: dict[str, None] = {}
        self._more = 0  # lines beyond MAX_LINES

    def leave_out(self, line: str) -> None:
        """Note a thing that the theatre lacks."""
        if line not in self._lines:
            if len(self._lines) < MAX_LINES:
                self._lines[line] = None
            else:
                self._more += 1

    def name(self, words: str, kind: str = "channel") -> str:
        """A valid name like `words` that no other window, or channel, has."""
        plain = re.sub(r"[^A-Za-z0-9_-]+", "-", words[:200]).strip("-_")[:50] or kind
        taken = {one.name for one in (self.channels if kind == "channel" else self.windows)}
        return next(
            name
            for k in range(1, 10_000)
            if (name := plain if k == 1 else f"{plain}-{k}") not in taken
        )

    def window(self, words: str, **keys: Any) -> Window | None:
        """Add a window; None if there is no room for it or if its keys are invalid."""
        if len(self.windows) >= MOST_WINDOWS:
            self.leave_out(f"windows beyond the first {MOST_WINDOWS}")
            return None
        try:
            one = convert({"name": self.name(words, "window"), **keys}, Window)
        except UserError as fault:
            self.leave_out(f"window {printable_word(words)!r}: {fault.message}")
            return None
        self.windows.append(one)
        return one

    def channel(self, words: str, window: Window, **keys: Any) -> bool:
        """Add a channel to a window; False if it is left out."""
        if len(self.channels) >= MOST_WINDOWS:
            self.leave_out(f"viewports beyond the first {MOST_WINDOWS}")
            return False
        try:
            given = {"name": self.name(words), "window": window.name, **keys}
            one = convert(given, Channel)
            x, y, width, height = viewport(one, window)
            if x + width > window.size[0] or y + height > window.size[1]:
                raise UserError("it reaches out of its window")
            for other in self.channels:
                if other.window == one.window and overlap(
                    viewport(other, window), (x, y, width, height)
                ):
                    raise UserError(f"it lies on {other.name!r} in its window")
        except UserError as fault:
            self.leave_out(f"viewport {printable_word(words)!r}: {fault.message}")
            return False
        self.channels.append(one)
        return True

    def beside(self, name: str | None, what: str) -> str | None:
        """The path of a file that the theatre names; None, with a line, if it leaves the folder."""
        if not name:
            return None
        path = PurePosixPath(name[:1000].replace("\\", "/"))
        inside = not path.is_absolute() and ".." not in path.parts and ":" not in name
        if not inside or not name.isprintable():
            self.leave_out(f"{what} {printable_word(name)!r}: expected a path within its folder")
            return None
        return str(path)

    def build(self) -> ImportedTheatre:
        """The theatre; a UserError if nothing is left."""
        self._drop_empty()
        self._move_apart()
        lines = list(self._lines)
        if self._more:
            lines.append(f"{self._more} more things")
        if not self.channels and not self.archives:
            why = f"; left out: {lines[0]}" if lines else ""
            more = f" (and {len(lines) - 1} more)" if len(lines) > 1 else ""
            raise UserError(f"no viewport in it can be shown{why}{more}", file=self.path)
        return ImportedTheatre(
            title=self.title,
            window=self.windows,
            channel=self.channels,
            mpcdi=self.archives,
            cluster=self.cluster,
            left_out=tuple(lines),
            meshes=self.meshes,
            **self.keys,
        )

    def _drop_empty(self) -> None:
        used = {one.window for one in self.channels}
        used |= {name for one in self.archives for name in (one.windows or {}).values()}
        for one in self.windows:
            if one.name not in used:
                self.leave_out(f"window {one.name!r}: no viewport of it can be shown")
        self.windows = [one for one in self.windows if one.name in used]

    def _move_apart(self) -> None:
        """Let the desktop place windows that would cover others."""
        found = list(self.windows)
        for i, k in combinations(range(len(found)), 2):
            one, other = found[i], found[k]
            if one.node != other.node:
                continue
            shared = one.monitor is not None and one.monitor == other.monitor
            covered = (
                one.position is not None
                and other.position is not None
                and overlap((*one.position, *one.size), (*other.position, *other.size))
            )
            if shared or covered:
                self.leave_out(
                    f"the place of window {other.name!r}: it lies on {one.name!r}, so the "
                    "desktop chooses another"
                )
                found[k] = msgspec.structs.replace(other, position=None, monitor=None)
        self.windows = found


def read_json(path: Path) -> Any:
    """The content of a JSON file of limited size; else a UserError."""
    data = read_input(path, MAX_JSON)
    try:
        return msgspec.json.decode(data.removeprefix(b"\xef\xbb\xbf"))
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as fault:
        reason = "too deep" if isinstance(fault, RecursionError) else str(fault).partition("\n")[0]
        raise UserError(f"not valid JSON ({reason})", file=path) from fault


def unused_keys(content: Any, known: Iterable[str], whole: Iterable[str]) -> list[str]:
    """Sorted keys of all tables in a JSON content that are not known.

    Tables of the keys `whole` are not looked into.
    """
    found: set[str] = set()
    waiting, known, whole = [content], set(known), set(whole)
    while waiting:
        here = waiting.pop()
        if isinstance(here, dict):
            found.update(key for key in here if key not in known)
            waiting.extend(value for key, value in here.items() if key in known - whole)
        elif isinstance(here, list):
            waiting.extend(here)
    return sorted(found)


def pixels_of(
    size: tuple[int, int], x: float, y: float, width: float, height: float
) -> tuple[int, int, int, int] | None:
    """The pixels x, y (from the upper left), width, height of shares from the lower left.

    Edges that neighbours share stay shared. None if a side is too short, or beyond the window.
    """
    left, right = (round(size[0] * edge) for edge in (x, x + width))
    top, bottom = (round(size[1] * (1 - edge)) for edge in (y + height, y))
    within = 0 <= left < right <= size[0] and 0 <= top < bottom <= size[1]
    if not within or min(right - left, bottom - top) < FEWEST_PIXELS:
        return None
    return left, top, right - left, bottom - top


def printable_word(word: str) -> str:
    """A name of another program for a line: short and on one line."""
    plain = "".join(c if c.isprintable() else "?" for c in word[: MAX_WORD + 1])
    return plain if len(plain) <= MAX_WORD else f"{plain[:MAX_WORD]}…"
