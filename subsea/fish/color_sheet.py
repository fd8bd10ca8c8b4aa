"""Skin sheets (textures) of species: painted from their colours, or read from a PNG file.

A file begins with the top row, an array with the bottom row as in OpenGL.
"""

import tomllib
import warnings
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from subsea.base.arrays import Bytes
from subsea.base.disk_cache import cached
from subsea.base.errors import UserError
from subsea.base.files import check_input, read_text, replacing
from subsea.base.pictures import in_srgb, write_png
from subsea.base.toml_edit import edit_toml
from subsea.base.toml_files import load_toml
from subsea.fish import paint, sheet_layout
from subsea.fish.species import Species


def sheet_of(species: Species) -> Bytes:
    """The sheet (640, 1024, 4) of one species."""
    return read(Path(species.skin.sheet)) if species.skin.sheet else paint.paint(species)


def sheets(species: Sequence[Species]) -> list[Bytes]:
    """Read or paint the sheets of many species in parallel threads; UserError as in `read`.

    Painted ones are kept on disk. numpy and the decompression of shipped ones release the GIL.
    """
    with ThreadPoolExecutor() as pool:
        return list(pool.map(_kept_sheet, species))


def _kept_sheet(species: Species) -> Bytes:
    return sheet_of(species) if species.skin.sheet else cached(paint.paint, species)


def read(path: Path) -> Bytes:
    """The sheet in a PNG file, in sRGB; UserError for anything else."""
    width, height = sheet_layout.SIZE
    expected = f"expected a PNG of {width}×{height} pixels with opacity (RGBA)"
    from PIL import Image  # most species are painted

    try:
        check_input(path)
    except UserError as fault:
        raise UserError(f"{fault.message}; {expected}", file=path) from fault
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # huge sizes are refused below
            with Image.open(path, formats=("PNG",)) as image:
                if image.size != sheet_layout.SIZE or image.mode != "RGBA":
                    about = f"{image.width}×{image.height} pixels, {image.mode}"
                    raise UserError(f"{about}; {expected}", file=path)
                return np.ascontiguousarray(np.asarray(in_srgb(image), np.uint8)[::-1])
    except OSError as fault:
        reason = fault.strerror or "not a picture, or damaged"
        raise UserError(f"{reason}; {expected}", file=path) from fault
    except (ValueError, SyntaxError, TypeError, EOFError, Image.DecompressionBombError) as fault:
        raise UserError(f"damaged ({fault}); {expected}", file=path) from fault


def write(path: Path, sheet: Bytes) -> None:
    """Write a sheet (640, 1024, 4), bottom row first, as a PNG file, atomically."""
    write_png(path, np.ascontiguousarray(sheet[::-1]))


def own_sheet_path(path: Path) -> Path:
    """The PNG path for the sheet of a species file; UserError if another file has that name."""
    picture = path.with_suffix(".png")
    if load_toml(path, Species).skin.sheet != picture.name and picture.exists():
        raise UserError(
            f"exists and is not the sheet of {path.name}; move it elsewhere", file=picture
        )
    return picture


def assign_sheet(path: Path, sheet: Bytes) -> Path:
    """Save a sheet as a PNG beside the species file and set its key there; return the PNG's path.

    Comments in the file stay. UserError as in `own_sheet_path`.
    """
    picture = own_sheet_path(path)
    text = read_text(path)
    old = tomllib.loads(text)["skin"].get("sheet")
    was = {} if old is None else {"sheet": old}
    text = edit_toml(text, was, {"sheet": picture.name}, ("skin",), path)
    write(picture, sheet)
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")
    return picture
