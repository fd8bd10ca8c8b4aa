"""A node's side of the fleet: reports state and picture, follows the technician's orders."""

from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor

from subsea.base.arrays import Bytes
from subsea.stage.fleet import messages
from subsea.stage.fleet.pictures import bounded_jpeg, parts_of
from subsea.stage.fleet.updates import Updates

NO_KEYS = "updates need keys: `subsea keys` makes them, `keys` in [cluster] uses them"
MOST_INTERVALS = 10_000  # pictures between two reports


class FrameTimes:
    """Times from picture to picture, ms, between two reports."""

    def __init__(self) -> None:
        self._intervals: deque[float] = deque(maxlen=MOST_INTERVALS)

    def add(self, elapsed_s: float) -> None:
        """Add the time since the last picture."""
        self._intervals.append(1e3 * elapsed_s)

    def take(self) -> tuple[float, float]:
        """Mean and longest time since the last call; 0 without pictures."""
        times = list(self._intervals)
        self._intervals.clear()
        return sum(times) / max(len(times), 1), max(times, default=0.0)


class FleetStation:
    """Follows the orders of the master; pictures are compressed in a thread."""

    def __init__(self, updates: Updates | None = None) -> None:
        """`updates` follows those orders; None: they are refused, as there are no keys."""
        self.picture_wanted = False
        self._restarts, self._updates = False, updates
        self._refusals: list[messages.Answer] = []
        self._thread = ThreadPoolExecutor(1, "fleet picture")
        self._jpeg: Future[bytes] | None = None  # the picture that is being compressed

    def hear(self, data: bytes) -> None:
        """Take a message of the master; a UserError for one that is faulty."""
        message = messages.from_master(data)
        if isinstance(message, messages.Restart):
            self._restarts = True
        elif isinstance(message, messages.PictureWanted):
            self.picture_wanted = True
        elif self._updates is not None:
            self._updates.hear(message)
        else:
            order = str(message.__struct_config__.tag)
            self._refusals.append(messages.Answer(order, False, NO_KEYS))

    @property
    def restarts(self) -> bool:
        """True if this computer is to start again."""
        return self._restarts or (self._updates is not None and self._updates.restarts)

    def take_answers(self) -> list[bytes]:
        """Take the answers to orders of an update."""
        answers, self._refusals = self._refusals, []
        if self._updates is not None:
            answers += self._updates.take_answers()
        return [messages.encode(answer) for answer in answers]

    def show(self, pixels: Bytes) -> None:
        """Compress a picture (h, w, 4), unless one is under way."""
        if self._jpeg is None:
            self.picture_wanted = False
            self._jpeg = self._thread.submit(bounded_jpeg, pixels.copy())

    def take_parts(self) -> list[bytes]:
        """Take the messages of a picture that is ready."""
        if self._jpeg is None or not self._jpeg.done():
            return []
        jpeg, self._jpeg = self._jpeg.result(), None
        return [messages.encode(part) for part in parts_of(jpeg)]

    def close(self) -> None:
        """End the threads."""
        self._thread.shutdown(cancel_futures=True)
        if self._updates is not None:
            self._updates.close()
