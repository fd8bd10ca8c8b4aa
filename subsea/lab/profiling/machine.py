"""The machine of a measurement, and its speed meanwhile."""

import os
import platform
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

import subsea
from subsea.base.processors import cores

PACKAGES = "numpy", "numba", "moderngl"
REFERENCE_SINES = 1 << 15  # on each core: about a third of a millisecond


def describe_machine(graphics: Mapping[str, str]) -> dict[str, Any]:
    """Data to cite with a figure; `graphics` is the `info` of an OpenGL context.

    `load` is the load average of the last minute, None where the system has none.
    """
    return {
        "cpu": _processor(),
        "cores": cores(),
        "load": round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None,
        "system": platform.platform(),
        "driver": graphics["GL_VERSION"],
        "python": platform.python_version(),
        "packages": {name: version(name) for name in PACKAGES},
        "commit": _commit(Path(subsea.__file__).parents[1]),
    }


def machine_line(machine: Mapping[str, Any]) -> str:
    """The machine in one line."""
    count = f"{machine['cores']} cores" if machine["cores"] > 1 else "1 core"
    load = "" if machine["load"] is None else f", load {machine['load']}"
    commit = f"; commit {machine['commit']}" if machine["commit"] else ""
    return f"{machine['cpu']}, {count}{load}; OpenGL {machine['driver']}{commit}"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor() or platform.machine())


def _commit(checkout: Path) -> str | None:
    """The commit of a checkout, with "+" if files differ from it; None elsewhere."""
    if not (checkout / ".git").exists():
        return None
    ask = ["git", "-C", str(checkout), "describe", "--always", "--exclude=*", "--dirty=+"]
    try:
        told = subprocess.run(ask, capture_output=True, text=True, check=False, timeout=10)
    except (OSError, subprocess.TimeoutExpired):
        return None
    return told.stdout.strip() or None


@contextmanager
def reference_work() -> Iterator[Callable[[], float]]:
    """Yield a function that does a small fixed work on every core and returns its time, s.

    Other programs slow it down as they slow down frames, independently of our version.
    """
    number = cores()
    work = [np.linspace(0.0, 1.0, REFERENCE_SINES) for _ in range(number)]
    out = [np.empty(REFERENCE_SINES) for _ in range(number)]

    def measure() -> float:
        start = time.perf_counter()
        list(pool.map(np.sin, work, out))
        return time.perf_counter() - start

    with ThreadPoolExecutor(number) as pool:
        yield measure
