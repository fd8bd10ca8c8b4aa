"""Commands by OSC over UDP: `/subsea/COMMAND VALUE…`. The only module that speaks OSC.

Nothing is answered, so that a forged sender gets nothing. The board keeps the last refusal. Time
tags and patterns in addresses have no effect.
"""

import asyncio
import logging
from typing import Any

from pythonosc.osc_packet import OscPacket

from subsea.base.errors import UserError
from subsea.stage.console.board import Board
from subsea.stage.console.commands import from_words

PREFIX = "/subsea/"


class OscConsole(asyncio.DatagramProtocol):
    """Puts the commands of packets on the board."""

    def __init__(self, board: Board) -> None:
        self._board = board
        logging.getLogger().addFilter(_not_of_packets)

    def connection_lost(self, exc: Exception | None) -> None:
        """Let the parser log again."""
        logging.getLogger().removeFilter(_not_of_packets)

    def datagram_received(self, data: bytes, addr: Any) -> None:
        """Take a packet of any content."""
        try:
            messages = [timed.message for timed in OscPacket(data).messages]
        except Exception:  # the parser has various errors
            self._board.refusals.add("OSC: a packet that has no message")
            return
        for message in messages:
            if not message.address.startswith(PREFIX):
                continue
            try:
                command = from_words(message.address.removeprefix(PREFIX), list(message))
                if command is not None:
                    self._board.put(command)
            except UserError as fault:
                self._board.refusals.add(f"OSC {message.address[:100]}: {fault}")

    def error_received(self, exc: Exception) -> None:
        """Ignore what a receiver of nothing said."""


def _not_of_packets(record: logging.LogRecord) -> bool:
    """False for warnings of the parser: senders of packets must not fill the terminal."""
    return record.module not in ("osc_message", "osc_bundle")
