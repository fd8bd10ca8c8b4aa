"""Three nodes of a theatre, as processes on one display; one of them dies, then the master."""

import re
import subprocess
import sys
import time
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from subsea.cli.main import main
from tests.stage.console.conftest import Client, free_port
from tests.support.scenes import BARE
from tests.support.windows import display_pixels

SIZE = 200, 150
NODES = {"left": (-60, -20), "middle": (-20, 20), "right": (20, 60)}


def theatre(folder):
    """A theatre file of three nodes side by side, with their keys."""
    text = f'[cluster]\nmaster = "middle"\naddress = "127.0.0.1:{free_port()}"\nkeys = "keys"\n'
    text += "timeout_s = 5.0\n"  # a busy machine must not count as dead
    for k, (name, (left, right)) in enumerate(NODES.items()):
        text += (
            f'[[window]]\nname = "{name}"\nnode = "{name}"\nsize = {list(SIZE)}\n'
            f'position = [{k * SIZE[0]}, 0]\n[[channel]]\nname = "{name}"\nwindow = "{name}"\n'
            f"cylinder = {{ radius_cm = 275, left_deg = {left}, right_deg = {right}, "
            "bottom_cm = -75, top_cm = 75 }\n"
        )
    (folder / "hall.toml").write_text(text)
    (folder / "console").write_text(str(free_port()))
    assert main(["keys", str(folder / "keys"), *NODES]) == 0


class Node:
    """`subsea dive --node NAME` in its own process, and its output."""

    def __init__(self, folder, name, call, more=("--scenario", str(BARE))):
        self.folder, self._file = folder, folder / f"{call}.told"
        command = [sys.executable, "-m", "subsea", "dive", "--theatre", str(folder / "hall.toml")]
        command += ["--node", name, *more, "--quality", "low"]
        if name == "middle":
            command += ["--console", f"127.0.0.1:{(folder / 'console').read_text()}"]
        with self._file.open("w") as file:
            self.process = subprocess.Popen(command, stderr=file)

    @property
    def told(self):
        return self._file.read_text()

    def until(self, words, seconds=150.0):
        end = time.monotonic() + seconds
        while words not in self.told:
            assert self.process.poll() is None, self.told
            assert time.monotonic() < end, self.told
            time.sleep(0.1)

    def end(self):
        self.process.terminate()
        return self.process.wait(60.0)


def windows():
    """The pixels of the three windows on the display, each (150, 200, 3)."""
    picture = display_pixels()
    return {
        name: picture[: SIZE[1], k * SIZE[0] : (k + 1) * SIZE[0]].astype(float)
        for k, name in enumerate(NODES)
    }


@pytest.fixture(scope="module")
def hall(display, tmp_path_factory):
    folder = tmp_path_factory.mktemp("hall")
    theatre(folder)
    nodes = {}

    def start(name, call):
        nodes[call] = Node(folder, name, call)
        return nodes[call]

    try:
        for name in NODES:
            start(name, name)
        yield nodes, start, int((folder / "console").read_text())
    finally:
        for node in nodes.values():
            node.process.kill()
            node.process.wait()


def until(true, seconds=60.0):
    """Wait until something is true."""
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end
        time.sleep(0.2)


def patterned(shown):
    """True if every window shows a picture that is not black and stands still."""
    time.sleep(1.0)
    again = windows()
    return all((shown[k] == again[k]).all() and shown[k].max() > 100.0 for k in shown)


def sea(picture):
    """True if a window shows water: mostly blue, and all corners different."""
    red, _, blue = picture.reshape(-1, 3).mean(axis=0)
    return blue > red + 30.0 and picture.std() > 4.0


def white_pixels(picture):
    return (picture.min(axis=2) > 200.0).sum()


def lines_up_the_left_projector(presenter, file):
    """Move a corner of the left node's picture from the master, undo it, do it again, and save."""

    def ask(command, **values):
        answer = presenter.ask("/api/commands", {"command": f"line-up-{command}", **values})
        assert answer[0] == 200, answer

    def fault():
        told = presenter.ask("/api/state")[1]["fault"]
        return told and told["text"]

    told = fault()  # a computer may have no sound
    ask("edit", on=True)
    ask("show", pattern="grid", others="full")
    ask("choose", channel="left", point="lower_right")
    until(lambda: patterned(windows()))
    before = windows()
    ask("move", right=-20.0, down=-15.0)
    until(lambda: (windows()["left"] != before["left"]).mean() > 0.05)
    assert all((windows()[name] == before[name]).all() for name in ("middle", "right"))
    ask("undo")
    until(lambda: all((windows()[name] == before[name]).all() for name in NODES))
    ask("redo")
    ask("save")
    _, state, _ = presenter.ask("/api/state")
    assert not state["projectors"]["unsaved"] and fault() == told
    assert "corners_px" in file.read_text() and file.with_name("hall.toml.bak").exists()
    ask("edit", on=False)


