"""Write theatre files: a theatre of another program, with the meshes that are in no file, a copy of
a theatre file, or a layout, with comments and the steps to line its projectors up."""

import io
import os
import textwrap
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from msgspec import inspect
from PIL import Image

from subsea.base.arrays import Array
from subsea.base.errors import UserError, printable
from subsea.base.files import check_file, read_text, replacing
from subsea.base.toml_edit import edit_toml, toml_value
from subsea.base.toml_files import MAX_BYTES
from subsea.stage.theatre.imported import ImportedTheatre
from subsea.stage.theatre.layouts import TheatreLayout, front_channel
from subsea.stage.theatre.measured_mesh import MeasuredMesh
from subsea.stage.theatre.theatre_file import FILE, Theatre
from subsea.view.rig import Warp

# A comment before the first of each kind of table.
COMMENTS = {
    "window": "One for each monitor or projector; `monitor = 1` makes it fill one.",
    "channel": "A part of a window and the screen that it fills.",
    "mpcdi": "Channels from a calibration archive.",
    "cluster": "Several computers: start each with --node.",
    "loudspeaker": "As the best seat hears them.",
}
IN_A_ROW = 6  # windows of a row of the desktop
COLUMN = 98  # of comments
UNWRITTEN = "meshes", "left_out", "refused"


def write_theatre(theatre: Theatre, path: Path, out: Path, force: bool = False) -> list[Path]:
    """Write a theatre that was read from `path` to `out`; return the files that were written.

    A theatre file of our own keeps its comments. Files that it names are named relative to `out`.
    Warps that are in no file are written beside it. Existing files are a UserError without `force`;
    nothing is written then.
    """
    if out.suffix.lower() != ".toml":
        raise UserError("expected a file that ends in .toml", file=out)
    made = theatre.meshes if isinstance(theatre, ImportedTheatre) else {}
    names = {key: out.with_name(f"{out.stem}-{Path(key).name}") for key in made}
    masks = {
        key: names[key].with_suffix(".png") for key, mesh in made.items() if mesh.mask is not None
    }
    files = [*names.values(), *masks.values(), out]
    for file in files:
        check_free(file, force)

    def placed(file: str) -> str:
        if file in names:
            return names[file].name
        if Path(file).is_absolute():
            return file
        return os.path.relpath(path.parent / file, out.parent).replace(os.sep, "/")

    if path.suffix.lower() == ".toml":
        text = _with_files(path, placed)
    else:
        content = moved_files(plain(theatre), placed)
        for channel, table in zip(theatre.channel, content.get("channel", ()), strict=True):
            if channel.warp in masks:
                table["mask"] = masks[channel.warp].name
        text = compose_theatre(theatre, content, path)
    for key, mesh in made.items():
        _write(names[key], compose_obj(mesh.warp).encode())
        if key in masks:
            _write(masks[key], _png(mesh))
    _write(out, text.encode())
    return files


def moved_files(content: Any, placed: Callable[[str], str], kind: Any = Theatre) -> Any:
    """Return the content of a theatre file with `placed` applied to the names of all files."""
    return _moved(content, inspect.type_info(kind), placed)


def _moved(content: Any, shape: inspect.Type, placed: Callable[[str], str]) -> Any:
    """Apply `placed` to the texts in a content whose type is `File`."""
    match shape, content:
        case inspect.StrType(pattern=pattern), str() if pattern == FILE:
            return placed(content)
        case inspect.UnionType(), _:
            for kind in shape.types:  # at most one of them names a file
                content = _moved(content, kind, placed)
        case inspect.ListType(), list():
            return [_moved(inner, shape.item_type, placed) for inner in content]
        case inspect.DictType(), dict():
            return {key: _moved(inner, shape.value_type, placed) for key, inner in content.items()}
        case inspect.StructType(), dict():
            kinds = {field.encode_name: field.type for field in shape.fields}
            return {key: _moved(inner, kinds[key], placed) for key, inner in content.items()}
    return content


def _with_files(path: Path, placed: Callable[[str], str]) -> str:
    """Return the text of a theatre file of our own in which the names of files are `placed`."""
    text = read_text(path, MAX_BYTES)
    old = tomllib.loads(text)
    new = moved_files(old, placed)
    changed = text if new == old else edit_toml(text, old, new, file=path)
    if tomllib.loads(changed) != new:
        raise UserError("its tables cannot be edited; write each table with a header", file=path)
    return changed


