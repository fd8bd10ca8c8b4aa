"""`subsea doctor`: report what this machine can do, and what to install."""

import os
import platform
import subprocess
import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from subsea.base.command_line import add_command
from subsea.base.errors import UserError
from subsea.base.system import (
    BASE_COMMAND,
    EXTRAS,
    INSTALL_WINDOW,
    import_fault,
    install_command,
    missing_packages,
)

if TYPE_CHECKING:
    from subsea.ui.monitors import Monitor

PACKAGES = (
    "numpy", "numba", "h5py", "moderngl", "glfw", "pyrr", "imgui-bundle", "msgspec", "pillow",
    "av", "tqdm", "pyzmq", "platformdirs", "tomlkit",
)  # fmt: skip
BASE = "dive", "film", "simulate", "capture"
DIVE = ("dive",)
SEA = "dive", "film", "simulate"
HEADSET_S = 10.0  # for a runtime that answers late: some of them start first
DESCRIBE_HEADSET = """\
from subsea.base.registry import DEVICES, load_named
print(*load_named(DEVICES, "headset", "device")(), sep="\\n")
"""


class Finding(NamedTuple):
    """One line of the report."""

    name: str
    good: bool
    text: str
    needed_by: Sequence[str] = BASE  # the parts of BASE that do not work without it


