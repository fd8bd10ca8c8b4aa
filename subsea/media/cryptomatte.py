"""Cryptomatte: which things share a pixel, and how much of it each covers (Friedman and Jones).

Each pixel holds pairs of an id and a coverage, the largest first. An id is a hash of a name, and a
manifest in the header lists the names. Programs for compositing read mattes from this, with soft
edges. Specification 1.2.0 of Psyop: https://github.com/Psyop/Cryptomatte
"""

import json
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Ints

RANKS = 6  # pairs of a pixel: in three layers of two
NOTHING = -1  # in place of a thing


class Matte(NamedTuple):
    """A set of things, and which of them each value of an identity map belongs to."""

    layer: str  # the name of its channels
    names: tuple[str, ...]  # of things, each once
    thing: Ints  # (values,) index into `names`, or NOTHING

    @property
    def ids(self) -> NDArray[np.float32]:
        """The ids (n,) of the things."""
        return np.array([id_of(name) for name in self.names], np.float32)

    def channels(self, samples: NDArray[np.uint16]) -> dict[str, Array]:
        """The channels (h, w) by name of identities (s, h, w) at several places of each pixel."""
        number, share = ranked(self.thing, samples)
        known = number != NOTHING
        ids = np.where(known, np.append(self.ids, np.float32(0.0))[number], np.float32(0.0))
        out = {}
        for rank in range(RANKS):
            name = f"{self.layer}{rank // 2:02d}"
            first, second = ("R", "G") if rank % 2 == 0 else ("B", "A")
            out[f"{name}.{first}"], out[f"{name}.{second}"] = ids[rank], share[rank]
        return out

    def header(self) -> dict[str, str]:
        """The attributes of the header."""
        key = f"cryptomatte/{murmur3(self.layer.encode()):08x}"[: len("cryptomatte/") + 7]
        manifest = {name: f"{hashed(name):08x}" for name in self.names}
        return {
            f"{key}/name": self.layer,
            f"{key}/hash": "MurmurHash3_32",
            f"{key}/conversion": "uint32_to_float32",
            f"{key}/manifest": json.dumps(manifest, separators=(",", ":")),
        }


def matte(layer: str, names: Mapping[int, str], values: int) -> Matte:
    """Make the matte of things from `names` of values of an identity map, all below `values`.

    Values of one name are one thing.
    """
    known = tuple(dict.fromkeys(names.values()))
    number = {name: k for k, name in enumerate(known)}
    thing = np.full(values, NOTHING, np.int32)
    for value, name in names.items():
        thing[value] = number[name]
    return Matte(layer, known, thing)


def ranked(thing: Ints, samples: NDArray[np.uint16]) -> tuple[Ints, Array]:
    """Rank the things of each pixel by the share of its samples (s, h, w) that show them.

    Returns numbers of things (RANKS, h, w), or NOTHING, and shares (RANKS, h, w) float32.
    """
    count, height, width = samples.shape
    number = np.full((RANKS, height, width), NOTHING, np.int32)
    share = np.zeros((RANKS, height, width), np.float32)
    number[0] = thing[samples[0]]
    share[0] = number[0] != NOTHING
    row, column = np.nonzero((samples != samples[0]).any(axis=0))  # few pixels show two things
    if not len(row):
        return number, share
    shown = np.sort(thing[samples[:, row, column]], axis=0)
    begins = np.concatenate([np.ones((1, len(row)), np.bool_), shown[1:] != shown[:-1]])
    # Samples until the next thing begins, counted from behind.
    place = np.where(begins, np.arange(count)[:, None], count)
    after = np.minimum.accumulate(place[::-1], axis=0)[::-1]
    after = np.concatenate([after[1:], np.full((1, len(row)), count)])
    covers = np.where(begins & (shown != NOTHING), after - np.arange(count)[:, None], 0)
    order = np.argsort(-covers, axis=0, kind="stable")[:RANKS]
    found = np.take_along_axis(covers, order, axis=0)
    things = np.where(found > 0, np.take_along_axis(shown, order, axis=0), NOTHING)
    number[:, row, column], share[:, row, column] = NOTHING, 0.0
    number[: len(order), row, column] = things
    share[: len(order), row, column] = found / count
    return number, share


def id_of(name: str) -> np.float32:
    """The id of a name: its hash as a float, whose bits are those of `hashed`."""
    return np.uint32(hashed(name)).view(np.float32)


def hashed(name: str) -> int:
    """Hash a name, so that its bits are those of a normal float."""
    bits = murmur3(name.encode())
    exponent = bits >> 23 & 255
    return bits ^ 1 << 23 if exponent in (0, 255) else bits


def murmur3(data: bytes, seed: int = 0) -> int:
    """Hash bytes to 32 bits (Appleby's MurmurHash3_x86_32, in the public domain)."""
    whole = 2**32 - 1
    bits = seed

    def mixed(block: int) -> int:
        block = block * 0xCC9E2D51 & whole
        return (block << 15 | block >> 17) * 0x1B873593 & whole

    even = len(data) // 4 * 4
    for at in range(0, even, 4):
        bits ^= mixed(int.from_bytes(data[at : at + 4], "little"))
        bits = (bits << 13 | bits >> 19) & whole
        bits = (5 * bits + 0xE6546B64) & whole
    bits ^= mixed(int.from_bytes(data[even:], "little")) ^ len(data)
    bits = (bits ^ bits >> 16) * 0x85EBCA6B & whole
    bits = (bits ^ bits >> 13) * 0xC2B2AE35 & whole
    return bits ^ bits >> 16
