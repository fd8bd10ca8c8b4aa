"""Jobs in processes that may die."""

import multiprocessing

import pytest

from subsea.base.errors import UserError
from subsea.jobs.workers import MAX_ATTEMPTS, process_pool, serial
from tests.support import work


def no_check():
    pass


def test_processes_give_the_results_of_this_process(tmp_path, monkeypatch):
    for name in ("socket.py", "tempfile.py", "subsea.py", "tests.py"):  # never executed
        (tmp_path / name).write_text(f"open({str(tmp_path / 'executed')!r}, 'w')\n")
    monkeypatch.chdir(tmp_path)
    jobs = {f"job {k}": k for k in range(5)}
    expected = {name: k * k for name, k in jobs.items()}
    assert dict(serial(work.square, jobs, no_check)) == expected
    assert dict(process_pool(2)(work.square, jobs, no_check)) == expected
    assert not (tmp_path / "executed").exists()
    assert not multiprocessing.active_children()


def test_a_crash_costs_only_its_job(tmp_path):
    wanted = {"sound": 0, "once": 1, "always": MAX_ATTEMPTS + 1}
    jobs = {name: (str(tmp_path / name), count) for name, count in wanted.items()}
    found = dict(process_pool(2)(work.crash, jobs, no_check))
    assert found == {"sound": 0, "once": 1, "always": None}
    assert (tmp_path / "always").read_text() == MAX_ATTEMPTS * "x"
    assert (tmp_path / "once").read_text() == "x"  # made again once


def test_an_error_arrives_as_it_is_and_ends_the_processes():
    with pytest.raises(UserError) as fault:
        dict(process_pool(1)(work.refuse, {"a": 7}, no_check))
    assert str(fault.value) == "7: refused"
    assert not multiprocessing.active_children()


def test_an_interruption_ends_the_processes_at_once():
    def check():
        if multiprocessing.active_children():
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        dict(process_pool(2)(work.sleep, {"a": 1000.0}, check))
    assert not multiprocessing.active_children()
