"""The windows of a theatre.

Set up a theatre: its working channels, their windows, and the rig.
"""

from collections.abc import Callable, Sequence
from hashlib import sha256
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from subsea.base.errors import UserError, unknown
from subsea.base.files import file_hash
from subsea.base.progress import count_noun, print_line, say
from subsea.base.toml_files import error_at
from subsea.dive.options import DisplayOptions
from subsea.dive.pilot import Pilot
from subsea.dive.tick_source import TickSource
from subsea.sound.space import Layout, loudspeakers
from subsea.stage.cluster.link import cluster_faults
from subsea.stage.cluster.messages import HASH
from subsea.stage.cluster.ticks import tick_source_maker
from subsea.stage.theatre.adjusting import in_larger_pixels, patch_adjustment
from subsea.stage.theatre.channels import ProjectorChannel, usable_channels
from subsea.stage.theatre.imported import ImportedTheatre
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.theatre_file import FEWEST_PIXELS, Archive, Channel, Theatre, Window
from subsea.stage.theatre.theatre_rig import theatre_rig, visible_channels
from subsea.stage.theatre.theatre_writer import write_theatre
from subsea.stage.theatre.warp import describe_warp
from subsea.ui.monitors import Installation, Screen
from subsea.view.rig import CameraRig, front
from subsea.view.stereo import EYES, Stereo
from subsea.world.world import World

if TYPE_CHECKING:
    from subsea.stage.parts import TheatrePart


class TheatreSetup(NamedTuple):
    """The part of a theatre that this computer shows."""

    theatre: Theatre
    path: Path
    windows: tuple[Window, ...]  # one for each output of the rig
    rig: CameraRig
    # Of this computer, none if all belong to others; None: the theatre lists none.
    loudspeakers: Layout | None = None
    in_front: bool = True  # False: other computers show what is ahead of the audience
    whole: Theatre | None = None  # with all its pixels, if the theatre is shrunk
    channels: tuple[ProjectorChannel, ...] = ()  # those that work, of all computers
    digest: str = ""  # of the file when it was read


class TheatreWindows(NamedTuple):
    """The windows of a theatre on this computer, and what makes its ticks."""

    installation: Installation
    make_ticks: Callable[[World, Pilot], TickSource]
    setup: TheatreSetup
    view: dict[str, str]  # must be equal on all computers; a saved line-up changes it


def set_up_theatre(
    name: str,
    display: str = "mono",
    stereo: Stereo = EYES,
    node: str | None = None,
    shrink: int = 1,
) -> TheatreSetup:
    """Load a theatre; faulty channels are reported and left out.

    `node`: the windows of one computer; None: all. `shrink`: times fewer pixels a side. A UserError
    if nothing can be shown.
    """
    theatre, path = load_theatre(name)
    if node is not None and theatre.cluster is None:
        raise UserError("has no [cluster]; drop --node", file=path)
    if node is not None and node not in theatre.nodes:
        raise UserError(unknown("node", node, list(theatre.nodes)).message, file=path)
    digest, whole = file_hash(path), theatre
    theatre = shrink_theatre(theatre, shrink)
    for line in chain(*import_notes(theatre)):
        say(f"{path}: left out: {line}")
    found, faults, unseen = _shown_channels(theatre, path, display, stereo)
    if not found:
        raise unseen[0]
    for fault in (*faults, *unseen):
        say(f"{fault}; left out")
    numbers = shown_windows(theatre, found, node)
    if not numbers:
        raise UserError(f"node {node!r} has no window with a channel that works", file=path)
    rig = theatre_rig(theatre, found, numbers, display, stereo)
    windows = tuple(theatre.window[number] for number in numbers)
    everybody = rig
    if node is not None:
        numbers = shown_windows(theatre, found, None)
        everybody = theatre_rig(theatre, found, numbers, display, stereo)
    ahead = front(everybody).channel == front(rig).channel
    return TheatreSetup(
        theatre, path, windows, rig, _loudspeakers(theatre, node), ahead, whole, found, digest
    )


def _shown_channels(
    theatre: Theatre, path: Path, display: str = "mono", stereo: Stereo = EYES
) -> tuple[tuple[ProjectorChannel, ...], tuple[UserError, ...], tuple[UserError, ...]]:
    """The channels that work and are in sight, faults of others, and those out of sight."""
    found, faults = usable_channels(theatre, path)
    found, unseen = visible_channels(theatre, found, display, stereo)
    return found, faults, tuple(error_at(path, one.key or "", one.message) for one in unseen)


