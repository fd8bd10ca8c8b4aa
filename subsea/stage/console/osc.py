"""Commands by OSC over UDP: `/subsea/COMMAND VALUE…`. The only module that speaks OSC.

Nothing is answered, so that a forged sender gets nothing. Time tags and patterns in addresses have
no effect.
"""

import asyncio
import logging
from typing import Any

from pythonosc.osc_packet import OscPacket

from subsea.base.errors import UserError
from subsea.stage.console.board import Board, RateLimit
from subsea.stage.console.commands import from_words

PREFIX = "/subsea/"
MAX_PACKET, MAX_MESSAGES = 2048, 8  # bytes; messages in a bundle
PACKETS_A_S = 60.0


class OscConsole(asyncio.DatagramProtocol):
    """Puts the commands of packets on the board; `refused` counts the others."""

    def __init__(self, board: Board) -> None:
        self._board = board
        self._limit = RateLimit(PACKETS_A_S, int(PACKETS_A_S))
        self.refused = 0
        logging.getLogger().addFilter(_not_of_packets)

    def connection_lost(self, exc: Exception | None) -> None:
        """Let the parser log again."""
        logging.getLogger().removeFilter(_not_of_packets)

    def datagram_received(self, data: bytes, addr: Any) -> None:
        """Take a packet of any content."""
        # A packet cannot be delayed as a request can: one too many is lost.
        if len(data) > MAX_PACKET or self._limit.delay() is None:
            self.refused += 1
            return
        try:
            messages = OscPacket(data).messages
        except Exception:  # the parser has various errors
            self.refused += 1
            return
        for timed in messages[:MAX_MESSAGES]:
            try:
                self._give(timed.message.address, list(timed.message))
            except UserError:
                self.refused += 1

    def _give(self, address: str, values: list[Any]) -> None:
        if not address.startswith(PREFIX):
            raise UserError(f"expected an address that begins with {PREFIX}")
        self._board.put(from_words(address.removeprefix(PREFIX), values))

    def error_received(self, exc: Exception) -> None:
        """Ignore what a receiver of nothing said."""


def _not_of_packets(record: logging.LogRecord) -> bool:
    """False for warnings of the parser: senders of packets must not fill the terminal."""
    return record.module not in ("osc_message", "osc_bundle")
