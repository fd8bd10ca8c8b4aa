"""How a dive ends: by itself, by a key, or before it began."""

import os
import subprocess
import sys
import time

import pytest

DIVE = [sys.executable, "-m", "subsea", "dive", "--size", "320x240"]


def test_it_ends_by_itself(display):
    done = subprocess.run([*DIVE, "--seconds", "0.5"], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr


def test_a_key_for_it_is_a_clean_exit(display, tmp_path):
    settings = tmp_path / "settings.toml"
    settings.write_text('[controls]\nleave = ["X"]\n')
    command = [*DIVE, "--seconds", "100", "--settings", str(settings)]
    running = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        while running.poll() is None:
            subprocess.run(["xdotool", "key", "x"], check=True, timeout=20)
            time.sleep(0.2)
        assert running.returncode == 0
    finally:
        running.kill()
        _, err = running.communicate()
    assert "Traceback" not in err


@pytest.mark.parametrize("name", ["", ":4711"])
def test_no_display_is_one_line_that_names_the_film(name):
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    if name:
        environment["DISPLAY"] = name
    done = subprocess.run(DIVE, capture_output=True, text=True, timeout=120, env=environment)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert "subsea film" in done.stderr


def test_too_old_an_opengl_is_one_line_with_what_to_install(display):
    environment = os.environ | {"MESA_GL_VERSION_OVERRIDE": "2.1"}
    done = subprocess.run(DIVE, capture_output=True, text=True, timeout=120, env=environment)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert "apt-get install" in done.stderr


@pytest.mark.parametrize("mode", ["side-by-side", "top-bottom", "anaglyph", "equirectangular"])
def test_other_displays_open_too(display, mode):
    command = [*DIVE, "--seconds", "0.3", "--display", mode]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr


def test_a_window_without_a_buffer_for_each_eye_is_one_line_with_other_modes(display):
    command = [*DIVE, "--display", "stereo"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert "quad-buffered" in done.stderr
    assert "anaglyph" in done.stderr
