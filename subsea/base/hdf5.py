"""Read HDF5 files with checks and write them atomically; no other module opens them."""

import math
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import h5py
import numpy as np
from numpy.typing import NDArray

from subsea.base.errors import UserError
from subsea.base.files import open_input, refuse_locked, replacing

MAX_DATASET_BYTES = 256 * 2**20  # a repertoire has a few megabytes; more is a damaged header
MAX_ATTRIBUTE_BYTES = 2**20
MAX_INFLATION = 1032  # times the size of deflated data
SHUFFLE, DEFLATE = h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_DEFLATE
PACKINGS = ((), (DEFLATE,), (SHUFFLE, DEFLATE))  # of the library's many filters
Kind = Literal["f", "i", "u", "b"]
KINDS = {"f": "floating-point", "i": "whole", "u": "unsigned whole", "b": "true or false"}
NOUNS = {str: "a text", int: "a whole number", float: "a number", bool: "true or false"}
NO_VARIABLE = "This is a netCDF dimension but not a netCDF variable."
LAYOUT = {"libver": ("earliest", "v110"), "track_order": False}  # without timestamps


@contextmanager
def reading(path: Path) -> Iterator[Any]:
    """Open `path` for reading; any fault of the file is one line that names it."""
    try:
        # A file of Python takes none of HDF5's locks, which some file systems do not have.
        with open_input(path) as raw:
            refuse_locked(raw, path)
            with h5py.File(raw, "r") as file:
                yield file
    except (OSError, KeyError, RuntimeError, ValueError, TypeError, zlib.error) as fault:
        reason = str(fault).splitlines()[0] if str(fault) else type(fault).__name__
        raise UserError(f"not a readable HDF5 file ({reason})", file=path) from fault


def format_of(path: Path) -> str:
    """The attribute `format` of a file; a UserError for a file without one."""
    with reading(path) as file:
        return str(attribute(file, "format", str, str(path)))


@contextmanager
def writing(path: Path) -> Iterator[Any]:
    """Write a small file `path` atomically; the same input gives the same bytes.

    The file is composed in memory, so a disk that fills up causes an error of one plain write,
    outside the HDF5 library.
    """
    with replacing(path) as temporary:
        with h5py.File(temporary, "w", driver="core", backing_store=False, **LAYOUT) as file:
            yield file
            file.flush()
            image = file.id.get_file_image()
        temporary.write_bytes(image)


@contextmanager
def recording(
    path: Path,
    attributes: Mapping[str, Any],
    constants: Mapping[str, NDArray[Any]],
    notes: Mapping[str, Mapping[str, Any]] | None = None,
    dimensions: Mapping[str, Sequence[str]] | None = None,
    late: Mapping[str, Any] | None = None,
) -> Iterator[Callable[[Mapping[str, NDArray[Any]]], None]]:
    """Write a file whose datasets grow along their first axis.

    Yields `append`, which accepts a block of rows for every dataset. `constants` do not grow; those
    of type object are words. `notes` are the attributes of each dataset, by its name; `dimensions`
    are the paths of its dimension scales, as netCDF has them. `late` are more attributes of the
    file, which the caller fills until the end. Ctrl-C saves the blocks so far as a complete file
    and continues as KeyboardInterrupt. With no rows, or on any other fault, no file is left.
    """
    notes = notes or {}
    interrupted: KeyboardInterrupt | None = None
    with (
        replacing(path) as temporary,
        temporary.open("w+b", buffering=0) as raw,
        _forgiving(raw) as disk,
        h5py.File(disk, "w", **LAYOUT) as file,
    ):
        growing: dict[str, Any] = {}
        rows: dict[str, int] = {}

        def append(block: Mapping[str, NDArray[Any]]) -> None:
            for name, values in block.items():
                if name not in growing:
                    growing[name] = file.create_dataset(
                        name,
                        shape=(0, *values.shape[1:]),
                        maxshape=(None, *values.shape[1:]),
                        chunks=(max(len(values), 1), *values.shape[1:]),
                        dtype=values.dtype,
                        compression="gzip",
                        compression_opts=1,
                        shuffle=True,
                    )
                    growing[name].attrs.update(notes.get(name, {}))
                begin = rows.get(name, 0)
                growing[name].resize(begin + len(values), axis=0)
                growing[name][begin:] = values
            rows.update({name: rows.get(name, 0) + len(values) for name, values in block.items()})
            disk.check()

        file.attrs.update(attributes)
        for name, values in constants.items():
            file.create_dataset(
                name,
                data=values,
                dtype=h5py.string_dtype() if values.dtype == object else values.dtype,
            )
            file[name].attrs.update(notes.get(name, {}))
        try:
            yield append
        except KeyboardInterrupt as interrupt:
            if not any(rows.values()):
                raise
            interrupted = interrupt
        for name, dataset in growing.items():
            dataset.resize(rows.get(name, 0), axis=0)  # an interruption may have cut a block short
        _attach_scales(file, dimensions or {})
        file.attrs.update(late or {})
    if interrupted:
        raise interrupted