def _loudspeakers(theatre: Theatre, node: str | None) -> Layout | None:
    """The loudspeakers of one computer, None: of all; None if the theatre lists none."""
    if not theatre.loudspeaker:
        return None
    shown = [one for one in theatre.loudspeaker if node in (None, one.node)]
    return loudspeakers([(one.azimuth_deg, one.elevation_deg) for one in shown])


def named_rig(
    name: str, display: str, stereo: Stereo, shrink: int
) -> tuple[CameraRig, tuple[str, ...]]:
    """The rig of a theatre, and the names of its outputs, for `view.display_rigs.chosen_rig`."""
    house = set_up_theatre(name, display, stereo, shrink=shrink)
    names = tuple(window.name for window in house.windows)
    return house.rig, names if len(names) > 1 else ("",)


def theatre_digest(name: str) -> str:
    """A digest of a theatre file and of the calibration files that it names."""
    theatre, path = load_theatre(name)
    made = theatre.meshes if isinstance(theatre, ImportedTheatre) else {}
    files = [file for one in theatre.channel for file in (one.warp, one.mask, one.black_mask)]
    named = [file for file in files if file is not None and file not in made]
    named += [archive.file for archive in theatre.mpcdi]
    whole = sha256()
    for mesh in made.values():
        whole.update(mesh.warp.vertices.tobytes())
        whole.update(mesh.warp.triangles.tobytes())
    for file in (path, *(path.parent / one for one in named)):
        try:
            whole.update(bytes.fromhex(file_hash(file)))
        except UserError:  # reported where it is used
            whole.update(b"none")
    return whole.hexdigest()


def view_parts(name: str, display: str, stereo: Stereo) -> dict[str, str]:
    """Theatre and display as parts of an `Identity`: all but which eye is which."""
    return {
        "theatre files": HASH + theatre_digest(name)[:10],
        "--display": display,
        "--eye-distance": str(stereo.separation_cm),
        "--comfort": str(stereo.comfort_deg),
        "--screen-distance": str(stereo.screen_cm),
        "--screen-width": str(stereo.screen_width_cm),
    }


def shown_windows(
    theatre: Theatre, found: Sequence[ProjectorChannel], node: str | None
) -> list[int]:
    """Indices of the windows with a channel, of one node; None: of all nodes."""
    return [
        number
        for number, window in enumerate(theatre.window)
        if node in (None, window.node) and any(one.window == number for one in found)
    ]


