"""Install a wheel of subsea in an environment beside the running one, and switch between them.

The running environment is reached through a link, such as ``~/subsea/current``. A new one becomes a
folder beside it, with the same packages. The link is replaced in one step, and ``current-before``
then leads to the environment before.
"""

import os
import shutil
import subprocess
import sys
import sysconfig
import venv
from collections.abc import Sequence
from importlib.metadata import requires
from pathlib import Path
from typing import NamedTuple

from subsea.base.errors import UserError
from subsea.base.system import CHECKOUT
from subsea.stage.fleet.wheel import Wheel

BEFORE = "-before"  # ends the name of the link to the environment before
MARK = ".made-by-subsea-fleet"  # a file in environments that may be removed again
LIMIT_S = 300.0  # longest time of one step
OURS = "subsea", "capture"  # packages of the wheel


class LinkedEnvironment(NamedTuple):
    """The environment of a computer that an update replaces."""

    link: Path  # that leads to it
    site: Path  # its packages

    @property
    def before(self) -> Path:
        """The link to the environment before, which may be missing."""
        return self.link.with_name(f"{self.link.name}{BEFORE}")


def running_installation() -> LinkedEnvironment:
    """The environment of this process; a UserError if no link leads to it."""
    if CHECKOUT.is_file():
        raise UserError("subsea runs from a checkout, which no wheel replaces")
    for program in (sys.argv[0], sys.executable):
        folder = Path(program).absolute().parents[1]
        if folder.is_symlink() and folder.resolve() == Path(sys.prefix).resolve():
            return LinkedEnvironment(folder, Path(sysconfig.get_path("purelib")))
    raise UserError(
        f"subsea was not started through a link to its environment {sys.prefix}: "
        "docs/how-to/fleet.md says how to make one"
    )


def missing_packages(needed: Sequence[str], have: Sequence[str] | None = None) -> str:
    """Say how the packages that a wheel needs differ from those of this subsea; empty if not.

    An update has no network, so it can bring none. `have` are those of this subsea.
    """
    have = requires("subsea") or () if have is None else have
    if not (other := sorted({*needed} - {*have})):
        return ""
    return f"needs other packages than this version: {', '.join(other[:4])}; install it by hand"


def install(wheel: Wheel, place: LinkedEnvironment) -> Path:
    """Install a wheel in a new environment and try it; returns its folder, or a UserError.

    Nothing changes for the running version.
    """
    folder = place.link.parent / f"subsea-{wheel.version}-{wheel.digest[:8]}"
    if folder.exists():
        if folder.resolve() == place.link.resolve():
            raise UserError(f"this computer runs this very wheel already: {folder}")
        if folder.resolve() == place.before.resolve():
            raise UserError("the version before is this very wheel: `subsea fleet rollback`")
        shutil.rmtree(folder)
    try:
        venv.EnvBuilder(symlinks=os.name == "posix").create(folder)
        (folder / MARK).touch()
        python = _program(folder, "python")
        site = Path(
            _said([python, "-P", "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"])
        )
        _copy_packages(place.site, site)
        if not (site / "pip").is_dir():
            _said([python, "-P", "-m", "ensurepip"])
        offline = "--no-index", "--no-deps", "--disable-pip-version-check", "--quiet"
        _said([python, "-P", "-m", "pip", "install", *offline, str(wheel.path)])
        _said([python, "-P", "-m", "pip", "check", "--disable-pip-version-check"])
        _try(folder, wheel.version)
    except (OSError, shutil.Error, subprocess.SubprocessError) as fault:
        shutil.rmtree(folder, ignore_errors=True)
        raise UserError(f"cannot install {wheel.path.name}: {fault}") from fault
    except UserError:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    return folder


def switch(place: LinkedEnvironment, folder: Path) -> None:
    """Let the link lead to another environment, and `before` to the present one."""
    _point(place.before, place.link.resolve())
    _point(place.link, folder)


def version_before(place: LinkedEnvironment) -> str:
    """The version to which a rollback would return; a UserError if there is none that works."""
    if not place.before.is_dir():
        raise UserError(f"there is no version before: {place.before} is missing")
    return _try(place.before.resolve())


def roll_back(place: LinkedEnvironment) -> None:
    """Exchange the present environment and the one before."""
    switch(place, place.before.resolve())


def remove_old(place: LinkedEnvironment) -> None:
    """Remove environments of earlier updates to which neither link leads."""
    kept = {place.link.resolve(), place.before.resolve()}
    for mark in place.link.parent.glob(f"*/{MARK}"):
        if mark.parent.resolve() not in kept:
            shutil.rmtree(mark.parent, ignore_errors=True)


def _point(link: Path, folder: Path) -> None:
    """Let a link lead to a folder beside it, in one step."""
    made = link.with_name(f".{link.name}.new")
    made.unlink(missing_ok=True)
    made.symlink_to(os.path.relpath(folder, link.parent), target_is_directory=True)
    made.replace(link)


def _copy_packages(source: Path, target: Path) -> None:
    """Copy all packages but ours, by hard links where the disk has them: they are not changed."""

    def left_out(folder: str, names: list[str]) -> list[str]:
        if Path(folder) != source:
            return []
        return [name for name in names if name in OURS or name.startswith("subsea-")]

    def linked(one: str, other: str) -> str:
        try:
            os.link(one, other)
        except OSError:
            shutil.copy2(one, other)
        return other

    shutil.copytree(
        source, target, symlinks=True, ignore=left_out, copy_function=linked, dirs_exist_ok=True
    )


def _try(folder: Path, wanted: str = "") -> str:
    """Start the program of an environment; returns its version, or a UserError."""
    told = _said([_program(folder, "subsea"), "--version"]).split()
    version = told[-1] if told else ""
    if not version or (wanted and version != wanted):
        raise UserError(f"{folder.name} says {' '.join(told)!r}, expected version {wanted}")
    return version


def _program(folder: Path, name: str) -> str:
    return str(folder / "bin" / name if os.name == "posix" else folder / "Scripts" / f"{name}.exe")


def _said(command: Sequence[str]) -> str:
    """Run a program without the settings of this Python; returns its output, or a UserError."""
    clean = {name: text for name, text in os.environ.items() if not name.startswith("PYTHON")}
    done = subprocess.run(
        command, env=clean, capture_output=True, text=True, errors="replace", timeout=LIMIT_S,
        stdin=subprocess.DEVNULL, check=False,
    )  # fmt: skip
    if done.returncode != 0:
        lines = [line for line in (done.stdout + done.stderr).splitlines() if line.strip()]
        code = f"exit code {done.returncode}"
        name = f"{Path(command[0]).name} {' '.join(command[1:4])}"
        raise UserError(": ".join([name, code, *lines[-1:]]))
    return done.stdout.strip()