def check_free(path: Path, force: bool) -> None:
    """Refuse to replace a file, which may hold measured values, unless forced."""
    check_file(path)
    if path.exists() and not force:
        raise UserError("exists; choose another name, or give --force to replace it", file=path)


def compose_theatre(theatre: Theatre, content: dict[str, Any], source: Path) -> str:
    """The text of a theatre file with this content, and what is left out of it as comments."""
    lines = [_comment(f"Written by `subsea theatre {source.name} --write`.")]
    for kind in ("refused", "left_out"):
        lines += [_comment(f"Left out: {line}") for line in getattr(theatre, kind, ())]
    lines.append("")
    tables = {key: value for key, value in content.items() if _is_table(value)}
    lines += _pairs({key: value for key, value in content.items() if key not in tables})
    for key, value in tables.items():
        header = f"[{key}]" if isinstance(value, dict) else f"[[{key}]]"
        comment = [_comment(COMMENTS[key])] if key in COMMENTS else []
        for table in [value] if isinstance(value, dict) else value:
            lines += ["", *comment, header, *_pairs(table)]
            comment = []
    return "\n".join(lines) + "\n"


def _is_table(value: Any) -> bool:
    """True for a table or a list of tables, which have headers."""
    return isinstance(value, dict) or (isinstance(value, list) and isinstance(value[0], dict))


def compose_obj(warp: Warp) -> str:
    """A Wavefront OBJ file of a warp."""
    places = warp.vertices[:, :2].astype(np.float64)
    # The reader takes a mesh without x or y below -0.5 as one from 0 to 1.
    shown = places if places.min() >= 0.25 else 2.0 * places - 1.0
    lines = [f"v {x:.7g} {y:.7g} 0" for x, y in shown]
    lines += [f"vt {u:.7g} {v:.7g}" for u, v in warp.vertices[:, 2:4].astype(np.float64)]
    lines += [f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in (warp.triangles + 1).tolist()]
    return "\n".join(lines) + "\n"


def _pairs(table: dict[str, Any]) -> list[str]:
    first = [key for key in ("name", "window", "viewport") if key in table]
    keys = [*first, *(key for key in table if key not in first)]
    return [f"{key} = {toml_value(table[key])}" for key in keys]


def plain(value: Any) -> Any:
    """Turn structs into tables without keys that have their default, tuples into lists."""
    if isinstance(value, msgspec.Struct):
        table = {}
        for field in msgspec.structs.fields(value):
            inner = getattr(value, field.name)
            same = field.default is not msgspec.NODEFAULT and inner == field.default
            empty = field.default_factory is not msgspec.NODEFAULT and not inner
            # A screen is there even if all its keys have their defaults.
            if not (same or empty or inner is None) and field.name not in UNWRITTEN:
                table[field.name] = plain(inner)
        return table
    if isinstance(value, dict):
        return {key: plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in value]
    return value


def _comment(text: str) -> str:
    return f"# {printable(text)}"


def _png(mesh: MeasuredMesh) -> bytes:
    """The factors of a mask as a picture."""
    assert mesh.mask is not None
    factors: Array = np.asarray(mesh.mask[..., :3])
    packed = io.BytesIO()
    Image.fromarray(np.round(255 * np.clip(factors, 0, 1)).astype(np.uint8)).save(packed, "PNG")
    return packed.getvalue()


def _write(path: Path, data: bytes) -> None:
    with replacing(path) as part:
        part.write_bytes(data)


def mesh_name(stem: str, channel: str) -> str:
    """The name of the mesh file of a channel, beside the theatre file with this stem."""
    return f"{stem}-{channel}.data"


