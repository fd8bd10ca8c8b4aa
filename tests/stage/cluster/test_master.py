"""A master and its nodes, without windows: in step, late, lost, refused."""

import socket
import time
from contextlib import ExitStack
from types import SimpleNamespace

import numpy as np
import pytest
import zmq

from subsea import __version__
from subsea.base.errors import UserError
from subsea.dive.presented import NOTHING, Presented
from subsea.stage.cluster import identity
from subsea.stage.cluster.follower import NO_KEYS, Follower
from subsea.stage.cluster.keys import Keys, read_keys, write_keys
from subsea.stage.cluster.master import Master
from subsea.stage.cluster.messages import (
    FLEET,
    MAGIC,
    SMALL,
    Hello,
    Identity,
    Picture,
    Swap,
    WorldState,
    encode,
)
from subsea.stage.theatre.line_up import LineUpState
from subsea.stage.theatre.theatre_file import Adjustment
from subsea.world import snapshot


def told(harness, *words):
    return any(all(word in line for word in words) for line in harness.told)


def late(harness):
    """Number of timeouts of a node."""
    return sum("has not drawn" in line for line in harness.told)


def both_in_step(harness, seas):
    left, right = harness.node(seas[1], "left"), harness.node(seas[2], "right")
    harness.show_until(lambda: len(harness.master.in_step()) == 2)
    return left, right


def assert_all_show_the_same(harness, *nodes, pictures=20):
    """Assert that all show the same for some pictures."""
    harness.show_until(lambda: len(harness.master.in_step()) == len(nodes))
    first = harness.master._number + 1
    harness.show_pictures(pictures, ticks=2)
    for number in range(first, first + pictures):
        for node in nodes:
            assert node.seen[number] == harness.seen[number]


def test_all_nodes_show_the_same(harness, seas):
    left, right = both_in_step(harness, seas)
    assert_all_show_the_same(harness, left, right, pictures=40)
    assert left.node.waiting == ""
    for line in harness.master.report():
        assert "ms on average" in line
        assert "late" not in line
        assert "dropped" not in line


def test_messages_of_the_fleet_pass_both_ways(harness, seas):
    left, _ = both_in_step(harness, seas)
    assert left.node.send_fleet(FLEET + b"\xffof a later version")
    harness.show_until(lambda: harness.master.fleet_heard)
    assert list(harness.master.fleet_heard) == [("left", FLEET + b"\xffof a later version")]
    harness.master.send_fleet("left", FLEET + b"order")
    harness.show_until(lambda: left.node.fleet_heard)
    assert list(left.node.fleet_heard) == [FLEET + b"order"]
    assert not [line for line in harness.told if "refused" in line]
    assert len(harness.master.in_step()) == 2
    left.close()
    harness.show_until(lambda: len(harness.master.in_step()) == 1)
    harness.master.send_fleet("left", FLEET + b"order")  # nobody is there


def test_a_picture_may_have_no_tick(harness, seas):
    left = harness.node(seas[1], "left")
    harness.show_until(lambda: harness.master.in_step() == ["left"])
    tick = harness.master.world.state.tick
    harness.show_pictures(5, ticks=0)
    assert harness.master.world.state.tick == tick
    assert left.seen[harness.master._number] == harness.seen[harness.master._number]


def test_lights_are_switched_on_for_all(harness, seas):
    left, right = both_in_step(harness, seas)
    lights = harness.master.world.state.submarine.lights
    for on in (True, False):
        lights[:] = on
        assert_all_show_the_same(harness, left, right)
        assert all(bool(sea.state.submarine.lights[0]) == on for sea in seas)
    assert not told(harness, "differs")


def test_what_a_presenter_shows_reaches_all(harness, seas):
    left, right = both_in_step(harness, seas)
    shown = Presented(0.5, True, "Good evening", 1.0)
    harness.master.presented = shown
    assert_all_show_the_same(harness, left, right)
    assert left.node.presented == right.node.presented == shown
    harness.master.presented = NOTHING
    assert_all_show_the_same(harness, left, right)
    assert left.node.presented == right.node.presented == NOTHING