def shrink_theatre(theatre: Theatre, times: int) -> Theatre:
    """The same theatre with `times` fewer pixels a side.

    A UserError if a window or viewport would get smaller than a file may ask for.
    """
    if times == 1:
        return theatre

    def less(window: Window) -> Window:
        size = window.size[0] // times, window.size[1] // times
        _check_left(times, size, f"window {window.name!r}")
        place = None if window.position is None else tuple(x // times for x in window.position)
        return msgspec.structs.replace(window, size=size, position=place)

    def smaller(channel: Channel) -> Channel:
        channel = in_larger_pixels(channel, times)
        if channel.viewport is None:
            return channel
        x, y, width, height = channel.viewport
        left, top = x // times, y // times  # common edges stay common
        size = (x + width) // times - left, (y + height) // times - top
        _check_left(times, size, f"channel {channel.name!r}")
        return msgspec.structs.replace(channel, viewport=(left, top, *size))

    return msgspec.structs.replace(
        theatre,
        window=[less(window) for window in theatre.window],
        channel=[smaller(channel) for channel in theatre.channel],
        mpcdi=[_smaller_regions(archive, times) for archive in theatre.mpcdi],
    )


def _smaller_regions(archive: Archive, times: int) -> Archive:
    """Count the adjustments of an archive's regions in larger pixels."""
    adjust = {name: in_larger_pixels(one, times) for name, one in archive.adjust.items()}
    return msgspec.structs.replace(in_larger_pixels(archive, times), adjust=adjust)


def _check_left(times: int, size: tuple[int, int], what: str) -> None:
    if min(size) < FEWEST_PIXELS:
        raise UserError(
            f"--shrink {times} leaves {size[0]}x{size[1]} pixels of {what}, expected "
            f"{FEWEST_PIXELS} or more a side"
        )


def import_notes(theatre: Theatre) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """List the pictures of another program's file that are not shown, and what else has no use."""
    if isinstance(theatre, ImportedTheatre):
        return theatre.refused, theatre.left_out
    return (), ()


def describe(name: str, write: Path | None = None, force: bool = False) -> int:
    """Print the parts and faults of a theatre; exit code 0 if all works, else 1.

    `write`: also write it as a theatre file of our own.
    """
    theatre, path = load_theatre(name)
    if write is not None:
        for file in write_theatre(theatre, path, write, force):
            print_line(f"wrote {file}")
    print_line(f"{path}: {theatre.title or 'a theatre'}")
    found: Sequence[ProjectorChannel]
    try:
        found, faults, unseen = _shown_channels(theatre, path)
        faults = (*faults, *unseen)
    except UserError as fault:
        found, faults = (), (fault,)
    for number, window in enumerate(theatre.window):
        where = "where the desktop puts it"
        if window.monitor is not None:
            where = f"on monitor {window.monitor!r}"
        elif window.position is not None:
            where = f"at {window.position[0]}, {window.position[1]}"
        if len(theatre.nodes) > 1:
            where += f" of {window.node}"
        print_line(f"window {window.name}: {window.size[0]}x{window.size[1]} pixels {where}")
        for one in found:
            if one.window == number:
                print_line(f"  channel {one.name}: {_words(one)}")
    if found:
        rig = theatre_rig(theatre, found, shown_windows(theatre, found, None))
        drawn = sum(eye.viewport[2] * eye.viewport[3] for eye in rig.eyes)
        shown = sum(width * height for width, height in rig.outputs)
        views = count_noun(len(rig.eyes), "view", "views")
        print_line(
            f"{views}, {drawn / 1e6:.1f} million pixels drawn for "
            f"{shown / 1e6:.1f} million shown, on a canvas of {rig.canvas[0]}x{rig.canvas[1]}"
        )
    if theatre.cluster is not None:
        master, address = theatre.cluster.master, theatre.cluster.address
        others = ", ".join(node for node in theatre.nodes if node != master) or "nobody else"
        print_line(f"master {master} at {address}, with {others}")
        faults = (*faults, *cluster_faults(theatre.cluster, theatre.nodes, path))
    for node in theatre.node:
        print_line(f"node {node.name}: woken at {node.mac} through {node.wake}")
    for projector in theatre.projector:
        place = f"{projector.address}, port {projector.port}"
        print_line(f"projector {projector.name}: PJLink at {place}")
    refused, unused = import_notes(theatre)
    for fact in unused:
        print_line(f"left out: {fact}")
    for line in (*refused, *faults):
        print_line(f"does not work: {line}")
    return 1 if refused or faults else 0


def _words(one: ProjectorChannel) -> str:
    """A short description of a channel."""
    parts = [f"{one.place[2]}x{one.place[3]} pixels, {type(one.screen).__name__.lower()}"]
    if one.screen is None:
        parts = [f"{one.place[2]}x{one.place[3]} pixels, {one.shape.name.lower()}"]
    parts.append(f"{one.distance_cm:.0f} cm away")
    if one.warp is not None:
        parts.append(f"warped by {describe_warp(one.warp)}")
    if one.mask is not None:
        parts.append("blended")
    if patch_adjustment(one.adjustment, one.size) is not None:
        parts.append("adjusted")
    return ", ".join(parts)


def theatre_windows(
    theatre: "TheatrePart", display: DisplayOptions, leads: bool = False
) -> TheatreWindows:
    """The rig and windows of a theatre, and the maker of its tick source.

    A master that `leads` has its nodes open the scenarios that it shows.
    """
    setup = set_up_theatre(theatre.name, display.mode, display.stereo, theatre.node, theatre.shrink)
    view: dict[str, str] = {}
    if theatre.node is not None:
        view = view_parts(theatre.name, display.mode, display.stereo)
    make_ticks = tick_source_maker(
        setup.theatre, setup.path, theatre.node, view, theatre.resumes, leads
    )
    screens = [
        Screen(window.name, window.size, window.position, window.monitor)
        for window in setup.windows
    ]
    shown = Installation(setup.rig, screens, str(setup.path), setup.loudspeakers, setup.in_front)
    return TheatreWindows(shown, make_ticks, setup, view)
