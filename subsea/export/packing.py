"""How arrays are stored in a glTF file: as they are, or rounded and compressed.

`quantised` needs KHR_mesh_quantization of the reader, `meshopt` also EXT_meshopt_compression.
Keys of animations and texture coordinates are rounded as glTF itself allows.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.base.extras import require
from subsea.export.packed import COMPRESSIONS, MESHOPT, PLAIN

QUANTIZATION, COMPRESSION = "KHR_mesh_quantization", "EXT_meshopt_compression"
SHORT, BYTE, FULL_SHORT, FULL_BYTE = 32767, 127, 65535, 255  # greatest values: of ±1, and of 1


class PositionGrid(NamedTuple):
    """The grid of rounded positions: a position is `middle` + `half` times its integer / SHORT.

    One step for all axes, so that normals need no correction.
    """

    middle: Array  # (3,) metres
    half: float  # metres; 0: positions are stored as they are

    @property
    def matrix(self) -> Array:
        """From stored positions to metres (4, 4)."""
        out = np.eye(4)
        if self.half:
            out[:3, :3] *= self.half
            out[:3, 3] = self.middle
        return out

    def node(self) -> dict[str, list[float]]:
        """The same as properties of a node."""
        if not self.half:
            return {}
        return {"translation": self.middle.tolist(), "scale": [self.half] * 3}


class Stored(NamedTuple):
    """An array to store."""

    values: NDArray[Any]
    normalised: bool = False  # its integers stand for numbers from 0 or -1 to 1
    step: float = 0.0  # of its floats, as coarse as compression may make them; 0: exact


class Packing(NamedTuple):
    """The rounding and compression of the arrays of a file."""

    kind: str = PLAIN

    @property
    def rounds(self) -> bool:
        """True if values are rounded to integers."""
        return self.kind != PLAIN

    def grid(self, points: Array, reach: float = 0.0) -> PositionGrid:
        """The grid of points (..., 3), metres, and of offsets of up to `reach` along an axis."""
        if not self.rounds:
            return PositionGrid(np.zeros(3), 0.0)
        low, high = points.reshape(-1, 3).min(axis=0), points.reshape(-1, 3).max(axis=0)
        half = max(float((high - low).max()) / 2.0, reach) or 1.0
        return PositionGrid((low + high) / 2.0, half)

    def positions(self, points: Array, grid: PositionGrid) -> Stored:
        """Positions (n, 3), metres."""
        return self.offsets(points - grid.middle, grid)

    def offsets(self, ways: Array, grid: PositionGrid) -> Stored:
        """Differences (n, 3) of positions, metres."""
        if not grid.half:
            return _single(ways)
        return Stored(np.round(ways / grid.half * SHORT).astype(np.int16), True)

    def normals(self, normals: Array) -> Stored:
        """Unit vectors (n, 3)."""
        return Stored(_bytes(normals), True) if self.rounds else _single(normals)

    def turned_normals(self, change: Array) -> Stored:
        """Differences (n, 3) of unit vectors; those beyond ±1 cannot be rounded."""
        rounded = self.rounds and np.abs(change).max(initial=0.0) <= 1.0
        return Stored(_bytes(change), True) if rounded else _single(change)

    def coordinates(self, places: Array) -> Stored:
        """Texture coordinates (n, 2) from 0 to 1."""
        if not self.rounds:
            return _single(places)
        return Stored(np.round(places * FULL_SHORT).astype(np.uint16), True)

    def weights(self, weights: Array) -> Stored:
        """Weights (n, 4) of joints, of sum 1."""
        if not self.rounds:
            return _single(weights)
        whole = np.round(weights * FULL_BYTE).astype(np.int64)
        # The greatest takes the rest, so that the sum is exact.
        rows = np.arange(len(whole))
        whole[rows, weights.argmax(axis=1)] += FULL_BYTE - whole.sum(axis=1)
        return Stored(whole.astype(np.uint8), True)

    def shares(self, shares: Array) -> Stored:
        """Weights (...) of morph targets, 0 to 1."""
        if not self.rounds:
            return _single(shares)
        return Stored(np.round(shares * FULL_BYTE).astype(np.uint8), True)

    def rotations(self, turns: Array) -> Stored:
        """Unit quaternions (T, 4)."""
        if not self.rounds:
            return _single(turns)
        return Stored(np.round(turns * SHORT).astype(np.int16), True)

    def lengths(self, values: Array, step: float) -> Stored:
        """Positions (T, 3) of nodes, metres; `step` is what they may be off."""
        return Stored(np.asarray(values, np.float32), step=step if self.rounds else 0.0)

    def extensions(self) -> list[str]:
        """Extensions of glTF that a reader needs."""
        rounded = [QUANTIZATION] if self.rounds else []
        return rounded + ([COMPRESSION] if self.kind == MESHOPT else [])


EXACT = Packing()


def packing_of(kind: str) -> Packing:
    """The packing of a name; UserError without the package that it needs."""
    if kind not in COMPRESSIONS:
        raise UserError(f"unknown compression {kind!r}, expected {', '.join(COMPRESSIONS)}")
    if kind == MESHOPT:
        require("meshopt", "compressed glTF")
    return Packing(kind)


def _single(values: Array) -> Stored:
    return Stored(np.asarray(values, np.float32))


def _bytes(values: Array) -> NDArray[np.int8]:
    return np.round(np.clip(values, -1.0, 1.0) * BYTE).astype(np.int8)
