"""A console on a board whose dive is a thread that notes its commands."""

import http.client
import json
import socket
import threading
import time
from dataclasses import replace
from ipaddress import ip_address
from typing import Any

import msgspec
import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.stage.console.board import Board
from subsea.stage.console.commands import (
    BlankScreens,
    LineUpCommand,
    PresenterCommand,
    ShowCaption,
)
from subsea.stage.console.options import ConsoleOptions, ListenAddress, console_options
from subsea.stage.console.server import ConsoleServer
from subsea.stage.line_up import apply_command
from subsea.stage.theatre.line_up import Adjustments, LineUp
from tests.support.browser import browser

TOKEN = "a-token-of-more-than-thirty-two-letters"
STATE: dict[str, Any] = {
    "title": "A bay", "scenario": "bay", "tours": ["auto", "directed", "reef"], "tour": None,
    "scenarios": [{"name": "bay", "title": "A bay"}, {"name": "deep", "title": "The deep"}],
    "cues": [{"number": 0, "name": "sharks", "caption": "Here they come", "begun": True},
             {"number": 1, "name": "", "caption": "", "begun": False}],
    "next_cue": 1, "caption": "", "fish": None, "quality": "auto", "quality_now": "picture auto",
    "species": [{"name": "moon_wrasse", "living": 7}, {"name": "extinct", "living": 0}],
    "volume": 0.6, "blank": False, "line_up": False, "several_computers": False,
    "nodes": [{"name": "left", "connected": True, "in_step": True, "last_ms": 1.25, "mean_ms": 2.0,
               "longest_ms": 9.0, "late": 0, "dropped": 0, "diverged": 0}],
    "projectors": None, "fleet": None, "loading": False, "pictures_a_s": 59.9, "up_s": 100.0,
    "fault": None,
    "show": {
        "title": "Afternoons", "item": 2, "items": 2, "open": True, "elapsed_s": 30.0,
        "next": "cue", "hours": "open 10:00 to 17:00",
        "programme": [
            {"scenario": "bay", "tour": "reef", "start": "after", "for_s": 60.0, "languages": 1,
             "caption": "Good morning", "on": True},
            {"scenario": None, "tour": None, "start": "cue", "for_s": None, "languages": 2,
             "caption": "Here they come", "on": False},
        ],
        "special_days": [{"title": "Gala", "when": "each 12-24", "hours": "closed", "now": True}],
    },
}  # fmt: skip


def free_port(kind: socket.SocketKind = socket.SOCK_STREAM) -> int:
    """A port of this computer that nobody uses."""
    with socket.socket(socket.AF_INET, kind) as taken:
        taken.bind(("127.0.0.1", 0))
        return int(taken.getsockname()[1])


@pytest.fixture(scope="module")
def page():
    """A page in a browser."""
    with browser() as one:
        one.size(1024, 768)
        yield one


class FakeDive:
    """Takes commands as a dive does, and refuses captions that say so."""

    def __init__(self, board: Board) -> None:
        self.board, self.state = board, dict(STATE)
        self.taken: list[PresenterCommand] = []
        self.line_up: LineUp | None = None  # of a theatre
        self.saved: list[Adjustments] = []
        self.nodes_wanted: list[str] = []  # the page asks for pictures of these nodes
        self.alive = True  # beats
        self.stops = False  # takes no commands
        self._ends = False
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def close(self) -> None:
        self._ends = True
        self._thread.join()

    def _run(self) -> None:
        while not self._ends:
            if self.alive:
                self.board.beat()
            self.board.state = msgspec.json.encode(self.state)
            self.board.health = msgspec.json.encode({"up_s": 100.0, "fault": None})
            while not self.stops and (request := self.board.take()) is not None:
                command, done = request
                self.taken.append(command)
                if isinstance(command, BlankScreens):
                    self.state["blank"] = command.on
                try:
                    done.set_result(self._apply(command))
                except UserError as fault:
                    done.set_exception(fault)
            self.nodes_wanted += self.board.take_wanted_nodes()
            if self.board.picture_wanted:
                ramp = np.linspace(0, 255, 64 * 36 * 4).reshape(36, 64, 4)
                self.board.show(ramp.astype(np.uint8))
            time.sleep(0.01)

    def _apply(self, command: PresenterCommand) -> str:
        if isinstance(command, ShowCaption) and command.text == "refuse":
            raise UserError("the dive refuses")
        if isinstance(command, LineUpCommand) and self.line_up is not None:
            done = apply_command(self.line_up, command, self.saved.append)
            self.state["projectors"] = self.line_up.describe()
            self.board.state = msgspec.json.encode(self.state)
            return done
        return "done"


class Client:
    """A client of a console at a port of this computer."""

    def __init__(self, port: int) -> None:
        self.port, self.host = port, f"127.0.0.1:{port}"

    def ask(self, path: str, content: Any = None, /, **headers: str) -> tuple[int, Any, Any]:
        """GET a path, or POST JSON; returns status, content and headers."""
        client = http.client.HTTPConnection("127.0.0.1", self.port, timeout=30)
        try:
            sent = {"Host": self.host, "Connection": "close"}
            sent |= {name.replace("_", "-"): value for name, value in headers.items()}
            body = None
            if content is not None:
                body = content if isinstance(content, bytes) else json.dumps(content)
                sent.setdefault("Content-Type", "application/json")
            client.request("GET" if content is None else "POST", path, body, sent)
            answer = client.getresponse()
            data = answer.read()
            kind = answer.headers.get_content_type()
            return answer.status, json.loads(data) if "json" in kind else data, answer.headers
        finally:
            client.close()


class Console(Client):
    """A console, its dive, and a client."""

    def __init__(self, options: ConsoleOptions) -> None:
        super().__init__(options.http.port)
        self.options, self.board = options, Board()
        self.dive = FakeDive(self.board)
        self.server = ConsoleServer(options, self.board)

    def close(self) -> None:
        self.server.close()
        self.dive.close()


def local(**changes: Any) -> ConsoleOptions:
    """Options of a console for this computer, on ports that are free."""
    ip = ip_address("127.0.0.1")
    osc = ListenAddress(ip, free_port(socket.SOCK_DGRAM))
    return replace(ConsoleOptions(ListenAddress(ip, free_port()), osc), **changes)


@pytest.fixture
def console():
    """A console that needs no token."""
    made = Console(local())
    yield made
    made.close()


@pytest.fixture
def guarded():
    """A console that needs one."""
    made = Console(local(token=TOKEN))
    yield made
    made.close()


@pytest.fixture
def secure(certificate, tmp_path):
    """A console with TLS and a token, as for other computers."""
    file = tmp_path / "token"
    file.write_text(TOKEN)
    file.chmod(0o600)
    options, _ = console_options(f"127.0.0.1:{free_port()}", None, file, certificate)
    made = Console(options)
    yield made
    made.close()
