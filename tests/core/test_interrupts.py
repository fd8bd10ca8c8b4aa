"""Ctrl-C between two steps."""

import signal

import pytest

from subsea.core.interrupts import deferred_interrupts


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_comes_up_when_asked_for_and_only_once(number):
    before = signal.getsignal(number)
    with deferred_interrupts() as check:
        check()
        signal.raise_signal(number)  # comes up nowhere by itself
        with pytest.raises(KeyboardInterrupt):
            check()
        check()
    assert signal.getsignal(number) is before


def test_the_old_handlers_are_back_after_a_fault():
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(ZeroDivisionError), deferred_interrupts():
        raise ZeroDivisionError
    assert signal.getsignal(signal.SIGINT) is before
