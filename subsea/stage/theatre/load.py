"""Load a theatre from a file of our own or of another program, and check its names and places."""

from collections.abc import Callable, Iterator
from itertools import combinations
from pathlib import Path
from typing import Any

import msgspec

from subsea.base.errors import UserError, unknown
from subsea.base.files import read_input, text_of
from subsea.base.registry import THEATRE_FORMATS, load, registered
from subsea.base.system import named_or_file, resource_names, unknown_name
from subsea.base.toml_files import error_at, load_toml
from subsea.stage.theatre.imported import ImportedTheatre, TheatreBuilder
from subsea.stage.theatre.measured_mesh import angles_of
from subsea.stage.theatre.mesh_formats import FORMATS, MAX_BYTES, read_mesh
from subsea.stage.theatre.mpcdi import read_mpcdi
from subsea.stage.theatre.ndisplay import read_ndisplay
from subsea.stage.theatre.sgct import read_sgct
from subsea.stage.theatre.theatre_file import FOLDER, SLOTS, Archive, Theatre, covers, viewport
from subsea.stage.theatre.vioso import vioso_maps, vioso_mesh
from subsea.view.rig import overlap

SIZE = (1280, 720)  # of the window of a mesh
FIELD = {"left_deg": -40, "right_deg": 40, "down_deg": -25, "up_deg": 25}


def load_theatre(name: str) -> tuple[Theatre, Path]:
    """Load the theatre called `name`, or from the path `name`; return it with its file.

    The suffix of a path tells which program's file it is (`READERS`, or a registered format).
    Raises a UserError; the geometry of screens is checked when they are built.
    """
    suffix = Path(name).suffix.lower()
    others = registered(THEATRE_FORMATS)
    reader = READERS.get(suffix)
    if reader is None and suffix[1:] in others:
        reader = load(others[suffix[1:]])
    path = Path(name)
    if reader is not None:
        theatre: Theatre = reader(path)
    else:
        if suffix not in ("", ".toml") and path.is_file():
            suffixes = ".toml", *READERS, *(f".{other}" for other in others)
            raise unknown_name("theatre", name, [], *suffixes)
        path = named_or_file(name, FOLDER, ".toml", "theatre")
        theatre = load_toml(path, Theatre)
    for key, fault in _faults(theatre):
        raise error_at(path, key, fault) if key else UserError(fault, file=path)
    return theatre, path


def theatre_titles() -> tuple[list[str], Callable[[str], str]]:
    """The names of shipped theatres and a function for their titles, for `subsea list`."""
    return resource_names(FOLDER, ".toml"), lambda name: load_theatre(name)[0].title


def read_json(path: Path) -> ImportedTheatre:
    """Read a configuration of SGCT, or of nDisplay if it has its table."""
    text = text_of(read_input(path), path, foreign=True)
    try:
        content = msgspec.json.decode(text)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as fault:
        raise UserError(f"not valid JSON ({fault})", file=path) from fault
    if isinstance(content, dict) and "nDisplay" in content:
        return read_ndisplay(path, content["nDisplay"])
    return read_sgct(path, content)


def read_archive(path: Path) -> ImportedTheatre:
    """Read the projectors of an MPCDI archive, a window for each."""
    builder = TheatreBuilder(path, path.stem)
    archive = read_mpcdi(path)
    builder.refuse(*archive.faults)
    windows = {}
    for region in archive.regions:
        if region.frustum is None:
            builder.refuse(
                f"region {region.name!r}: it has no frustum of its own; name the screen in a "
                "theatre file with [[mpcdi]]"
            )
        elif (window := builder.window(region.name, size=region.size)) is not None:
            windows[region.name] = window.name
    if windows:
        builder.archives.append(Archive(file=path.name, windows=windows))
    return builder.build()


def read_lone_mesh(path: Path) -> ImportedTheatre:
    """Make a window for one mesh, with its own view if it has one."""
    builder = TheatreBuilder(path, path.stem)
    measured = read_mesh(path, SIZE)
    builder.leave_out(*measured.notes)
    screen: dict[str, Any] = {"dome": {}} if path.suffix.lower() == ".data" else {"angles": FIELD}
    if measured.view is not None:
        screen = {"angles": angles_of(measured.view)}
    else:
        builder.leave_out("its screen: a mesh says nothing of it, so change it here")
    window = builder.window(path.stem, size=SIZE)
    if window is not None:
        builder.channel(path.stem, window, warp=path.name, **screen)
    return builder.build()


def read_maps(path: Path) -> ImportedTheatre:
    """Make a window for each map of a VIOSO file."""
    builder = TheatreBuilder(path, path.stem)
    maps, notes = vioso_maps(read_input(path, MAX_BYTES), str(path))
    builder.leave_out(*notes, "the screen of each map: a map says nothing of it, so change it here")
    for measured in maps:
        name = measured.name or path.stem
        try:
            mesh = vioso_mesh(measured, f"{path}: map {name!r}")
        except UserError as fault:
            builder.refuse(f"{fault}")
            continue
        window = builder.window(name, size=measured.size)
        if window is not None:
            key = f"{window.name}.obj"
            builder.meshes[key] = mesh
            builder.channel(name, window, warp=key, angles=FIELD)
    return builder.build()


READERS: dict[str, Callable[[Path], ImportedTheatre]] = {
    ".json": read_json,
    ".ndisplay": read_json,
    ".mpcdi": read_archive,
    **dict.fromkeys(FORMATS, read_lone_mesh),
    ".vwf": read_maps,
}


