"""Messages that a receiver of another library reads, and a receiver that is gone."""

import socket
import time

from pythonosc.osc_message import OscMessage

from subsea.stage.cues.osc_out import OscSender


def test_a_message_arrives_as_it_was():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as desk:
        desk.bind(("127.0.0.1", 0))
        desk.settimeout(20.0)
        sender = OscSender(f"127.0.0.1:{desk.getsockname()[1]}")
        sender.send("/cue/4/start", 3, 2.5, "Grüße", True)
        packet = desk.recv(2000)
        sender.close()
    # OSC 1.0: address and types padded to four bytes, numbers with the highest byte first.
    assert packet.startswith(b"/cue/4/start\0\0\0\0,ifsT\0\0\0\0\0\0\x03\x40\x20\0\0")
    message = OscMessage(packet)
    assert (message.address, message.params) == ("/cue/4/start", [3, 2.5, "Grüße", True])


def test_a_receiver_that_is_gone_is_one_line():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        place = f"127.0.0.1:{one.getsockname()[1]}"
    sender, lines, end = OscSender(place), [], time.monotonic() + 20.0
    while not lines:
        assert time.monotonic() < end
        sender.send("/a", 1)
        time.sleep(0.01)
        lines += [line] if (line := sender.check()) else []
    assert lines[0].startswith(f"OSC to {place} does not arrive (")
    for _ in range(10):
        sender.send("/a", 1)
        assert sender.check() == ""
    sender.close()