def test_a_line_up_reaches_all_with_its_picture_and_nodes_that_come_later(
    harness, seas, monkeypatch
):
    monkeypatch.setattr("subsea.stage.cluster.master.LINE_UP_S", 0.05)
    left = harness.node(seas[1], "left")
    harness.show_until(lambda: harness.master.in_step() == ["left"])
    heard = {}
    take = left.node._make

    def made(picture):
        heard[picture.number] = picture.line_up
        return take(picture)

    left.node._make = made
    assert left.node.line_up is None
    for gamma in (2.0, 2.4):
        state = LineUpState({"left": Adjustment(gamma=gamma)}, open=True, channel="left")
        harness.master.line_up = state
        harness.show_pictures()
        assert heard[harness.master._number] == state  # in the very next picture
        assert left.node.line_up == state
    harness.show_pictures()
    assert heard[harness.master._number] is None  # an unchanged line-up is not sent again
    right = harness.node(seas[2], "right")
    harness.show_until(lambda: right.node.line_up == harness.master.line_up)
    assert not told(harness, "differs")


def test_nodes_report_and_ask(harness, seas):
    left = harness.node(seas[1], "left")
    harness.show_until(lambda: harness.master.in_step() == ["left"])
    left.rest()
    left.node.report("hall.toml: no space is left\x1b[2J")
    left.node.ask(b'{"command": "line-up-undo"}')
    left.asleep = False
    harness.show_until(lambda: harness.master.reports and harness.master.asked)
    assert [*harness.master.reports] == ["node left: hall.toml: no space is left?[2J"]
    assert [*harness.master.asked] == [b'{"command": "line-up-undo"}']


def test_a_saved_theatre_file_renews_what_nodes_must_have(harness, seas):
    left = harness.node(seas[1], "left")
    harness.show_until(lambda: harness.master.in_step() == ["left"])
    harness.master.renew_view({"theatre files": "#new"})
    right = harness.node(seas[2], "right")
    harness.show_until(lambda: right.fault)
    assert "theatre files" in right.fault
    left.rest()
    left.node.renew_view({"theatre files": "#new"})
    left.asleep = False
    harness.show_until(lambda: harness.master.in_step() == ["left"])


def test_a_late_node_is_skipped_until_it_catches_up(make_harness, seas, address):
    harness = make_harness(seas[0], address, timeout_s=1.0)
    left, right = both_in_step(harness, seas)
    right.rest()
    start = time.monotonic()
    harness.show_pictures(2)
    assert time.monotonic() - start > 0.9
    harness.show_pictures(20)
    assert harness.master.in_step() == ["left"]
    assert told(harness, "node right", "has not drawn", "going on")
    assert late(harness) == 1  # the master no longer waits for it
    right.asleep = False
    harness.show_until(lambda: len(harness.master.in_step()) == 2)
    assert told(harness, "node right", "in step again")
    assert_all_show_the_same(harness, left, right)
    assert any("late once; rejoined once" in line for line in harness.master.report())


def test_a_closed_node_is_not_waited_for(harness, seas):
    left, right = both_in_step(harness, seas)
    right.close()
    harness.show_pictures(10)
    assert harness.master.in_step() == ["left"]
    assert told(harness, "node right", "going on without it")
    assert late(harness) == 0
    assert_all_show_the_same(harness, left)
    again = harness.node(seas[2], "right")
    assert_all_show_the_same(harness, left, again)


def test_a_second_node_of_the_same_name_takes_over(harness, seas):
    first = harness.node(seas[1], "left")
    harness.show_until(lambda: harness.master.in_step() == ["left"])
    second = harness.node(seas[2], "left")
    harness.show_until(lambda: first.fault is not None)
    assert first.fault == "another computer has come as node left"
    assert_all_show_the_same(harness, second)


