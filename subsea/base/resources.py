"""Locate shaders, assets, repertoires and the user's own files.

Resources are next to the package in a checkout and inside it in an installed wheel. The user's own
files are in the user's data folder.
"""

from pathlib import Path

import platformdirs

from subsea.base.errors import unknown

_PACKAGE = Path(__file__).parents[1]
_INSTALLED = _PACKAGE / "_data"
ROOT = _INSTALLED if _INSTALLED.is_dir() else _PACKAGE.parent


def resource_path(relative: str) -> Path:
    """The path of a file or folder such as ``shaders/fish.vert``."""
    return ROOT / relative


def own_path(relative: str) -> Path:
    """The path of a folder of the user, such as ``scenarios``, which may be missing."""
    return platformdirs.user_data_path("subsea", appauthor=False) / relative


def resource_names(folder: str, suffix: str) -> list[str]:
    """Sorted stems of the files in `folder` that end in `suffix`."""
    return stems(resource_path(folder), suffix)


def stems(folder: Path, suffix: str) -> list[str]:
    """Sorted stems of the files in any folder that end in `suffix`; empty if it is missing."""
    return sorted(path.stem for path in folder.glob(f"[!.]*{suffix}"))


def is_path(name: str, suffix: str) -> bool:
    """True if `name` is a path: it has a slash or ends in `suffix`."""
    return "/" in name or "\\" in name or name.endswith(suffix)


def named_or_file(name: str, folder: str, suffix: str, kind: str) -> Path:
    """The resource `name` in `folder`, or the file at the path `name`.

    An unknown name is a UserError that lists the known ones.
    """
    if is_path(name, suffix):
        return Path(name)
    known = resource_names(folder, suffix)
    if name not in known:
        raise unknown(kind, name, known)
    return resource_path(folder) / f"{name}{suffix}"
