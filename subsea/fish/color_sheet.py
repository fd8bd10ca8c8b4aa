"""The sheet that a species wears: painted from its colours, or a picture in a file of its own.

In the file the upper row is the first, as picture viewers have it; in arrays the bottom row is,
as OpenGL wants it.
"""

import tomllib
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from subsea.core.arrays import Bytes
from subsea.core.atomic_io import replacing
from subsea.core.disk_cache import cached
from subsea.core.errors import UserError
from subsea.core.toml_edit import edit_toml
from subsea.core.toml_files import load_toml
from subsea.fish import paint, sheet_layout
from subsea.fish.species import Species


def sheet_of(species: Species) -> Bytes:
    """The sheet (640, 1024, 4) of one species, as `sheets` has it."""
    return read(Path(species.skin.sheet)) if species.skin.sheet else paint.paint(species)


def sheets(species: Sequence[Species]) -> list[Bytes]:
    """Return the sheets of many species; painted ones come from the disk cache.

    A missing or damaged file, or one that is not a sheet, is a UserError.
    """
    painted = [one for one in species if not one.skin.sheet]
    done = iter(cached(paint.paint_all, tuple(painted)) if painted else [])
    return [read(Path(one.skin.sheet)) if one.skin.sheet else next(done) for one in species]


def read(path: Path) -> Bytes:
    """The sheet in a PNG file; anything else is a UserError."""
    width, height = sheet_layout.SIZE
    expected = f"expected a PNG of {width}×{height} pixels with opacity (RGBA)"
    from PIL import Image  # most species are painted

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about huge sizes, which are refused below
            with Image.open(path, formats=("PNG",)) as image:
                if image.size != sheet_layout.SIZE or image.mode != "RGBA":
                    about = f"{image.width}×{image.height} pixels, {image.mode}"
                    raise UserError(f"{about}; {expected}", file=path)
                return np.ascontiguousarray(np.asarray(image, np.uint8)[::-1])
    except OSError as fault:
        reason = fault.strerror if fault.errno else "no picture, or damaged"
        raise UserError(f"cannot read the sheet ({reason}); {expected}", file=path) from fault
    except (ValueError, SyntaxError, TypeError, EOFError, Image.DecompressionBombError) as fault:
        raise UserError(f"damaged ({fault}); {expected}", file=path) from fault


def write(path: Path, sheet: Bytes) -> None:
    """Write a sheet (640, 1024, 4), bottom row first, as a PNG file; whole or not at all."""
    from PIL import Image

    with replacing(path) as temporary:
        Image.fromarray(np.ascontiguousarray(sheet[::-1])).save(temporary, "PNG")


def picture_of(path: Path) -> Path:
    """Return the path of the sheet of a species file: a PNG with its name.

    An existing file that is not its sheet is a UserError, as is a faulty species file.
    """
    picture = path.with_suffix(".png")
    if load_toml(path, Species).skin.sheet != picture.name and picture.exists():
        raise UserError(
            f"is there already, and no sheet of {path.name}; move it elsewhere", file=picture
        )
    return picture


def wear(path: Path, sheet: Bytes) -> Path:
    """Save a sheet as a PNG beside the species file, and set its key there.

    All else in the file stays, comments too. Returns the path of the PNG.
    A UserError as in `picture_of`.
    """
    picture = picture_of(path)
    text = path.read_text(encoding="utf-8")
    old = tomllib.loads(text)["skin"].get("sheet")
    was = {} if old is None else {"sheet": old}
    text = edit_toml(text, was, {"sheet": picture.name}, ("skin",), path)
    write(picture, sheet)
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")
    return picture