def test_a_node_that_lost_a_picture_fetches_the_state(harness, seas):
    left = harness.node(seas[1], "left")
    assert_all_show_the_same(harness, left)
    left.node._number -= 1
    harness.show_until(lambda: left.node._number == harness.master._number)
    assert_all_show_the_same(harness, left)


def test_a_diverged_node_is_resynchronised_once(harness, seas):
    words = []
    left = harness.node(seas[1], "left", told=words)
    assert_all_show_the_same(harness, left)
    left.rest()
    seas[1].state.fishes.position[0, 0] += 0.001
    left.asleep = False
    harness.show_until(lambda: told(harness, "node left", "its world differs", "fetches the state"))
    assert any("this world differs from the master's" in line for line in words)
    assert_all_show_the_same(harness, left)
    left.rest()
    seas[1].state.fishes.position[1, 2] += 0.001
    left.asleep = False
    harness.show_until(lambda: left.fault is not None)
    assert left.fault.startswith("the master refuses node left: its world differed")
    assert told(harness, "node left", "differed from the master's again")
    harness.show_pictures(5)
    assert harness.master.in_step() == []


def refused(harness, node):
    harness.show_until(lambda: node.fault is not None)
    return node.fault


def test_another_scenario_or_seed_is_refused_on_both_sides(harness, seas, make_sea):
    left = harness.node(seas[1], "left")
    fault = refused(harness, harness.node(make_sea(seed=99), "right"))
    assert fault == (
        f"the master refuses node right: it has subsea {__version__} with seed 99 (expected 1)"
    )
    assert told(harness, "node right: has subsea", "seed 99 (expected 1)", "refused")
    fault = refused(harness, harness.node(make_sea(fish=5), "right"))
    assert "with another sea, made of the same scenario" in fault
    assert told(harness, "node right", "another sea")
    assert_all_show_the_same(harness, left)


SEA_OF = "another sea, made of the same scenario: other fishes in number"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"scenario": "Bay"}, "has subsea VERSION with scenario Bay (expected A bare sea)"),
        ({"contents of the scenario": "#0"}, "with other contents of the scenario"),
        ({"species": "#0"}, "with other species"),
        ({"pictures of species": "#0"}, "with other pictures of species"),
        ({"repertoires": "#0", "shaders": "#0"}, "with other repertoires, other shaders"),
        ({"numpy": "1.0"}, f"with numpy 1.0 (expected {np.__version__})"),
        ({"subsea/behavior": "#0"}, "with other code in subsea/behavior"),
        ({"--comfort": "1.0"}, "with --comfort 1.0 (expected none)"),
        ({identity.SEA: "#0"}, f"with {SEA_OF}"),
        ({identity.SEA: "#0", "seed": "4"}, "with seed 4 (expected 1)"),
    ],
)
def test_differences_of_identity_are_named(seas, changes, words):
    ours = identity.identity_of(seas[0])
    assert identity.difference(identity.identity_of(seas[1]), ours) == ""
    theirs = Identity("0.0.9", ours.parts | changes)
    told = identity.difference(theirs, ours)
    version = f"0.0.9 (expected {__version__})"
    assert words.replace("VERSION", version) in told and version in told
    # Versions are not compared, nor is a sea that follows from other parts.
    assert identity.difference(Identity("0.0.9", ours.parts), ours) == ""
    assert ("another sea" in told) == (set(changes) == {identity.SEA})


def test_parts_that_only_one_side_has_are_differences(seas):
    ours = identity.identity_of(seas[0])
    fewer = Identity(ours.version, {k: v for k, v in ours.parts.items() if k != "seed"})
    assert "seed none (expected 1)" in identity.difference(fewer, ours)
    assert "seed 1 (expected none)" in identity.difference(ours, fewer)
    told = identity.difference(Identity(ours.version, {}), ours)
    assert told.endswith(" more differences") and len(told) < 500


def test_an_identity_fits_a_message(seas):
    assert len(encode(Hello("n" * 64, identity.identity_of(seas[0])))) < SMALL


