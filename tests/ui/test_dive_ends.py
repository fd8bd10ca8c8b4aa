"""The end of a dive: by itself, by a key, or before its start."""

import ctypes
import os
import signal
import subprocess
import sys
import time

import pytest

from subsea.cli.main import main
from tests.support.scenes import BARE

WORDS = ["dive", "--size", "320x240", "--scenario", str(BARE)]
DIVE = [sys.executable, "-m", "subsea", *WORDS]


def test_it_ends_by_itself(display):
    command = [*DIVE[:3], "dive", "--size", "320x240", "--seconds", "0.5"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr


def test_a_key_for_it_is_a_clean_exit(display, tmp_path):
    settings = tmp_path / "settings.toml"
    settings.write_text('[controls]\nleave = ["X"]\n')
    command = [*DIVE, "--seconds", "100", "--settings", str(settings)]
    running = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        while running.poll() is None:
            subprocess.run(["xdotool", "key", "x"], check=True, timeout=60)
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
    assert main([*WORDS, "--seconds", "0.3", "--display", mode]) == 0


def test_a_window_without_a_buffer_for_each_eye_is_one_line_with_other_modes(display, capfd):
    assert main([*WORDS, "--display", "stereo"]) == 2
    told = capfd.readouterr().err
    assert len(told.splitlines()) == 1
    assert "quad-buffered" in told
    assert "anaglyph" in told


@pytest.mark.parametrize(
    ("hands", "line"),
    [
        ("close button", "reading repertoires"),
        ("Ctrl-C", "waking the fishes"),
        ("Ctrl-C", "starting OpenGL"),
        ("Escape", "starting OpenGL"),
    ],
)
def test_leaving_while_it_loads_ends_at_once_and_says_nothing_more(display, hands, line):
    running = subprocess.Popen([*DIVE, "--seconds", "100"], stderr=subprocess.PIPE, text=True)
    with running:
        try:
            told = next(text for text in running.stderr if line in text)
            if hands == "Escape":
                subprocess.run(["xdotool", "key", "Escape"], check=True, timeout=60)
            elif hands == "close button":
                close_windows()
            else:
                running.send_signal(signal.SIGINT)
            _, rest = running.communicate(timeout=60)
        finally:
            running.kill()
    assert told
    # Lines on progress and the interruption, but no error.
    assert all(text.startswith("subsea: ") for text in rest.splitlines())
    assert running.returncode == (130 if hands == "Ctrl-C" else 0)


class ClientMessage(ctypes.Structure):
    """XClientMessageEvent, padded to the size of all events."""

    _fields_ = (
        ("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("sent", ctypes.c_int),
        ("display", ctypes.c_void_p), ("window", ctypes.c_ulong), ("kind", ctypes.c_ulong),
        ("format", ctypes.c_int), ("data", ctypes.c_long * 5), ("room", ctypes.c_long * 12),
    )  # fmt: skip


def close_windows():
    """Ask every window of a dive to close, as its close button does."""
    command = ["xdotool", "search", "--name", "subsea"]
    read = subprocess.run(command, check=True, capture_output=True, text=True, timeout=60)
    x = ctypes.CDLL("libX11.so.6")
    x.XOpenDisplay.restype = ctypes.c_void_p
    x.XInternAtom.restype = ctypes.c_ulong
    there = ctypes.c_void_p(x.XOpenDisplay(None))
    protocols, close = (
        x.XInternAtom(there, name, False) for name in (b"WM_PROTOCOLS", b"WM_DELETE_WINDOW")
    )
    for text in read.stdout.split():
        event = ClientMessage(type=33, window=int(text), kind=protocols, format=32)
        event.data[0] = close
        x.XSendEvent(there, ctypes.c_ulong(int(text)), False, 0, ctypes.byref(event))
    x.XCloseDisplay(there)
