"""Several processes compile the kernels of a dive; the dive compiles nothing itself."""

import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from subsea.dive import warm_up as module
from subsea.dive.warm_up import JOBS, warm_up
from subsea.kernels.cache import processor, versions
from tests.support.daily import only

# Prints the kernels that Python calls, with types, after the lines of a program. Kernels that only
# kernels call are compiled with these.
CALLED = """
import gc
from numba.core.dispatcher import Dispatcher
from subsea.base.source_stamp import ROOT
from subsea.cli.main import main
from subsea.dive.warm_up import JOBS
{}
for kernel in gc.get_objects():
    if isinstance(kernel, Dispatcher):
        function = kernel.py_func
        if function.__code__.co_filename.startswith(str(ROOT / "subsea")):
            for types in kernel.overloads:
                print("called", function.__module__, function.__name__, *types)
"""
# These are compiled with the kernels that call them; tests/test_shipped_wheel.py finds others.
CALLEES = ("ends", "ends_world", "plus", "ray_meets_rock", "rotate", "store")
WARM_UP = "for job in JOBS.values(): job()"
DIVE = """
assert main(["simulate", "--scenario", "preying", "--ticks", "3", "--out", "sea.h5"]) == 0
for scenario in "peaceful", "preying":
    film = ["film", f"{scenario}.mp4", "--scenario", scenario, "--seconds", "0.1"]
    assert main([*film, "--size", "64x64"]) == 0
"""
# Short jobs replace those of a dive: these tests cover the processes.
SHORT = """
import sys
from subsea.dive import warm_up
from subsea.dive.warm_up import warm_up as run
from tests.support.short_job import run as run_short
warm_up.run_job = run_short
told = lambda line: print(line, flush=True)
"""


def _program(tmp_path: Path, text: str, **how: object) -> "subprocess.Popen[str]":
    """A process in its own group, with empty caches."""
    places = {
        "NUMBA_CACHE_DIR": str(tmp_path / "kernels"), "XDG_CACHE_HOME": str(tmp_path),
        "SHORT_JOBS": str(tmp_path / "jobs"),
    }  # fmt: skip
    return subprocess.Popen(
        [sys.executable, "-P", "-c", SHORT + text], stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True, start_new_session=True, env=os.environ | places, **how,
    )  # fmt: skip


def _jobs(tmp_path: Path) -> list[str]:
    return sorted(line for line in (tmp_path / "jobs").read_text().splitlines())


def _called(folder: Path, program: str) -> set[str]:
    """The kernels that a program calls, with nothing kept that kernels have made."""
    folder.mkdir()
    run = subprocess.run(
        [sys.executable, "-P", "-c", CALLED.format(program)], cwd=folder, capture_output=True,
        text=True, check=False, env=os.environ | {"XDG_CACHE_HOME": str(folder)},
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    called = {line for line in run.stdout.splitlines() if line.startswith("called ")}
    return {line for line in called if line.split()[2] not in CALLEES}


@pytest.mark.nightly  # it depends on which kernels are kept when it begins
def test_a_dive_calls_no_kernel_that_is_not_compiled_in_advance(tmp_path):
    dive = _called(tmp_path / "dive", DIVE)
    assert len(dive) > 50
    late = sorted(dive - _called(tmp_path / "warm-up", WARM_UP))
    assert not late, "\n".join(late)


def test_each_part_is_compiled_once_and_then_no_more(tmp_path):
    stranger = tmp_path / "folder" / "subsea.py"  # in the current folder
    stranger.parent.mkdir()
    stranger.write_text("raise SystemExit")
    program = _program(
        tmp_path, "run(told, processes=2); run(told, processes=2)", cwd=stranger.parent
    )
    told, faults = program.communicate(timeout=200)
    assert program.returncode == 0, faults
    assert told.splitlines() == [
        f"compiling the fishes' code, once: {done}/{len(JOBS)}" for done in range(len(JOBS) + 1)
    ]
    assert _jobs(tmp_path) == sorted(JOBS)


@pytest.mark.nightly
def test_of_two_at_once_one_waits_for_what_the_other_compiles(tmp_path):
    first = _program(tmp_path, "warm_up.JOBS = {'waiting': None}; run(told, processes=2)")
    assert "once: 0/" in first.stdout.readline()
    second = _program(tmp_path, "run(told, processes=2)")
    assert second.stdout.readline() == "waiting for another dive, which compiles the fishes' code\n"
    (tmp_path / "jobs-go").touch()
    for program in (first, second):
        _, faults = program.communicate(timeout=200)
        assert program.returncode == 0, faults
    assert _jobs(tmp_path) == ["waiting"]


def test_where_nothing_can_be_cached_nothing_is_compiled_in_vain(tmp_path):
    program = _program(
        tmp_path,
        "run(told, processes=2)",
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0)),
    )
    told, faults = program.communicate(timeout=200)
    assert program.returncode == 0, faults
    assert told == "compiling the fishes' code (a minute or more)\n"  # on the first call


@pytest.mark.parametrize("number", only([signal.SIGINT], [signal.SIGINT, signal.SIGKILL]))
def test_nobody_is_left_who_compiles(tmp_path, number):
    """After Ctrl-C, sent to the whole group, or after a kill of the first process."""
    program = _program(
        tmp_path,
        """
warm_up.JOBS = {"endless": None, "endless too": None}
run(told, processes=2)
""",
    )
    program.stdout.readline()  # on the progress
    workers = [int(program.stdout.readline()) for _ in range(2)]
    if number == signal.SIGINT:
        os.killpg(program.pid, number)
    else:
        program.kill()
    program.communicate(timeout=60)
    assert program.returncode != 0
    end = time.monotonic() + 60
    while any(_lives(worker) for worker in workers):
        assert time.monotonic() < end
        time.sleep(0.05)


def _lives(process: int) -> bool:
    try:
        return ") Z" not in Path(f"/proc/{process}/stat").read_text()
    except OSError:
        return False


def test_a_part_that_fails_leaves_the_rest_to_the_dive(tmp_path):
    program = _program(tmp_path, "warm_up.JOBS = {'failing': None}; run(told, processes=2)")
    told, faults = program.communicate(timeout=200)
    assert program.returncode == 0, faults
    assert told.splitlines()[-1] == "compiling the fishes' code (a minute or more)"


def test_a_single_core_compiles_when_a_kernel_is_called(monkeypatch, tmp_path):
    told: list[str] = []
    monkeypatch.setattr(module, "_marker", lambda: tmp_path / "warm-never")
    warm_up(told.append, processes=1)
    assert told == ["compiling the fishes' code (a minute or more)"]


def test_kernels_of_another_python_or_processor_have_another_marker(monkeypatch):
    names = {module._marker().name}
    for name, other in (
        ("versions", {**versions(), "python": "cpython-399"}),
        ("processor", processor()._replace(features="+sse2")),
        ("code_stamp", "other"),
    ):
        with monkeypatch.context() as patched:
            patched.setattr(module, name, lambda other=other: other)
            names.add(module._marker().name)
    assert len(names) == 4


def test_shipped_kernels_are_not_compiled(monkeypatch, tmp_path):
    told: list[str] = []
    monkeypatch.setattr(module, "_marker", lambda: tmp_path / "warm-never")
    monkeypatch.setattr(module, "shipped_code", module.code_stamp)
    warm_up(told.append, processes=1)
    assert told == []
