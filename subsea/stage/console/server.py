"""The thread of the console's server, which ends with the dive and never ends it."""

import asyncio
import os
import socket
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import closing, suppress
from threading import Thread
from typing import Any

from subsea.base.errors import UserError
from subsea.stage.console.board import Board
from subsea.stage.console.options import ConsoleOptions, ListenAddress

BEGIN_S, END_S = 20.0, 3.0  # longest times to begin, and to end
BACKLOG = 64


class ConsoleServer:
    """Listens in a thread of its own until it is closed."""

    def __init__(self, options: ConsoleOptions, board: Board) -> None:
        """Begin to listen; a UserError if that is impossible, as when a port is taken."""
        self._options, self._board = options, board
        self._fault: str | None = None
        http = _bound(options.http, socket.SOCK_STREAM, "--console")
        osc = None
        try:
            if options.osc is not None:
                osc = _bound(options.osc, socket.SOCK_DGRAM, "--console-osc")
        except UserError:
            http.close()
            raise
        begun: Future[Callable[[], object]] = Future()  # gives a function that stops the server
        self._thread = Thread(
            target=self._run, args=(http, osc, begun), name="console", daemon=True
        )
        self._thread.start()
        try:
            self._stop = begun.result(BEGIN_S)
        except Exception as fault:
            begun.cancel()  # a server that begins too late ends again
            raise UserError(f"the console: {str(fault) or 'cannot begin'}") from fault

    def check(self) -> str:
        """Why the server has ended by itself, once; empty if it has not."""
        words, self._fault = self._fault, None
        return "" if words is None else f"the console has ended: {words}"

    def close(self) -> None:
        """Stop listening and end all connections."""
        with suppress(RuntimeError):  # its loop has ended
            self._stop()
        self._thread.join(END_S)

    def _run(self, http: socket.socket, osc: socket.socket | None, begun: Future[Any]) -> None:
        try:
            with closing(http), closing(osc or http):
                asyncio.run(self._serve(http, osc, begun))
        except Exception as fault:  # whatever it is, the dive goes on
            if begun.done():
                self._fault = str(fault) or type(fault).__name__
            else:
                begun.set_exception(fault)

    async def _serve(
        self, http: socket.socket, osc: socket.socket | None, begun: Future[Any]
    ) -> None:
        from subsea.stage.console.http import Connections, HttpConsole
        from subsea.stage.console.osc import OscConsole

        loop, stopped = asyncio.get_running_loop(), asyncio.Event()
        loop.set_exception_handler(lambda *_: None)  # of connections that break
        console = HttpConsole(self._options, self._board)
        runner = console.runner()
        await runner.setup()
        connections = Connections(self._options, console, runner.server)
        accepting = loop.create_task(connections.accept(http))
        accepting.add_done_callback(lambda _: stopped.set())
        transport: Any = None
        if osc is not None:
            transport, _ = await loop.create_datagram_endpoint(
                lambda: OscConsole(self._board), sock=osc
            )
        begun.set_result(lambda: loop.call_soon_threadsafe(stopped.set))
        await stopped.wait()
        ended = accepting.done()
        accepting.cancel()
        if transport is not None:
            transport.close()
        await connections.close()
        await runner.cleanup()
        if ended:
            accepting.result()


def _bound(place: ListenAddress, kind: socket.SocketKind, option: str) -> socket.socket:
    """A socket at an address; a UserError if it is taken or not this computer's."""
    family = socket.AF_INET6 if place.ip.version == 6 else socket.AF_INET
    made = socket.socket(family, kind)
    try:
        if kind == socket.SOCK_STREAM and os.name == "posix":  # elsewhere it would share a port
            made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        made.bind((str(place.ip), place.port))
        if kind == socket.SOCK_STREAM:
            made.listen(BACKLOG)
        made.setblocking(False)
    except OSError as fault:
        made.close()
        raise UserError(f"{option} {place}: cannot listen there ({fault.strerror})") from fault
    return made
