"""The doctor finds installed and missing parts."""

import os
import subprocess
import sys


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


def test_with_a_display_a_dive_is_possible(display):
    code, lines = doctor(DISPLAY=display)
    assert code == 0, lines
    assert lines[-1] == "a dive is possible"
    for name in ("Python", "packages", "fish fusilier", "OpenGL, window", "monitor", "display"):
        assert any(line.startswith("ok") and name in line for line in lines), name


def test_it_tells_with_what_quality_a_dive_begins_and_why(display):
    _, lines = doctor(DISPLAY=display)
    [line] = [line for line in lines if " quality " in line]
    assert "auto begins at low: llvmpipe" in line
    assert line.endswith("computes pictures without a GPU; holds 50 ms")


def test_without_a_display_it_says_what_still_works():
    code, lines = doctor()
    assert code == 1
    assert any(line.startswith("no") and "subsea film" in line for line in lines)


def test_an_unwritable_cache_is_told(tmp_path):
    _, lines = doctor(NUMBA_CACHE_DIR="/proc/nowhere")
    assert any("NUMBA_CACHE_DIR" in line for line in lines)