def test_code_assets_and_sheets_are_parts(make_sea, tmp_path, monkeypatch):
    ours = identity.identity_of(make_sea())
    assert {"subsea/rendering", "subsea/motor", "subsea"} <= set(ours.parts)
    shader = tmp_path / "a.frag"
    shader.write_text("1")
    identity._program.cache_clear()
    monkeypatch.setattr(identity, "resource_path", lambda name: tmp_path)
    other = identity.identity_of(make_sea())
    identity._program.cache_clear()
    assert identity.difference(other, ours).endswith("with other shaders")


def test_the_code_that_is_compared_covers_what_an_import_runs(tmp_path):
    def parts(**changes):
        dive = "from subsea import __version__\nfrom subsea.fish import fins\n"
        names = "subsea", "subsea/ui", "subsea/fish"
        files = {f"{name}/__init__.py": "" for name in names} | {"subsea/fish/fins.py": ""}
        root = tmp_path / "-".join(["code", *changes]).replace("/", "-")
        for name, text in {**files, "subsea/ui/dive.py": dive, **changes}.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(text)
        return identity.code_parts(root)

    before = parts()
    for name in ("subsea", "subsea/ui", "subsea/fish"):
        after = parts(**{f"{name}/__init__.py": "from math import pi"})
        assert {part for part in after if after[part] != before[part]} == {name}


def test_a_leading_master_has_nodes_open_its_scenario(harness, seas, make_sea, monkeypatch):
    harness.master.offers = "two"
    node = harness.node(make_sea(seed=99), "left")
    harness.show_until(lambda: node.node.wanted == ("two", 1))
    assert node.fault is None and harness.master.in_step() == []
    # Not a stranger, nor a node with other code.
    fault = refused(harness, harness.node(make_sea(seed=99), "middle"))
    assert "not among the nodes of the theatre: left, right" in fault
    assert told(harness, "node middle", "refused")
    ours = identity._program()
    monkeypatch.setattr(identity, "_program", lambda: ours | {"subsea/motor": "#01"})
    fault = refused(harness, harness.node(make_sea(seed=99), "right"))
    assert f"has subsea {__version__} with " in fault and "other code in subsea/motor" in fault
    assert told(harness, "node right", "other code in subsea/motor", "refused")


def test_repeated_attempts_do_not_flood_the_log(harness, seas):
    ours = identity.identity_of(seas[0])
    other = Identity(ours.version, ours.parts | {"seed": "4"})
    with zmq.Context() as context:
        stranger = context.socket(zmq.DEALER)
        stranger.linger = 0
        stranger.connect(f"tcp://{harness.address}")
        for k in range(30):
            stranger.send(encode(Hello("left", other)))
            stranger.send(encode(Hello(f"node{k}", ours)))
        harness.show_until(lambda: harness.master._refusals == 30)
        stranger.close()
    assert sum("seed 4 (expected 1): refused" in line for line in harness.told) == 1
    assert sum("not among the nodes" in line for line in harness.told) == 2


def test_garbage_does_not_stop_the_dive(harness, seas):
    left, right = both_in_step(harness, seas)
    host, port = harness.address.split(":")
    with zmq.Context() as context, socket.create_connection((host, int(port))) as raw:
        stranger = context.socket(zmq.DEALER)
        stranger.linger = 0
        stranger.connect(f"tcp://{harness.address}")
        raw.sendall(b"GET / HTTP/1.1\r\n\r\n" * 1000)
        for words in (b"", b"garbage", MAGIC, MAGIC + b"\xff" * 50, b"x" * (SMALL - 10)):
            stranger.send(words)
        stranger.send_multipart([b"one", b"two", b"three"])
        stranger.send(encode(Hello("left", identity.identity_of(seas[0])))[:-1])
        assert_all_show_the_same(harness, left, right)
        harness.show_until(lambda: told(harness, "refused: the message received is not one of"))
        stranger.send(b"x" * (SMALL + 1))  # too long: ends the connection
        for _ in range(50):
            stranger.send(b"garbage")
        assert_all_show_the_same(harness, left, right)
        stranger.close()
    assert sum(line.startswith("refused") for line in harness.told) <= 4  # less than one each
    assert set(harness.master.in_step()) == {"left", "right"}


