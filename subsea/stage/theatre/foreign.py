"""Other programs' files that a theatre can be read from, by their suffix."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from subsea.base.errors import UserError
from subsea.base.files import read_input
from subsea.stage.theatre.imported import ImportedTheatre, TheatreBuilder, read_json
from subsea.stage.theatre.measured_mesh import angles_of
from subsea.stage.theatre.mpcdi import read_mpcdi
from subsea.stage.theatre.ndisplay import read_ndisplay
from subsea.stage.theatre.sgct import read_sgct
from subsea.stage.theatre.theatre_file import Archive
from subsea.stage.theatre.vioso import MAX_BYTES, vioso_maps, vioso_mesh
from subsea.stage.theatre.warp_files import FORMATS, read_mesh

SIZE = (1280, 720)  # of the window of a mesh
FIELD = {"left_deg": -40, "right_deg": 40, "down_deg": -25, "up_deg": 25}


def read_any_json(path: Path) -> ImportedTheatre:
    """A configuration of SGCT, or of nDisplay if it has its table."""
    content = read_json(path)
    if isinstance(content, dict) and "nDisplay" in content:
        return read_ndisplay(path, content)
    return read_sgct(path, content)


def read_archive(path: Path) -> ImportedTheatre:
    """The projectors of an MPCDI archive, a window for each."""
    builder = TheatreBuilder(path, path.stem)
    found = read_mpcdi(path)
    for fault in found.faults:
        builder.leave_out(fault)
    windows = {}
    for region in found.regions:
        if region.frustum is None:
            builder.leave_out(
                f"region {region.name!r}: it has no frustum of its own; name the screen in a "
                "theatre file with [[mpcdi]]"
            )
            continue
        window = builder.window(region.name, size=region.size)
        if window is not None:
            windows[region.name] = window.name
    if windows:
        builder.archives.append(Archive(file=path.name, windows=windows))
    return builder.build()


def read_lone_mesh(path: Path) -> ImportedTheatre:
    """A window for one mesh, with its own view if it has one."""
    builder = TheatreBuilder(path, path.stem)
    found = read_mesh(path, SIZE)
    for note in found.notes:
        builder.leave_out(note)
    screen: dict[str, Any] = {"angles": FIELD}
    if found.view is not None:
        screen = {"angles": angles_of(found.view)}
    elif path.suffix.lower() == ".data":
        screen = {"dome": {}}
    if found.view is None:
        builder.leave_out("its screen: a mesh says nothing of it, so change it here")
    window = builder.window(path.stem, size=SIZE)
    if window is not None:
        builder.channel(path.stem, window, warp=path.name, **screen)
    return builder.build()


def read_maps(path: Path) -> ImportedTheatre:
    """A window for each map of a VIOSO file."""
    builder = TheatreBuilder(path, path.stem)
    maps, notes = vioso_maps(read_input(path, MAX_BYTES), str(path))
    for note in notes:
        builder.leave_out(note)
    builder.leave_out("the screen of each map: a map says nothing of it, so change it here")
    for one in maps:
        name = one.name or path.stem
        try:
            made = vioso_mesh(one, f"{path}: map {name!r}")
        except UserError as fault:
            builder.leave_out(f"{fault}")
            continue
        window = builder.window(name, size=one.size)
        if window is not None:
            key = f"{window.name}.obj"
            builder.meshes[key] = made
            builder.channel(name, window, warp=key, angles=FIELD)
    return builder.build()


READERS: dict[str, Callable[[Path], ImportedTheatre]] = {
    ".json": read_any_json,
    ".ndisplay": read_any_json,
    ".mpcdi": read_archive,
    **dict.fromkeys(FORMATS, read_lone_mesh),
    ".vwf": read_maps,
}
