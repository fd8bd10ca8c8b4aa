"""`subsea doctor`: report what this machine can do, and what to install."""

import os
import platform
import sys
import tempfile
from argparse import Namespace
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from subsea.core.command_line import add_command
from subsea.core.errors import UserError

if TYPE_CHECKING:
    from subsea.ui.monitors import Monitor

PACKAGES = (
    "numpy", "numba", "h5py", "moderngl", "glfw", "pyrr", "imgui-bundle", "msgspec", "pillow",
    "av", "tqdm",
)  # fmt: skip


class Finding(NamedTuple):
    """One line of the report; the `needed` ones decide whether a dive is possible."""

    name: str
    good: bool
    text: str
    needed: bool = True


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "doctor",
        "report what this machine can do, and what to install",
        "Exit code 0 if a dive in a window is possible here, 1 if not.",
        ["subsea doctor"],
    )
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Print the findings; 0 if a dive in a window is possible here, else 1."""
    checks: tuple[Callable[[], list[Finding]], ...] = (
        _python,
        _packages,
        _cache,
        _fishes,
        _display,
        _headless,
    )
    findings = [finding for check in checks for finding in check()]
    for finding in findings:
        mark = "ok  " if finding.good else "no  " if finding.needed else "--  "
        print(f"{mark}{finding.name:<24} {finding.text}")
    possible = all(finding.good for finding in findings if finding.needed)
    print("a dive is possible" if possible else "a dive is not possible yet: fix the lines above")
    return 0 if possible else 1


def _python() -> list[Finding]:
    good = sys.version_info >= (3, 11)
    text = f"{platform.python_version()} on {platform.platform()}"
    return [Finding("Python", good, text if good else f"{text}; 3.11 or later is needed")]


def _packages() -> list[Finding]:
    from importlib.metadata import PackageNotFoundError, version

    found, missing = [], []
    for package in PACKAGES:
        try:
            found.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            missing.append(package)
    if missing:
        return [Finding("packages", False, f"pip install {' '.join(missing)}")]
    return [Finding("packages", True, ", ".join(found))]


def _cache() -> list[Finding]:
    """Check the folder of compiled kernels; without one every start compiles again."""
    from numba.core import config

    import subsea

    beside = Path(subsea.__file__).parent
    places = [Path(config.CACHE_DIR)] if config.CACHE_DIR else [beside, _user_cache()]
    for place in places:
        if _writable(place):
            return [Finding("cache of kernels", True, str(place), needed=False)]
    text = f"not writable: {places[0]}; set NUMBA_CACHE_DIR to a folder that is"
    return [Finding("cache of kernels", False, text, needed=False)]


def _user_cache() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _fishes() -> list[Finding]:
    """Check every species; a dive needs only the shipped ones."""
    from subsea.fish.species import (
        hidden_names,
        is_shipped,
        load_species,
        own_species,
        repertoire_file,
        species_names,
    )
    from subsea.repertoire import read_repertoire

    findings = []
    for name in species_names():
        needed = is_shipped(name)
        own = "" if needed else f", of your own in {own_species()}"
        try:
            load_species(name)
            file = repertoire_file(name)
            if not file.exists():
                raise UserError(f"not recorded yet: `subsea-capture record {name}`{own}")
            repertoire = read_repertoire(file)
            text = f"{len(repertoire.segments)} segments, {repertoire.source}{own}"
            findings.append(Finding(f"fish {name}", True, text, needed))
        except UserError as fault:
            findings.append(Finding(f"fish {name}", False, str(fault), needed))
    for name in hidden_names():
        text = f"{own_species() / name}.toml: a shipped species has this name, take another one"
        findings.append(Finding(f"fish {name}", False, text, needed=False))
    return findings


def _headless() -> list[Finding]:
    from subsea.render import headless_context

    try:
        context = headless_context()
    except UserError as fault:
        return [Finding("OpenGL, no window", False, f"{fault}", needed=False)]
    with context:  # a context that is current on this thread prevents windows from opening
        text = f"{context.info['GL_RENDERER']}, OpenGL {context.version_code / 100:.1f}"
    context.release()
    return [Finding("OpenGL, no window", True, text, needed=False)]


def _quality(renderer: str) -> Finding:
    """The quality at which a dive begins by default."""
    from subsea.dive.adaptive_quality import target_for
    from subsea.render.output.quality import LADDER, first_rung, name_of, on_software

    why = "computes pictures without a GPU" if on_software(renderer) else "is a GPU"
    text = f"auto begins at {name_of(LADDER[first_rung(renderer)])}: {renderer} {why}"
    return Finding("quality", True, f"{text}; holds {target_for(renderer):.3g} ms", needed=False)


def _monitor(monitor: "Monitor") -> Finding:
    """The name and position by which a theatre file may refer to a monitor."""
    left, top = monitor.position
    rate = f" at {monitor.rate} Hz" if monitor.rate else ""
    text = f"{monitor!s}{rate}, position {left}, {top}"
    return Finding("monitor", True, text, needed=False)


def _display() -> list[Finding]:
    """Display, monitors, and the OpenGL of hidden windows."""
    from subsea.ui.system_packages import INSTALL
    from subsea.view.stereo import OTHER_STEREO

    try:
        from subsea.render import window_context
        from subsea.ui.monitors import on_display
        from subsea.ui.window import hidden_window
    except ImportError as fault:
        return [Finding("display", False, f"{fault}; try: {INSTALL}")]
    try:
        with on_display() as display:
            findings = [
                Finding("display", True, display.platform),
                *(_monitor(monitor) for monitor in display.monitors),
            ]
            with hidden_window() as loader:
                if loader is None:
                    findings.append(Finding("OpenGL, window", False, INSTALL))
                else:
                    context = window_context(loader)
                    text = f"{context.info['GL_RENDERER']}, {context.info['GL_VERSION']}"
                    findings.append(Finding("OpenGL, window", True, text))
                    findings.append(_quality(context.info["GL_RENDERER"]))
            with hidden_window(stereo=True) as loader:
                text = "yes" if loader else f"no; use --display {OTHER_STEREO}"
                findings.append(Finding("quad-buffered stereo", bool(loader), text, needed=False))
            return findings
    except UserError as fault:
        return [Finding("display", False, str(fault))]
