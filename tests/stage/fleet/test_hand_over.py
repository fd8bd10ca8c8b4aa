"""A command asks the dive of the master for its address, and gives it back."""

import subprocess
import sys
import threading
import time

import pytest

from subsea.base.errors import UserError
from subsea.stage.fleet import hand_over
from subsea.stage.fleet.hand_over import address_wanted, is_wanted, wait_until_free

HERE, THERE = "127.0.0.1:5560", "127.0.0.1:5561"
HOLDS = "from subsea.stage.fleet.hand_over import *\n"
HOLDS += f"with address_wanted({HERE!r}): print('held', flush=True); time.sleep(60)"


@pytest.fixture(autouse=True)
def state(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    return tmp_path


def test_an_address_is_wanted_within_the_block(state):
    assert not is_wanted(HERE) and not list(state.iterdir())
    with address_wanted(HERE):
        assert is_wanted(HERE) and not is_wanted(THERE)
    assert not is_wanted(HERE)


def test_a_dive_waits_until_it_is_free():
    told, done = [], []

    def wait():
        wait_until_free(HERE, told.append)
        done.append(True)

    with address_wanted(HERE):
        thread = threading.Thread(target=wait)
        thread.start()
        time.sleep(0.2)
        assert told and not done
    thread.join(30.0)
    assert done and len(told) == 1
    wait_until_free(HERE, told.append)
    assert len(told) == 1


def test_two_commands_do_not_work_at_once(monkeypatch):
    monkeypatch.setattr(hand_over, "TRIES", 2)
    with (
        address_wanted(HERE),
        pytest.raises(UserError, match="another `subsea fleet` works"),
        address_wanted(HERE),
    ):
        pass


def test_the_end_of_a_process_frees_it():
    command = [sys.executable, "-c", HOLDS]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"held\n" and is_wanted(HERE)
        process.kill()
        process.wait()
    assert not is_wanted(HERE)