def test_a_follower_ignores_garbage(seas, address):
    """Another program listens at the master's address."""
    words = []
    with zmq.Context() as context:
        other = context.socket(zmq.ROUTER)
        other.linger = 0
        other.bind(f"tcp://{address}")
        node = Follower(seas[1], "left", "master", address, None, 0.2, words.append)
        before = snapshot.checksum(seas[1])
        node.picture(0.3)
        route, _ = other.recv_multipart()
        for bad in (b"", b"garbage", MAGIC + b"\x00" * 99):
            other.send_multipart([route, bad])
        end = time.monotonic() + 60.0
        while not any("not one of subsea" in line for line in words):
            assert time.monotonic() < end and node.picture(0.3) is None
        assert node.picture(0.3) is None
        assert sum("not one of subsea" in line for line in words) == 1
        assert node.waiting.startswith("waiting for the master at")
        limit = snapshot.size_limit(seas[1]) + SMALL
        other.send_multipart([route, b"x" * (limit + 1)])
        assert node.picture(0.3) is None
        assert snapshot.checksum(seas[1]) == before
        node.close()
        other.close()


class Flood:
    """A socket that has always one more message; it fails after a second."""

    def __init__(self, *frames):
        self.frames, self._end = frames, time.monotonic() + 1.0

    def poll(self, wait_ms):
        assert time.monotonic() < self._end, "the thread is held"
        return 1

    def recv_multipart(self, copy=True):
        return self.frames

    def send(self, data, flags=0):
        return None

    def close(self):
        return None

    disable_monitor = close


@pytest.mark.parametrize("data", [b"garbage", encode(Swap(0)), encode(Picture(9, 0, 0.5, []))])
def test_nobody_at_the_masters_address_holds_a_node(seas, address, data):
    node = Follower(seas[1], "left", "master", address, None, 0.2)
    node._failures.close(0)
    node._socket.close(0)
    node._failures, node._socket = SimpleNamespace(poll=lambda ms: 0, close=int), Flood(data)
    assert node.picture(0.02) is None
    node.swap()
    node.close()


def test_no_node_holds_the_master(harness):
    flood = Flood(SimpleNamespace(bytes=b"route"), SimpleNamespace(bytes=b"garbage"))
    flood.send_multipart = flood.send
    socket, harness.master._socket = harness.master._socket, flood
    try:
        harness.master._hear(0.01)
    finally:
        harness.master._socket = socket


def test_errors_about_states_are_printable(seas, address):
    header = (
        b'{"tick": 0, "seed": 0, "seen_light": {}, "checksum": "", "arrays": [], "\\u001b[2J": 0}'
    )
    data = snapshot.MAGIC + len(header).to_bytes(4, "little") + header
    node = Follower(seas[1], "left", "master", address)
    with pytest.raises(UserError, match=r"sent what is not a snapshot .*\?\[2J"):
        node._take(WorldState("dive", 1, data))
    node.close()


@pytest.mark.nightly
def test_a_restarted_master_begins_a_new_dive(make_harness, seas, address):
    words = []
    harness = make_harness(seas[0], address, timeout_s=1.0)
    left = harness.node(seas[1], "left", told=words)
    assert_all_show_the_same(harness, left)
    harness.master.close()
    harness._stack.pop_all()  # the node stays
    end = time.monotonic() + 60.0
    while not left.node.waiting and time.monotonic() < end:
        time.sleep(0.01)
    assert left.node.waiting == f"waiting for the master at {address}"
    another = make_harness(seas[2], address)
    assert_all_show_the_same(another, left)
    assert left.node.waiting == ""
    left.close()
    assert sum("waiting for the master" in line for line in words) == 2


@pytest.fixture(scope="module")
def keyed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("keys")
    write_keys(folder, ["master", "left", "right", "thief"])
    return folder


