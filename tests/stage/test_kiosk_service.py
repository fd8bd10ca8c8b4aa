"""A kiosk that a real systemd keeps up: its unit, its watchdog and its ends."""

import os
import signal
import subprocess
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


def install(manager, *words):
    """Write the unit of a kiosk; it differs from an operator's in shorter times only."""
    path = manager.units / UNIT
    assert main(["dive", "--kiosk", "--quality", "low", *words, "--write-unit", str(path)]) == 0
    # The test's home would have no compiled kernels.
    cache = os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")
    extra = [f"DISPLAY={os.environ['DISPLAY']}", f"PYTHONPATH={ROOT}", f"XDG_CACHE_HOME={cache}"]
    (manager.units / f"{UNIT}.d").mkdir(exist_ok=True)
    (manager.units / f"{UNIT}.d/test.conf").write_text(
        "[Service]\nRestartSec=1\nWatchdogSec=15\n"
        + "".join(f'Environment="{one}"\n' for one in extra)
        + f"StandardError=append:{manager.units}/told\n"
    )
    manager.control("daemon-reload")
    return manager.units / "told"


def sea():
    """True if the display shows the sea."""
    red, _, blue = display_pixels().reshape(-1, 3).mean(axis=0)
    return blue > red + 20.0 and display_pixels().std() > 4.0


def test_systemd_accepts_the_unit(manager):
    install(manager, "--scenario", str(BARE))
    done = subprocess.run(
        ["systemd-analyze", "--user", "verify", str(manager.units / UNIT)],
        env=manager.environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.nightly
def test_a_kiosk_comes_back_until_the_operator_ends_it(manager):
    told = install(manager, "--scenario", str(BARE))
    manager.control("start", UNIT)  # returns when the dive is ready
    assert sea()
    first = manager.state(UNIT)
    assert (first["ActiveState"], first["SubState"]) == ("active", "running")

    os.kill(int(first["MainPID"]), signal.SIGKILL)
    manager.until(UNIT, NRestarts="1")
    killed = manager.until(UNIT, ActiveState="active")
    assert killed["MainPID"] != first["MainPID"] and sea()

    time.sleep(20.0)  # longer than the watchdog's time: pictures keep it calm
    calm = manager.state(UNIT)
    assert (calm["NRestarts"], calm["MainPID"]) == ("1", killed["MainPID"])
    assert "pictures a second" in calm["StatusText"]

    os.kill(int(calm["MainPID"]), signal.SIGSTOP)  # a window that shows no picture any more
    manager.until(UNIT, NRestarts="2")
    hung = manager.until(UNIT, ActiveState="active")
    assert hung["MainPID"] != calm["MainPID"] and sea()

    User.do("key", "ctrl+shift+q")
    manager.until(UNIT, ActiveState="inactive")
    time.sleep(3.0)
    ended = manager.state(UNIT)
    assert (ended["ActiveState"], ended["Result"]) == ("inactive", "success")
    assert ended["MainPID"] == "0"
    assert "Traceback" not in told.read_text()


def test_an_operator_stops_it_without_a_failure(manager):
    install(manager, "--scenario", str(BARE))
    manager.control("start", UNIT)
    manager.control("stop", UNIT)
    ended = manager.state(UNIT)
    assert (ended["ActiveState"], ended["Result"]) == ("inactive", "success")


@pytest.mark.nightly
def test_an_error_that_stays_is_not_tried_again_and_one_that_may_pass_is(manager, tmp_path):
    scenario = tmp_path / "mine.toml"
    scenario.write_text(BARE.read_text())
    install(manager, "--scenario", str(scenario))
    scenario.unlink()
    manager.control("start", UNIT, check=False)
    time.sleep(3.0)
    ended = manager.state(UNIT)
    assert (ended["ActiveState"], ended["ExecMainStatus"], ended["NRestarts"]) == (
        "failed", "2", "0",
    )  # fmt: skip
    manager.control("reset-failed", UNIT)

    scenario.write_text(BARE.read_text())
    drop_in = manager.units / f"{UNIT}.d/test.conf"
    right = drop_in.read_text()
    drop_in.write_text(right.replace(f"DISPLAY={os.environ['DISPLAY']}", "DISPLAY=:4711"))
    manager.control("daemon-reload")
    manager.control("start", "--no-block", UNIT)
    late = manager.until(UNIT, NRestarts="2")
    assert late["ActiveState"] == "activating"
    drop_in.write_text(right)
    manager.control("daemon-reload")
    manager.until(UNIT, ActiveState="active")
    assert sea()
    manager.control("stop", UNIT)


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
