"""Load a theatre from a file of our own or of another program, and check its names and places."""

from itertools import combinations
from pathlib import Path

from subsea.base.errors import UserError, unknown
from subsea.base.system import named_or_file
from subsea.base.toml_files import error_at, load_toml
from subsea.stage.theatre.foreign import READERS
from subsea.stage.theatre.theatre_file import FOLDER, Channel, Theatre, Window, viewport
from subsea.view.rig import overlap


def load_theatre(name: str) -> tuple[Theatre, Path]:
    """Load the theatre called `name`, or from the path `name`; return it with its file.

    The suffix of a path tells which program's file it is. Raises a UserError; the geometry of
    screens is checked when they are built.
    """
    if reader := READERS.get(Path(name).suffix.lower()):
        path = Path(name)
        theatre: Theatre = reader(path)
    else:
        path = named_or_file(name, FOLDER, ".toml", "theatre")
        theatre = load_toml(path, Theatre)
    _check(path, theatre)
    return theatre, path


def _check(path: Path, theatre: Theatre) -> None:
    """Refuse names that are taken or unknown, and windows and channels that overlap."""
    _distinct(path, "window", [window.name for window in theatre.window])
    _distinct(path, "channel", [channel.name for channel in theatre.channel])
    if not theatre.channel and not theatre.mpcdi:
        raise UserError("shows nothing, expected at least one `channel` or `mpcdi`", file=path)
    for k, speaker in enumerate(theatre.loudspeaker):
        if speaker.node not in theatre.nodes:
            fault = unknown("node", speaker.node, list(theatre.nodes)).message
            raise error_at(path, f"loudspeaker[{k}].node", fault)
    for k, window in enumerate(theatre.window):
        if window.position is not None and window.monitor is not None:
            fault = f"window {window.name!r} has a `position` and a `monitor`, expected one"
            raise error_at(path, f"window[{k}].position", fault)
    names = [channel.name for channel in theatre.channel]
    for name in theatre.room.projectors if theatre.room else ():
        if name not in names:
            fault = unknown("channel", name, names).message
            raise error_at(path, f"room.projectors.{name}", f"`room.projectors`: {fault}")
    _apart(path, theatre)
    windows = {window.name: window for window in theatre.window}
    for k, channel in enumerate(theatre.channel):
        if channel.window not in windows:
            fault = unknown("window", channel.window, list(windows)).message
            raise error_at(path, f"channel[{k}].window", f"channel {channel.name!r}: {fault}")
        _inside(path, k, channel, windows[channel.window])
    for (_, one), (k, other) in combinations(enumerate(theatre.channel), 2):
        if one.window == other.window and overlap(
            viewport(one, windows[one.window]), viewport(other, windows[other.window])
        ):
            raise error_at(
                path,
                f"channel[{k}]",
                f"channels {one.name!r} and {other.name!r} lie on one another in window "
                f"{one.window!r}; expected viewports side by side",
            )
    for k, archive in enumerate(theatre.mpcdi):
        for region, shown in (archive.windows or {}).items():
            if shown not in windows:
                fault = unknown("window", shown, list(windows)).message
                message = f"region {region!r} of {archive.file}: {fault}"
                raise error_at(path, f"mpcdi[{k}].windows.{region}", message)
    cluster = theatre.cluster
    if cluster is None and len(theatre.nodes) > 1:
        raise UserError(
            f"windows are on the nodes {', '.join(theatre.nodes)}, expected a table "
            "[cluster] that says which of them is the `master`",
            file=path,
        )
    if cluster is not None and cluster.master not in theatre.nodes:
        fault = unknown("node", cluster.master, list(theatre.nodes)).message
        raise error_at(path, "cluster.master", f"`cluster.master`: {fault}")


def _distinct(path: Path, kind: str, names: list[str]) -> None:
    for k, name in enumerate(names):
        if name in names[:k]:
            fault = f"{names.count(name)} {kind}s are called {name!r}, expected 1"
            raise error_at(path, f"{kind}[{k}].name", fault)


def _apart(path: Path, theatre: Theatre) -> None:
    """Refuse windows of a computer that share a monitor or overlap."""
    for (_, one), (k, other) in combinations(enumerate(theatre.window), 2):
        if one.node != other.node:
            continue
        if one.monitor is not None and one.monitor == other.monitor:
            raise error_at(
                path,
                f"window[{k}].monitor",
                f"windows {one.name!r} and {other.name!r} both fill monitor {one.monitor!r}; "
                "expected one window a monitor, with several channels if need be",
            )
        if (
            one.position is not None
            and other.position is not None
            and overlap((*one.position, *one.size), (*other.position, *other.size))
        ):
            raise error_at(
                path,
                f"window[{k}].position",
                f"windows {one.name!r} and {other.name!r} lie on one another; expected places "
                "side by side",
            )


def _inside(path: Path, k: int, channel: Channel, window: Window) -> None:
    x, y, width, height = viewport(channel, window)
    if x + width > window.size[0] or y + height > window.size[1]:
        raise error_at(
            path,
            f"channel[{k}].viewport",
            f"channel {channel.name!r}: `viewport` {list(channel.viewport or ())} reaches "
            f"out of window {window.name!r} of {window.size[0]}x{window.size[1]} pixels",
        )
