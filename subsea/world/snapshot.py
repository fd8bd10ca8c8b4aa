"""All that changes in a world, as bytes and back, and a checksum of it.

A snapshot is a JSON header (names, dtypes, shapes and offsets of the arrays, tick, seed and
checksum) and the arrays' bytes behind it. It may come from another computer: everything in it is
checked against the world that is to take it before a byte is copied, nothing is ever executed.
"""

import hashlib
from collections.abc import Iterator
from typing import Annotated, Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from subsea.behavior.table import BEHAVIORS
from subsea.core.errors import UserError
from subsea.repertoire import SEGMENTS
from subsea.scenario.directions import INFLUENCES
from subsea.state import BAIT, COURTSHIP, EAT, LANDED, NOBODY, PREDATOR, SUBMARINE, WALL
from subsea.world.world import MINDS, World

Arrays = dict[str, NDArray[Any]]

MAGIC = b"subsea snapshot 1\n"
MAX_HEADER = 1 << 16  # bytes
MAX_VALUE = 1e7  # of any number that is not infinite: far more than a centimetre or a second here

CONSTANT = {
    "fishes": {"species", "length", "scale", "rate", "identity", "snout", "girth", "oars"},
    "minds": set(MINDS),
    "sea": {
        "heights",
        "floor",
        "half_width",
        "radius",
        "pillars",
        "rocks",
        "climate",
        "tackle",
        "crest",
    },
    "seaweed": {
        "first",
        "rest",
        "lean",
        "look",
        "kind",
        "cell_cm",
        "cell_first",
        "cell_cluster",
    },
}
"""What no tick changes, by the parts of `state.State`; everything else it may."""

INFINITE = {"fishes.stay", "minds.leader_seen", "minds.food_distance", "minds.mate_distance"}
"""What may be infinite: never, or nowhere."""


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
    """Every array that a tick may change, by a name such as ``fishes.position``: no copies."""
    return {name: array for name, array, constant in _arrays(world) if not constant}


def constant(world: World) -> Arrays:
    """Every array of a world's state that stays as it was created, numbers as arrays of one."""
    return {name: array for name, array, constant in _arrays(world) if constant}


def checksum_of(arrays: Arrays, *more: object) -> str:
    """BLAKE2b over names, dtypes, shapes and bytes of arrays, and what else is given, as text."""
    blake = hashlib.blake2b(repr(more).encode(), digest_size=16)
    for name, array in arrays.items():
        blake.update(f"{name} {array.dtype.str} {array.shape}".encode())
        blake.update(np.ascontiguousarray(array).data)
    return blake.hexdigest()


def checksum(world: World) -> str:
    """Of everything that changes: equal checksums are equal worlds."""
    return checksum_of(changing(world), world.state.tick, world.state.seed, _seen_light(world))


def take(world: World) -> bytes:
    """Everything that changes in the world, as it is now."""
    arrays = changing(world)
    tick, seed = world.state.tick, world.state.seed
    header = _Header(tick, seed, _seen_light(world), checksum(world), _entries(arrays))
    text = msgspec.json.encode(header)
    parts = [MAGIC, len(text).to_bytes(4, "little"), text]
    return b"".join(parts + [np.ascontiguousarray(array).tobytes() for array in arrays.values()])


def size_limit(world: World) -> int:
    """Bytes that no snapshot of this world exceeds."""
    return MAX_HEADER + 64 + sum(array.nbytes for array in changing(world).values())


def restore(world: World, data: bytes) -> None:
    """Put a world of the same scenario and seed into the state that `take` saw.

    Whatever does not fit it to the byte is a UserError, and the world stays as it is.
    """
    header, content = _read(data)
    arrays, state = changing(world), world.state
    if header.seed != state.seed:
        raise _fault(f"of seed {header.seed}, expected {state.seed}")
    expected = _entries(arrays)
    for theirs, ours in zip(header.arrays, expected, strict=False):
        if theirs != ours:
            raise _fault(f"{_words(theirs)} where {_words(ours)} was expected")
    if len(header.arrays) != len(expected):
        raise _fault(f"{len(header.arrays)} arrays, expected {len(expected)}")
    length = sum(array.nbytes for array in arrays.values())
    if len(content) != length:
        raise _fault(f"{len(content)} bytes of arrays, expected {length}")
    given = {
        name: np.frombuffer(content, array.dtype, array.size, entry.offset).reshape(array.shape)
        for (name, array), entry in zip(arrays.items(), expected, strict=True)
    }
    if checksum_of(given, header.tick, header.seed, header.seen_light) != header.checksum:
        raise _fault("the checksum is not that of its arrays")
    _refuse_impossible(world, given)
    if not all(0 <= fish < len(state.fishes.species) for fish in header.seen_light):
        raise _fault("the light that is seen by a fish that is none")
    for name, array in arrays.items():
        array[...] = given[name]
    state.tick = header.tick
    world.seen_light.clear()
    world.seen_light.update(header.seen_light)


def check(world: World) -> None:
    """A UserError that names a number in the world which no tick writes."""
    arrays = changing(world)
    for name, array in arrays.items():
        if array.dtype.kind == "f" and np.isnan(array).any():
            raise UserError(f"{name} holds what is no number")
    _refuse_impossible(world, arrays)


def _seen_light(world: World) -> dict[int, float]:
    return {int(fish): float(light) for fish, light in sorted(world.seen_light.items())}