def compose_layout(
    layout: TheatreLayout, stem: str, size: tuple[int, int], computers: bool, command: str
) -> str:
    """The text of a theatre file; `size` is that of every window, `command` made it.

    With `computers` each window is on a node of its own. The master is in front of the audience,
    as its window has text and its picture is the presenter's.
    """
    names = [channel.name for channel in layout.channels]
    lines = [f"# {layout.title}. Made by:", f"#   {command}"]
    lines += [f"# {note}." for note in layout.notes]
    lines += ["#"]
    for number, step in enumerate(line_up(layout, computers), 1):
        lines += textwrap.wrap(f"# {number}. {step}", COLUMN, subsequent_indent="#   ")
    lines += ["", f'title = "{layout.title}"']
    lines += ["eye_cm = [0, 0, 0]  # the best seat; lengths count from here: right, up, ahead"]
    if layout.dome is not None:
        lines += ["level = true  # the rim of a dome shows any tilt of the horizon"]
    for number, name in enumerate(names):
        row, column = divmod(number, IN_A_ROW)
        lines += ["", "[[window]]", f'name = "{name}"']
        lines += [f'node = "{name}"'] * computers
        lines += [f"size = {list(size)}"]
        place = [0, 0] if computers else [column * size[0], row * size[1]]
        lines += [f"position = {place}  # or `monitor = {1 if computers else number + 1}`"]
    for channel in layout.channels:
        lines += ["", "[[channel]]", f'name = "{channel.name}"', f'window = "{channel.name}"']
        lines += [f"{type(channel.screen).__name__.lower()} = {_toml(channel.screen)}"]
        if channel.viewport is not None:
            lines += [f"viewport = {list(channel.viewport)}  # with square pixels on the screen"]
        if layout.blend and len(names) > 1:
            lines += ["blend = true", "gamma = 2.2  # of the projector", "black = 0.0"]
        if channel.nodes is not None:
            lines += [f'warp = "{mesh_name(stem, channel.name)}"']
    lines += ["", "# Only for `subsea theatre FILE --picture`.", "[room]"]
    lines += [f"floor_cm = {_toml(layout.floor_cm)}"]
    if layout.dome is not None:
        lines += [f"dome = {_toml(layout.dome)}"]
    if layout.mirror is not None:
        lines += [f"mirror = {_toml(layout.mirror)}"]
    lines += ["", "[room.projectors]  # places of the lenses"]
    lines += [f"{channel.name} = {_toml(channel.lens.place)}" for channel in layout.channels]
    if computers:
        lines += ["", "# One computer shows all nodes as it stands. For several enter the master's"]
        lines += ["# own address, make keys with"]
        lines += [f'# `subsea keys keys {" ".join(names)}`, and add `keys = "keys"`.', "[cluster]"]
        lines += [f'master = "{front_channel(layout).name}"', 'address = "127.0.0.1:5560"']
    return "\n".join(lines) + "\n"


def line_up(layout: TheatreLayout, computers: bool) -> list[str]:
    """The steps to line up the projectors of a layout, in their order."""
    warped = any(channel.nodes is not None for channel in layout.channels)
    blended = layout.blend and len(layout.channels) > 1
    steps = ["Fix each projector at its place under [room.projectors]. Switch off keystone, zoom "
             "modes and dynamic contrast; let it warm up for half an hour."]  # fmt: skip
    if layout.mirror is not None:
        steps += ["Fix the mirror at its place under [room]. The front surface must reflect. "
                  "Set focus at the middle of the dome."]  # fmt: skip
    steps += ["Measure the screen: corners, radius or angles, in centimetres from the best seat. "
              "Correct the channels below, then run `subsea theatre FILE`."]  # fmt: skip
    steps += [
        "Dive with `subsea dive --theatre FILE` and press T for the test pattern. The white "
        "edge of each picture must be complete, and numbers must stand in their places."
    ]
    if warped:
        steps += [
            "Move each projector until its pattern fits: first its middle, then its size, "
            "then its corners. The meshes hold for the places of the lenses in this file; "
            "for others make them again with these places, or with a calibration camera."
        ]
    else:
        steps += [
            "Move each projector until its pattern fits the measured corners: first its "
            "middle with lens shift, then its size with zoom. Circles must be round."
        ]
    if blended:
        steps += [
            "Compare the patterns of neighbours where they overlap: lines must meet within "
            "a pixel or two at eye level, then at the top and the bottom."
        ]
        steps += [
            "Press T again. If the overlap is brighter than the rest in all scenes, lower "
            "`gamma`; if it is darker, raise it."
        ]
        steps += ["In a dark room show a dark scene. If overlaps are grey strips, raise `black` "
                  "in steps of 0.001."]  # fmt: skip
    if computers:
        steps += ["Start a dive on each computer with its `--node NAME`, in any order."]
    return steps


def _short(value: Any) -> Any:
    """Round numbers to a thousandth, whole ones without a point."""
    if isinstance(value, dict):
        return {key: _short(inner) for key, inner in value.items()}
    if isinstance(value, list | np.ndarray):
        return [_short(inner) for inner in value]
    number = round(float(value), 3)
    return int(number) if number.is_integer() else number


def _toml(value: Any) -> str:
    return toml_value(_short(plain(value)))
