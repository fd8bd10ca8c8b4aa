"""Read fisheye pictures over the sea: of a show, and of the show of a node's master."""

import hashlib
import math
from collections.abc import Callable, Iterator
from io import BytesIO
from pathlib import Path

import msgspec
import numpy as np

from subsea.base.errors import UserError
from subsea.base.files import MIB, read_input
from subsea.base.pictures import naming_faults
from subsea.base.toml_files import error_at
from subsea.dive.presented import OverlayFile
from subsea.stage.show_file import Show
from subsea.view.fisheye import Fisheye

MOST_PIXELS, MOST_BYTES = 8192, 256 * MIB  # pixels of a side; bytes of a file
WITHOUT = "the sea is shown without it"
DIGEST = 16  # letters of the hash of a file


def overlay_faults(show: Show, path: Path) -> Iterator[UserError]:
    """Overlays that cannot be shown; their items are shown without them."""
    for number, item in enumerate(show.item):
        if item.overlay is not None:
            try:
                read_overlay(path.parent, item.overlay.picture)
            except UserError as fault:
                yield error_at(path, f"item[{number}].overlay", f"item {number + 1}: {fault}")


def read_overlay(folder: Path, overlay: OverlayFile) -> tuple[Fisheye, OverlayFile]:
    """Read the picture of an overlay, and name it with its digest.

    A UserError if it cannot be shown, or is not the one of the digest that `overlay` has.
    """
    from PIL import Image

    file = folder / overlay.file
    data = read_input(file, MOST_BYTES)
    digest = hashlib.sha256(data).hexdigest()[:DIGEST]
    if overlay.digest not in ("", digest):
        raise UserError("differs from the master's; copy it from there", file=file)
    opened = naming_faults("PNG picture", file)
    with opened, Image.open(BytesIO(data), formats=("PNG",)) as image:
        if image.width != image.height or not 16 <= image.width <= MOST_PIXELS:
            size = f"{image.width}×{image.height} pixels"
            raise UserError(f"{size}, expected a square of 16 to {MOST_PIXELS}", file=file)
        pixels = np.asarray(image.convert("RGBA"))
    angles = math.radians(overlay.tilt_deg), math.radians(overlay.angle_deg)
    return Fisheye(pixels, *angles), msgspec.structs.replace(overlay, digest=digest)


class MasterOverlay:
    """The overlay that the master of a node shows, from a file of this computer.

    The master sends its name and digest with each picture. The file is read before the first
    picture that has it, so that all computers show it at the same moment.
    """

    def __init__(self, folder: Path, tell: Callable[[str], object]) -> None:
        """`folder` has the files; `tell` takes a line for each that cannot be shown."""
        self._folder, self._tell = folder, tell
        self._wanted: OverlayFile | None = None
        self._shown: Fisheye | None = None

    def follow(self, wanted: OverlayFile | None) -> Fisheye | None:
        """Return what is to be shown."""
        if wanted != self._wanted:
            self._wanted, self._shown = wanted, None
            if wanted is not None:
                try:
                    self._shown, _ = read_overlay(self._folder, wanted)
                except UserError as fault:
                    self._tell(f"{fault}; {WITHOUT}")
        return self._shown
