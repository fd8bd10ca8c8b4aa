"""Ticks of a cluster: those of a leader, and of a follower."""

import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.cli import main
from subsea.dive.captions import Caption
from subsea.dive.pilot import Pilot
from subsea.dive.presented import NOTHING
from subsea.dive.tick_source import LocalTicks
from subsea.stage import setup as theatre_windows
from subsea.stage.cluster.follower import Follower
from subsea.stage.cluster.keys import write_keys
from subsea.stage.cluster.master import Master
from subsea.stage.cluster.ticks import (
    FOLLOW_S,
    FollowerTicks,
    LeaderTicks,
    MasterScenario,
    tick_source_maker,
)
from subsea.stage.theatre.load import load_theatre
from subsea.submarine.vessel import NEUTRAL, Rail
from subsea.ui.dive import Dive
from subsea.world import snapshot
from subsea.world.world import TICK_S


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
def test_a_follower_shows_the_pictures_of_its_leader(seas, tour, address):
    pilot = Pilot() if tour else pressed("left")
    lead = LeaderTicks(Master(seas[0], ["left"], address, timeout_s=5.0), pilot, tour)
    assert pilot.helm(TICK_S) == NEUTRAL or not tour
    follow = FollowerTicks(Follower(seas[1], "left", "middle", address, timeout_s=0.5))
    shown, drawn, ended = [], [], threading.Event()

    def node():
        while not ended.is_set():
            alpha = follow.advance(100.0)  # its own time does not count
            if alpha is not None:
                shown.append((alpha, seas[1].state.tick, snapshot.checksum(seas[1])))
                follow.swap(lambda: drawn.append("node"))

    assert follow.advance(1.0) is None
    assert follow.waiting == f"waiting for the master at {address}"
    thread = threading.Thread(target=node)
    thread.start()
    try:
        led, end = [], time.monotonic() + 60.0
        while len(shown) < 30 and time.monotonic() < end:
            alpha = lead.advance(0.7 * TICK_S)
            led.append((alpha, seas[0].state.tick, snapshot.checksum(seas[0])))
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
        over = seas[0].state.submarine.position - seas[0].state.fishes.position[0]
        assert np.linalg.norm(over - (0.0, 0.0, 100.0)) < 30.0
    assert follow.waiting == ""
    assert follow.idle_s > 0.0
    assert follow.close() == []
    [line] = lead.close()
    assert line.startswith("node left: ")


def test_a_follower_drifts_on_when_its_leader_is_lost(seas, address):
    lead = LeaderTicks(Master(seas[0], ["left"], address, timeout_s=5.0), Pilot())
    node = Follower(seas[1], "left", "middle", address, timeout_s=0.1)
    follow = FollowerTicks(node)
    assert not node.lost  # before its first dive it stands still
    end = time.monotonic() + 60.0
    while not node._joined and time.monotonic() < end:
        lead.advance(0.0)
        follow.advance(0.0)
    lead.close()
    tick, drawn = seas[1].state.tick, []
    node._heard_s -= 10.0
    follow.advance(0.0)
    assert follow.waiting == f"waiting for the master at {address}"
    assert follow.advance(2.5 * TICK_S) == pytest.approx(0.5)
    assert seas[1].state.tick == tick + 2
    follow.swap(lambda: drawn.append(True))  # waits for nobody
    assert drawn == [True]
    again = LeaderTicks(Master(seas[0], ["left"], address, timeout_s=5.0), Pilot())
    while node.lost and time.monotonic() < end:
        again.advance(TICK_S)
        follow.advance(0.0)
    while seas[1].state.tick != seas[0].state.tick and time.monotonic() < end:
        again.advance(0.0)
        follow.advance(0.0)
    assert snapshot.checksum(seas[1]) == snapshot.checksum(seas[0])
    follow.close()
    again.close()


def test_a_node_opens_what_its_master_waits_with_once(seas, address):
    """A fault is one line, and the sea before goes on."""
    ticks = FollowerTicks(Follower(seas[1], "left", "middle", address))
    opened, told = [], []
    dive = SimpleNamespace(
        tick_source=ticks, note=told.append,
        open_world=lambda scenario, source, seed: opened.append((source.stem, seed)),
    )  # fmt: skip
    follower = MasterScenario()
    for wanted in (("peaceful", 7), None, ("peaceful", 7), ("peaceful", 7), ("../sea", 1)):
        ticks.wanted = wanted
        follower.follow(dive)
    assert opened == [("peaceful", 7)] and ticks.wanted is None
    assert [line for line in told if "differ from the master's" in line] == told[:1]
    assert "unknown scenario '../sea'" in told[1] and len(told) == 2
    ticks.close()


class FakeMaster:
    """A master whose nodes are in step when a test says so."""

    def __init__(self, world):
        self.world, self.presented, self.offers, self.nodes = world, NOTHING, "two", ["left"]
        self.shown = []

    def picture(self, ticks, alpha):
        assert list(ticks) is not None
        self.shown.append(self.presented.blank)

    def in_step(self):
        return self.nodes

    def swap(self):
        """All have drawn."""

    def report(self):
        return []

    close = swap


