"""Several processes compile what a dive needs, which then compiles nothing itself."""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from subsea.core.kernels import warm_up
from subsea.core.kernels.warm_up import kernels, precompile

START = """
import sys
import subsea
from numba.core import event
from numba.core.dispatcher import Dispatcher
from subsea.cli.main import main
from subsea.core.kernels.warm_up import _share_out, kernels

class Compiled(event.Listener):
    def on_start(self, event):
        function = event.data["dispatcher"].py_func
        if not function.__name__.startswith("make_"):
            sys.exit(f"{function.__module__}.{function.__name__} is compiled, but not in the list")

    def on_end(self, event):
        pass

missing = [number for number, kernel in enumerate(kernels()) if not kernel.is_kept]
_share_out(kernels(), missing, 2, print)
for kernel in kernels():
    if not kernel.is_kept:
        sys.exit(f"{kernel.name} is in the list, but cannot be compiled or kept")
with event.install_listener("numba:compile", Compiled()):
    code = main(["benchmark", "--frames", "2", "--size", "64x64"])
listed = {(kernel.name, kernel.signature) for kernel in kernels()}
for name, module in list(sys.modules.items()):
    for called in vars(module).values() if name.startswith("subsea.") else ():
        if isinstance(called, Dispatcher):
            function = called.py_func
            for types in called.overloads:  # compiled in here, or kept
                if (f"{function.__module__}.{function.__name__}", types) not in listed:
                    sys.exit(f"{function.__module__}.{function.__name__} is not in the list")
sys.exit(code)
"""


def test_a_dive_compiles_nothing_then():
    """Else `tools/list_kernels.py` is to be run."""
    run = subprocess.run([sys.executable, "-c", START], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr


def test_each_kernel_comes_after_those_that_it_calls():
    for number, kernel in enumerate(kernels()):
        assert all(called < number for called in kernel.calls)
        assert all(kernels()[called].inner for called in kernel.calls)


SOME = """
import subsea.core.kernels.warm_up as precompiling
from subsea.core.kernels.warm_up import kernels

SMALL = ("vector", "plus", "dot", "times", "norm", "unit")
some = [n for n, k in enumerate(kernels())
        if k.module == "subsea.geometry.vector" and k.name.rpartition(".")[2] in SMALL]
assert len(some) > 10
"""


def _program(tmp_path: Path, text: str, **how: object) -> "subprocess.Popen[str]":
    """A process of its own group, in which nothing is kept yet."""
    kept = {"NUMBA_CACHE_DIR": str(tmp_path / "kernels"), "XDG_CACHE_HOME": str(tmp_path)}
    return subprocess.Popen(
        [sys.executable, "-P", "-c", SOME + text], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, start_new_session=True, env=os.environ | kept, **how,
    )  # fmt: skip


def test_what_is_missing_is_shared_out(tmp_path):
    stranger = tmp_path / "folder" / "subsea.py"  # in the folder that it is started in
    stranger.parent.mkdir()
    stranger.write_text("raise SystemExit")
    program = _program(
        tmp_path,
        """
calls, asked = {n: kernels()[n].calls for n in some}, {}
ask = precompiling._ask
def asking(worker, number):
    asked.setdefault(worker.pid, []).append(number)
    assert not any(not kernels()[called].is_kept for called in calls[number] if called in calls)
    return ask(worker, number)
precompiling._ask = asking
precompiling._share_out(kernels(), some, 2, print)
assert all(kernels()[n].is_kept for n in some)
assert sorted(sum(asked.values(), [])) == some
assert len(asked) == 2
precompiling.FEW = 0
precompiling.kernels = lambda: [kernels()[n] for n in some]
precompiling.precompile(print, 2)  # it is all there
""",
        cwd=stranger.parent,
    )
    told, faults = program.communicate(timeout=200)
    assert program.returncode == 0, faults
    lines = told.splitlines()
    assert len(lines) == 10
    assert lines[0].startswith("compiling the fishes' code, once: 0 of ")


def test_of_two_at_once_one_waits_for_what_the_other_compiles(tmp_path):
    text = """
precompiling.FEW = 0
precompiling._missing = lambda known: [n for n in some if not known[n].is_kept]
precompiling.precompile(lambda line: print(line, flush=True), 2)
assert not precompiling._missing(kernels())
"""
    first = _program(tmp_path, text)
    assert "once: 0 of" in first.stdout.readline()
    second = _program(tmp_path, text)
    told, faults = second.communicate(timeout=200)
    assert second.returncode == 0, faults
    assert told == "waiting for another dive, which compiles the fishes' code\n"
    _, faults = first.communicate(timeout=200)
    assert first.returncode == 0, faults


def test_where_nothing_can_be_kept_nothing_is_compiled_in_vain(tmp_path):
    program = _program(
        tmp_path,
        "precompiling.precompile(print, 2)",
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0)),
    )
    told, faults = program.communicate(timeout=200)
    assert program.returncode == 0, faults
    first, then = told.splitlines()
    assert "once: 0 of" in first
    assert then == "compiling the fishes' code (a minute or more)"  # when they are called


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_nobody_is_left_who_compiles(tmp_path, number):
    """After Ctrl-C, which the whole group hears, or when the first process was killed."""
    program = _program(
        tmp_path,
        """
begin = precompiling._begun
def begun(stack):
    worker = begin(stack)
    print(worker.pid, flush=True)
    return worker
precompiling._begun = begun
precompiling._share_out(kernels(), some, 2, lambda line: print(line, flush=True))
""",
    )
    workers = [int(program.stdout.readline()) for _ in range(2)]
    program.stdout.readline()
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


def test_a_list_of_other_code_does_no_harm(tmp_path, monkeypatch):
    told: list[str] = []
    kernel = ["subsea.geometry.vector.no_longer_there", [0], False, []]
    other = tmp_path / "kernels.json"
    other.write_text(json.dumps({"types": ["float64"], "kernels": [kernel]}))
    monkeypatch.setattr(warm_up, "LIST", other)
    kernels.cache_clear()
    try:
        precompile(told.append, 2)
    finally:
        kernels.cache_clear()
    assert told == []


def test_a_single_core_compiles_when_a_kernel_is_called(monkeypatch):
    told: list[str] = []
    monkeypatch.setattr(warm_up.Kernel, "is_kept", False)
    precompile(told.append, 1)
    assert len(told) == 1
