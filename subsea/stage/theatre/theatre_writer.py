"""Write a theatre as a TOML file of our own, with the meshes that are in no file."""

import io
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from PIL import Image

from subsea.base.arrays import Array
from subsea.base.errors import UserError, printable
from subsea.base.files import check_file, replacing
from subsea.base.toml_edit import toml_value
from subsea.stage.theatre.imported import ImportedTheatre
from subsea.stage.theatre.measured_mesh import MeasuredMesh
from subsea.stage.theatre.theatre_file import Theatre
from subsea.view.rig import Warp

# A comment before the first of each kind of table.
COMMENTS = {
    "window": "One for each monitor or projector; `monitor = 1` makes it fill one.",
    "channel": "A part of a window and the screen that it fills.",
    "mpcdi": "Channels from a calibration archive.",
    "cluster": "Several computers: start each with --node.",
    "loudspeaker": "As the best seat hears them.",
}
KEYS = ("title", "scale", "eye_cm", "eye_distance_cm", "level")


def write_theatre(theatre: Theatre, path: Path, out: Path, force: bool = False) -> list[Path]:
    """Write a theatre that was read from `path` to `out`; return the files that were written.

    Files that it names are named relative to `out`. Warps that are in no file are written beside
    it. Existing files are a UserError without `force`; nothing is written then.
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
        if file.exists() and not force:
            raise UserError("is there already, expected a new name or --force", file=file)
        check_file(file)
    folder = os.path.relpath(path.parent, out.parent)

    def placed(file: str | None) -> str | None:
        return None if file is None else os.path.normpath(Path(folder) / file).replace(os.sep, "/")

    channels = []
    for channel in theatre.channel:
        warp = channel.warp
        if warp is not None and warp in made:
            own_mask = masks[warp].name if warp in masks else placed(channel.mask)
            channel = msgspec.structs.replace(channel, warp=names[warp].name, mask=own_mask)
        else:
            changes = {"warp": placed(warp), "mask": placed(channel.mask)}
            channel = msgspec.structs.replace(channel, **changes)
        channels.append(channel)
    archives = [msgspec.structs.replace(one, file=placed(one.file)) for one in theatre.mpcdi]
    moved = msgspec.structs.replace(theatre, channel=channels, mpcdi=archives)
    for key, mesh in made.items():
        _write(names[key], compose_obj(mesh.warp).encode())
        if key in masks:
            _write(masks[key], _png(mesh))
    _write(out, compose_theatre(moved, path).encode())
    return files


def compose_theatre(theatre: Theatre, source: Path) -> str:
    """The text of a theatre file, with what is left out as comments."""
    lines = [_comment(f"Written by `subsea theatre {source.name} --write`.")]
    lines += [_comment(f"Left out: {line}") for line in getattr(theatre, "left_out", ())]
    lines.append("")
    content = plain(theatre)
    lines += [f"{key} = {toml_value(content[key])}" for key in KEYS if key in content]
    for kind in ("window", "channel", "mpcdi", "loudspeaker"):
        lines += _tables(kind, content.get(kind, ()))
    if "cluster" in content:
        lines += ["", _comment(COMMENTS["cluster"]), "[cluster]", *_pairs(content["cluster"])]
    return "\n".join(lines) + "\n"


def compose_obj(warp: Warp) -> str:
    """A Wavefront OBJ file of a warp."""
    places = warp.vertices[:, :2].astype(np.float64)
    # The reader takes a mesh without x or y below -0.5 as one from 0 to 1.
    shown = places if places.min() >= 0.25 else 2.0 * places - 1.0
    lines = [f"v {x:.7g} {y:.7g} 0" for x, y in shown]
    lines += [f"vt {u:.7g} {v:.7g}" for u, v in warp.vertices[:, 2:4].astype(np.float64)]
    lines += [f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in (warp.triangles + 1).tolist()]
    return "\n".join(lines) + "\n"


def _tables(kind: str, tables: Iterable[dict[str, Any]]) -> list[str]:
    lines = []
    for number, table in enumerate(tables):
        lines.append("")
        if number == 0:
            lines.append(_comment(COMMENTS[kind]))
        lines += [f"[[{kind}]]", *_pairs(table)]
    return lines


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
            if not (same or empty or inner is None) and field.name not in ("meshes", "left_out"):
                table[field.name] = plain(inner)
        return table
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
