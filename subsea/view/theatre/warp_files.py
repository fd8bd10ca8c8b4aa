"""Read the warp file of a channel, of any supported format."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from subsea.core.errors import UserError
from subsea.view.rig import Warp
from subsea.view.theatre.bourke import read_bourke
from subsea.view.theatre.obj import read_obj
from subsea.view.theatre.pfm import read_pfm
from subsea.view.theatre.warp import checked, from_grid

KINDS = (".obj", ".pfm", ".data")


def read_warp(path: Path, size: tuple[int, int]) -> tuple[Warp, NDArray[np.float32] | None]:
    """The warp for a projector of `size` pixels, and a mask (h, w, 4) if the file has brightness.

    Known by its suffix: an OBJ mesh, a PFM grid of u and v, or Paul Bourke's ``.data``. Any fault
    is a UserError of one line.
    """
    suffix = path.suffix.lower()
    if suffix == ".obj":
        return read_obj(path), None
    if suffix == ".data":
        return read_bourke(path, size)
    if suffix == ".pfm":
        return checked(from_grid(sources_of(read_pfm(path), str(path)), size), str(path)), None
    raise UserError(f"expected a warp file that ends in {', '.join(KINDS)}", file=path)


def sources_of(numbers: NDArray[np.float32], where: str) -> NDArray[np.float32]:
    """u and v (h, w, 2) from the numbers (h, w, c) of a PFM file; UserError for a grey one."""
    if numbers.shape[2] != 3:
        raise UserError("one number a point ('Pf'), expected u and v ('PF')", file=where)
    if min(numbers.shape[:2]) < 2:
        raise UserError(
            f"{numbers.shape[1]}×{numbers.shape[0]} points, expected 2×2 or more", file=where
        )
    return numbers[..., :2]
