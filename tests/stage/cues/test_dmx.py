"""Packets of Art-Net and sACN against bytes of their specifications, and a desk that is gone."""

import socket
import time

import pytest

from subsea.stage.cues.dmx import SENDER, LightSender, artnet_packet, place_of, sacn_packet
from subsea.stage.theatre.theatre_file import Lights


def test_a_packet_of_art_net():
    """Art-Net 4, ArtDmx: table of fields."""
    packet = artnet_packet(0x1234, 7, bytes([255, 128, 1]))
    assert packet == (
        b"Art-Net\0" b"\x00\x50" b"\x00\x0e" b"\x07" b"\x00" b"\x34\x12" b"\x00\x04"
        b"\xff\x80\x01\x00"
    )  # fmt: skip
    assert len(artnet_packet(0, 1, bytes(512))) == 18 + 512


def test_a_packet_of_sacn():
    """ANSI E1.31-2018, table 4-1, and lengths of a full packet in clauses 5 to 7."""
    packet = sacn_packet(0x0102, 9, bytes([255, 3]), priority=120)
    assert len(packet) == 638
    assert packet[:16] == b"\x00\x10\x00\x00ASC-E1.17\x00\x00\x00"
    assert packet[16:22] == b"\x72\x6e\x00\x00\x00\x04"
    assert packet[22:38] == SENDER
    assert packet[38:44] == b"\x72\x58\x00\x00\x00\x02"
    assert packet[44:108] == b"subsea".ljust(64, b"\0")
    assert packet[108:115] == bytes([120, 0, 0, 9, 0, 1, 2])
    assert packet[115:126] == b"\x72\x0b\x02\xa1\x00\x00\x00\x01\x02\x01\x00"
    assert packet[126:] == bytes([255, 3]) + bytes(510)
    assert sacn_packet(1, 0, b"", last=True)[112] == 0x40


def test_places_of_universes():
    sacn, artnet = Lights(protocol="sacn"), Lights(protocol="artnet", address="10.0.0.9", port=7000)
    assert place_of(sacn, 1) == ("239.255.0.1", 5568)
    assert place_of(sacn, 63999) == ("239.255.249.255", 5568)
    assert place_of(artnet, 3) == ("10.0.0.9", 7000)
    with pytest.raises(ValueError, match="expected an IP address"):
        Lights(protocol="sacn", address="desk.local")


@pytest.fixture
def desk():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as made:
        made.bind(("127.0.0.1", 0))
        made.settimeout(20.0)
        yield made


def heard(desk, universe):
    """The next packet of a universe of Art-Net."""
    while True:
        packet = desk.recv(2000)
        if packet[14] == universe:
            return packet


def lights(desk, **rest):
    port = desk.getsockname()[1]
    return Lights(address="127.0.0.1", port=port, rate=44.0, **rest)


def test_levels_are_sent_when_they_change_and_kept_alive(desk):
    sender = LightSender(lights(desk, protocol="artnet"))
    sender.set({1: bytes([9]), 2: bytes([5])})
    first = heard(desk, 1)
    assert first[18:] == bytes([9, 0]) and heard(desk, 2)[18] == 5
    begun = time.monotonic()
    kept = heard(desk, 1)  # nothing has changed
    assert kept[18:] == first[18:] and kept[12] == first[12] + 1
    assert time.monotonic() - begun > 0.5
    sender.set({1: bytes([200]), 2: bytes([5])})
    while heard(desk, 1)[18] != 200:
        pass
    sender.set({1: bytes([3])})
    sender.close()
    while heard(desk, 1)[18] != 3:
        pass


def test_a_source_of_sacn_says_that_it_ends(desk):
    sender = LightSender(lights(desk, protocol="sacn"))
    sender.set({1: bytes([9])})
    assert desk.recv(2000)[112] == 0
    sender.close()
    options = []
    while options[-3:] != [0x40] * 3:
        options.append(desk.recv(2000)[112])


def test_a_desk_that_is_gone_is_one_line_and_may_come_back():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        chosen = lights(one, protocol="artnet")
    sender = LightSender(chosen)  # nobody listens now
    end, lines, level = time.monotonic() + 30.0, [], 0
    while not lines:
        assert time.monotonic() < end
        level = (level + 1) % 256
        sender.set({1: bytes([level])})
        time.sleep(0.02)
        lines += [line] if (line := sender.check()) else []
    assert lines[0].startswith(f"the lights do not answer: 127.0.0.1:{chosen.port} (")
    for _ in range(20):
        level = (level + 1) % 256
        sender.set({1: bytes([level])})
        time.sleep(0.02)
        assert sender.check() == ""
    sender.close()
