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

DIVE = """
import sys
from numba.core import event
from subsea.cli.main import main
from subsea.base.source_stamp import ROOT
from subsea.dive.warm_up import warm_up

class Compiled(event.Listener):
    def on_start(self, event):
        function = event.data["dispatcher"].py_func
        if function.__code__.co_filename.startswith(str(ROOT / "subsea")):
            compiled.append(f"{function.__module__}.{function.__name__}")

    def on_end(self, event):
        pass

compiled = []
warm_up(print)
with event.install_listener("numba:compile", Compiled()):
    code = main(["benchmark", "--frames", "2", "--size", "64x64"])
print(sorted(set(compiled)))
sys.exit(code)
"""
# Short jobs replace those of a dive: these tests cover the processes.
SHORT = """
import sys
from subsea.dive import warm_up
from subsea.dive.warm_up import warm_up as run
warm_up.MODULE = "tests.support.short_job"
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


def test_a_dive_compiles_nothing_then():
    run = subprocess.run([sys.executable, "-c", DIVE], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert run.stdout.splitlines()[-1] == "[]"


def test_each_part_is_compiled_once_and_then_no_more(tmp_path):
    stranger = tmp_path / "folder" / "subsea.py"  # in the current folder
    stranger.parent.mkdir()
    stranger.write_text("raise SystemExit")
    program = _program(tmp_path, "run(told, processes=2, first=lambda: told('first'));"
                       "run(told, processes=2)", cwd=stranger.parent)  # fmt: skip
    told, faults = program.communicate(timeout=200)
    assert program.returncode == 0, faults
    lines = told.splitlines()
    place = lines.index("first")  # once what draws a world is compiled
    assert place > 0
    del lines[place]
    assert lines == [
        f"compiling the fishes' code, once: {done}/{len(JOBS)}" for done in range(len(JOBS) + 1)
    ]
    assert _jobs(tmp_path) == sorted(JOBS)


def test_of_two_at_once_one_waits_for_what_the_other_compiles(tmp_path):
    first = _program(tmp_path, "run(told, processes=2)")
    assert "once: 0/" in first.stdout.readline()
    second = _program(tmp_path, "run(told, processes=2)")
    told, faults = second.communicate(timeout=200)
    assert second.returncode == 0, faults
    assert told == "waiting for another dive, which compiles the fishes' code\n"
    _, faults = first.communicate(timeout=200)
    assert first.returncode == 0, faults
    assert _jobs(tmp_path) == sorted(JOBS)


def test_where_nothing_can_be_cached_nothing_is_compiled_in_vain(tmp_path):
    program = _program(
        tmp_path,
        "run(told, processes=2)",
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0)),
    )
    told, faults = program.communicate(timeout=200)
    assert program.returncode == 0, faults
    assert told == "compiling the fishes' code (a minute or more)\n"  # on the first call


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_nobody_is_left_who_compiles(tmp_path, number):
    """After Ctrl-C, sent to the whole group, or after a kill of the first process."""
    program = _program(
        tmp_path,
        """
start = warm_up._start
def started(job, stack):
    worker = start("endless", stack)
    print(worker.pid, flush=True)
    return worker
warm_up._start = started
run(told, processes=2)
""",
    )
    program.stdout.readline()
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


def test_a_check_that_raises_ends_it(monkeypatch, tmp_path):
    def leave() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "_marker", lambda: tmp_path / "warm-never")
    monkeypatch.setattr(module, "MODULE", "tests.support.short_job")
    with pytest.raises(KeyboardInterrupt):
        warm_up(check=leave, processes=2)
    assert not (tmp_path / "warm-never").exists()
