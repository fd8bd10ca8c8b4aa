"""Tell the service manager of this process how it does: the protocol of sd_notify(3)."""

import os
import socket
import time
from contextlib import suppress

from subsea.base.errors import printable

EVERY_S = 1.0  # between two reports of pictures
SOCKET = "NOTIFY_SOCKET"  # variable with the address; "@" begins an abstract one


def notify(**fields: object) -> None:
    """Send fields such as ``READY=1``; without a service manager do nothing.

    Never waits: a message that cannot be sent at once is dropped.
    """
    address = os.environ.get(SOCKET, "")
    if not address or not hasattr(socket, "AF_UNIX"):
        return
    text = "\n".join(f"{name}={printable(str(value))}" for name, value in fields.items())
    with suppress(OSError, ValueError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as one:
        one.setblocking(False)
        one.sendto(text.encode(), f"\0{address[1:]}" if address.startswith("@") else address)


class PictureReports:
    """Reports of shown pictures: the first makes the service ready, each keeps its watchdog calm.

    A window that shows no pictures any more is silent, and the watchdog ends it.
    """

    def __init__(self) -> None:
        self._told = 0  # pictures in the last report
        self._last_s = 0.0

    def update(self, pictures: int, status: str, now_s: float | None = None) -> None:
        """Report the number of `pictures` shown so far, at most once a second."""
        now_s = time.monotonic() if now_s is None else now_s
        if pictures == self._told or (self._told and now_s - self._last_s < EVERY_S):
            return
        if self._told:
            rate = (pictures - self._told) / (now_s - self._last_s)
            notify(WATCHDOG=1, STATUS=f"{status}, {rate:.1f} pictures a second")
        else:
            notify(READY=1, WATCHDOG=1, STATUS=status)
        self._told, self._last_s = pictures, now_s
