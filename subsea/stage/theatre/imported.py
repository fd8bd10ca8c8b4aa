"""Build a theatre from another program's file, with a line for each thing that is left out."""

import re
from itertools import combinations
from pathlib import Path
from typing import Any

import msgspec

from subsea.base.errors import UserError
from subsea.base.validation import convert
from subsea.stage.theatre.measured_mesh import MeasuredMesh
from subsea.stage.theatre.theatre_file import (
    MOST_WINDOWS,
    Archive,
    Channel,
    Cluster,
    Theatre,
    Window,
    covers,
    parse_address,
    reaches_out,
    viewport,
)
from subsea.view.rig import overlap

HERE = "127.0.0.1"


class ImportedTheatre(Theatre, frozen=True, kw_only=True):
    """A theatre from a file of another program."""

    left_out: tuple[str, ...] = ()  # a line for each thing that is not in this theatre
    # Warps that are in no file of their own, by the name that `Channel.warp` has for them.
    meshes: dict[str, MeasuredMesh] = msgspec.field(default_factory=dict)


class TheatreBuilder:
    """Collects the windows and channels of a theatre; what does not fit is left out with a line."""

    def __init__(self, path: Path, title: str = "") -> None:
        """Begin with an empty theatre for the file `path`."""
        self.path, self.title = path, " ".join(title.split())
        self.windows: list[Window] = []
        self.channels: list[Channel] = []
        self.archives: list[Archive] = []
        self.meshes: dict[str, MeasuredMesh] = {}
        self.cluster: Cluster | None = None
        self.keys: dict[str, Any] = {}  # of the theatre
        self._lines: dict[str, None] = {}

    def leave_out(self, line: str) -> None:
        """Note a thing that the theatre lacks."""
        self._lines[line] = None

    def name(self, words: str, kind: str = "channel") -> str:
        """Make a valid name like `words` that no other window, or channel, has."""
        plain = re.sub(r"[^A-Za-z0-9_-]+", "-", words).strip("-_")[:50] or kind
        tables = self.channels if kind == "channel" else self.windows
        taken = {table.name for table in tables}
        name, number = plain, 1
        while name in taken:
            number += 1
            name = f"{plain}-{number}"
        return name

    def window(self, words: str, **keys: Any) -> Window | None:
        """Add a window; None if there is no room for it or if its keys are invalid."""
        if len(self.windows) >= MOST_WINDOWS:
            self.leave_out(f"windows beyond the first {MOST_WINDOWS}")
            return None
        try:
            window = convert({"name": self.name(words, "window"), **keys}, Window)
        except UserError as fault:
            self.leave_out(f"window {words!r}: {fault.message}")
            return None
        self.windows.append(window)
        return window

    def channel(self, words: str, window: Window, **keys: Any) -> None:
        """Add a channel to a window, or leave it out."""
        if len(self.channels) >= MOST_WINDOWS:
            self.leave_out(f"viewports beyond the first {MOST_WINDOWS}")
            return
        try:
            given = {"name": self.name(words), "window": window.name, **keys}
            channel = convert(given, Channel)
            if reaches_out(channel, window):
                raise UserError("it reaches out of its window")
            place = viewport(channel, window)
            for other in self.channels:
                if other.window == window.name and overlap(viewport(other, window), place):
                    raise UserError(f"it lies on {other.name!r} in its window")
        except UserError as fault:
            self.leave_out(f"viewport {words!r}: {fault.message}")
        else:
            self.channels.append(channel)

    def lead(self, master: str, host: str) -> None:
        """Make the node `master` the master of a cluster, at the IP address `host`."""
        host = HERE if host == "localhost" else host
        try:
            parse_address(f"{host}:5560")
        except ValueError:
            self.leave_out(
                f"master's address {host!r}: expected an IP address, so {HERE} stands in the "
                "[cluster]"
            )
            host = HERE
        self.cluster = Cluster(master=master, address=f"{host}:5560")
        if host != HERE:
            self.leave_out("keys of the [cluster]: make them with `subsea keys`")

    def build(self) -> ImportedTheatre:
        """Make the theatre; a UserError if nothing is left."""
        used = {channel.window for channel in self.channels}
        used |= {name for archive in self.archives for name in (archive.windows or {}).values()}
        for window in self.windows:
            if window.name not in used:
                self.leave_out(f"window {window.name!r}: no viewport of it can be shown")
        lines = list(self._lines)
        if not self.channels and not self.archives:
            why = f"; left out: {lines[0]}" if lines else ""
            more = f" (and {len(lines) - 1} more)" if len(lines) > 1 else ""
            raise UserError(f"no viewport in it can be shown{why}{more}", file=self.path)
        windows = [window for window in self.windows if window.name in used]
        for i, k in combinations(range(len(windows)), 2):
            if covers(windows[i], windows[k]):
                self.leave_out(
                    f"the place of window {windows[k].name!r}: it lies on {windows[i].name!r}, so "
                    "the desktop chooses another"
                )
                windows[k] = msgspec.structs.replace(windows[k], position=None, monitor=None)
        return ImportedTheatre(
            title=self.title,
            window=windows,
            channel=self.channels,
            mpcdi=self.archives,
            cluster=self.cluster,
            left_out=tuple(self._lines),
            meshes=self.meshes,
            **self.keys,
        )
