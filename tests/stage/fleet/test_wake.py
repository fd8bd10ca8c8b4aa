"""The packet that wakes a computer, heard by a socket, and networks that refuse it."""

import errno
import socket

import pytest

from subsea.base.errors import UserError
from subsea.stage.fleet.wake import magic_packet, wake
from subsea.stage.theatre.theatre_file import NodeTable


def test_a_magic_packet_arrives():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as card:
        card.bind(("127.0.0.1", 0))
        card.settimeout(20.0)
        place = f"127.0.0.1:{card.getsockname()[1]}"
        wake(NodeTable(name="left", mac="00:1A:2b:3c:4d:5E", wake=place))
        packet = card.recv(2000)
    # AMD, Magic Packet Technology (20213): six bytes FF, then 16 times the address.
    assert packet == b"\xff" * 6 + b"\x00\x1a\x2b\x3c\x4d\x5e" * 16
    assert magic_packet("00-1a-2b-3c-4d-5e") == packet


def test_a_network_that_refuses_is_one_line(monkeypatch):
    def refuse(*given):
        raise OSError(errno.ENETUNREACH, "Network is unreachable")

    monkeypatch.setattr(socket.socket, "sendto", refuse)
    beyond = NodeTable(name="left", mac="00:1a:2b:3c:4d:5e", wake="[2001:db8::1]:9")
    with pytest.raises(
        UserError, match=r"node left: cannot wake it through \[2001:db8::1\]:9 \(Net"
    ):
        wake(beyond)
