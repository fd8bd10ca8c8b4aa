"""Read the colours of pictures as sRGB, and write PNG files that say so.

Pillow is imported when a picture is read or written: most dives do neither. Pictures of numbers,
such as masks of theatres, are not read here.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from subsea.base.errors import UserError
from subsea.base.files import replacing

if TYPE_CHECKING:
    from PIL import Image

# (height, width, 1, 3 or 4) of 8 bits, top row first; also (height, width) of 16 bits.
Pixels = NDArray[np.uint8] | NDArray[np.uint16]


@contextmanager
def naming_faults(kind: str, file: Path | str) -> Iterator[None]:
    """Turn any fault of reading a picture into a UserError that names its kind and file."""
    try:
        yield
    except UserError:
        raise
    except Exception as fault:  # Pillow raises nearly anything for a damaged file
        raise UserError(f"not a readable {kind}", file=file) from fault


def in_srgb(picture: Image.Image) -> Image.Image:
    """Convert a picture to sRGB by its embedded profile; return one of mode RGB or RGBA.

    Without a profile, or with one that is damaged or of another kind of picture, colours are taken
    as they are. Greys have 8 bits.
    """
    from PIL import Image, ImageCms

    opacity = picture.getchannel("A") if picture.mode in ("RGBA", "LA") else None
    flat = {"RGBA": "RGB", "YCbCr": "RGB", "LA": "L"}.get(picture.mode)
    colours = picture.convert(flat) if flat else picture
    profile = picture.info.get("icc_profile")
    if profile:
        # Pillow raises this error for a damaged profile, and for one of another kind.
        with suppress(ImageCms.PyCMSError):
            converted = ImageCms.profileToProfile(
                colours, BytesIO(profile), ImageCms.createProfile("sRGB"), outputMode="RGB"
            )
            colours = converted or colours
    colours = colours.convert("RGB")
    return colours if opacity is None else Image.merge("RGBA", (*colours.split(), opacity))


def write_png(path: Path, picture: Pixels) -> None:
    """Write one picture completely or not at all; a UserError if the disk refuses.

    Pictures of 8 bits are marked as sRGB. Those of 16 bits hold numbers, not colours.
    """
    from PIL import Image, PngImagePlugin

    marks = PngImagePlugin.PngInfo()
    if picture.dtype == np.uint8:
        marks.add(b"sRGB", b"\0")
    with replacing(path) as temporary:
        Image.fromarray(picture).save(temporary, format="PNG", pnginfo=marks)