def _arrays(world: World) -> Iterator[tuple[str, NDArray[Any], bool]]:
    """Name and array of everything in the state, and whether it stays as it was created."""
    state = world.state
    parts: dict[str, dict[str, Any]] = {
        part: getattr(state, part)._asdict()
        for part in ("fishes", "minds", "sea", "seaweed", "live", "reef", "directions")
    }
    parts["submarine"] = vars(state.submarine)
    for part, members in parts.items():
        for name, value in members.items():
            stays = part == "reef" or name in CONSTANT.get(part, ())
            yield f"{part}.{name}", np.asarray(value), stays


def _entries(arrays: Arrays) -> list[_Entry]:
    """What the header says of arrays that follow one another."""
    entries, offset = [], 0
    for name, array in arrays.items():
        entries.append(_Entry(name, array.dtype.str, list(array.shape), offset))
        offset += array.nbytes
    return entries


def _read(data: bytes) -> tuple[_Header, memoryview]:
    """Header and the arrays' bytes."""
    begin = len(MAGIC) + 4
    if data[: len(MAGIC)] != MAGIC or len(data) < begin:
        raise _fault("it does not begin as one")
    length = int.from_bytes(data[len(MAGIC) : begin], "little")
    if length > MAX_HEADER or begin + length > len(data):
        raise _fault(f"a header of {length} bytes does not fit")
    try:
        header = msgspec.json.decode(data[begin : begin + length], type=_Header)
    except (msgspec.DecodeError, UnicodeDecodeError) as fault:
        raise _fault(f"its header: {fault}") from fault
    return header, memoryview(data)[begin + length :]


def _refuse_impossible(world: World, given: Arrays) -> None:
    """A UserError for values that no tick writes: compiled code does not check its indices."""
    ranges = _ranges(world, given)
    for name, array in given.items():
        if array.dtype.kind == "f":
            amount = np.abs(array)
            wrong = ~(amount <= MAX_VALUE)
            if name in INFINITE:
                wrong &= ~np.isinf(amount)
        elif array.dtype.kind == "b":
            wrong = array.view(np.uint8) > 1
        else:
            low, high = ranges[name]
            wrong = (array < low) | (array >= high)
        if wrong.any():
            where = [int(k) for k in np.argwhere(wrong)[0]]
            raise _fault(f"{name}{where} is {array[tuple(where)]}, which no tick writes")
    recorded = len(world.library.entry)
    live, a, b = given["fishes.live"], given["fishes.row_a"], given["fishes.row_b"]
    slots = given["live.fish"]
    simulated = slots[(slots >= 0) & live[slots]] if len(live) else slots[:0]
    if (b[~live] >= recorded).any() or (np.minimum(a, b)[simulated] < recorded).any():
        raise _fault("a fish's pose is not among the rows of its motor")


def _ranges(world: World, given: Arrays) -> dict[str, tuple[int, Any]]:
    """Lowest value of every array of whole numbers, and what lies above its highest."""
    n, segments, behaviors = len(world.state.fishes.species), len(SEGMENTS), len(BEHAVIORS)
    sea, specks = world.state.sea, len(world.state.sea.plankton)
    rows, long = (0, len(world.library.rotation)), 2**31 - 1
    # What eaters of plankton are after is a speck, all else is about fishes.
    grazes = world.state.minds.kind != PREDATOR
    food = np.where(grazes, specks, n)
    target = np.where(grazes & (given["minds.intention"] == EAT), specks, n)
    remembered = np.where(grazes & (given["minds.memory"] == EAT), specks, n)
    remembered[given["minds.memory"] < 0] = max(n, specks)  # nobody reads what is left there
    fish = dict.fromkeys(
        ("neighbour", "threat", "mate", "mates", "leader", "partner", "shunned", "betrothed"),
        (NOBODY, n),
    )
    minds = fish | {
        "predator": (SUBMARINE, n), "predators": (SUBMARINE, n),
        "barrier": (WALL, len(sea.pillars) + len(sea.rocks)),
        "food": (-1, food), "foods": (-1, food[:, None]), "target": (BAIT, target),
        "memory": (-1, behaviors), "memory_target": (BAIT, remembered),
        "intention": (0, behaviors), "courtship": (0, len(COURTSHIP)),
        "fancy": (-1, 16), "quarry": (-1, long + 1),
    }  # fmt: skip
    fishes = {
        "row_a": rows, "row_b": rows, "previous_row_a": rows, "previous_row_b": rows,
        "segment": (0, segments), "wanted_segment": (0, segments), "recommended": (-1, segments),
    }  # fmt: skip
    return {
        **{f"minds.{name}": ends for name, ends in minds.items()},
        **{f"fishes.{name}": ends for name, ends in fishes.items()},
        "sea.catch": (NOBODY, np.array([LANDED + 1, n])),
        "live.fish": (-1, n),
        "directions.began": (-1, 2**48 + 1),
        "directions.times": (0, long + 1),
        "directions.ceded": (0, 1 << len(INFLUENCES)),
        "directions.stage": (0, long),
        "directions.cast": (SUBMARINE, n),
        "directions.courtship": (0, len(COURTSHIP)),
        "live.waiting": (0, long),
    }


def _words(entry: _Entry) -> str:
    return f"{entry.name} {entry.dtype} {entry.shape} at {entry.offset}"


def _fault(what: str) -> UserError:
    return UserError(f"not a snapshot of this dive: {what}")