GROUP = "this machine"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "doctor",
        "check this machine and say what to install",
        "Ends with a line for each part. Exit code 0 if dive, film, simulate and capture work,\n"
        "1 if not; extras do not change it.",
        ["subsea doctor"],
    )
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Print the findings and verdicts; 0 if all parts of BASE work here, else 1."""
    checks = (_python, _packages, _cache, _fishes, _display, _headless, _headset)
    findings = [finding for check in checks for finding in check()]
    for finding in findings:
        mark = "ok  " if finding.good else "no  " if finding.needed_by else "--  "
        print(f"{mark}{finding.name:<24} {finding.text}")
    print()
    faults = [
        next((one for one in findings if not one.good and part in one.needed_by), None)
        for part in BASE
    ]
    for part, fault in zip(BASE, faults, strict=True):
        verdict = f"does not work: {fault.name}: {fault.text}" if fault else "works"
        print(f"{part:<10} {verdict}")
    for extra in EXTRAS:
        missing = " and ".join(missing_packages(extra))
        verdict = f"needs {missing}: run `{install_command(extra)}`" if missing else "works"
        print(f"{extra:<10} {verdict}")
    return 1 if any(faults) else 0


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
        return [Finding("packages", False, f"{', '.join(missing)}: run `{BASE_COMMAND}`")]
    return [Finding("packages", True, ", ".join(found))]


def _cache() -> list[Finding]:
    """Check the folder of compiled kernels; without one every start compiles again."""
    from numba.core import config

    import subsea
    from subsea.dive.warm_up import is_writable

    user_cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    beside = Path(subsea.__file__).parent
    places = [Path(config.CACHE_DIR)] if config.CACHE_DIR else [beside, user_cache]
    for place in places:
        if is_writable(place):
            return [Finding("cache of kernels", True, str(place), ())]
    text = f"not writable: {places[0]}; set NUMBA_CACHE_DIR to a folder that is"
    return [Finding("cache of kernels", False, text, ())]


def _fishes() -> list[Finding]:
    """Check every species; the shipped ones are needed."""
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
        needed_by = SEA if is_shipped(name) else ()
        own = "" if needed_by else f", own species in {own_species()}"
        try:
            load_species(name)
            file = repertoire_file(name)
            if not file.exists():
                raise UserError(f"not recorded yet: `subsea-capture record {name}`{own}")
            repertoire = read_repertoire(file)
            text = f"{len(repertoire.segments)} segments, {repertoire.source}{own}"
            findings.append(Finding(f"fish {name}", True, text, needed_by))
        except UserError as fault:
            findings.append(Finding(f"fish {name}", False, str(fault), needed_by))
    for name in hidden_names():
        text = f"{own_species() / name}.toml: a shipped species has this name; rename yours"
        findings.append(Finding(f"fish {name}", False, text, ()))
    return findings


def _headless() -> list[Finding]:
    from subsea.rendering.gl.context import headless_context

    try:
        context = headless_context()
    except UserError as fault:
        return [Finding("OpenGL, no window", False, f"{fault}", ("film",))]
    with context:  # a context that is current on this thread prevents windows from opening
        text = f"{context.info['GL_RENDERER']}, OpenGL {context.version_code / 100:.1f}"
    context.release()
    return [Finding("OpenGL, no window", True, text, ("film",))]


def _headset() -> list[Finding]:
    """The runtime and the headset; nothing without the extra, which has its own line."""
    if missing_packages("headset"):
        return []
    try:  # a process of its own: the runtime is a library that may print, wait or crash
        done = subprocess.run(
            [sys.executable, "-P", "-c", DESCRIBE_HEADSET],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            timeout=HEADSET_S,
            check=True,
        )
        # The runtime may print lines too; ours are the last ones.
        runtime, headset, missing = done.stdout.splitlines()[-3:]
    except subprocess.TimeoutExpired:
        return [_runtime_fault(f"no answer in {HEADSET_S:.0f} s")]
    except (subprocess.CalledProcessError, OSError, ValueError):
        return [_runtime_fault("it crashes")]
    findings = [Finding("OpenXR runtime", True, runtime, ())] if runtime else []
    if headset:
        findings.append(Finding("headset", True, headset, ()))
    if missing:
        findings.append(Finding("headset" if runtime else "OpenXR runtime", False, missing, ()))
    return findings


def _runtime_fault(text: str) -> Finding:
    return Finding("OpenXR runtime", False, f"{text}; start the software of the headset", ())


def _quality(renderer: str) -> Finding:
    """The quality at which a dive begins by default."""
    from subsea.dive.adaptive_quality import target_for
    from subsea.rendering.output.quality import LADDER, first_rung, name_of, on_software

    why = "computes pictures without a GPU" if on_software(renderer) else "is a GPU"
    text = f"auto begins at {name_of(LADDER[first_rung(renderer)])}: {renderer} {why}"
    return Finding("quality", True, f"{text}; holds {target_for(renderer):.3g} ms", ())


def _monitor(monitor: "Monitor") -> Finding:
    """The name and position by which a theatre file may refer to a monitor."""
    left, top = monitor.position
    rate = f" at {monitor.rate} Hz" if monitor.rate else ""
    text = f"{monitor!s}{rate}, position {left}, {top}"
    return Finding("monitor", True, text, ())


def _display() -> list[Finding]:
    """Display, monitors, and the OpenGL of hidden windows."""
    from subsea.view.stereo import OTHER_STEREO

    try:
        from subsea.rendering.gl.context import opengl_remedy, window_context
        from subsea.ui.monitors import on_display
        from subsea.ui.window import hidden_window
    except ImportError as fault:
        return [Finding("display", False, f"{import_fault(fault)}", DIVE)]
    try:
        with on_display() as display:
            findings = [
                Finding("display", True, display.platform, DIVE),
                *(_monitor(monitor) for monitor in display.monitors),
            ]
            with hidden_window() as loader:
                if loader is None:
                    text = opengl_remedy(INSTALL_WINDOW)
                    findings.append(Finding("OpenGL, window", False, text, DIVE))
                else:
                    context = window_context(loader)
                    text = f"{context.info['GL_RENDERER']}, {context.info['GL_VERSION']}"
                    findings.append(Finding("OpenGL, window", True, text, DIVE))
                    findings.append(_quality(context.info["GL_RENDERER"]))
            with hidden_window(stereo=True) as loader:
                text = "yes" if loader else f"no; use --display {OTHER_STEREO}"
                findings.append(Finding("quad-buffered stereo", bool(loader), text, ()))
            return findings
    except UserError as fault:
        return [Finding("display", False, str(fault), DIVE)]
