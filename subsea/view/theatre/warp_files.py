"""Read the warp file of a channel, of any supported format."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from subsea.core.errors import UserError
from subsea.core.input_files import read_input
from subsea.view.rig import Warp
from subsea.view.theatre import pfm
from subsea.view.theatre.bourke import parse_bourke
from subsea.view.theatre.obj import parse_obj
from subsea.view.theatre.warp import from_grid, validated

MAX_BYTES = {".obj": 32 * 2**20, ".pfm": pfm.MAX_BYTES, ".data": 32 * 2**20}


def read_warp(path: Path, size: tuple[int, int]) -> tuple[Warp, NDArray[np.float32] | None]:
    """The warp for a projector of `size` pixels, and a mask (h, w, 4) if the file has brightness.

    Known by its suffix: an OBJ mesh, a PFM grid of u and v, or Paul Bourke's ``.data``. Any fault
    is a UserError of one line.
    """
    suffix, where = path.suffix.lower(), str(path)
    if suffix not in MAX_BYTES:
        raise UserError(f"expected a warp file that ends in {', '.join(MAX_BYTES)}", file=path)
    data = read_input(path, MAX_BYTES[suffix])
    if suffix == ".obj":
        return parse_obj(data, where), None
    if suffix == ".data":
        return parse_bourke(data, size, where)
    return validated(from_grid(sources_of(pfm.parse_pfm(data, where), where), size), where), None


def sources_of(numbers: NDArray[np.float32], where: str) -> NDArray[np.float32]:
    """u and v (h, w, 2) from the numbers (h, w, c) of a PFM file; UserError for a grey one."""
    if numbers.shape[2] != 3:
        raise UserError("one number a point ('Pf'), expected u and v ('PF')", file=where)
    if min(numbers.shape[:2]) < 2:
        raise UserError(
            f"{numbers.shape[1]}×{numbers.shape[0]} points, expected 2×2 or more", file=where
        )
    return numbers[..., :2]