def _attach_scales(file: Any, dimensions: Mapping[str, Sequence[str]]) -> None:
    """Name the dimensions of datasets by the datasets at these paths.

    A missing one becomes a dimension without values, as in a netCDF file.
    """
    for name, scales in dimensions.items():
        for k, path in enumerate(scales):
            length = file[name].shape[k]
            label = path.rpartition("/")[2]
            if path not in file:
                file.create_dataset(path, shape=(length,), dtype=">f4")
                label = f"{NO_VARIABLE}{length:10d}"
            if not file[path].is_scale:
                file[path].make_scale(label)
            if path != name:
                file[name].dims[k].attach_scale(file[path])


class _Disk:
    """A file that accepts everything that the HDF5 library writes, and stores its first fault.

    The library cannot handle a full disk: it retries from destructors and finally crashes the
    process. It also reads again what it wrote, so that parts that the disk refused stay in memory.
    """

    def __init__(self, raw: Any) -> None:
        self.fault: OSError | None = None
        self.raw = raw
        self.refused: list[tuple[int, bytes]] = []  # places in the file, and what belongs there

    def check(self) -> None:
        """Raise the first fault."""
        if self.fault:
            raise self.fault

    def write(self, data: memoryview) -> int:
        """Write all data; after a fault, keep it in memory."""
        left = memoryview(data).cast("B")
        try:
            while len(left) and not self.fault:
                left = left[self.raw.write(left) :]
        except OSError as fault:
            self.fault = fault
        if len(left):
            self.refused.append((self.raw.tell(), bytes(left)))
        return len(data)

    def readinto(self, buffer: memoryview) -> int:
        """Read into a buffer as if the disk had accepted all data."""
        begin = self.raw.tell()
        size: int = self.raw.readinto(buffer)
        whole = memoryview(buffer).cast("B")
        whole[size:] = bytes(len(whole) - size)
        for place, data in self.refused:
            low, high = max(place, begin), min(place + len(data), begin + len(whole))
            if low < high:
                whole[low - begin : high - begin] = data[low - place : high - place]
            size = max(size, high - begin)
        return size

    def truncate(self, size: int) -> int:
        """Set the length of the file."""
        try:
            return int(self.raw.truncate(size))
        except OSError as fault:
            self.fault = self.fault or fault
            return size

    def __getattr__(self, name: str) -> Any:
        """Pass everything that a full disk cannot affect to the file."""
        return getattr(self.raw, name)


@contextmanager
def _forgiving(raw: Any) -> Iterator[_Disk]:
    """Yield a file for the HDF5 library; raise its first fault at the end."""
    disk = _Disk(raw)
    try:
        yield disk
    except Exception:
        disk.check()  # the library's own error is not the cause
        raise
    disk.check()


def text(value: str) -> NDArray[Any]:
    """A string as `attribute` reads it: UTF-8 of fixed length."""
    return words([value]).reshape(())


def words(values: Sequence[str]) -> NDArray[Any]:
    """A row of strings as `texts` reads it: UTF-8 of fixed length."""
    row = [value.encode("utf-8") for value in values]
    return np.array(row, h5py.string_dtype("utf-8", max(map(len, row), default=0) or 1))


def has_attribute(group: Any, name: str) -> bool:
    """True if `group` has an attribute of that name."""
    return name in group.attrs


def attribute(group: Any, name: str, kind: type, where: str) -> Any:
    """The attribute `name` of a group as a plain Python value of the given `kind`.

    Strings must be of fixed length. Variable-length strings are in a heap of the file, and the HDF5
    library searches a damaged heap forever.
    """
    if name not in group.attrs:
        raise UserError(f"attribute {name!r} is missing, expected {NOUNS[kind]}", file=where)
    stored = group.attrs.get_id(name)
    plain = stored.dtype.kind in "Sbiuf" and stored.shape == ()
    if not plain or stored.dtype.itemsize > MAX_ATTRIBUTE_BYTES:
        raise UserError(f"attribute {name!r} is not {NOUNS[kind]}", file=where)
    value: Any = group.attrs[name]
    if isinstance(value, bytes):
        value = value.decode("utf-8", "replace")
    if isinstance(value, np.generic):
        value = value.item()
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if not isinstance(value, kind):
        raise UserError(f"attribute {name!r} is {value!r}, expected {NOUNS[kind]}", file=where)
    if isinstance(value, float) and not math.isfinite(value):
        raise UserError(f"attribute {name!r} is {value!r}, expected a finite number", file=where)
    return value


