"""Listen at the master's address without a dive: nodes that look for their master call there."""

import math
import time
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import zmq

from subsea.stage.cluster import link, messages
from subsea.stage.cluster.keys import Keys


class RollCall:
    """The connections to the nodes while no dive runs on the master's computer."""

    def __init__(self, address: str, keys: Keys) -> None:
        """Listen at `address` for the computers whose keys are known; or a UserError."""
        self.address = address
        self._names = {key.decode(): name for name, key in keys.others.items()}
        self._routes: dict[str, bytes] = {}
        self._context: Any = zmq.Context()
        self._authenticator: Any = None
        try:
            self._authenticator = link.authenticator(self._context, keys)
            self._socket, self._failures = link.listening(
                self._context, address, keys, messages.SMALL
            )
        except BaseException:
            self._leave()
            raise

    def hear(self, wait_s: float) -> Iterator[tuple[str, bytes]]:
        """Wait up to `wait_s` for nodes, and give what they say: name and message of the fleet."""
        end = time.monotonic() + wait_s
        while self._socket.poll(math.ceil(1000.0 * wait_s)):
            wait_s = 0.0
            route, *content = self._socket.recv_multipart(copy=False)
            if len(content) == 1 and (name := self._names.get(content[0].get("User-Id"))):
                self._routes[name] = route.bytes
                if (data := content[0].bytes).startswith(messages.FLEET):
                    yield name, data
            if time.monotonic() > end:
                return

    def send(self, name: str, data: bytes) -> None:
        """Send a message of the fleet to a node; one that has gone misses it."""
        if name in self._routes:
            with suppress(zmq.ZMQError):
                self._socket.send_multipart([self._routes[name], data], zmq.NOBLOCK)

    def close(self) -> None:
        """Close all connections; a second call does nothing."""
        if self._socket.closed:
            return
        self._failures.close(0)
        self._socket.disable_monitor()
        self._socket.close()
        self._leave()

    def _leave(self) -> None:
        if self._authenticator:
            self._authenticator.stop()
        self._context.term()
