"""Tell another program by OSC over UDP what happens in a show. Nothing is awaited."""

import socket
import time
from typing import Any

from pythonosc.osc_message_builder import OscMessageBuilder

from subsea.stage.theatre.theatre_file import parse_address

BACK_S = 3.0  # without a fault, after which a receiver counts as back


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
        self._fault, self._fault_s, self._told = "", 0.0, False

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
            self._fault, self._fault_s = fault.strerror or str(fault), time.monotonic()

    def check(self) -> str:
        """A line if the receiver is gone or back since the last call, else an empty one."""
        gone = bool(self._fault) and time.monotonic() - self._fault_s < BACK_S
        if gone and not self._told:
            self._told = True
            return f"OSC to {self._address} does not arrive ({self._fault}); the show goes on"
        return ""

    def close(self) -> None:
        """Send nothing more."""
        self._socket.close()
