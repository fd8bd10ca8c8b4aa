"""Numpy array types, by type of element.

Plain values and arrays as bytes that are data only: reading them executes nothing.

A checksum, the size of the head, the head and the arrays. The head is MessagePack: a name and the
value, with places of arrays.
"""

import zlib
from collections.abc import Sequence
from typing import Annotated, Any, get_args, get_origin

import msgspec
import numpy as np
from msgspec import msgpack
from numpy.typing import NDArray

from subsea.base.progress import count_noun

Array = NDArray[np.floating[Any]]
Ints = NDArray[np.integer[Any]]
Bools = NDArray[np.bool_]
Bytes = NDArray[np.uint8]


SUM_BYTES, SIZE_BYTES = 4, 4  # of the checksum, and of the size of the head after it
ALIGNED = 64  # bytes: alignment of the arrays, as kernels need it
ARRAY = 1  # code of an array in the head
KINDS = "biufc"  # of elements: numbers

Natural = Annotated[int, msgspec.Meta(ge=0)]


class _StoredArray(msgspec.Struct, array_like=True, forbid_unknown_fields=True):
    """An array in the head; `place` counts from the first array."""

    dtype: str
    shape: list[Natural]
    by_columns: bool
    place: Natural


def pack(name: str, value: object) -> bytearray:
    """Pack a value of plain values, named tuples, dataclasses and arrays of numbers.

    Raises a TypeError for anything else.
    """
    entries: dict[int, _StoredArray] = {}  # by identity, so that shared arrays stay shared
    arrays = bytearray()

    def place(one: object) -> msgpack.Ext:
        if not isinstance(one, np.ndarray) or one.dtype.kind not in KINDS:
            raise TypeError(f"{type(one).__name__}: expected an array of numbers")
        if id(one) not in entries:
            by_columns = one.flags.f_contiguous and not one.flags.c_contiguous
            entries[id(one)] = _StoredArray(one.dtype.str, list(one.shape), by_columns, len(arrays))
            arrays.extend(one.tobytes("F" if by_columns else "C"))
            arrays.extend(bytes(-len(arrays) % ALIGNED))
        return msgpack.Ext(ARRAY, msgpack.encode(entries[id(one)]))

    head = msgpack.encode((name, value), enc_hook=place)
    data = bytearray(SUM_BYTES) + len(head).to_bytes(SIZE_BYTES) + head
    data += bytes(-len(data) % ALIGNED)
    data += arrays
    data[:SUM_BYTES] = zlib.crc32(memoryview(data)[SUM_BYTES:]).to_bytes(SUM_BYTES)
    return data


def unpack(data: memoryview, name: str, kind: Any) -> Any:
    """Unpack a value of a type; arrays share the memory of `data`.

    Raises a ValueError or a MsgspecError if checksum, name, or the type of any part differs.
    """
    if zlib.crc32(data[SUM_BYTES:]) != int.from_bytes(data[:SUM_BYTES]):
        raise ValueError("damaged")
    start = SUM_BYTES + SIZE_BYTES
    end = start + int.from_bytes(data[SUM_BYTES:start])
    rest = data[end + -end % ALIGNED :]
    arrays: dict[bytes, Any] = {}

    def array(code: int, packed: memoryview) -> Any:
        entry = msgpack.decode(packed, type=_StoredArray)
        dtype = np.dtype(entry.dtype)
        if code != ARRAY or dtype.kind not in KINDS:
            raise ValueError("not an array of numbers")
        if bytes(packed) not in arrays:
            size = int(np.prod(entry.shape, dtype=object))
            flat = np.frombuffer(rest, dtype, size, entry.place) if size else np.zeros(0, dtype)
            arrays[bytes(packed)] = flat.reshape(
                entry.shape, order="F" if entry.by_columns else "C"
            )
        return arrays[bytes(packed)]

    found, value = msgpack.decode(
        data[start:end], type=tuple[str, kind], ext_hook=array, dec_hook=_checked
    )
    if found != name:
        raise ValueError(f"holds {found}")
    return value


def _checked(kind: Any, array: Any) -> Any:
    """An array whose elements are of the annotated type; a ValueError for others."""
    arguments = get_args(kind)  # of ndarray: shape and dtype
    if arguments and isinstance(array, np.ndarray):
        element = get_args(arguments[1])[0]
        if element is not Any and not np.issubdtype(array.dtype, get_origin(element) or element):
            raise ValueError(f"elements are {array.dtype}")
    return array


SUMMARY = ("mean", "p50", "p95", "p99", "max")


def summarize_ms(durations_s: Sequence[float] | NDArray[np.floating[Any]]) -> dict[str, float]:
    """Mean, percentiles and maximum in milliseconds of durations in seconds, keyed by SUMMARY.

    Percentiles are interpolated linearly.
    """
    ms = 1000.0 * np.asarray(durations_s, np.float64)
    p50, p95, p99 = np.percentile(ms, [50, 95, 99])
    return dict(zip(SUMMARY, map(float, (ms.mean(), p50, p95, p99, ms.max())), strict=True))


def describe_durations(durations_s: Sequence[float]) -> str:
    """Number of frames and statistics of their times, in one line."""
    figures = summarize_ms(durations_s)
    named = ", ".join(f"{name} {figures[name]:.1f}" for name in ("mean", "p50", "p95", "max"))
    return f"{count_noun(len(durations_s), 'frame', 'frames')}; frame time in ms: {named}"