def texts(group: Any, name: str, where: str) -> list[str]:
    """The attribute `name` of a group: a row of strings of fixed length."""
    if name not in group.attrs:
        raise UserError(f"attribute {name!r} is missing, expected a row of words", file=where)
    stored = group.attrs.get_id(name)
    rows = stored.dtype.kind == "S" and len(stored.shape) == 1
    if not rows or math.prod(stored.shape) * stored.dtype.itemsize > MAX_ATTRIBUTE_BYTES:
        raise UserError(f"attribute {name!r} is not a row of words", file=where)
    return [word.decode("utf-8", "replace") for word in group.attrs[name]]


def array(
    group: Any,
    name: str,
    shape: tuple[int | None, ...],
    where: str,
    kind: Kind = "f",
    least: int = 1,
    most_bytes: int = MAX_DATASET_BYTES,
) -> NDArray[Any]:
    """Check and read the dataset `name` of finite numbers of the given kind.

    `shape` gives each length, None for any length of at least `least`. Refuses links that lead out
    of the file or the group, other types or shapes, and implausible sizes.
    """
    place = f"{where}/{name}"
    if not isinstance(group.get(name, getlink=True), h5py.HardLink):
        raise UserError("missing, expected a dataset", file=place)
    dataset = group[name]
    if isinstance(dataset, h5py.Dataset) and (dataset.is_virtual or dataset.external):
        raise UserError("its numbers are in other files, expected them in this", file=place)
    expected = "×".join("n" if n is None else str(n) for n in shape)
    if not isinstance(dataset, h5py.Dataset) or dataset.dtype.kind != kind:
        raise UserError(f"expected {expected} {KINDS[kind]} numbers", file=place)
    fits = len(dataset.shape) == len(shape) and all(
        have == want if want is not None else have >= least
        for have, want in zip(dataset.shape, shape, strict=True)
    )
    if not fits:
        found = "×".join(map(str, dataset.shape))
        raise UserError(f"shape {found}, expected {expected}", file=place)
    if dataset.size * dataset.dtype.itemsize > most_bytes:
        raise UserError(f"claims an implausible {dataset.size} numbers", file=place)
    if not _unpacks_within(dataset, most_bytes):
        raise UserError("packed in an unusual way, expected plain gzip at most", file=place)
    values = np.asarray(dataset[()])
    if not np.isfinite(values).all():
        raise UserError("contains numbers that are not finite", file=place)
    return values


def _unpacks_within(dataset: Any, most_bytes: int) -> bool:
    """True if the chunks of a dataset unpack without more memory than they claim.

    The library inflates chunks to any size, and allocates whole chunks even if a dataset fills only
    a corner of them.
    """
    if dataset.chunks is None:
        return True
    claimed = math.prod(dataset.chunks) * dataset.dtype.itemsize
    made = dataset.id.get_create_plist()
    packing = tuple(made.get_filter(k)[0] for k in range(made.get_nfilters()))
    if claimed > most_bytes or packing not in PACKINGS:
        return False
    if not packing or dataset.id.get_storage_size() * MAX_INFLATION <= most_bytes:
        return True
    large: list[Any] = []
    skips = 1 << packing.index(DEFLATE)  # chunks that it would enlarge are stored without it
    dataset.id.chunk_iter(
        lambda piece: (
            large.append(piece.chunk_offset)
            if piece.size * MAX_INFLATION > most_bytes and not piece.filter_mask & skips
            else None
        )
    )
    for place in large:
        inflating = zlib.decompressobj()
        inflating.decompress(dataset.id.read_direct_chunk(place)[1], claimed)
        if inflating.unconsumed_tail:
            return False
    return True


def has_member(group: Any, name: str) -> bool:
    """True if `group` has a member of that name; unlike ``in``, this follows no link."""
    return group.get(name, getlink=True) is not None


def subgroup(group: Any, name: str, where: str) -> Any:
    """The group `name` inside `group`; links are refused."""
    if not isinstance(group.get(name, getlink=True), h5py.HardLink) or not isinstance(
        group[name], h5py.Group
    ):
        raise UserError("missing, expected a group", file=f"{where}/{name}")
    return group[name]
