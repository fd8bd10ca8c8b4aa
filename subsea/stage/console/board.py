"""Exchange between the thread of the dive and that of the console's server.

The dive writes the state and pictures, and takes commands between two frames. The server reads
them, and puts commands into a queue of bounded length.
"""

import time
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from queue import Empty, Full, Queue

import numpy as np

from subsea.base.arrays import Bytes
from subsea.base.errors import UserError
from subsea.dive.captions import FaultLog
from subsea.stage.console.commands import PresenterCommand

MOST_WAITING = 32  # commands that the dive has not taken yet
WANTED_S = 2.0  # the dive makes pictures so long after the last request for one
ALIVE_S = 10.0  # a dive that has drawn nothing for longer is reported as stuck
RETRY = "the dive is busy, try again"

Request = tuple[PresenterCommand, "Future[str]"]


class Board:
    """State, picture and heartbeat of the dive, and the queue of commands to it."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """`clock` gives the time, s."""
        self.state = b"{}"  # JSON
        self.health = b"{}"  # JSON
        self.picture: Bytes | None = None  # (h, w, 4)
        self.picture_number = 0  # changes with the picture
        self.node_pictures: dict[str, bytes] = {}  # the last JPEG of each node
        self.refusals = FaultLog(clock)  # of commands; the last is seen in state and health
        self._clock = clock
        self._waiting: Queue[Request] = Queue(MOST_WAITING)
        self._wanted_nodes: Queue[str] = Queue(MOST_WAITING)
        self._wanted_s = self._beat_s = -np.inf

    def put(self, command: PresenterCommand) -> "Future[str]":
        """Ask the dive for a command; its result is a text, or a UserError.

        A UserError if too many are waiting.
        """
        done: Future[str] = Future()
        try:
            self._waiting.put_nowait((command, done))
        except Full:
            raise UserError(RETRY) from None
        return done

    def take(self) -> Request | None:
        """The next command that is still wanted; None if there is none. For the dive."""
        while True:
            try:
                command, done = self._waiting.get_nowait()
            except Empty:
                return None
            if done.set_running_or_notify_cancel():
                return command, done

    def want_picture(self) -> None:
        """Ask the dive for pictures for a while."""
        self._wanted_s = self._clock()

    @property
    def picture_wanted(self) -> bool:
        """True if somebody looks at the pictures."""
        return self._clock() - self._wanted_s < WANTED_S

    def want_node(self, name: str) -> None:
        """Ask the dive for a picture of a node; too many requests are dropped."""
        with suppress(Full):
            self._wanted_nodes.put_nowait(name)

    def take_wanted_nodes(self) -> list[str]:
        """Take the names of the nodes whose pictures are wanted. For the dive."""
        names = []
        with suppress(Empty):
            while True:
                names.append(self._wanted_nodes.get_nowait())
        return names

    def show(self, picture: Bytes) -> None:
        """Publish a picture (h, w, 4)."""
        self.picture = picture
        self.picture_number += 1

    def beat(self) -> None:
        """Note that the dive is alive."""
        self._beat_s = self._clock()

    @property
    def beat_age_s(self) -> float:
        """Time since the dive was last alive; infinite before."""
        return self._clock() - self._beat_s

    @property
    def alive(self) -> bool:
        """True if the dive has drawn within ALIVE_S."""
        return self.beat_age_s < ALIVE_S
