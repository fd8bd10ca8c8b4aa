"""Ctrl-C and SIGTERM between two steps, and where it is safe."""

import signal
import time

import glfw
import pytest

from subsea.base import interrupts
from subsea.base.command_line import run_command
from subsea.base.interrupts import deferred_interrupts


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_is_raised_once_when_checked(number):
    before = signal.getsignal(number)
    with deferred_interrupts() as check:
        check()
        signal.raise_signal(number)  # comes up nowhere by itself
        with pytest.raises(KeyboardInterrupt):
            check()
        check()
    assert signal.getsignal(number) is before


def test_the_old_handlers_are_restored_after_a_fault():
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(ZeroDivisionError), deferred_interrupts():
        raise ZeroDivisionError
    assert signal.getsignal(signal.SIGINT) is before


CALLED = """
def call(signal, number, steps):
    signal.raise_signal(number)
    steps.append("called")
    return signal
"""


def called_by_c(module):
    """A function of a module whose exceptions are lost."""
    names = {"__name__": module}
    exec(CALLED, names)
    return names["call"]


def wait():
    for _ in range(200):
        time.sleep(0.01)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("module", ["llvmlite.binding.ffi", "subsea.kernels.struct_ref"])
def test_an_interrupt_in_a_callback_is_raised_after_it(module, number, capsys):
    steps = []

    def work():
        called_by_c(module)(signal, number, steps)
        wait()
        return 0

    before = signal.getsignal(number)
    assert run_command("subsea", work) == 130
    assert steps == ["called"]
    assert capsys.readouterr().err == "subsea: interrupted\n"
    assert signal.getsignal(number) is before


def test_a_destructor_is_not_interrupted(recwarn):
    class Held:
        def __del__(self):
            called_by_c("any")(signal, signal.SIGINT, steps)

    steps = []

    def work():
        Held()
        wait()
        return 0

    assert run_command("subsea", work) == 130
    assert steps == ["called"] and not recwarn.list


def test_a_callback_of_a_window_is_not_interrupted(capsys):
    def work():
        report = glfw._GLFWerrorfun(
            lambda code, text: called_by_c("any")(signal, signal.SIGINT, steps)
        )
        report(0, b"")
        wait()
        return 0

    steps = []
    assert run_command("subsea", work) == 130
    assert steps == ["called"]
    assert capsys.readouterr().err == "subsea: interrupted\n"


def test_a_second_interrupt_does_not_stop_the_clean_up():
    steps = []

    def work():
        try:
            signal.raise_signal(signal.SIGTERM)
        finally:
            signal.raise_signal(signal.SIGINT)
            steps.append("cleaned up")
        return 0

    assert run_command("subsea", work) == 130
    assert steps == ["cleaned up"]


def test_a_process_without_a_safe_point_ends(monkeypatch):
    class EndedError(Exception):
        pass

    def end(code):
        raise EndedError(code)

    monkeypatch.setattr(interrupts.os, "_exit", end)
    monkeypatch.setattr(interrupts, "LIMIT_S", 0.05)
    names = {"__name__": "numba.core", "wait": wait, "call": called_by_c("numba")}
    exec("def compile(signal, number):\n    call(signal, number, [])\n    wait()\n", names)
    with pytest.raises(EndedError, match="130"):
        run_command("subsea", lambda: names["compile"](signal, signal.SIGINT))


def test_an_ignored_signal_stays_ignored():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        assert run_command("subsea", lambda: signal.raise_signal(signal.SIGINT) or 0) == 0
    finally:
        signal.signal(signal.SIGINT, before)
