"""Recognise result files by their content, so that no result replaces a file of another kind."""

import csv
import json
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

from subsea.base.errors import UserError
from subsea.base.files import check_file, logical_lines, read_text, text_of

MAX_JSON = 100_000_000  # bytes; no report is longer
HEAD = 4096  # characters that identify a file of text
VERTEX = re.compile(r"\s*v(\s+[-+.\deE]+){3}")
OBJ_WORDS = ("mtllib", "usemtl", "o", "g", "s", "v", "vt", "vn", "vp", "f", "l", "p")


class FileKind(NamedTuple):
    """A kind of file that commands write."""

    noun: str  # with its article, for messages
    fits: Callable[[Path], bool]  # an error of the file: it does not


def signed(noun: str, signature: bytes, at: int = 0) -> FileKind:
    """Files with these bytes at an offset."""

    def fits(path: Path) -> bool:
        with path.open("rb") as file:
            return file.read(at + len(signature))[at:] == signature

    return FileKind(noun, fits)


def hdf5_file(noun: str, form: str) -> FileKind:
    """HDF5 files with this attribute `format`."""

    def fits(path: Path) -> bool:
        from subsea.base.hdf5 import format_of  # slow to import

        return format_of(path) == form

    return FileKind(noun, fits)


def json_file(noun: str, *keys: str) -> FileKind:
    """JSON files: a table with at least one of these keys."""

    def fits(path: Path) -> bool:
        if path.stat().st_size > MAX_JSON:
            return False
        content = json.loads(path.read_bytes())
        return isinstance(content, dict) and not content.keys().isdisjoint(keys)

    return FileKind(noun, fits)


def csv_file(noun: str, *columns: str) -> FileKind:
    """CSV files with these first columns."""

    def fits(path: Path) -> bool:
        with path.open(encoding="utf-8-sig", newline="") as file:
            return next(csv.reader([file.readline(HEAD)]), [])[: len(columns)] == [*columns]

    return FileKind(noun, fits)


def toml_file(noun: str, *tables: str) -> FileKind:
    """TOML files with all of these tables."""

    def fits(path: Path) -> bool:
        import tomllib

        return tomllib.loads(read_text(path)).keys() >= set(tables)

    return FileKind(noun, fits)


def _is_mesh(path: Path) -> bool:
    with path.open("rb") as file:
        head = text_of(file.read(HEAD), path, foreign=True)
    whole = [line for _, line in [*logical_lines(head)][:-1] if line.strip()]
    known = (line.split()[0] in OBJ_WORDS or line.lstrip()[0] == "#" for line in whole)
    return any(map(VERTEX.match, whole)) or (bool(whole) and all(known))


FILM = signed("an MP4 film", b"ftyp", at=4)
SOUND = signed("a WAV file", b"WAVE", 8)
PICTURE = signed("a PNG picture", b"\x89PNG\r\n\x1a\n")
LIGHT = signed("an OpenEXR picture", b"\x76\x2f\x31\x01")
GLTF = signed("a glTF file (.glb)", b"glTF")
USD = signed("a USD stage (.usdc)", b"PXR-USDC")
MESH = FileKind("a Wavefront OBJ mesh", _is_mesh)


def check_result(path: Path, kind: FileKind, force: bool = False) -> None:
    """Raise a UserError unless `path` can be written and replaces only a file of this kind.

    An empty file may be replaced, and with `force` any file.
    """
    check_file(path)
    if force or not path.is_file() or path.stat().st_size == 0:
        return
    try:
        fits = kind.fits(path)
    except (UserError, OSError, ValueError, RecursionError):
        fits = False
    if not fits:
        raise UserError(
            f"exists and is not {kind.noun}; choose another name or give --force", file=path
        )


def check_results(paths: Iterable[Path], kind: FileKind, force: bool = False) -> None:
    """`check_result` of several files of one kind."""
    for path in paths:
        check_result(path, kind, force)
