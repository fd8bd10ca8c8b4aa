"""Small pictures of scenarios, for the menu."""

import warnings
from io import BytesIO
from pathlib import Path

import numpy as np

from subsea.base.arrays import Bytes
from subsea.base.input_files import MIB, read_input

SIZE = 480, 270  # larger pictures are scaled down
MOST_PIXELS = 16_000_000


def read_thumbnail(scenario: Path) -> Bytes | None:
    """The picture (h, w, 3) of a scenario file, top row first: the JPEG file of the same name.

    None if it is missing, damaged or too large, since a scenario needs no picture.
    """
    from PIL import Image

    try:
        data = read_input(scenario.with_suffix(".jpg"), MIB)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the number of pixels is checked below
            with Image.open(BytesIO(data), formats=("JPEG",)) as image:
                if image.width * image.height > MOST_PIXELS:
                    return None
                image.thumbnail(SIZE)
                return np.asarray(image.convert("RGB"))
    except Exception:  # Pillow's readers raise any exception for damaged files
        return None
