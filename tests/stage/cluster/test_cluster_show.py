"""A show on three nodes of a theatre, as processes on one display."""

import shutil

import numpy as np
import pytest
from PIL import Image

from subsea.cli.main import main
from tests.stage.cluster.test_cluster_windows import NODES, Node, sea, theatre, until, windows
from tests.stage.console.conftest import Client, free_port
from tests.support.scenes import BARE

pytestmark = pytest.mark.timeout(900)  # three processes, and more so if kernels are compiled

SHOW = """
title = "three seas"
fade_s = 0.5
[[item]]
scenario = "one"
tour = "auto"
[[item]]
start = "cue"
scenario = "two"
tour = "auto"
caption = "The second sea"
[[item]]
start = "cue"
scenario = "one"
caption = "A title over the sea"
overlay = { file = "title.png", tilt_deg = 90 }
"""
COLOURS = {"left": 0, "middle": 1, "right": 2}  # channel of each window's part of the overlay


def write_overlay(path):
    """Write a fisheye ahead: red to the left, green in the middle, blue to the right.

    The windows end where the colours do, at 20° of 90°.
    """
    x = np.linspace(-1.0, 1.0, 512)
    pixels = np.zeros((512, 512, 4), np.uint8)
    parts = (x < -20 / 90, abs(x) <= 20 / 90, x > 20 / 90)
    for channel, part in enumerate(parts):
        pixels[:, part, channel] = 255
    pixels[..., 3] = 255
    Image.fromarray(pixels).save(path)


def titled(name, picture):
    """True if a window shows its part of the overlay: in its upper half there are no words."""
    mean = picture[10:70, 15:-15].reshape(-1, 3).mean(axis=0)
    channel = COLOURS[name]
    return mean[channel] > 120.0 and np.delete(mean, channel).max() < 60.0


@pytest.fixture
def hall(display, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    folder = tmp_path / "data/subsea/scenarios"
    folder.mkdir(parents=True)
    for name in ("one", "two"):
        text = BARE.read_text()
        (folder / f"{name}.toml").write_text(text.replace("A bare sea", f"Sea {name}"))
    theatre(tmp_path)
    (tmp_path / "console").write_text(str(free_port()))
    (tmp_path / "show").mkdir()
    (tmp_path / "show/show.toml").write_text(SHOW)
    write_overlay(tmp_path / "show/title.png")
    shutil.copy(tmp_path / "show/title.png", tmp_path)  # beside the theatre of left ...
    (tmp_path / "right").mkdir()  # ... but not beside that of right
    shutil.copy(tmp_path / "hall.toml", tmp_path / "right")
    shutil.copytree(tmp_path / "keys", tmp_path / "right/keys")
    nodes = {}
    try:
        for name in NODES:
            more = ["--playlist", str(tmp_path / "show/show.toml")] if name == "middle" else None
            folder = tmp_path / "right" if name == "right" else tmp_path
            nodes[name] = Node(folder, name, name, more or ["--scenario", "two"])
        yield nodes, tmp_path
    finally:
        for node in nodes.values():
            node.process.kill()
            node.process.wait()


@pytest.mark.nightly
def test_nodes_follow_a_show_of_three_items_and_two_cues(hall):
    nodes, folder = hall
    master, port = nodes["middle"], int((folder / "console").read_text())
    presenter = Client(port)

    def state():
        return presenter.ask("/api/state")[1]

    def together(item, scenario, title=()):
        def true():
            now = state()
            return (
                now["show"]["item"] == item
                and now["scenario"] == scenario
                and all(one["in_step"] for one in now["nodes"])
                and all(
                    titled(name, picture) if name in title else sea(picture)
                    for name, picture in windows().items()
                )
            )

        until(true, 240.0)

    # The nodes began with another scenario: they open the first of the show.
    master.until("node left: is in step", 400.0)
    together(1, "one")
    assert presenter.ask("/api/commands", {"command": "next-item"})[0] == 200
    until(lambda: all(picture.max() <= 2.0 for picture in windows().values()), 30.0)
    together(2, "two")
    assert presenter.ask("/api/commands", {"command": "next-item"})[0] == 200
    together(3, "one", title=("left", "middle"))
    nodes["right"].until("title.png: no such file; the sea is shown without it")
    # A node that comes later shows its part, too, now that it has the file.
    shutil.copy(folder / "title.png", folder / "right")
    nodes["right"].end()
    nodes["again"] = Node(folder / "right", "right", "again", ["--scenario", "one"])
    master.until("node right: is in step again")
    together(3, "one", title=NODES)
    # A presenter opens another sea for all.
    assert presenter.ask("/api/commands", {"command": "scenario", "name": "two"})[0] in (200, 202)
    together(3, "two", title=NODES)
    told = [node.told for node in nodes.values()]
    assert not any("differ" in text or "refuse" in text for text in told), told


def test_only_the_master_plays_a_show(tmp_path, capsys):
    theatre(tmp_path)
    for text, words in (
        (SHOW, "--playlist is for the master of the cluster, 'middle'"),
        (SHOW.replace('"two"', '"two.toml"'), "'two.toml' is a path, expected a name"),
        (SHOW.replace('tour = "auto"', 'tour = "glide"', 1), "'glide' begins elsewhere"),
        (SHOW.replace('tour = "auto"', 'eyes = "0"', 1), "eyes`: it is for one computer"),
        (SHOW.replace('tour = "auto"', "bodies = false", 1), "bodies`: it is for one computer"),
    ):
        text = text.replace('scenario = "one"', 'scenario = "peaceful"')
        (tmp_path / "show.toml").write_text(text)
        node = "left" if "master" in words else "middle"
        options = ["--theatre", f"{tmp_path}/hall.toml", "--playlist", f"{tmp_path}/show.toml"]
        assert main(["dive", *options, "--node", node]) == 2
        assert words in capsys.readouterr().err
