"""Read what a wheel of subsea says about itself."""

import hashlib
import re
import zipfile
from importlib.metadata import PathDistribution
from pathlib import Path
from typing import NamedTuple

from subsea.base.errors import UserError
from subsea.base.files import MIB, open_input
from subsea.stage.fleet.messages import MOST_WHEEL

MOST_METADATA = MIB


class Wheel(NamedTuple):
    """A wheel file, and what its metadata say."""

    path: Path
    version: str
    size: int  # bytes
    digest: str  # SHA-256
    requires: tuple[str, ...]  # sorted


def read_wheel(path: Path) -> Wheel:
    """Read a wheel of subsea; a UserError for anything else."""
    named = re.fullmatch(r"subsea-([\w.+!]+)(-[\w.]+){3,4}\.whl", path.name)
    if named is None:
        raise UserError(
            "expected a wheel of subsea, such as subsea-2.0-py3-none-any.whl", file=path
        )
    with open_input(path) as file:
        size = file.seek(0, 2)
        if size > MOST_WHEEL:
            raise UserError(f"larger than {MOST_WHEEL // MIB} MiB, expected a wheel", file=path)
        file.seek(0)
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    try:
        with zipfile.ZipFile(path) as archive:
            folder = f"subsea-{named[1]}.dist-info/"
            if archive.getinfo(f"{folder}METADATA").file_size > MOST_METADATA:
                raise KeyError
            found = PathDistribution(zipfile.Path(archive, folder))
            name, version = found.metadata["Name"], found.version
            requires = tuple(sorted(found.requires or ()))
    except (zipfile.BadZipFile, KeyError, OSError, UnicodeDecodeError) as fault:
        raise UserError("not a wheel, or a damaged one", file=path) from fault
    if name != "subsea" or version != named[1]:
        raise UserError(f"holds {name} {version}, expected what its name says", file=path)
    return Wheel(path, version, size, digest, requires)
