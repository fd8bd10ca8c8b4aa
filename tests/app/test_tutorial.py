"""docs/tutorial.md: every command in it is typed, in a short form, one after another."""

import os
import re
import shlex
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from PIL import Image

from subsea.resources import ROOT
from subsea.skins.flank import across
from subsea.skins.placing import silhouette
from subsea.species import load_species

TEXT = (ROOT / "docs/tutorial.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w*)\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)
# A step is a command, or a file or the end of one to be saved.
STEPS = [
    step
    for kind, block in BLOCKS
    for step in ([block] if kind == "toml" else block.splitlines())
    if step.strip()
]
# A hand would close these; they are closed once they are there.
WINDOWS = ("subsea build", "subsea skin")
SHORT = {
    "subsea dive": ["--seconds", "1"],
    "subsea film": ["--size", "96x64", "--fps", "2", "--quality", "low"],
    "subsea-capture learn": ["--budget", "2", "--only", "swim"],
    "subsea-capture export": ["--detail", "3"],
}
# Nothing better may be learned, a busy machine be slow, and have no second display.
MAY_FAIL = {
    "subsea-capture learn": (0, 1),
    "subsea-capture inspect": (0, 1),
    "subsea doctor": (0, 1),
}


class Workshop:
    """A folder beside the assets, a home in it, and what has been done there."""

    def __init__(self, folder):
        self.folder, self.done = folder, 0
        (folder / "assets").symlink_to(ROOT / "assets")
        kept = ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "DISPLAY", "PATH", "LANG")
        self.environment = {key: os.environ[key] for key in kept if key in os.environ}
        self.environment |= {"HOME": str(folder), "PYTHONPATH": str(ROOT)}
        self.environment.setdefault("XDG_CACHE_HOME", os.path.expanduser("~/.cache"))  # noqa: PTH111
        plan = load_species("moon_wrasse").surface
        mask = silhouette(plan, across(300, 200, plan), (200, 300))
        pixels = np.full((200, 300, 4), (230, 120, 30, 255), np.uint8)
        pixels[~mask] = (0, 0, 255, 0)
        Image.fromarray(pixels).save(folder / "jewel.png")

    def up_to(self, number):
        """Do all steps that are not done yet, to that of the number."""
        while self.done <= number:
            self.done += 1
            self.do(STEPS[self.done - 1])

    def do(self, step):
        """Save a file, or type a command."""
        if step.startswith("#"):
            name, end = re.match(r"# ([\w.]+)(, at its end)?\n", step).groups()
            with (self.folder / name).open("a" if end else "w") as file:
                file.write(step)
            return
        what = next((one for one in [*SHORT, *MAY_FAIL, *WINDOWS] if step.startswith(one)), "")
        command = self.command(step)
        if what in WINDOWS and "--auto" not in step:
            self.look_at(command)
            return
        done = subprocess.run(
            command, cwd=self.folder, env=self.environment, capture_output=True, text=True,
            timeout=280,
        )  # fmt: skip
        assert done.returncode in MAY_FAIL.get(what, (0,)), done.stdout + done.stderr

    def command(self, step):
        """The words of a command, in its short form."""
        words = shlex.split(step)
        if words == ["make", "run"]:
            return [sys.executable, str(ROOT / "run_submarine.py"), "--seconds", "1"]
        if words == ["make", "bench"]:  # installs nothing here, but says what it would do
            return ["make", "-C", str(ROOT), "--dry-run", "--always-make", "bench"]
        short = SHORT.get(" ".join(words[:2]), [])
        if words[0] == "subsea":
            return [sys.executable, "-m", "subsea", *words[1:], *short]
        if words[0] == "subsea-capture":
            return [sys.executable, "-m", "capture", *words[1:], *short]
        if words[0] == ".":  # the environment of a checkout is this one
            return ["true"]
        return ["bash", "-c", step]

    def look_at(self, command):
        """Open a window, wait until it is there, and close it as Ctrl-C does."""
        running = subprocess.Popen(
            command, cwd=self.folder, env=self.environment, stderr=subprocess.PIPE, text=True
        )
        try:
            search = ["xdotool", "search", "--onlyvisible", "--pid", str(running.pid)]
            end = time.monotonic() + 120
            while subprocess.run([*search], capture_output=True).returncode:
                assert running.poll() is None, running.stderr.read()
                assert time.monotonic() < end, "no window"
                time.sleep(0.2)
            time.sleep(1.0)
            running.send_signal(signal.SIGINT)
            _, err = running.communicate(timeout=60)
            assert running.returncode in (0, 130), err
            assert "Traceback" not in err
        finally:
            running.kill()


@pytest.fixture(scope="module")
def workshop(display, tmp_path_factory):
    return Workshop(tmp_path_factory.mktemp("workshop"))


@pytest.mark.parametrize("number", range(len(STEPS)), ids=[s.splitlines()[0] for s in STEPS])
def test_every_step_of_the_tutorial_can_be_taken(workshop, number):
    workshop.up_to(number)


def test_in_the_end_there_is_all_that_it_promises(workshop):
    workshop.up_to(len(STEPS) - 1)
    made = {str(path.relative_to(workshop.folder)) for path in workshop.folder.rglob("*.*")}
    own = ".local/share/subsea"
    assert {
        "lagoon.mp4", f"{own}/species/reef_jewel.toml", f"{own}/species/reef_jewel.png",
        f"{own}/repertoires/reef_jewel.h5",
    } <= made  # fmt: skip
    assert any(name.startswith("jewel/") for name in made)
    text = (workshop.folder / own / "species/reef_jewel.toml").read_text()
    assert 'name = "Reef jewel"' in text and 'sheet = "reef_jewel.png"' in text


def test_it_links_only_to_what_there_is():
    for link in re.findall(r"\]\(([^)#]+)", TEXT):
        assert (ROOT / "docs" / link).exists(), link
