"""Read the warp file of a channel, of any supported format."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.errors import UserError
from subsea.base.files import read_input
from subsea.stage.theatre import domeprojection, pfm, scalable, sciss, simcad, skyskan, vioso
from subsea.stage.theatre.bourke import parse_bourke
from subsea.stage.theatre.measured_mesh import MeasuredMesh
from subsea.stage.theatre.obj import parse_obj
from subsea.stage.theatre.warp import from_grid, validated
from subsea.view.rig import Warp


class WarpFormat(NamedTuple):
    """A format of warp files."""

    max_bytes: int
    # Bytes of a file, pixels of the projector, and the name of the file for errors.
    parse: Callable[[bytes, tuple[int, int], str], MeasuredMesh]


def _parse_pfm(data: bytes, size: tuple[int, int], where: str) -> MeasuredMesh:
    sources = sources_of(pfm.parse_pfm(data, where), where)
    return MeasuredMesh(validated(from_grid(sources, size), where))


FORMATS = {
    ".obj": WarpFormat(32 * 2**20, lambda data, _, where: MeasuredMesh(parse_obj(data, where))),
    ".pfm": WarpFormat(pfm.MAX_BYTES, _parse_pfm),
    ".data": WarpFormat(32 * 2**20, lambda *given: MeasuredMesh(*parse_bourke(*given))),
    ".sgc": WarpFormat(sciss.MAX_BYTES, lambda data, _, at: sciss.parse_sciss(data, at)),
    ".csv": WarpFormat(
        domeprojection.MAX_BYTES,
        lambda data, _, where: domeprojection.parse_domeprojection(data, where),
    ),
    ".simcad": WarpFormat(simcad.MAX_BYTES, lambda data, _, at: simcad.parse_simcad(data, at)),
    ".ol": WarpFormat(scalable.MAX_BYTES, scalable.parse_scalable),
    ".skyskan": WarpFormat(skyskan.MAX_BYTES, lambda data, _, at: skyskan.parse_skyskan(data, at)),
    ".vwf": WarpFormat(vioso.MAX_BYTES, lambda data, _, where: vioso.parse_vioso(data, where)),
}


def read_warp(path: Path, size: tuple[int, int]) -> tuple[Warp, NDArray[np.float32] | None]:
    """The warp for a projector of `size` pixels, and a mask (h, w, 4) if the file has brightness.

    The suffix tells the format (`FORMATS`). Any fault is a UserError of one line.
    """
    found = read_mesh(path, size)
    return found.warp, found.mask


def read_mesh(path: Path, size: tuple[int, int]) -> MeasuredMesh:
    """All that a warp file says, with the view in a file beside it; else a UserError."""
    suffix, where = path.suffix.lower(), str(path)
    if suffix not in FORMATS:
        raise UserError(f"expected a warp file that ends in {', '.join(FORMATS)}", file=path)
    form = FORMATS[suffix]
    found = form.parse(read_input(path, form.max_bytes), size, where)
    beside = domeprojection.frustum_file(path)
    if suffix == ".csv" and beside.is_file():
        data = read_input(beside, domeprojection.MAX_FRUSTUM)
        found = found._replace(view=domeprojection.parse_frustum(data, str(beside)))
    return found


def sources_of(numbers: NDArray[np.float32], where: str) -> NDArray[np.float32]:
    """u and v (h, w, 2) from the numbers (h, w, c) of a PFM file; UserError for a grey one."""
    if numbers.shape[2] != 3:
        raise UserError("one number a point ('Pf'), expected u and v ('PF')", file=where)
    if min(numbers.shape[:2]) < 2:
        raise UserError(
            f"{numbers.shape[1]}×{numbers.shape[0]} points, expected 2×2 or more", file=where
        )
    return numbers[..., :2]
