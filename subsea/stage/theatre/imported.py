"""Build a theatre from another program's file, with a line for each thing that is left out."""

import re
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np
from msgspec import inspect

from subsea.base.errors import UserError
from subsea.base.files import read_input
from subsea.base.validation import convert
from subsea.stage.theatre.measured_mesh import MeasuredMesh
from subsea.stage.theatre.mesh_formats import read_mesh
from subsea.stage.theatre.pixel_files import MAX_PICTURE, parse_png, stretched
from subsea.stage.theatre.theatre_file import (
    FEWEST_PIXELS,
    MOST_WINDOWS,
    Archive,
    Channel,
    Cluster,
    Theatre,
    Window,
    covers,
    parse_address,
    viewport,
)
from subsea.stage.theatre.warp import identity, validated
from subsea.view.rig import Rect, overlap

HERE = "127.0.0.1"


class Part(NamedTuple):
    """Shares of a rectangle, from its lower left."""

    x: float
    y: float
    width: float
    height: float


def inside(place: Rect, size: tuple[int, int]) -> Rect:
    """The part of a rectangle in a window of `size`, whose sides may be negative."""
    x, y, width, height = place
    left, top = max(x, 0), max(y, 0)
    return left, top, min(x + width, size[0]) - left, min(y + height, size[1]) - top


def without(place: Rect, hole: Rect) -> list[Rect]:
    """The rectangles of a place beside a hole, above it, below it, left and right, if large."""
    x, y, width, height = place
    left, top = max(hole[0], x), max(hole[1], y)
    right, low = min(hole[0] + hole[2], x + width), min(hole[1] + hole[3], y + height)
    beside = [
        (x, y, width, top - y), (x, low, width, y + height - low),
        (x, top, left - x, low - top), (right, top, x + width - right, low - top),
    ]  # fmt: skip
    return [rect for rect in beside if min(rect[2:]) >= FEWEST_PIXELS]


def unused_keys(content: Any, shape: inspect.Type) -> set[str]:
    """Collect the keys of all tables of a content that their structs have not."""
    match shape:
        case inspect.UnionType():
            return set().union(*(unused_keys(content, kind) for kind in shape.types))
        case inspect.ListType() if isinstance(content, list):
            return set().union(*(unused_keys(inner, shape.item_type) for inner in content))
        case inspect.DictType() if isinstance(content, dict):
            inner = content.values()
            return set().union(*(unused_keys(value, shape.value_type) for value in inner))
        case inspect.StructType() if isinstance(content, dict):
            kinds = {field.encode_name: field.type for field in shape.fields}
            known = [unused_keys(content[key], kinds[key]) for key in kinds.keys() & content.keys()]
            return set(content.keys() - kinds.keys()).union(*known)
    return set()


