"""Save a line-up into the theatre file: only its own keys change, the old file is kept."""

import tomllib
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import msgspec

from subsea.base.errors import UserError
from subsea.base.files import file_hash, read_input, replacing, text_of
from subsea.base.system import resource_path
from subsea.base.toml_edit import edit_toml, toml_pieces
from subsea.base.toml_files import MAX_BYTES
from subsea.base.toml_positions import place_of
from subsea.base.validation import convert
from subsea.stage.theatre.channels import ProjectorChannel
from subsea.stage.theatre.theatre_file import FOLDER, Adjustment, Theatre, adjustment_of
from subsea.stage.theatre.theatre_writer import plain

Content = dict[str, Any]


class AdjustedChannel(NamedTuple):
    """A channel and the adjustment that its theatre file is to have."""

    channel: ProjectorChannel
    adjustment: Adjustment


def file_adjustment(theatre: Theatre, channel: ProjectorChannel) -> Adjustment:
    """Find the adjustment of a channel in its theatre file."""
    kind, number = _table_place(channel)
    table = getattr(theatre, kind)[number]
    adjusted = table.adjust.get(channel.name, table) if kind == "mpcdi" else table
    return adjustment_of(adjusted)


def save_line_up(path: Path, digest: str, adjusted: Iterable[AdjustedChannel]) -> str:
    """Write adjustments into the theatre file that had this hash; returns the hash of the new file.

    Comments and all other keys stay. The old file is kept beside it as `.bak`, `.bak2` and so on. A
    file that has them already is left alone. UserErrors; nothing is written then.
    """
    _check_ours(path)
    data = read_input(path, MAX_BYTES)
    text = text_of(data, path)
    adjusted = list(adjusted)
    now = file_hash(path)
    if now != digest:
        with suppress(UserError, ValueError, LookupError):  # it may be another theatre by now
            if with_adjustments(text, path, adjusted) == text:
                return now
        raise UserError(
            "has changed on disk since the dive read it, so the line-up is not saved; start the "
            "dive again",
            file=path,
        )
    changed = with_adjustments(text, path, adjusted)
    if changed == text:
        return now
    with replacing(_free(path)) as part:
        part.write_bytes(data)
    with replacing(path) as part:
        part.write_bytes(changed.encode("utf-8"))
    return file_hash(path)


def with_adjustments(text: str, path: Path, adjusted: Iterable[AdjustedChannel]) -> str:
    """Return the text of a theatre file with adjustments of its channels."""
    ends = "\r\n" if text.count("\r\n") == text.count("\n") > 0 else "\n"
    text = text.replace(ends, "\n")
    before = tomllib.loads(text)
    wanted = convert(before, Theatre)
    head, pieces = toml_pieces(text)
    for channel, adjustment in adjusted:
        kind, number = _table_place(channel)
        old = before[kind][number]
        new = _table(old, adjustment, channel.name if kind == "mpcdi" else None)
        if new == old:
            continue
        wanted, before[kind][number] = _with_table(wanted, kind, number, new), new
        places = [k for k, piece in enumerate(pieces) if piece.key == kind and piece.begins]
        if len(places) == len(before[kind]):
            piece = pieces[places[number]]
            edited = edit_toml(piece.text, old, new, (kind, 0), path)
            pieces[places[number]] = piece._replace(text=edited)
        else:  # an array of inline tables
            whole = edit_toml(
                head + "".join(p.text for p in pieces), old, new, (kind, number), path
            )
            head, pieces = toml_pieces(whole)
    result = head + "".join(piece.text for piece in pieces)
    if convert(tomllib.loads(result), Theatre) != wanted:
        raise UserError("its tables cannot be edited; write each table with a header", file=path)
    return result.replace("\n", ends)


def _table_place(channel: ProjectorChannel) -> tuple[str, int]:
    """The kind and the number of the table of a channel in its theatre file."""
    kind, number = place_of(channel.key)
    return str(kind), int(number)


def _table(old: Content, adjustment: Adjustment, region: str | None) -> Content:
    """The table of a channel, or of the archive of a region, with an adjustment.

    Keys with their default are left out, unless the file has them.
    """
    if region is not None:
        regions = dict(old.get("adjust", {}))
        regions[region] = _table(regions.get(region, {}), adjustment, None)
        return {**old, "adjust": regions}
    content = plain(adjustment)
    new = {key: value for key, value in old.items() if key not in Adjustment.__struct_fields__}
    for key in Adjustment.__struct_fields__:
        default = getattr(Adjustment(), key)
        if key in content:
            new[key] = content[key]
        elif key in old and default is not None:
            same = old[key] == plain(default)
            new[key] = old[key] if same else plain(default)
    return new


def _with_table(theatre: Theatre, kind: str, number: int, table: Content) -> Theatre:
    """The theatre with another table of this kind."""
    tables = list(getattr(theatre, kind))
    tables[number] = convert(table, type(tables[number]))
    return msgspec.structs.replace(theatre, **{kind: tables})


def _check_ours(path: Path) -> None:
    """Refuse files of other programs, and those that belong to subsea."""
    copy = f"`subsea theatre {path.stem if path.suffix == '.toml' else path} --write mine.toml`"
    if path.suffix.lower() != ".toml":
        raise UserError(
            "is another program's file, so the line-up is not saved; make a theatre file of it "
            f"with {copy}",
            file=path,
        )
    if path.resolve().parent == resource_path(FOLDER).resolve():
        raise UserError(
            f"belongs to subsea; make a theatre file of your own with {copy}", file=path
        )


def _free(path: Path) -> Path:
    """The first free name for the old file."""
    number = 1
    while (free := path.with_name(f"{path.name}.bak{number if number > 1 else ''}")).exists():
        number += 1
    return free
