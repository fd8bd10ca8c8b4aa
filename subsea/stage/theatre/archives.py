"""Zip archives and XML of unknown origin: read in memory, never unpacked, limited in size."""

import struct
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import BinaryIO
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from subsea.base.errors import UserError, unreadable
from subsea.base.files import open_input

Fetch = Callable[[str, int], bytes | None]  # path, most bytes -> content

MAX_ARCHIVE = 2**30  # bytes
MAX_DIRECTORY = 2**20  # bytes of the directory, which `zipfile` reads first
MAX_XML = 2**20

_END = b"PK\x05\x06"  # signature of the record at the end of an archive
# NotImplementedError: zipfile does not know the compression.
_DAMAGED = (zipfile.BadZipFile, NotImplementedError, struct.error, ValueError)
_END_64 = b"PK\x06\x07"  # signature in archives of more than 4 GB or 65,535 files


@contextmanager
def open_archive(path: Path) -> Iterator[Fetch]:
    """Open a zip archive; yields a function that reads a file of it, None if it is absent.

    Paths ignore case and the kind of slash. Faults of the archive, here and later, are UserErrors.
    """
    with ExitStack() as stack:
        file = stack.enter_context(open_input(path))
        try:
            _check_length(file, path)
            archive = stack.enter_context(zipfile.ZipFile(file))
        except OSError as fault:
            raise unreadable(path, fault) from fault
        except _DAMAGED as fault:
            raise UserError(
                f"not a readable zip archive ({first_line(fault)})", file=path
            ) from fault
        known = {normalized(one.filename): one for one in archive.infolist()}

        def fetch(name: str, most: int) -> bytes | None:
            one = known.get(normalized(name))
            return None if one is None else _inflated(archive, one, most, f"{path}: {name[:80]!r}")

        yield fetch


def parse_xml(data: bytes, where: str) -> Element:
    """The root of a document, with names of elements and attributes in lower case.

    A document type, and with it any entity, is refused.
    """
    builder = TreeBuilder()
    parser = expat.ParserCreate()

    def start(tag: str, attributes: dict[str, str]) -> None:
        builder.start(tag.lower(), {key.lower(): value for key, value in attributes.items()})

    def refuse(*_: object) -> None:
        raise UserError("has a document type, expected plain XML", file=where)

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda tag: builder.end(tag.lower())
    parser.CharacterDataHandler = builder.data
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(data, True)
        return builder.close()
    except (expat.ExpatError, LookupError, ValueError) as fault:
        raise UserError(f"not readable XML ({first_line(fault)})", file=where) from fault


def normalized(name: str) -> str:
    """Normalize a path for comparison: lower case, forward slashes, no leading ./"""
    return name.strip().replace("\\", "/").removeprefix("./").lower()


def first_line(fault: BaseException) -> str:
    """The first line of an error."""
    return str(fault).partition("\n")[0][:200] or type(fault).__name__


def _check_length(file: BinaryIO, path: Path) -> None:
    """Refuse a file that is not an archive or would exhaust memory when opened."""
    length = file.seek(0, 2)
    file.seek(max(length - 2**16 - 42, 0))
    end = file.read()
    at = end.rfind(_END)
    if not 0 <= at <= len(end) - 22:
        raise UserError("not a zip archive", file=path)
    (directory,) = struct.unpack_from("<I", end, at + 12)
    crowded = directory > MAX_DIRECTORY or end[max(at - 20, 0) : at].startswith(_END_64)
    if length > MAX_ARCHIVE or crowded:
        raise UserError("too large an archive, or one of too many files", file=path)


def _inflated(archive: zipfile.ZipFile, one: zipfile.ZipInfo, most: int, where: str) -> bytes:
    if one.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) or one.flag_bits & 1:
        raise UserError("packed in an unusual way or encrypted, expected plain zip", file=where)
    try:
        with archive.open(one) as file:
            data = file.read(most + 1)  # the size in its header may be false
    except (*_DAMAGED, RuntimeError, EOFError, OSError, zlib.error) as fault:
        raise UserError(f"cannot be unpacked ({first_line(fault)})", file=where) from fault
    if len(data) > most:
        raise UserError(f"larger than {most / 2**20:.0f} MB, expected a smaller file", file=where)
    return data
