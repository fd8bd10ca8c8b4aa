"""Parts of the rows, and the threads that run them."""

import os
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.kernels.threads import (
    PARTS_EACH,
    cut,
    run_all,
    share,
    side_by_side,
    threads,
    use_threads,
)


@pytest.fixture(params=[1, 2, 3, 16])
def number(request):
    use_threads(request.param)
    yield request.param
    use_threads()


@pytest.fixture
def two():
    use_threads(2)
    yield
    use_threads()


@given(st.integers(0, 400), st.integers(1, 90), st.sampled_from([1, 2, 3, 16]))
def test_the_parts_are_all_rows_in_order_and_none_is_small(rows, least, number):
    use_threads(number)
    parts = []
    try:
        for task in cut(lambda part: parts.append(part), np.arange(rows), least):
            task()
    finally:
        use_threads()
    assert np.concatenate(parts).tolist() == list(range(rows))
    assert len(parts) <= max(PARTS_EACH * number, 1)
    assert len(parts) == 1 or min(map(len, parts)) >= least


def test_every_row_is_worked_on_once(number):
    counts = np.zeros(1000)

    def count(part):
        counts[part] += 1

    for _ in range(20):
        share(count, np.arange(1000), 10)
    assert (counts == 20).all()


def test_a_small_number_of_rows_stays_in_the_calling_thread(number):
    seen = []
    share(lambda part: seen.append(threading.get_ident()), np.arange(19), 10)
    assert seen == [threading.get_ident()]


def test_results_are_in_the_order_of_the_calls(number):
    calls = [lambda k=k: (time.sleep(0.002 * (5 - k)), k)[1] for k in range(5)]
    assert side_by_side(calls) == list(range(5))
    assert side_by_side(calls, shared=False) == list(range(5))


def test_tasks_run_side_by_side(two):
    meeting = threading.Barrier(2, timeout=20.0)
    run_all([meeting.wait] * 2)
    with pytest.raises(threading.BrokenBarrierError):  # one after another they do not meet
        meeting.reset()
        threading.Timer(0.1, meeting.abort).start()
        run_all([meeting.wait] * 2, shared=False)


def test_groups_are_passed_to_every_part(number):
    given, seen = object(), []
    share(lambda part, group: seen.append(group), np.arange(8), 1, given)
    assert set(seen) == {given}


def test_the_first_fault_is_raised_once_all_have_ended(number):
    """The same as with one thread, whichever fails first."""
    ended = []

    def task(k):
        def run():
            time.sleep(0.01 if k == 2 else 0.0)
            if k >= 2:
                raise ValueError(k)
            ended.append(k)

        return run

    for _ in range(10):
        ended.clear()
        with pytest.raises(ValueError, match=r"^2$"):
            run_all([task(k) for k in range(8)])
        assert sorted(ended) == [0, 1]
    assert side_by_side([lambda: 1, lambda: 2]) == [1, 2]  # the threads go on


def test_ctrl_c_waits_for_the_other_threads(two):
    """No kernel writes into the arrays of a world that is being given up."""
    helping, written = threading.Event(), []
    caller = threading.get_ident()

    def work():
        if threading.get_ident() == caller:
            assert helping.wait(20.0)
            raise KeyboardInterrupt
        helping.set()
        time.sleep(0.1)
        written.append(True)

    with pytest.raises(KeyboardInterrupt):
        run_all([work, work])
    assert written == [True]


def test_tasks_may_run_tasks(number):
    counts = np.zeros(64)

    def inner(part):
        counts[part] += 1

    def outer(part):
        share(inner, part, 1)

    share(outer, np.arange(64), 4)
    assert (counts == 1).all()


def test_two_threads_may_share_work_at_the_same_time(two):
    counts = np.zeros((2, 500))

    def count(row):
        def add(part):
            counts[row, part] += 1

        for _ in range(50):
            share(add, np.arange(500), 5)

    both = [threading.Thread(target=count, args=(row,)) for row in range(2)]
    for one in both:
        one.start()
    for one in both:
        one.join()
    assert (counts == 50).all()


@pytest.mark.parametrize("text", ["0", "-1", "two", "1.5", "257"])
def test_a_wrong_number_of_threads_is_one_line(monkeypatch, text):
    monkeypatch.setenv("SUBSEA_THREADS", text)
    with pytest.raises(UserError, match=f"SUBSEA_THREADS is '{text}', expected a whole number"):
        use_threads()


def test_the_number_of_threads_is_a_setting_of_the_environment(monkeypatch):
    monkeypatch.setenv("SUBSEA_THREADS", "5")
    use_threads()
    assert threads() == 5
    monkeypatch.delenv("SUBSEA_THREADS")
    use_threads()
    assert threads() >= 1


FORK = """
import os
import numpy as np
from subsea.kernels.threads import share, use_threads
use_threads(2)
counts = np.zeros(100)
def count(part):
    counts[part] += 1
share(count, np.arange(100), 5)
child = os.fork()
share(count, np.arange(100), 5)
if not child:
    os._exit(0 if (counts == 2).all() else 1)
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), (counts == 2).all())
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no processes to fork")
def test_a_forked_process_has_threads_of_its_own():
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", FORK],
        capture_output=True, text=True, timeout=60, check=True,
    )  # fmt: skip
    assert done.stdout.split() == ["0", "True"]
