"""The window library and the panel library load in every kind of session, in one order."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

CHILD = """
import subsea.ui.monitors
from subsea.ui import glfw
print(glfw._glfw._name)
"""
SESSIONS = {  # variables of a session, and the folder of the library that it needs
    "x11": ({"XDG_SESSION_TYPE": "x11", "DISPLAY": ":9"}, "imgui_bundle"),
    "xwayland": (
        {"XDG_SESSION_TYPE": "wayland", "WAYLAND_DISPLAY": "w", "DISPLAY": ":9"},
        "imgui_bundle",
    ),
    "wayland": ({"XDG_SESSION_TYPE": "wayland", "WAYLAND_DISPLAY": "w"}, "wayland"),
}


@pytest.mark.nightly
@pytest.mark.skipif(sys.platform != "linux", reason="other systems have one kind of session")
@pytest.mark.parametrize("session", SESSIONS)
def test_windows_load_in_the_session(session):
    variables, folder = SESSIONS[session]
    hidden = {"DISPLAY", "WAYLAND_DISPLAY", "PYGLFW_LIBRARY"}
    environment = {key: text for key, text in os.environ.items() if key not in hidden}
    done = subprocess.run(
        [sys.executable, "-c", CHILD],
        env=environment | variables, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert Path(done.stdout.strip()).parent.name == folder
