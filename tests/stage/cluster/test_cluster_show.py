"""A show on three nodes of a theatre, as processes on one display."""

import pytest

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
"""


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
    (tmp_path / "show.toml").write_text(SHOW)
    nodes = {}
    try:
        for name in NODES:
            more = ["--playlist", str(tmp_path / "show.toml")] if name == "middle" else None
            nodes[name] = Node(tmp_path, name, name, more or ["--scenario", "two"])
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

    def together(item, scenario):
        def true():
            now = state()
            return (
                now["show"]["item"] == item
                and now["scenario"] == scenario
                and all(one["in_step"] for one in now["nodes"])
                and all(sea(picture) for picture in windows().values())
            )

        until(true, 240.0)

    # The nodes began with another scenario: they open the first of the show.
    master.until("node left: is in step", 400.0)
    together(1, "one")
    assert presenter.ask("/api/commands", {"command": "next-item"})[0] == 200
    until(lambda: all(picture.max() <= 2.0 for picture in windows().values()), 30.0)
    together(2, "two")
    assert presenter.ask("/api/commands", {"command": "next-item"})[0] == 200
    together(3, "one")
    # A presenter opens another sea for all.
    assert presenter.ask("/api/commands", {"command": "scenario", "name": "two"})[0] in (200, 202)
    together(3, "two")
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
