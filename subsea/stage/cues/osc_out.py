"""Tell another program by OSC over UDP what happens in a show. Nothing is awaited."""

import socket
from typing import Any

from pythonosc.osc_message_builder import OscMessageBuilder

from subsea.stage.theatre.theatre_file import parse_address


class OscSender:
    """Sends messages to one address; a receiver that is gone is one line."""

    def __init__(self, address: str) -> None:
        """`address` is an IP address with a port."""
        ip, port = parse_address(address)
        family = socket.AF_INET6 if ip.version == 6 else socket.AF_INET
        self._place, self._address = (str(ip), port), address
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._connected = False
        self._fault, self._told = "", False

    def send(self, address: str, *values: Any) -> None:
        """Send a message; numbers, texts, True and False."""
        builder = OscMessageBuilder(address)
        for value in values:
            builder.add_arg(value)
        try:
            if not self._connected:  # so that a computer without the port is noticed
                self._socket.connect(self._place)
                self._connected = True
            self._socket.send(builder.build().dgram)
        except OSError as fault:
            self._fault = fault.strerror or str(fault)

    def check(self) -> str:
        """A line when the first message does not arrive, else an empty one."""
        if not self._fault or self._told:
            return ""
        self._told = True
        return f"OSC to {self._address} does not arrive ({self._fault}); the show goes on"

    def close(self) -> None:
        """Send nothing more."""
        self._socket.close()
