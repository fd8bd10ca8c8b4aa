"""A kiosk that a real systemd keeps up: its unit, its watchdog and its ends."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from subsea.base.system import ROOT
from subsea.cli.main import main
from tests.support.scenes import BARE
from tests.support.systemd import user_systemd
from tests.support.windows import User, display_pixels

UNIT = "subsea.service"
pytestmark = pytest.mark.timeout(900)  # a first start compiles


@pytest.fixture(scope="module")
def manager(display, tmp_path_factory):
    home = tmp_path_factory.mktemp("home")
    with user_systemd(home) as running:
        yield running


def install(manager, *lines):
    """Write the unit of a kiosk with more `lines`, and with shorter times than an operator's."""
    path = manager.units / UNIT
    words = ["dive", "--kiosk", "--quality", "low", "--scenario", str(BARE)]
    assert main([*words, "--write-unit", str(path)]) == 0
    # The test's home would have no compiled kernels.
    cache = os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")
    extra = [f"DISPLAY={os.environ['DISPLAY']}", f"PYTHONPATH={ROOT}", f"XDG_CACHE_HOME={cache}"]
    lines = [*(f'Environment="{one}"' for one in extra), *lines]
    lines += ["RestartSec=100ms", f"StandardError=append:{manager.units}/told"]
    (manager.units / f"{UNIT}.d").mkdir(exist_ok=True)
    (manager.units / f"{UNIT}.d/test.conf").write_text("\n".join(["[Service]", *lines, ""]))
    manager.control("daemon-reload")
    return manager.units / "told"


@pytest.fixture
def order(manager, tmp_path):
    """The file of orders to a stand-in for the dive, in the installed unit."""
    file, program = tmp_path / "order", Path(__file__).with_name("service_process.py")
    install(manager, "WatchdogSec=3", "ExecStart=", f"ExecStart={sys.executable} {program} {file}")
    return file


def sea():
    """True if the display shows the sea."""
    red, _, blue = display_pixels().reshape(-1, 3).mean(axis=0)
    return blue > red + 20.0 and display_pixels().std() > 4.0


def ended(manager):
    """The result of the unit once it has ended."""
    state = manager.until(UNIT, ActiveState="inactive")
    return state["Result"], state["MainPID"]


def test_systemd_accepts_the_unit(manager):
    install(manager)
    done = subprocess.run(
        ["systemd-analyze", "--user", "verify", str(manager.units / UNIT)],
        env=manager.environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.nightly
def test_a_kiosk_is_a_service_until_the_operator_ends_it(manager):
    told = install(manager)
    manager.control("start", UNIT)  # returns when the dive is ready
    assert sea()
    while "pictures a second" not in manager.state(UNIT)["StatusText"]:
        time.sleep(0.1)
    User.do("key", "ctrl+shift+q")
    assert ended(manager) == ("success", "0")
    assert "Traceback" not in told.read_text()


@pytest.mark.nightly
def test_a_service_comes_back_until_it_ends_in_order(manager, order):
    order.write_text("run")
    manager.control("start", UNIT)
    first = manager.state(UNIT)
    assert (first["ActiveState"], first["SubState"]) == ("active", "running")

    os.kill(int(first["MainPID"]), signal.SIGKILL)
    manager.until(UNIT, NRestarts="1")
    killed = manager.until(UNIT, ActiveState="active")
    assert killed["MainPID"] != first["MainPID"]

    time.sleep(3.5)  # longer than the watchdog's time: pictures keep it calm
    calm = manager.state(UNIT)
    assert (calm["NRestarts"], calm["MainPID"]) == ("1", killed["MainPID"])

    os.kill(int(calm["MainPID"]), signal.SIGSTOP)  # a window that shows no picture any more
    manager.until(UNIT, NRestarts="2")
    hung = manager.until(UNIT, ActiveState="active")
    assert hung["MainPID"] != calm["MainPID"]
    os.kill(int(hung["MainPID"]), signal.SIGUSR1)
    assert ended(manager) == ("success", "0")


@pytest.mark.nightly
def test_an_error_that_stays_is_not_tried_again_and_one_that_may_pass_is(manager, order):
    order.write_text("2")
    manager.control("start", UNIT, check=False)
    failed = manager.until(UNIT, ActiveState="failed")
    assert (failed["ExecMainStatus"], failed["NRestarts"]) == ("2", "0")
    manager.control("reset-failed", UNIT)
    order.write_text("75")
    manager.control("start", "--no-block", UNIT)
    assert manager.until(UNIT, NRestarts="2")["ActiveState"] == "activating"
    order.write_text("run")
    manager.until(UNIT, ActiveState="active")
    manager.control("stop", UNIT)
    assert ended(manager) == ("success", "0")


def test_a_unit_is_not_written_for_a_dive_that_cannot_begin(tmp_path, capsys):
    path = tmp_path / UNIT
    for words, line in (
        (["--scenario", "peacefull"], "did you mean 'peaceful'?"),
        (["--tour", "refe"], "refe"),
        (["--theatre", "three-computers", "--node", "top"], "top"),
    ):
        assert main(["dive", *words, "--write-unit", str(path)]) == 2
        told = capsys.readouterr().err
        assert line in told and len(told.splitlines()) == 1
        assert not path.exists()
    path.write_text("[Service]\nExecStart=/my/own\n")
    assert main(["dive", "--write-unit", str(path)]) == 2
    assert path.read_text().endswith("/my/own\n")
