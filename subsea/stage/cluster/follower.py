"""A node of a cluster: steps the same ticks as the master and shows its own windows."""

import math
import time
from collections import deque
from collections.abc import Mapping
from typing import Any

import zmq

from subsea.base.errors import UserError
from subsea.dive.presented import NOTHING
from subsea.stage.cluster import link, messages
from subsea.stage.cluster.identity import NO_VIEW, identity_of
from subsea.stage.cluster.keys import Keys
from subsea.stage.cluster.master import Say
from subsea.stage.theatre.line_up import LineUpState
from subsea.submarine.vessel import NEUTRAL
from subsea.world import snapshot
from subsea.world.step import step
from subsea.world.world import World

CALL_S = 1.0  # interval of calls to a silent master
SILENT_S = 1.0  # shortest silence that counts, as a master may draw slowly
HURRY_S = 0.25  # longest time without a picture while a node catches up
FLEET_HEARD = 64  # messages of the fleet that nobody has taken
ENDED = 3  # connections that end before they begin, after which a node says so
NO_KEYS = "one uses keys and the other does not, or it is another program"


class Follower:
    """The connection to the master: call `picture`; if it returns one, draw, `swap`, show."""

    def __init__(
        self,
        world: World,
        name: str,
        master: str,
        address: str,
        keys: Keys | None = None,
        timeout_s: float = 2.0,
        tell: Say = lambda message: None,
        view: Mapping[str, str] = NO_VIEW,
    ) -> None:
        """Connect to the node `master` at `address` as the node `name`.

        The node stops waiting for a master that is silent for `timeout_s`. With `keys` the master
        must have its known key. `view` must equal the master's. Raises UserErrors.
        """
        self.world = world
        self.waiting = ""  # cause of a wait
        self.presented = NOTHING  # over the sea of the last picture
        self.line_up: LineUpState | None = None  # of the theatre; None: as its file has it
        self.wanted: tuple[str, int] | None = None  # name and seed of the master's scenario
        self._name, self._address, self._timeout_s, self._tell = name, address, timeout_s, tell
        self._identity = identity_of(world, view)
        self._dive = ""  # ID of the dive that it takes part in
        self._joined = False  # True after it has taken part in one
        self._given = b""  # the state that a new master fetches
        self._number = 0  # of the last picture
        self._alpha = 1.0
        self.fleet_heard: deque[bytes] = deque(maxlen=FLEET_HEARD)
        self._heard: deque[messages.FromMaster] = deque()
        self._heard_s = self._called_s = -math.inf
        self._garbled = False
        self._ended = 0  # connections without a handshake since it last heard the master
        self._context: Any = zmq.Context()
        try:
            limit = max(snapshot.size_limit(world), messages.LINE_UP) + messages.SMALL
            self._socket, self._failures = link.calling(self._context, address, keys, master, limit)
        except BaseException:
            self._context.term()
            raise
        self._wait_for(f"waiting for the master at {address}")

    def picture(self, patience_s: float) -> float | None:
        """Step the ticks of the next picture; return the point between the last two to draw at.

        Returns None if no picture comes within `patience_s`; `waiting` then says why, once the
        master has been silent for too long. A node that is behind steps the ticks of all missed
        pictures and draws the last. If the master refuses this node or its key: UserError.
        """
        start, made = time.monotonic(), False
        while True:
            spent = time.monotonic() - start
            message = self._next(0.0 if made else patience_s - spent)
            if message is None or (not made and spent > patience_s + HURRY_S):
                break
            if isinstance(message, messages.WorldState):
                self._take(message)
                made = False
            elif isinstance(message, messages.OpenSea):
                self.wanted = message.name, message.seed
                return None
            elif isinstance(message, messages.Resume):
                self._give(message.offset)
            elif isinstance(message, messages.Picture) and self._dive:
                made |= self._make(message)
            if made and spent > HURRY_S:
                self._wait_for("catching up with the others")
                return None
        if made:
            self._wait_for("")
            return self._alpha
        self._call()
        return None

    def swap(self) -> None:
        """Report the picture as drawn and wait until all nodes show theirs."""
        self._say(messages.PictureDrawn(self._number))
        end = time.monotonic() + self._timeout_s
        while (message := self._next(end - time.monotonic())) is not None:
            if isinstance(message, messages.Swap) and message.number >= self._number:
                return
            if not isinstance(message, messages.Swap):  # the others have gone on
                self._heard.appendleft(message)
                return
            if time.monotonic() > end:
                return

    def report(self, words: str) -> None:
        """Tell the presenter a line, if there is a connection."""
        self._say(messages.NodeReport(words[:1000]))

    def send_fleet(self, data: bytes) -> bool:
        """Send a message of the fleet to the master; False if there is no connection."""
        return self._send(data)

    def ask(self, command: bytes) -> None:
        """Ask the master to apply a command of this node's keyboard, if there is a connection."""
        self._say(messages.NodeRequest(command))

    def renew_view(self, view: Mapping[str, str]) -> None:
        """Take other parts of the view that must equal the master's, after a file was saved."""
        self._identity = identity_of(self.world, view)

    @property
    def lost(self) -> bool:
        """True if the master has fallen silent during a dive."""
        return self._joined and self._silent()

    def drift(self, ticks: int) -> None:
        """Step ticks without the master, which resumes from this state or sends its own."""
        self._dive = ""
        for _ in range(ticks):
            step(self.world, NEUTRAL)

    def close(self) -> None:
        """Close the connection."""
        self._failures.close(0)
        self._socket.disable_monitor()
        self._socket.close()
        self._context.term()

    def _make(self, picture: messages.Picture) -> bool:
        """Step the ticks of a picture; False if it is not the next one, or of another world."""
        if picture.number <= self._number:
            return False
        if picture.number > self._number + 1:
            self._dive, self._called_s = "", -math.inf  # a picture was lost: fetch the state
            return False
        state = self.world.state
        state.submarine.lights[:] = picture.lights
        differs = picture.checksum and picture.checksum != snapshot.checksum(self.world)
        if differs or picture.tick != state.tick:
            self._tell(f"this world differs from the master's at tick {picture.tick}")
            self._say(messages.Diverged(picture.tick))
            self._dive, self._called_s = "", time.monotonic()
            return False
        for steered in messages.ticks_of(picture):
            step(self.world, steered)
        self._number, self._alpha = picture.number, picture.alpha
        self.presented = picture.presented
        self.line_up = self.line_up if picture.line_up is None else picture.line_up
        return True

    def _take(self, state: messages.WorldState) -> None:
        try:
            snapshot.restore(self.world, state.snapshot)
        except UserError as fault:
            raise UserError(f"the master at {self._address} sent what is {fault}") from fault
        self._dive, self._number, self._joined = state.dive, state.number, True
        self._given = b""
        self._tell(f"took the state of the dive at tick {self.world.state.tick}")

    def _give(self, offset: int) -> None:
        """Send a slice of the state of this world to a master that resumes the dive."""
        if offset == 0:
            self._given = snapshot.take(self.world)
        for at in range(offset, min(offset + messages.SLICE, len(self._given)), messages.PART):
            self._say(
                messages.StatePart(len(self._given), at, self._given[at : at + messages.PART])
            )

    def _call(self) -> None:
        """Call the master if it is silent or its state is needed."""
        now, silent = time.monotonic(), self._silent()
        if silent and self._ended < ENDED:
            self._wait_for(f"waiting for the master at {self._address}")
        elif silent:
            self._wait_for(f"at {self._address} each connection ends as it begins: {NO_KEYS}")
        if (silent or not self._dive) and now - self._called_s > CALL_S:
            tick = self.world.state.tick if self._joined else 0
            if self._say(messages.Hello(self._name, self._identity, self._dive, tick)):
                self._called_s = now

    def _silent(self) -> bool:
        return time.monotonic() - self._heard_s > max(self._timeout_s, SILENT_S)

    def _next(self, wait_s: float) -> messages.FromMaster | None:
        """The next message of the master within `wait_s` seconds, or None.

        A bad message does not renew the wait: a flood of them would hold the window's thread.
        """
        self._refuse_failures()
        if self._heard:
            return self._heard.popleft()
        end = time.monotonic() + wait_s
        while self._socket.poll(math.ceil(1000.0 * max(end - time.monotonic(), 0.0))):
            frames = self._socket.recv_multipart()
            try:
                if len(frames) != 1:
                    raise UserError("the message received is not one of subsea")
                if frames[0].startswith(messages.FLEET):
                    self.fleet_heard.append(frames[0])
                    if time.monotonic() >= end:
                        return None
                    continue
                message = messages.from_master(frames[0])
            except UserError as fault:
                if not self._garbled:
                    self._tell(f"the master at {self._address}: {fault}")
                self._garbled = True
                if time.monotonic() >= end:
                    return None
                continue
            self._heard_s, self._ended = time.monotonic(), 0
            if isinstance(message, messages.Refused):
                raise UserError(message.reason)
            return message
        return None

    def _refuse_failures(self) -> None:
        """Raise a UserError if master and node cannot agree on keys.

        If one uses keys and the other does not, the connection mostly ends without a detail: that
        may also be a master that has just gone.
        """
        while why := link.failed(self._failures):
            if why == link.AUTH:
                raise UserError(
                    f"the master at {self._address} does not know the key of node {self._name}"
                )
            if why == link.PROTOCOL:
                raise UserError(
                    f"at {self._address} there is no master that this node can talk to: {NO_KEYS}"
                )
            self._ended += 1

    def _say(self, message: messages.FromNode) -> bool:
        """Send to the master; False if there is no connection."""
        return self._send(messages.encode(message))

    def _send(self, data: bytes) -> bool:
        try:
            self._socket.send(data, zmq.NOBLOCK)
        except zmq.Again:
            return False
        return True

    def _wait_for(self, words: str) -> None:
        if words and words != self.waiting:
            self._tell(words)
        self.waiting = words
