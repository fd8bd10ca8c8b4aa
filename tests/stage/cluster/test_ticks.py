"""Ticks of a cluster: those of a leader, and of a follower."""

import socket
import threading
import time

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.cli import main
from subsea.dive.pilot import Pilot
from subsea.dive.tick_source import LocalTicks
from subsea.scenario.load import load_scenario
from subsea.stage import setup as theatre_windows
from subsea.stage.cluster.follower import Follower
from subsea.stage.cluster.keys import write_keys
from subsea.stage.cluster.master import Master
from subsea.stage.cluster.ticks import FollowerTicks, LeaderTicks, tick_source_maker
from subsea.stage.theatre.load import load_theatre
from subsea.submarine.vessel import NEUTRAL, Rail
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S


@pytest.fixture(scope="module")
def worlds():
    made = [create_world(load_scenario("schooling")[0], fish=3) for _ in range(2)]
    for world in made:
        step(world, NEUTRAL)
    return made


@pytest.fixture
def address():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return f"127.0.0.1:{taken.getsockname()[1]}"


def pressed(action):
    pilot = Pilot()
    pilot.hold(action, "W")
    return pilot


def along(world):
    """A tour that depends on the world: just above the first fish."""
    x, y, z = world.state.fishes.position[0].astype(float)
    return Rail(np.array([x, y, z + 100.0]), np.array([1.0, 0.0, 0.0]), (0.5, 0.0))


def cued(world):
    """A tour that cuts to and fro, as directions may."""
    rail = along(world)
    return rail._replace(cut=True) if world.state.tick % 7 == 0 else rail


@pytest.mark.parametrize("tour", [None, along, cued])
def test_a_follower_shows_the_pictures_of_its_leader(worlds, tour, address):
    pilot = Pilot() if tour else pressed("left")
    lead = LeaderTicks(Master(worlds[0], ["left"], address, timeout_s=5.0), pilot, tour)
    assert pilot.helm(TICK_S) == NEUTRAL or not tour
    follow = FollowerTicks(Follower(worlds[1], "left", "middle", address, timeout_s=0.5))
    shown, drawn, ended = [], [], threading.Event()

    def node():
        while not ended.is_set():
            alpha = follow.advance(100.0)  # its own time does not count
            if alpha is not None:
                shown.append((alpha, worlds[1].state.tick, snapshot.checksum(worlds[1])))
                follow.swap(lambda: drawn.append("node"))

    assert follow.advance(1.0) is None
    assert follow.waiting == f"waiting for the master at {address}"
    thread = threading.Thread(target=node)
    thread.start()
    try:
        led, end = [], time.monotonic() + 60.0
        while len(shown) < 30 and time.monotonic() < end:
            alpha = lead.advance(0.7 * TICK_S)
            led.append((alpha, worlds[0].state.tick, snapshot.checksum(worlds[0])))
            lead.swap(lambda: drawn.append("master"))
            time.sleep(0.001)
    finally:
        ended.set()
        thread.join(60.0)
    assert len(shown) >= 30
    assert (drawn.count("node"), drawn.count("master")) == (len(shown), len(led))
    assert set(shown) <= set(led)  # all pictures of the node, also between ticks
    assert shown[-20:] == led[led.index(shown[-20]) :][:20]  # and no later one is missing
    if tour:
        over = worlds[0].state.submarine.position - worlds[0].state.fishes.position[0]
        assert np.linalg.norm(over - (0.0, 0.0, 100.0)) < 30.0
    assert follow.waiting == ""
    assert follow.idle_s > 0.0
    assert follow.close() == []
    [line] = lead.close()
    assert line.startswith("node left: ")


def test_a_follower_drifts_on_when_its_leader_is_lost(worlds, address):
    lead = LeaderTicks(Master(worlds[0], ["left"], address, timeout_s=5.0), Pilot())
    node = Follower(worlds[1], "left", "middle", address, timeout_s=0.1)
    follow = FollowerTicks(node)
    assert not node.lost  # before its first dive it stands still
    end = time.monotonic() + 60.0
    while not node._joined and time.monotonic() < end:
        lead.advance(0.0)
        follow.advance(0.0)
    lead.close()
    tick, drawn = worlds[1].state.tick, []
    node._heard_s -= 10.0
    follow.advance(0.0)
    assert follow.waiting == f"waiting for the master at {address}"
    assert follow.advance(2.5 * TICK_S) == pytest.approx(0.5)
    assert worlds[1].state.tick == tick + 2
    follow.swap(lambda: drawn.append(True))  # waits for nobody
    assert drawn == [True]
    again = LeaderTicks(Master(worlds[0], ["left"], address, timeout_s=5.0), Pilot())
    while node.lost and time.monotonic() < end:
        again.advance(TICK_S)
        follow.advance(0.0)
    while worlds[1].state.tick != worlds[0].state.tick and time.monotonic() < end:
        again.advance(0.0)
        follow.advance(0.0)
    assert snapshot.checksum(worlds[1]) == snapshot.checksum(worlds[0])
    follow.close()
    again.close()


