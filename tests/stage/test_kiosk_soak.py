"""A kiosk whose power is cut, by `subsea soak --kiosk`."""

import re
import sys
from pathlib import Path

import pytest

from subsea.cli.main import main
from subsea.stage import kiosk_soak
from tests.support.scenes import BARE

pytestmark = pytest.mark.timeout(900)  # a first start compiles


@pytest.mark.nightly
def test_a_kiosk_survives_cuts_of_the_power_and_a_full_disk(display, capsys, monkeypatch):
    monkeypatch.setattr(kiosk_soak, "RUNS_S", 20.0)
    words = ["soak", "--kiosk", "--minutes", "1", "--seed", "3", "--scenario", str(BARE)]
    assert main(words) == 0, capsys.readouterr()
    out = capsys.readouterr().out
    starts, full, saved = map(
        int, re.findall(r"(\d+) starts?, (\d+) with a full disk, (\d+) with", out)[0]
    )
    assert starts >= 2 and full >= 1 and saved < starts
    assert out.endswith("sound\n")


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("order", "full", "code", "faults"),
    [
        ("run", False, None, []),
        pytest.param("run", True, None, [], marks=pytest.mark.nightly),  # with a full disk
        ("hang", False, None, ["no picture for 1 s"]),
        ("2", False, 2, []),
    ],
)
def test_a_start_is_watched(tmp_path, monkeypatch, order, full, code, faults):
    monkeypatch.setattr(kiosk_soak, "STILL_S", 1.0 if faults else 60.0)
    (tmp_path / "order").write_text(order)
    program = Path(__file__).with_name("service_process.py")
    kiosk = kiosk_soak._Kiosk([sys.executable, str(program), f"{tmp_path}/order"], tmp_path, full)
    try:
        assert kiosk.heard("READY=1", 120.0) == (code is None), kiosk.last_line()
        assert kiosk.process.poll() == code
        if code is None:
            assert kiosk_soak._watch(kiosk, 1.5) == faults
            assert kiosk_soak._end(kiosk) == []
    finally:
        kiosk.cut()


@pytest.mark.nightly
def test_a_kiosk_that_cannot_begin_is_a_finding(capsys, monkeypatch, display):
    monkeypatch.setenv("DISPLAY", ":4711")
    assert main(["soak", "--kiosk", "--minutes", "0.1", "--scenario", str(BARE)]) == 1
    assert "ended with 75: subsea: no display" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words",
    [["--kiosk", "--json", "x.json"], ["--kiosk", "--set", "seed=1"], ["--playlist", "show.toml"]],
)
def test_options_that_do_not_go_together_are_refused(words, capsys):
    assert main(["soak", *words]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_a_broken_file_is_a_fault(tmp_path):
    assert kiosk_soak._faults_of_files(tmp_path) == []
    (tmp_path / "show.state").write_bytes(b"\x85half of a state")
    [fault] = kiosk_soak._faults_of_files(tmp_path)
    assert "show.state is not whole" in fault