class ImportedTheatre(Theatre, frozen=True, kw_only=True):
    """A theatre from a file of another program."""

    left_out: tuple[str, ...] = ()  # a line for each thing that is not in this theatre
    refused: tuple[str, ...] = ()  # a line for each picture that is not, or not right
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
        self._refused: dict[str, None] = {}

    def leave_out(self, *lines: str) -> None:
        """Note things that the theatre lacks."""
        self._lines.update(dict.fromkeys(lines))

    def refuse(self, *lines: str) -> None:
        """Note pictures that the theatre lacks."""
        self._refused.update(dict.fromkeys(lines))

    def leave_out_keys(self, content: Any, kind: Any, quiet: frozenset[str]) -> None:
        """Note the keys of a file's content that its struct `kind` has not, but `quiet` ones."""
        if unused := sorted(unused_keys(content, inspect.type_info(kind)) - quiet):
            words = ", ".join(f"`{key}`" for key in unused)
            self.leave_out(f"keys with no counterpart here: {words}")

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
            self.refuse(f"windows beyond the first {MOST_WINDOWS}")
            return None
        try:
            window = convert({"name": self.name(words, "window"), **keys}, Window)
        except UserError as fault:
            self.refuse(f"window {words!r}: {fault.message}")
            return None
        self.windows.append(window)
        return window

    def channel(self, words: str, window: Window, **keys: Any) -> None:
        """Add a channel to a window, or leave it out.

        Its part beyond the window is cut off, as are the parts of earlier channels under it.
        """
        if len(self.channels) >= MOST_WINDOWS:
            self.refuse(f"viewports beyond the first {MOST_WINDOWS}")
            return
        place: Rect = keys.pop("viewport", (0, 0, *window.size))
        try:
            given = {"name": self.name(words), "window": window.name, **keys}
            channel = self._cut(convert(given, Channel), place, inside(place, window.size))
        except UserError as fault:
            self.refuse(f"viewport {words!r}: {fault.message}")
            return
        if viewport(channel, window) != place:
            self.leave_out(f"viewport {words!r}: its part beyond its window is cut off")
        for other in [other for other in self.channels if other.window == window.name]:
            if overlap(viewport(other, window), viewport(channel, window)):
                self._uncover(other, viewport(other, window), channel, viewport(channel, window))
        if viewport(channel, window) == (0, 0, *window.size):
            channel = msgspec.structs.replace(channel, viewport=None)
        self.channels.append(channel)

    def _uncover(self, below: Channel, place: Rect, above: Channel, hole: Rect) -> None:
        """Replace a channel at a place by its parts beside another one at `hole`."""
        self.channels.remove(below)
        parts = without(place, hole)
        room = MOST_WINDOWS - 1 - len(self.channels)
        if len(parts) > room:
            self.refuse(f"viewports beyond the first {MOST_WINDOWS}")
        for part in parts[:room]:
            try:
                cut = self._cut(below, place, part)
            except UserError as fault:
                self.refuse(f"viewport {below.name!r}: {fault.message}")
                return
            self.channels.append(msgspec.structs.replace(cut, name=self.name(below.name)))
        if parts:
            self.leave_out(f"viewport {below.name!r}: its part under {above.name!r} is cut off")
        else:
            self.refuse(f"viewport {below.name!r}: it lies under {above.name!r}")

    def _cut(self, channel: Channel, place: Rect, kept: Rect) -> Channel:
        """The channel at a place, reduced to the pixels `kept` of it."""
        if min(kept[2:]) < FEWEST_PIXELS:
            raise UserError(f"fewer than {FEWEST_PIXELS} pixels of it lie in its window")
        if kept == place:
            return msgspec.structs.replace(channel, viewport=kept)
        x, y, width, height = place
        share = Part(
            (kept[0] - x) / width, (y + height - kept[1] - kept[3]) / height,
            kept[2] / width, kept[3] / height,
        )  # fmt: skip
        keys: dict[str, Any] = {"viewport": kept}
        whole = channel.part or (0.0, 0.0, 1.0, 1.0)
        if channel.dome is not None and channel.warp is None and channel.part is None:
            across, up = width / min(width, height), height / min(width, height)
            whole = (0.5 - across / 2, 0.5 - up / 2, across, up)
            keys["part"] = whole
        if channel.warp is None and channel.mask is None:
            keys["part"] = (
                whole[0] + share.x * whole[2], whole[1] + share.y * whole[3],
                share.width * whole[2], share.height * whole[3],
            )  # fmt: skip
        else:
            name = f"{channel.name}-{kept[0]}-{kept[1]}.obj"
            self.meshes[name] = self._cut_mesh(channel, (width, height), share)
            keys |= {"warp": name, "mask": None}
        part = keys.get("part", whole)
        if min(part[2:]) < 1e-3 or max(map(abs, part)) > 10:
            raise UserError("the part of its screen that is left is too small")
        return msgspec.structs.replace(channel, **keys)

    def _cut_mesh(self, channel: Channel, size: tuple[int, int], share: Part) -> MeasuredMesh:
        """The mesh and mask of a channel of `size` pixels, for a share of those alone."""
        folder, measured = self.path.parent, MeasuredMesh(identity())
        if channel.warp is not None:
            measured = self.meshes.get(channel.warp) or read_mesh(folder / channel.warp, size)
        masks = [] if measured.mask is None else [measured.mask]
        if channel.mask is not None:
            path = folder / channel.mask
            masks.append(parse_png(read_input(path, MAX_PICTURE), str(path)))
        mask = None
        for given in masks:
            factors = stretched(np.asarray(given[..., :3], np.float32), *size)
            mask = factors if mask is None else mask * factors
        if mask is not None:
            left, top = round(share.x * size[0]), round((1 - share.y - share.height) * size[1])
            right, low = left + round(share.width * size[0]), top + round(share.height * size[1])
            mask = np.pad(mask[top:low, left:right], ((0, 0), (0, 0), (0, 1)))
        vertices = measured.warp.vertices.copy()
        vertices[:, :2] = (vertices[:, :2] - share[:2]) / share[2:]
        return MeasuredMesh(validated(measured.warp._replace(vertices=vertices), "its mesh"), mask)

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
        lines = [*self._refused, *self._lines]
        if not self.channels and not self.archives:
            why = f"; left out: {lines[0]}" if lines else ""
            more = f" (and {len(lines) - 1} more)" if len(lines) > 1 else ""
            raise UserError(f"no viewport in it can be shown{why}{more}", file=self.path)
        windows = [window for window in self.windows if window.name in used]
        warps = {channel.warp for channel in self.channels}
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
            refused=tuple(self._refused),
            meshes={key: mesh for key, mesh in self.meshes.items() if key in warps},
            **self.keys,
        )
