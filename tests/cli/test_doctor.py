"""The doctor finds installed and missing parts."""

import os
import subprocess
import sys

import pytest

from subsea.cli import doctor as doctor_command
from subsea.cli.main import main


def doctor(**environment):
    """Exit code and the lines of the report."""
    base = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    done = subprocess.run(
        [sys.executable, "-m", "subsea", "doctor"],
        capture_output=True,
        text=True,
        env=base | environment,
        timeout=120,
        check=False,
    )
    assert not done.stderr
    return done.returncode, done.stdout.splitlines()


@pytest.mark.nightly
def test_with_a_display_a_dive_is_possible_at_a_quality_for_the_renderer(display):
    code, lines = doctor(DISPLAY=display)
    assert code == 0, lines
    for part in ("dive", "film", "simulate", "capture"):
        assert f"{part:<10} works" in lines
    for name in ("Python", "packages", "fish fusilier", "OpenGL, window", "monitor", "display"):
        assert any(line.startswith("ok") and name in line for line in lines), name
    [line] = [line for line in lines if " quality " in line]
    assert "auto begins at low: llvmpipe" in line
    assert line.endswith("computes pictures without a GPU; holds 50 ms")


@pytest.mark.nightly
def test_without_a_display_it_says_what_still_works():
    code, lines = doctor()
    assert code == 1
    assert any(line.startswith("no") and "subsea film" in line for line in lines)
    assert any(line.startswith("dive       does not work: display: ") for line in lines)
    for part in ("film", "simulate", "capture"):
        assert f"{part:<10} works" in lines


@pytest.mark.nightly
def test_an_unwritable_cache_is_reported(tmp_path):
    _, lines = doctor(NUMBA_CACHE_DIR="/proc/nowhere")
    assert any("NUMBA_CACHE_DIR" in line for line in lines)


def test_a_missing_extra_has_a_line_and_does_not_change_the_code(monkeypatch, capsys):
    for check in ("_python", "_packages", "_cache", "_fishes", "_display", "_headless"):
        monkeypatch.setattr(doctor_command, check, list)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert main(["doctor"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "plot       needs matplotlib: run `make bench`" in lines
    assert "cluster    needs Dask: run `.venv/bin/uv sync --inexact --extra cluster`" in lines
    fault = doctor_command.Finding("OpenGL, no window", False, "no driver", ("film",))
    monkeypatch.setattr(doctor_command, "_headless", lambda: [fault])
    assert main(["doctor"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "no  OpenGL, no window        no driver"
    assert "film       does not work: OpenGL, no window: no driver" in lines
    assert "dive       works" in lines
