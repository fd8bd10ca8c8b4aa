"""Write pictures of linear light and data as OpenEXR files.

Programs for compositing read these attributes: the primaries of the colours, the frame rate, a time
code and the matrices of the camera. As OpenEXR has it, a matrix acts on rows: `point @ matrix`.
"""

import errno
import os
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from subsea import __version__
from subsea.base.arrays import Array
from subsea.base.files import replacing
from subsea.view.camera import View

BT709 = 0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290  # red, green, blue, white: x and y each
MOST_FRAMES = 60  # of a second that a time code counts
UNITS = (
    "Z, worldToCamera and worldToNDC: cm, the camera looks along -z; forward and backward: pixels "
    "to the right and up; N: axes of the world, z up"
)
FULL = errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO  # faults of a disk while it is written


def write_exr(path: Path, channels: Mapping[str, Array], header: Mapping[str, Any]) -> None:
    """Write channels (h, w) by name completely or not at all; a UserError if the disk refuses."""
    import OpenEXR

    kept = {name: np.ascontiguousarray(values) for name, values in channels.items()}
    attributes = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with replacing(path) as temporary:
        try:
            with OpenEXR.File(attributes | dict(header), kept) as file:
                file.write(str(temporary))
        except RuntimeError as fault:  # the library's only error, with the system's words
            known = (code for code in FULL if os.strerror(code) in str(fault))
            raise OSError(next(known, None), str(fault)) from fault


def picture_header(rate: Fraction, frame: int) -> dict[str, Any]:
    """The attributes of the frame of this number since the beginning of a dive."""
    import OpenEXR

    header: dict[str, Any] = {
        "chromaticities": BT709,
        "framesPerSecond": rate,
        "pixelAspectRatio": 1.0,
        "software": f"subsea {__version__}",
        "comments": UNITS,
    }
    counted = round(rate)
    if 0 < counted <= MOST_FRAMES:
        seconds, part = divmod(frame, counted)
        minutes, seconds = divmod(seconds, 60)
        hours, minutes = divmod(minutes, 60)
        header["timeCode"] = OpenEXR.TimeCode(hours % 24, minutes, seconds, part, *([0] * 14))
    return header


def camera_header(view: View) -> dict[str, Any]:
    """The matrices of a camera: from the world to its axes, x right, y up, and to the picture.

    In the picture (0, 0) is the upper left corner and (1, 1) the lower right one.
    """
    corners = np.array([[0.5, 0, 0, 0.5], [0, -0.5, 0, 0.5], [0, 0, 1, 0], [0, 0, 0, 1]])
    return {
        "worldToCamera": np.ascontiguousarray(view.view.T, np.float32),
        "worldToNDC": np.ascontiguousarray((corners @ view.world_to_clip).T, np.float32),
    }
