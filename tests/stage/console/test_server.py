"""The thread of the server begins and ends with the dive, and never ends it."""

import socket
from dataclasses import replace

import pytest

from subsea.base.errors import UserError
from subsea.stage.console import http
from subsea.stage.console.board import Board
from subsea.stage.console.server import ConsoleServer
from tests.stage.console.conftest import local


@pytest.mark.parametrize("which", ["http", "osc"])
def test_a_port_that_is_taken_is_one_line(which):
    options = local()
    place = getattr(options, which)
    kind = socket.SOCK_STREAM if which == "http" else socket.SOCK_DGRAM
    with socket.socket(socket.AF_INET, kind) as other:
        other.bind((str(place.ip), place.port))
        if which == "http":
            other.listen()
        with pytest.raises(UserError) as fault:
            ConsoleServer(options, Board())
    assert f"{place}: cannot listen there" in str(fault.value)
    ConsoleServer(options, Board()).close()  # nothing is left open


def test_it_listens_again_after_it_was_closed():
    options = local()
    for _ in range(3):
        server = ConsoleServer(options, Board())
        assert server.check() == ""
        server.close()
        assert not server._thread.is_alive()


def test_a_fault_at_the_start_is_one_line(monkeypatch):
    def fail(self):
        raise RuntimeError("it fails")

    monkeypatch.setattr(http.HttpConsole, "runner", fail)
    options = replace(local(), osc=None)
    with pytest.raises(UserError, match="the console: it fails"):
        ConsoleServer(options, Board())


def test_a_fault_later_is_told_once(monkeypatch):
    from subsea.stage.console import http as connections

    async def fail(self, listener):
        raise RuntimeError("it fails")

    monkeypatch.setattr(connections.Connections, "accept", fail)
    server = ConsoleServer(replace(local(), osc=None), Board())
    server._thread.join(20.0)
    assert server.check() == "the console has ended: it fails"
    assert server.check() == ""
    server.close()
