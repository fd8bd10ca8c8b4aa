"""Packages of a USD stage and its textures: .usdz."""

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from subsea.base.atomic_io import replacing
from subsea.base.errors import UserError

ZIP_EPOCH_S = 315_619_200  # 1980-01-02, after the first day that a package can hold


def write_package(out: Path, fill: Callable[[Path], Path]) -> None:
    """Write the package `out` of what `fill` writes into a folder; it returns the stage there.

    UserError if it cannot be written. The same content gives the same bytes.
    """
    from pxr import Sdf, UsdUtils

    with (
        replacing(out) as part,
        tempfile.TemporaryDirectory(prefix=part.name, dir=part.parent) as name,
    ):
        folder = Path(name)
        stage = fill(folder)
        for path in folder.iterdir():  # a package holds these times
            os.utime(path, (ZIP_EPOCH_S, ZIP_EPOCH_S))
        package = folder / "package.usdz"
        if not UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(stage)), str(package)):
            raise UserError("cannot write the package", file=out)
        package.replace(part)