def watches_and_restarts_a_node(presenter, master, node):
    """See the left node's facts and picture on the master, and restart its program from there."""

    def left():
        nodes = presenter.ask("/api/state")[1]["fleet"]["nodes"]
        return next(one for one in nodes if one["name"] == "left")

    until(lambda: presenter.ask("/api/state")[1]["fleet"] is not None)  # after its first picture
    until(lambda: left()["version"] is not None)
    assert left()["connected"]
    assert 0.0 < left()["frame_ms"] <= left()["longest_ms"]
    until(lambda: presenter.ask("/api/nodes/left.jpg")[0] == 200)
    with Image.open(BytesIO(presenter.ask("/api/nodes/left.jpg")[1])) as picture:
        shown = np.asarray(picture.convert("RGB"), float)
    assert shown.shape[:2] == (150, 200)
    assert sea(shown)
    told = node.told.count("took the state of the dive")
    assert presenter.ask("/api/commands", {"command": "restart", "node": "left"})[0] == 200
    master.until("node left: is in step again")
    assert node.process.poll() is None  # the same process, by a new program
    assert node.told.count("took the state of the dive") > told
    until(lambda: left()["version"] is not None and left()["up_s"] < 60.0)


@pytest.mark.nightly  # every day test_lockstep.py restarts a node and resumes a dive
def test_three_windows_show_one_sea_when_a_node_dies_and_the_master(hall):
    nodes, start, console = hall
    master = nodes["middle"]
    for name in ("left", "right"):
        master.until(f"node {name}: is in step")
    time.sleep(1.0)
    shown = windows()
    assert all(sea(picture) for picture in shown.values())
    # The picture continues over this edge; the help covers the other edge of the middle window.
    seam = np.abs(shown["middle"][:100, -1] - shown["right"][:100, 0]).mean()
    assert seam < 3.0  # of 255

    presenter = Client(console)
    command = {"command": "blank", "on": True}
    assert presenter.ask("/api/commands", command)[0] == 200
    until(lambda: all(picture.max() <= 2.0 for picture in windows().values()))
    _, state, _ = presenter.ask("/api/state")
    assert {one["name"]: one["in_step"] for one in state["nodes"]} == {"left": True, "right": True}
    assert presenter.ask("/api/commands", {"command": "line-up", "on": True})[0] == 200
    assert presenter.ask("/api/commands", command | {"on": False})[0] == 200
    until(lambda: patterned(windows()))
    refused = {"command": "follow", "fish": "0"}
    assert presenter.ask("/api/commands", refused)[0] == 409
    assert presenter.ask("/api/commands", {"command": "line-up", "on": False})[0] == 200
    until(lambda: all(sea(picture) for picture in windows().values()))

    lines_up_the_left_projector(presenter, nodes["middle"].folder / "hall.toml")
    until(lambda: all(sea(picture) for picture in windows().values()))

    nodes["left"].process.kill()
    master.until("node left: is gone; going on without it")
    again = start("left", "left again")
    master.until("node left: is in step again")
    assert "took the state of the dive at tick" in again.told
    time.sleep(1.0)
    assert all(sea(picture) for picture in windows().values())

    assert master.end() == 130
    for name in ("left", "right"):
        assert re.search(rf"node {name}: \d+ pictures, waited for .* p95 .* ms", master.told)
    assert re.search(r"node left: .*dropped once; rejoined once", master.told)
    before = windows()
    for node in (nodes["right"], again):
        until(lambda node=node: node.told.count("waiting for the master at 127.0.0.1") == 2)
    time.sleep(1.0)
    after = windows()
    for name in ("left", "right"):  # the sea goes on, without words
        assert sea(after[name])
        assert np.abs(after[name][:100] - before[name][:100]).mean() > 1.0
        assert white_pixels(after[name][:75]) < 20  # letters are; so may be a speck of snow
    assert not any("differs" in node.told for node in nodes.values())

    second = start("middle", "middle again")
    for name in ("left", "right"):
        second.until(f"node {name}: is in step")
    [resumed] = re.findall(r"resumed the dive of node \w+ at tick (\d+)", second.told)
    for node in (nodes["right"], again):
        taken = [int(tick) for tick in re.findall(r"state of the dive at tick (\d+)", node.told)]
        assert taken == sorted(taken)  # it did not begin again
        assert taken[0] < int(resumed) <= taken[-1]
    watches_and_restarts_a_node(presenter, second, again)
    assert (nodes["right"].end(), again.end()) == (130, 130)
    assert not any("differs" in node.told for node in nodes.values())
