"""Save and restore everything that changes in a world, and compute its checksum.

A snapshot is a JSON header (names, dtypes, shapes and offsets of the arrays, tick, seed and
checksum) followed by the bytes of the arrays. It may come from another computer: all of it is
checked against the world before a byte is copied, and nothing is executed.
"""

import hashlib
from typing import Annotated, Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from subsea.base.errors import UserError
from subsea.repertoire import SEGMENTS
from subsea.scenario.directions import INFLUENCES
from subsea.state import EAT, GROUPS, LANDED, PREDATOR, Spec, declared
from subsea.state import arrays as arrays_of
from subsea.world.world import World

Arrays = dict[str, NDArray[Any]]

MAGIC = b"subsea snapshot 1\n"
MAX_HEADER = 1 << 16  # bytes
MAX_VALUE = 1e7  # of finite numbers: far beyond any valid length or time

SPECS: dict[str, Spec] = {
    f"{part}.{name}": spec
    for part, group in GROUPS.items()
    for name, spec in declared(group).items()
}


class _Entry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    name: Annotated[str, msgspec.Meta(max_length=64)]
    dtype: Annotated[str, msgspec.Meta(max_length=8)]
    shape: Annotated[list[int], msgspec.Meta(max_length=8)]
    offset: int


class _Header(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    tick: Annotated[int, msgspec.Meta(ge=0, le=2**48)]
    seed: Annotated[int, msgspec.Meta(ge=0, le=2**48)]
    seen_light: dict[int, Annotated[float, msgspec.Meta(ge=0, le=1)]]  # see `World`
    checksum: Annotated[str, msgspec.Meta(max_length=64)]
    arrays: Annotated[list[_Entry], msgspec.Meta(max_length=500)]


def changing(world: World) -> Arrays:
    """Return the arrays that a tick may change, not copied, by names like ``fishes.position``."""
    return {name: array for name, array, spec in arrays_of(world.state) if spec.saved}


def constant(world: World) -> Arrays:
    """Return the arrays that no tick changes; numbers are arrays without a dimension."""
    return {name: array for name, array, spec in arrays_of(world.state) if not spec.saved}


def may_be_infinite(name: str) -> bool:
    """True if an array may hold infinity, for never or nowhere."""
    return SPECS[name].may_be_infinite


def checksum_of(arrays: Arrays, *more: object) -> str:
    """Hash names, dtypes, shapes and bytes of arrays, and the text of `more`, with BLAKE2b."""
    blake = hashlib.blake2b(repr(more).encode(), digest_size=16)
    for name, array in arrays.items():
        blake.update(f"{name} {array.dtype.str} {array.shape}".encode())
        blake.update(np.ascontiguousarray(array).data)
    return blake.hexdigest()


def checksum(world: World) -> str:
    """Compute the checksum of all that changes: equal checksums mean equal worlds."""
    return checksum_of(changing(world), world.state.tick, world.state.seed, _seen_light(world))


def take(world: World) -> bytes:
    """Make a snapshot of a world."""
    arrays = changing(world)
    tick, seed = world.state.tick, world.state.seed
    header = _Header(tick, seed, _seen_light(world), checksum(world), _entries(arrays))
    text = msgspec.json.encode(header)
    parts = [MAGIC, len(text).to_bytes(4, "little"), text]
    return b"".join(parts + [np.ascontiguousarray(array).tobytes() for array in arrays.values()])


def size_limit(world: World) -> int:
    """Compute the largest size of a snapshot of this world, bytes."""
    return MAX_HEADER + 64 + sum(array.nbytes for array in changing(world).values())


def restore(world: World, data: bytes) -> None:
    """Restore the state of a snapshot in a world of the same scenario and seed.

    Raises a UserError and leaves the world unchanged if the snapshot does not fit exactly.
    """
    header, content = _read(data)
    arrays, state = changing(world), world.state
    if header.seed != state.seed:
        raise _error(f"seed {header.seed}, expected {state.seed}")
    expected = _entries(arrays)
    for theirs, ours in zip(header.arrays, expected, strict=False):
        if theirs != ours:
            raise _error(f"{_describe(theirs)} where {_describe(ours)} was expected")
    if len(header.arrays) != len(expected):
        raise _error(f"{len(header.arrays)} arrays, expected {len(expected)}")
    length = sum(array.nbytes for array in arrays.values())
    if len(content) != length:
        raise _error(f"{len(content)} bytes of arrays, expected {length}")
    given = {
        name: np.frombuffer(content, array.dtype, array.size, entry.offset).reshape(array.shape)
        for (name, array), entry in zip(arrays.items(), expected, strict=True)
    }
    if checksum_of(given, header.tick, header.seed, header.seen_light) != header.checksum:
        raise _error("the checksum is not that of its arrays")
    _check_values(world, given)
    if not all(0 <= fish < len(state.fishes.species) for fish in header.seen_light):
        raise _error("`seen_light` names a fish that does not exist")
    for name, array in arrays.items():
        array[...] = given[name]
    state.tick = header.tick
    world.seen_light.clear()
    world.seen_light.update(header.seen_light)


def check(world: World) -> None:
    """Raise a UserError that names an invalid number in the world."""
    arrays = changing(world)
    for name, array in arrays.items():
        if array.dtype.kind == "f" and np.isnan(array).any():
            raise UserError(f"{name} contains NaN")
    _check_values(world, arrays)


def _seen_light(world: World) -> dict[int, float]:
    return {int(fish): float(light) for fish, light in sorted(world.seen_light.items())}


def _entries(arrays: Arrays) -> list[_Entry]:
    """Make the header entries of consecutive arrays."""
    entries, offset = [], 0
    for name, array in arrays.items():
        entries.append(_Entry(name, array.dtype.str, list(array.shape), offset))
        offset += array.nbytes
    return entries


def _read(data: bytes) -> tuple[_Header, memoryview]:
    """Split a snapshot into header and bytes of the arrays."""
    begin = len(MAGIC) + 4
    if data[: len(MAGIC)] != MAGIC or len(data) < begin:
        raise _error("it does not begin as one")
    length = int.from_bytes(data[len(MAGIC) : begin], "little")
    if length > MAX_HEADER or begin + length > len(data):
        raise _error(f"a header of {length} bytes does not fit")
    try:
        header = msgspec.json.decode(data[begin : begin + length], type=_Header)
    except (msgspec.DecodeError, UnicodeDecodeError) as fault:
        raise _error(f"its header: {fault}") from fault
    return header, memoryview(data)[begin + length :]


def _check_values(world: World, given: Arrays) -> None:
    """Raise a UserError for invalid values: compiled code does not check its indices."""
    limits = _limits(world, given)
    for name, array in given.items():
        if array.dtype.kind == "f":
            amount = np.abs(array)
            wrong = ~(amount <= MAX_VALUE)
            if may_be_infinite(name):
                wrong &= ~np.isinf(amount)
        elif array.dtype.kind == "b":
            wrong = array.view(np.uint8) > 1
        else:
            within = SPECS[name].within
            assert within is not None
            low, high = within[0], limits.get(within[1], within[1])
            high = np.reshape(high, (-1, *[1] * (array.ndim - 1)))
            wrong = (array < low) | (array >= high)
        if wrong.any():
            where = [int(k) for k in np.argwhere(wrong)[0]]
            raise _error(f"{name}{where} is {array[tuple(where)]}, which no tick writes")
    recorded = len(world.library.entry)
    live, a, b = given["fishes.live"], given["fishes.row_a"], given["fishes.row_b"]
    slots = given["live.fish"]
    simulated = slots[(slots >= 0) & live[slots]] if len(live) else slots[:0]
    if (b[~live] >= recorded).any() or (np.minimum(a, b)[simulated] < recorded).any():
        raise _error("a fish's pose is not among the rows of its motor")


def _limits(world: World, given: Arrays) -> dict[int | str, Any]:
    """Return the limits that declarations name, for all fishes or each; integers lie below."""
    sea, n = world.state.sea, len(world.state.fishes.species)
    specks = len(sea.plankton)
    # Targets of plankton eaters are specks, all others are fishes.
    grazes = world.state.minds.kind != PREDATOR
    remembered = np.where(grazes & (given["minds.memory"] == EAT), specks, n)
    remembered[given["minds.memory"] < 0] = max(n, specks)  # never read
    return {
        "n": n,
        "b": len(world.table.behaviors),
        "rows": len(world.library.rotation),
        "segments": len(SEGMENTS),
        "solids": len(sea.pillars) + len(sea.rocks),
        "sites": len(sea.site_kind),
        "influences": 1 << len(INFLUENCES),
        "food": np.where(grazes, specks, n),
        "target": np.where(grazes & (given["minds.intention"] == EAT), specks, n),
        "remembered": remembered,
        "catch": (LANDED + 1, n),
    }


def _describe(entry: _Entry) -> str:
    return f"{entry.name} {entry.dtype} {entry.shape} at {entry.offset}"


def _error(what: str) -> UserError:
    return UserError(f"not a snapshot of this dive: {what}")
