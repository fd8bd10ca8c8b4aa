"""Accept connections, few at a time, and end those that do nothing."""

import asyncio
import socket
from collections import Counter
from typing import Any

from subsea.stage.console.http import ANSWER_S, HttpConsole
from subsea.stage.console.options import ConsoleOptions

CLIENTS = 128  # connections at once
OF_ONE = 16  # of one address that is not this computer's
ACCEPTS_A_S = 50.0
HANDSHAKE_S = 5.0  # longest time for that of TLS
IDLE_S = ANSWER_S + 4.0  # without an answer, also while a request trickles in
SWEEP_S = 1.0


class Connections:
    """The open connections of the HTTP console, made in the loop of the server's thread."""

    def __init__(self, options: ConsoleOptions, http: HttpConsole, factory: Any) -> None:
        """`factory` makes the protocol of a connection, and lists them in `connections`."""
        self._options, self._http, self._factory = options, http, factory
        self._sockets: dict[socket.socket, str] = {}  # that are open, with their address
        self._tasks: set[asyncio.Task[None]] = set()

    async def accept(self, listener: socket.socket) -> None:
        """Accept connections for ever."""
        loop = asyncio.get_running_loop()
        while True:
            await asyncio.sleep(1.0 / ACCEPTS_A_S)
            try:
                client, address = await loop.sock_accept(listener)
            except OSError:  # no file number is left, or the client has gone
                await asyncio.sleep(0.5)
                continue
            origin = address[0]
            own = self._options.http.ip.is_loopback
            crowded = Counter(self._sockets.values())[origin] >= OF_ONE and not own
            if len(self._sockets) >= CLIENTS or crowded:
                client.close()
                continue
            self._sockets[client] = origin
            task = loop.create_task(self._serve(client))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

    async def _serve(self, client: socket.socket) -> None:
        """Serve one connection to its end."""
        loop, tls = asyncio.get_running_loop(), self._options.tls
        transport: asyncio.Transport | None = None
        try:
            limit = HANDSHAKE_S if tls else None
            transport, protocol = await loop.connect_accepted_socket(
                self._factory, client, ssl=tls, ssl_handshake_timeout=limit
            )
            begun = loop.time()
            while protocol in self._factory.connections and not transport.is_closing():
                await asyncio.sleep(SWEEP_S)
                last = self._http.answered.get(protocol, begun)
                if loop.time() - last > IDLE_S:
                    transport.abort()
            self._http.answered.pop(protocol, None)
        except (TimeoutError, OSError, EOFError):  # a failed handshake
            pass
        finally:
            self._sockets.pop(client, None)
            if transport is not None:
                transport.abort()
            else:
                client.close()

    async def close(self) -> None:
        """End all connections."""
        for task in list(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await asyncio.sleep(0)  # the transports close now