@pytest.mark.parametrize("follows", [True, False])
def test_a_change_of_scenario_is_black_until_all_follow_within_a_limit(seas, capfd, follows):
    master = FakeMaster(seas[0])
    lead = LeaderTicks(master, Pilot(), leads=True)
    lead.advance(0.0)
    assert not lead.gathering and master.shown == [0.0]
    lead.change()  # before the next scenario is loaded
    assert master.shown[-1] == 1.0 == lead.presented.blank
    lead.close()
    after = FakeMaster(seas[0])
    after.nodes = []
    lead = LeaderTicks(after, Pilot(), leads=True, awaited=lead.followers)

    def shown(seconds):
        for _ in range(round(seconds / 0.25)):
            lead.presented = NOTHING  # as a presenter who wants to see the sea
            lead.advance(0.25)
        return after.shown[-1]

    assert shown(FOLLOW_S - 1.0) == 1.0 and lead.gathering
    after.nodes = ["left"] * follows
    if follows:
        assert shown(0.25) == 1.0 and not lead.gathering
    shown(1.25)
    assert shown(1.0) == 0.0 and not lead.gathering
    assert ("left: not followed in 30 s" in capfd.readouterr().err) != follows
    # A sea that nodes cannot open is not waited for, nor do others lead.
    after.offers = ""
    lead = LeaderTicks(after, Pilot(), leads=True, awaited=["right"])
    shown(0.5)
    assert not lead.gathering
    assert not LeaderTicks(after, Pilot(), awaited=["right"]).gathering


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


THREE = """
[cluster]
master = "left"
address = "127.0.0.1:5560"
""" + "".join(
    f"""
[[window]]
name = "{name}"
node = "{name}"
size = [64, 48]
[[channel]]
name = "{name}"
window = "{name}"
angles = {{ left_deg = -20, right_deg = 20, down_deg = -15, up_deg = 15, heading_deg = {degrees} }}
"""
    for name, degrees in (("left", -40), ("middle", 0), ("right", 40))
)


def test_captions_are_on_the_computer_ahead_of_the_audience(tmp_path):
    (tmp_path / "hall.toml").write_text(THREE)
    name = str(tmp_path / "hall.toml")
    ahead = [node for node in ("left", "middle", "right")
             if theatre_windows.set_up_theatre(name, node=node).in_front]  # fmt: skip
    assert ahead == ["middle"]
    for in_front, panel, words in ((True, None, "Look"), (False, None, ""), (False, 1, "Look")):
        picture = SimpleNamespace(text_panel=panel)  # each computer shows a part of it
        node = SimpleNamespace(_in_front=in_front, picture=picture, caption=Caption("Look", 1.0))
        assert Dive.subtitle.fget(node).words == words
    assert theatre_windows.set_up_theatre(name).in_front


def theatre(folder, address, more=""):
    path = folder / "hall.toml"
    path.write_text(THEATRE.replace("ADDRESS", address) + more)
    return load_theatre(str(path))


def test_a_theatre_file_determines_leader_and_follower(tmp_path, seas, address):
    found = theatre(tmp_path, address)
    for node, kind, hands in (("right", LeaderTicks, True), ("left", FollowerTicks, False)):
        ticks = tick_source_maker(*found, node, {})(seas[0], Pilot())
        assert isinstance(ticks, kind)
        assert (ticks.has_pilot, ticks.shared) == (hands, True)
        ticks.close()


@pytest.mark.parametrize("resumes", [True, False])
def test_a_leader_resumes_unless_told_otherwise(tmp_path, seas, address, resumes):
    found, asked = theatre(tmp_path, address), []
    lead = tick_source_maker(*found, "right", {}, resumes)(seas[0], Pilot())
    lead._master.resume = asked.append
    check = object()
    lead.resume(check)
    lead.close()
    assert asked == [check] * resumes
    LocalTicks(seas[0], Pilot()).resume(check)  # has nothing to resume


def test_a_node_with_another_view_is_refused(tmp_path, seas, address):
    found = theatre(tmp_path, address)
    lead = tick_source_maker(*found, "right", view={"--display": "mono"})(seas[0], Pilot())
    follow = tick_source_maker(*found, "left", view={"--display": "anaglyph"})(seas[1], Pilot())
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


def test_options_of_the_command_reach_the_ticks(tmp_path, monkeypatch):
    """Those of the display are part of the view."""

    def caught(found, path, node, view, resumes, leads):
        raise UserError(f"{resumes} {view}")

    def asked(*options):
        with pytest.raises(UserError) as met:
            main.run(["dive", "--theatre", str(path), "--node", "left", *options])
        return str(met.value)

    monkeypatch.setattr(theatre_windows, "tick_source_maker", caught)
    _, path = theatre(tmp_path, "127.0.0.1:5560")
    ours = asked()
    assert asked("--swap-eyes", "--shrink", "2", "--quality", "low") == ours
    assert asked("--no-resume") == ours.replace("True", "False", 1) != ours
    others = [asked("--display", "anaglyph"), asked("--eye-distance", "7"), asked("--comfort", "1")]
    theatre(tmp_path, "127.0.0.1:5561")
    assert len({ours, asked(), *others}) == 5


def test_faults_of_a_cluster_are_reported_before_a_world_is_made(tmp_path, seas):
    found = theatre(tmp_path, "127.0.0.1:5560")
    assert isinstance(tick_source_maker(*found, None, {})(seas[0], Pilot()), LocalTicks)
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