def _faults(theatre: Theatre) -> Iterator[tuple[str, str]]:
    """Find names that are taken or unknown, and windows and channels that overlap: key, message.

    Each fault after the first one may follow from those before it.
    """
    names = [channel.name for channel in theatre.channel]
    windows = {window.name: window for window in theatre.window}
    for kind, given in (
        ("window", [window.name for window in theatre.window]),
        ("channel", names),
        ("node", [node.name for node in theatre.node]),
        ("projector", [projector.name for projector in theatre.projector]),
    ):
        for k, name in enumerate(given):
            if name in given[:k]:
                message = f"{given.count(name)} {kind}s are called {name!r}, expected 1"
                yield f"{kind}[{k}].name", message
    if not theatre.channel and not theatre.mpcdi:
        yield "", "shows nothing, expected at least one `channel` or `mpcdi`"
    for key, kind, name, known, prefix in _references(theatre):
        if name not in known:
            yield key, f"{prefix}{unknown(kind, name, list(known)).message}"
    for k, window in enumerate(theatre.window):
        if window.position is not None and window.monitor is not None:
            message = f"window {window.name!r} has a `position` and a `monitor`, expected one"
            yield f"window[{k}].position", message
    for (_, window), (k, other) in combinations(enumerate(theatre.window), 2):
        pair = f"windows {window.name!r} and {other.name!r}"
        how = {
            "monitor": f"both fill monitor {window.monitor!r}; expected one window a monitor, with "
            "several channels if need be",
            "position": "lie on one another; expected places side by side",
        }
        if key := covers(window, other):
            yield f"window[{k}].{key}", f"{pair} {how[key]}"
    for k, channel in enumerate(theatre.channel):
        window = windows[channel.window]
        x, y, width, height = viewport(channel, window)
        if x + width > window.size[0] or y + height > window.size[1]:
            message = f"channel {channel.name!r}: `viewport` {list(channel.viewport or ())} reaches"
            message += f" out of window {window.name!r} of {window.size[0]}x{window.size[1]} pixels"
            yield f"channel[{k}].viewport", message
    for (_, first), (k, second) in combinations(enumerate(theatre.channel), 2):
        window = windows[first.window]
        places = viewport(first, window), viewport(second, window)
        if second.window == first.window and overlap(*places):
            message = f"channels {first.name!r} and {second.name!r} lie on one another in window "
            yield f"channel[{k}]", f"{message}{window.name!r}; expected viewports side by side"
    yield from _lamp_faults(theatre)
    if theatre.cluster is None and len(theatre.nodes) > 1:
        message = f"windows are on the nodes {', '.join(theatre.nodes)}, expected a table [cluster]"
        yield "", f"{message} that says which of them is the `master`"


def _lamp_faults(theatre: Theatre) -> Iterator[tuple[str, str]]:
    """Find lamps without a desk, or that take channels which are not there or taken."""
    if theatre.lamp and theatre.lights is None:
        yield "lamp[0]", "lamps need a table [lights] that says where their levels go"
    highest = 32767 if theatre.lights is not None and theatre.lights.protocol == "artnet" else 63999
    taken: dict[tuple[int, int], int] = {}
    for k, lamp in enumerate(theatre.lamp):
        if lamp.universe > highest or (lamp.universe == 0 and highest == 63999):
            low = 0 if highest == 32767 else 1
            message = f"universe {lamp.universe}, expected {low} to {highest}"
            yield f"lamp[{k}].universe", f"lamp {lamp.name!r}: {message}"
        if lamp.channels[-1] > SLOTS:
            message = f"takes channels {lamp.channel} to {lamp.channels[-1]}, of {SLOTS}"
            yield f"lamp[{k}].channel", f"lamp {lamp.name!r} {message}"
        for channel in lamp.channels:
            if (other := taken.setdefault((lamp.universe, channel), k)) != k:
                names = f"{theatre.lamp[other].name!r} and {lamp.name!r}"
                message = f"lamps {names} both take channel {channel}"
                yield f"lamp[{k}].channel", f"{message} of universe {lamp.universe}"
                break


def _references(theatre: Theatre) -> Iterator[tuple[str, str, str, tuple[str, ...], str]]:
    """List the names that must be known: key, kind, name, known names, start of a message."""
    nodes = theatre.nodes
    channels = tuple(channel.name for channel in theatre.channel)
    windows = tuple(window.name for window in theatre.window)
    for k, speaker in enumerate(theatre.loudspeaker):
        yield f"loudspeaker[{k}].node", "node", speaker.node, nodes, ""
    for k, node in enumerate(theatre.node):
        yield f"node[{k}].name", "node", node.name, nodes, ""
    for name in theatre.room.projectors if theatre.room else ():
        yield f"room.projectors.{name}", "channel", name, channels, "`room.projectors`: "
    for k, channel in enumerate(theatre.channel):
        start = f"channel {channel.name!r}: "
        yield f"channel[{k}].window", "window", channel.window, windows, start
    for k, archive in enumerate(theatre.mpcdi):
        for region, shown in (archive.windows or {}).items():
            start = f"region {region!r} of {archive.file}: "
            yield f"mpcdi[{k}].windows.{region}", "window", shown, windows, start
    if theatre.cluster is not None:
        yield "cluster.master", "node", theatre.cluster.master, nodes, "`cluster.master`: "