def test_only_nodes_with_known_keys_take_part(make_harness, seas, address, keyed):
    harness = make_harness(seas[0], address, keys=read_keys(keyed, "master", ["left", "right"]))
    left = harness.node(seas[1], "left", keys=read_keys(keyed, "left", ["master"]))
    assert_all_show_the_same(harness, left)
    thief = harness.node(seas[2], "right", keys=read_keys(keyed, "thief", ["master"]))
    assert "does not know the key of node right" in refused(harness, thief)
    harness.show_until(lambda: told(harness, "refused: a connection without a key that is known"))
    swapped = harness.node(seas[2], "right", keys=read_keys(keyed, "left", ["master"]))
    assert "it has the key of another node" in refused(harness, swapped)
    keyless = harness.node(seas[2], "right")
    harness.show_until(lambda: NO_KEYS in (keyless.fault or keyless.node.waiting))
    right = harness.node(seas[2], "right", keys=read_keys(keyed, "right", ["master"]))
    assert_all_show_the_same(harness, left, right)


def test_a_node_does_not_follow_a_master_with_another_key(make_harness, seas, address, keyed):
    """An impostor with the nodes' keys but not the master's secret listens in its place."""
    false = read_keys(keyed, "thief", ["left"])
    harness = make_harness(seas[0], address, nodes=["left"], keys=false)
    left = harness.node(seas[1], "left", keys=read_keys(keyed, "left", ["master"]))
    harness.show_pictures(50)
    time.sleep(1.0)
    harness.show_pictures(5)
    assert harness.master.in_step() == []
    assert not left.seen
    assert left.node.waiting or left.fault


def test_strangers_without_a_key_cannot_stop_the_dive(make_harness, seas, address, keyed):
    """A crowd of connections that send a greeting, or nothing, and stay open."""
    harness = make_harness(seas[0], address, keys=read_keys(keyed, "master", ["left", "right"]))
    left = harness.node(seas[1], "left", keys=read_keys(keyed, "left", ["master"]))
    assert_all_show_the_same(harness, left)
    host, port = address.split(":")
    with ExitStack() as stack:
        for k in range(300):
            raw = stack.enter_context(socket.create_connection((host, int(port))))
            raw.sendall(b"\xff" + bytes(8) + b"\x7f\x03\x00NULL" + bytes(48) if k % 2 else b"")
        assert_all_show_the_same(harness, left)
    assert_all_show_the_same(harness, left)
    assert sum(line.startswith("refused") for line in harness.told) <= 3
    assert "late" not in harness.master.report()[0]
    assert "dropped" not in harness.master.report()[0]


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("192.0.2.1:5560", "other computers reach it, so keys are needed"),
        ("[2001:db8::1]:5560", "so keys are needed"),
        ("0.0.0.0:5560", "no node can call it"),
        *((address, "expected an IP address and a port")
          for address in ("localhost:5560", "somewhere:5560", "127.0.0.1", "127.0.0.1:0",
                          "127.0.0.1:99999", "127.0.0.1:٥٥٦٠")),
    ],
)  # fmt: skip
def test_invalid_addresses_are_refused(seas, address, words):
    with pytest.raises(UserError, match=words):
        Master(seas[0], ["left"], address)
    with pytest.raises(UserError, match=words):
        Follower(seas[0], "left", "master", address)


def test_invalid_keys_close_the_sockets(seas, address):
    """The context of a socket left open would wait for ever."""
    none = b"," * 40
    keys = Keys(none, none, {"left": none, "master": none})
    with pytest.raises(UserError, match=r"cannot listen there \(Invalid argument\)"):
        Master(seas[0], ["left"], address, keys)
    with pytest.raises(UserError, match=r"cannot call there \(Invalid argument\)"):
        Follower(seas[0], "left", "master", address, keys)


def test_an_address_in_use_is_refused(harness, seas):
    with pytest.raises(UserError, match="cannot listen there"):
        Master(seas[1], ["left"], harness.address)
