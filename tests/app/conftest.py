"""A display to open windows on, and hands to use them: real events by xdotool."""

import os
import shutil
import subprocess
from collections.abc import Iterator

import pytest


@pytest.fixture(scope="module")
def display() -> Iterator[str]:
    """A virtual display of 800x600, named in DISPLAY as long as the tests of a module run."""
    for tool in ("Xvfb", "xdotool"):
        if shutil.which(tool) is None:
            pytest.fail(f"{tool} is missing; `make test` installs it, or prints how")
    read, write = os.pipe()
    # The server chooses a free number itself and tells it once it listens. Left to itself it
    # would begin anew whenever the last window closes, and refuse the next one meanwhile.
    command = ["Xvfb", "-displayfd", str(write), "-screen", "0", "800x600x24"]
    command += ["-nolisten", "tcp", "-noreset"]
    server = subprocess.Popen(
        command, pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    os.close(write)
    with os.fdopen(read) as pipe:
        name = ":" + pipe.readline().strip()
    before = {key: os.environ.pop(key, None) for key in ("DISPLAY", "WAYLAND_DISPLAY")}
    os.environ["DISPLAY"] = name
    try:
        yield name
    finally:
        os.environ.pop("DISPLAY")
        os.environ.update({key: value for key, value in before.items() if value is not None})
        server.terminate()
        server.wait()