THEATRE = """
[[window]]
name = "west"
node = "left"
size = [64, 48]

[[window]]
name = "east"
node = "right"
size = [64, 48]

[[channel]]
name = "west"
window = "west"
panorama = {}

[cluster]
master = "right"
address = "ADDRESS"
"""


def theatre(folder, address, more=""):
    path = folder / "hall.toml"
    path.write_text(THEATRE.replace("ADDRESS", address) + more)
    return load_theatre(str(path))


def test_a_theatre_file_determines_leader_and_follower(tmp_path, worlds, address):
    found = theatre(tmp_path, address)
    for node, kind, hands in (("right", LeaderTicks, True), ("left", FollowerTicks, False)):
        ticks = tick_source_maker(*found, node, {})(worlds[0], Pilot())
        assert isinstance(ticks, kind)
        assert (ticks.has_pilot, ticks.shared) == (hands, True)
        ticks.close()


@pytest.mark.parametrize("resumes", [True, False])
def test_a_leader_resumes_unless_told_otherwise(tmp_path, worlds, address, resumes):
    found, asked = theatre(tmp_path, address), []
    lead = tick_source_maker(*found, "right", {}, resumes)(worlds[0], Pilot())
    lead._master.resume = asked.append
    check = object()
    lead.resume(check)
    lead.close()
    assert asked == [check] * resumes
    LocalTicks(worlds[0], Pilot()).resume(check)  # has nothing to resume


def test_a_node_with_another_view_is_refused(tmp_path, worlds, address):
    found = theatre(tmp_path, address)
    lead = tick_source_maker(*found, "right", view={"--display": "mono"})(worlds[0], Pilot())
    follow = tick_source_maker(*found, "left", view={"--display": "anaglyph"})(worlds[1], Pilot())
    end = time.monotonic() + 60.0
    try:
        with pytest.raises(
            UserError, match=r"refuses node left: .* --display anaglyph \(expected mono\)"
        ):
            while time.monotonic() < end:
                follow.advance(0.1)
                lead.advance(0.0)
                lead.swap(lambda: None)
    finally:
        follow.close()
        lead.close()


def test_display_options_are_part_of_the_view(tmp_path, monkeypatch):
    def caught(found, path, node, view, resumes, leads):
        raise UserError(str(view))

    def view(*options):
        with pytest.raises(UserError) as met:
            main.run(["dive", "--theatre", str(path), "--node", "left", *options])
        return str(met.value)

    monkeypatch.setattr(theatre_windows, "tick_source_maker", caught)
    _, path = theatre(tmp_path, "127.0.0.1:5560")
    ours = view()
    assert view("--swap-eyes", "--shrink", "2", "--quality", "low") == ours
    others = [view("--display", "anaglyph"), view("--eye-distance", "7"), view("--comfort", "1")]
    theatre(tmp_path, "127.0.0.1:5561")
    assert len({ours, view(), *others}) == 5


def test_no_resume_is_passed_on(tmp_path, monkeypatch):
    def caught(found, path, node, view, resumes, leads):
        raise UserError(f"resumes: {resumes}")

    monkeypatch.setattr(theatre_windows, "tick_source_maker", caught)
    _, path = theatre(tmp_path, "127.0.0.1:5560")
    for option, resumes in ((), True), (("--no-resume",), False):
        with pytest.raises(UserError, match=f"resumes: {resumes}"):
            main.run(["dive", "--theatre", str(path), "--node", "left", *option])


def test_faults_of_a_cluster_are_reported_before_a_world_is_made(tmp_path, worlds):
    found = theatre(tmp_path, "127.0.0.1:5560")
    assert isinstance(tick_source_maker(*found, None, {})(worlds[0], Pilot()), LocalTicks)
    with pytest.raises(UserError, match=r"hall\.toml:\d+: \[cluster\]: address .* keys are needed"):
        tick_source_maker(*theatre(tmp_path, "192.0.2.7:5560"), "left", {})
    found = theatre(tmp_path, "192.0.2.7:5560", 'keys = "ours"\n')
    with pytest.raises(UserError, match=r"ours/right\.key_secret: no such file"):
        tick_source_maker(*found, "right", {})
    write_keys(tmp_path / "ours", ["left", "right"])
    tick_source_maker(*found, "right", {})
    (tmp_path / "ours" / "left.key").unlink()
    with pytest.raises(UserError, match=r"ours/left\.key: no such file"):
        tick_source_maker(*found, "right", {})
    tick_source_maker(*found, "left", {})  # which needs the master's key, and its own
