"""The fleet in a dive of a theatre: facts, projectors, and a restart."""

import socket
from contextlib import closing
from types import SimpleNamespace

import msgspec
import pytest

from subsea import __version__
from subsea.base import restarts
from subsea.base.errors import TransientError, UserError
from subsea.dive.options import DiveOptions
from subsea.stage import fleet_part
from subsea.stage.console.commands import RestartNode, SwitchProjector, WakeNode
from subsea.stage.fleet.hand_over import address_wanted
from subsea.stage.fleet_part import FleetPart
from subsea.stage.parts import ConsolePart, TheatrePart
from subsea.ui.dive import Dive
from tests.stage.console.conftest import local
from tests.stage.fleet.pjlink_server import PASSWORD, ProjectorServer
from tests.support.scenes import BARE
from tests.support.windows import dive_options

THEATRE = """
[[window]]
name = "front"
size = [320, 240]
[[channel]]
name = "front"
window = "front"
angles = {{ left_deg = -40, right_deg = 40, down_deg = -30, up_deg = 30 }}
[[node]]
name = "main"
mac = "00:1a:2b:3c:4d:5e"
wake = "127.0.0.1:{card}"
[[projector]]
name = "front"
address = "127.0.0.1"
port = {port}
password = "secret"
"""


@pytest.fixture
def projector():
    with closing(ProjectorServer(guarded=True)) as made:
        yield made


@pytest.fixture
def card():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as made:
        made.bind(("127.0.0.1", 0))
        made.settimeout(20.0)
        yield made


@pytest.fixture
def theatre(tmp_path, projector, card):
    path = tmp_path / "hall.toml"
    path.write_text(THEATRE.format(port=projector.port, card=card.getsockname()[1]))
    (tmp_path / "secret").write_text(PASSWORD)
    (tmp_path / "secret").chmod(0o600)
    return path


def test_a_technician_controls_a_theatre(display, user, coarse, theatre, projector, card):
    console = ConsolePart(local())
    parts = [console, FleetPart(str(theatre)), TheatrePart(str(theatre))]
    with closing(Dive(dive_options(BARE, (320, 240), coarse, parts=parts))) as running:

        def fleet():
            return msgspec.json.decode(console.remote.board.state)["fleet"]

        def given(command):
            done = console.remote.board.put(command)
            user.until(running, done.done)
            return done.result()

        user.until(running, lambda: fleet() and fleet()["nodes"][0]["version"] == __version__)
        [main] = fleet()["nodes"]
        assert (main["name"], main["own"], main["connected"]) == ("main", True, True)
        assert main["renderer"] == running.window_set.context.info["GL_RENDERER"]
        assert 0.0 < main["frame_ms"] <= main["longest_ms"]
        user.until(running, lambda: fleet()["projectors"][0]["power"] == "off")
        assert given(SwitchProjector("all", True)) == "switches all projectors on"
        user.until(running, lambda: "POWR 1" in projector.asked)
        assert given(WakeNode("main")) == "wakes main"
        assert card.recv(200).startswith(b"\xff" * 6)
        assert given(RestartNode("main")) == "restarts main"
        user.glide(running, 0.2)
        assert running.restarts
        assert not running.window_set.open


def test_a_password_that_others_read_ends_the_start_with_a_line(theatre):
    (theatre.parent / "secret").chmod(0o644)
    options = DiveOptions("peaceful")
    with pytest.raises(UserError, match=r"secret: others may read it \(mode 644\)"):
        FleetPart(str(theatre)).plan(options)


CLUSTER = """
[[window]]
name = "a"
node = "a"
size = [64, 48]
[[window]]
name = "b"
node = "b"
size = [64, 48]
[[channel]]
name = "a"
window = "a"
dome = {}
[cluster]
master = "a"
keys = "keys"
"""


def test_a_master_hands_its_address_over_between_two_items(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    monkeypatch.setattr(fleet_part, "LOOK_S", 0.0)
    awaited = []
    monkeypatch.setattr(restarts, "_awaited", awaited)
    (tmp_path / "hall.toml").write_text(CLUSTER)
    options, address = DiveOptions("peaceful"), "127.0.0.1:5560"
    node, master = (FleetPart(str(tmp_path / "hall.toml"), name) for name in "ba")
    for part in (node, master):
        part.plan(options)
    ends = [False]
    show = SimpleNamespace(may_end=lambda: ends[0])
    dive = SimpleNamespace(parts=[show, master], restarts=False)
    assert not master._hands_over(dive)
    with address_wanted(address):
        assert not master._hands_over(dive) and not node._hands_over(dive)
        ends[0] = True
        assert master._hands_over(dive) and not node._hands_over(dive)
        with pytest.raises(TransientError, match="`subsea fleet` works at the address"):
            FleetPart(str(tmp_path / "hall.toml"), "a").plan(options)
    told = capsys.readouterr().err.splitlines()
    assert told == ["subsea: `subsea fleet` asks for the computers: the dive ends with this item"]
    assert len(awaited) == 1
    awaited[0]()  # nobody wants it any more
    assert not master._hands_over(dive)
