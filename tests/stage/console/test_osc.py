"""Commands by OSC, and packets that have no command."""

import socket
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pythonosc.osc_bundle_builder import IMMEDIATELY, OscBundleBuilder
from pythonosc.osc_message_builder import OscMessageBuilder
from pythonosc.udp_client import SimpleUDPClient

from subsea.stage.console.board import MOST_WAITING, Board
from subsea.stage.console.commands import (
    BlankScreens,
    NextItem,
    SetVolume,
    ShowCaption,
    StartCue,
    StartTour,
    StopTour,
)
from subsea.stage.console.osc import OscConsole


def message(address, *values):
    builder = OscMessageBuilder(address)
    for value in values:
        builder.add_arg(value)
    return builder.build()


def taken(board):
    found = []
    while (request := board.take()) is not None:
        found.append(request[0])
    return found


@pytest.fixture
def heard():
    board = Board()
    console = OscConsole(board)
    yield board, console
    console.connection_lost(None)


def test_a_client_of_another_library_controls_the_dive(console):
    with SimpleUDPClient("127.0.0.1", console.options.osc.port) as client:
        client.send_message("/subsea/tour", "reef")
        client.send_message("/subsea/blank", 1)
        client.send_message("/subsea/volume", 0.25)
        client.send_message("/subsea/caption", ["Good evening", 4.0])
        client.send_message("/subsea/cue", [])
    wanted = [StartTour("reef"), BlankScreens(True), SetVolume(0.25),
              ShowCaption("Good evening", 4.0), StartCue(-1)]  # fmt: skip
    end = time.monotonic() + 20.0
    while len(console.dive.taken) < len(wanted):
        assert time.monotonic() < end
        time.sleep(0.02)
    assert console.dive.taken == wanted


def test_a_bundle_is_taken_at_once_and_not_at_its_time(heard):
    board, console = heard
    builder = OscBundleBuilder(time.time() + 3600.0)
    builder.add_content(message("/subsea/stop-tour"))
    console.datagram_received(builder.build().dgram, None)
    assert taken(board) == [StopTour()]


@pytest.mark.parametrize(
    "packet",
    [
        b"",
        b"/",
        b"/subsea/helm",  # not padded
        b"/subsea/*\0\0\0,\0\0\0",
        message("/other/helm").dgram,
        message("/subsea/nothing").dgram,
        message("/subsea/tour", 7).dgram,
        message("/subsea/tour", "reef", "more").dgram,
        message("/subsea/blank", 2).dgram,
        message("/subsea/volume", float("nan")).dgram,
        message("/subsea/volume", 7.0).dgram,
        message("/subsea/caption", "a" * 301).dgram,
        message("/subsea/caption", "a" * 3000).dgram,
        message("/subsea/tour", b"\xff\xfe").dgram,
        b"/subsea/tour\0\0\0\0,s\0\0\xff\xff\xff\xff\0\0\0\0",
        b"/subsea/tour\0\0\0\0,qqqqqq\0",  # unknown types
        b"/subsea/tour\0\0\0\0,[[[[[[\0",
        b"/subsea/tour\0\0\0\0,b\0\0\x7f\xff\xff\xff",  # a blob of 2 GB
        b"#bundle\0" + b"\0" * 8 + b"\x7f\xff\xff\xff",
        b"#bundle\0" + b"\0" * 8 + b"\xff\xff\xff\xff",
        (b"#bundle\0" + b"\0" * 7 + b"\1" + b"\0\0\7\xd0") * 100,  # one within the other
    ],
)
def test_what_is_no_command_is_dropped_in_silence(heard, capfd, packet):
    board, console = heard
    console.datagram_received(packet, None)
    assert taken(board) == []
    for_others = packet.startswith((b"/other", b"#bundle"))  # or for nobody
    assert for_others or board.refusals.state is not None
    assert capfd.readouterr() == ("", "")


@given(st.binary(max_size=400), st.booleans())
def test_any_packet_is_survived(data, bundle):
    board = Board()
    console = OscConsole(board)
    console.datagram_received(b"#bundle\0" * bundle + data, None)
    console.datagram_received(b"/subsea/" + data, None)
    console.connection_lost(None)


def test_what_a_flood_sends_beyond_the_queue_is_lost(heard):
    board, console = heard
    builder = OscBundleBuilder(IMMEDIATELY)
    for _ in range(50):
        builder.add_content(message("/subsea/helm"))
    console.datagram_received(builder.build().dgram, None)
    assert len(taken(board)) == MOST_WAITING


def test_a_button_that_is_released_is_no_refusal(heard):
    board, console = heard
    for pressed in (1.0, 0.0):
        console.datagram_received(message("/subsea/next-item", pressed).dgram, None)
    assert taken(board) == [NextItem()] and board.refusals.state is None
    console.datagram_received(message("/subsea/blank", 0.5).dgram, None)
    assert (
        board.refusals.state.text == "OSC /subsea/blank: expected true or false, got 0.5, at `on`"
    )


def test_nothing_is_answered(console):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.settimeout(0.5)
        for packet in (b"garbage", message("/subsea/helm").dgram, message("/subsea/x").dgram):
            client.sendto(packet, ("127.0.0.1", console.options.osc.port))
        with pytest.raises(TimeoutError):
            client.recv(100)
