"""Pause, single ticks, slow and fast motion, and rewind over the last minute.

The timeline stores the order of each tick of the last minute, and about one snapshot of the world a
second. It restores any tick of that minute from the snapshot before by repeating the orders since:
the same orders give the same world, to the byte (`snapshot.checksum`).

Code that changes the world between two ticks, as a panel does, must call `Timeline.touch`, which
also stores a snapshot. Dragging a slider makes many. If memory is short some are dropped; less than
a second of ticks after each dropped snapshot cannot be restored.
"""

from typing import NamedTuple

import numpy as np

from subsea.base.language import translated
from subsea.dive.idle_timer import MAX_TICKS_PER_FRAME, TickClock
from subsea.world import snapshot
from subsea.world.feeding import scatter_food
from subsea.world.step import Order, step
from subsea.world.to_scenario import Tunables, get_tunables, set_tunables
from subsea.world.world import TICK_S, World

RATES = (0.25, 0.5, 1.0, 2.0, 4.0)
REACH_TICKS = round(60.0 / TICK_S)  # range of stored orders and snapshots
KEPT_TICKS = round(1.0 / TICK_S)  # between snapshots
MOST_BYTES = 256 * 2**20  # of snapshots; a full store shortens the range


class _Kept(NamedTuple):
    """A snapshot of the world before a tick."""

    tick: int
    world: bytes  # see `snapshot.take`
    constants: Tunables
    touched: bool  # the world was changed after the tick before
    sure: float = np.inf  # the last tick that can be made from it


class _Made(NamedTuple):
    """Inputs of a tick, besides the world."""

    order: Order
    seen_light: dict[int, float]


class Timeline:
    """The time of a world on one computer."""

    def __init__(self, world: World, most_bytes: int = MOST_BYTES) -> None:
        """Start at the current world. Snapshots use at most about `most_bytes`."""
        self._world, self._most_bytes = world, most_bytes
        self._clock = TickClock(TICK_S)
        self._kept: list[_Kept] = []  # by rising tick
        self._made: list[_Made] = []  # all ticks since the first snapshot
        self._singles = 0  # single ticks that are due
        self._wanted: int | None = None  # the tick to go to
        self.rate = 1.0  # simulated seconds in a second
        self.paused = False
        self._keep()

    @property
    def tick(self) -> int:
        """The current tick."""
        return self._world.state.tick

    @property
    def earliest(self) -> int:
        """The first tick that can be restored."""
        return self._kept[0].tick

    @property
    def latest(self) -> int:
        """The last tick that was made: later than the current one after going back."""
        return self._kept[0].tick + len(self._made)

    @property
    def bytes(self) -> int:
        """Memory of all snapshots."""
        return sum(len(kept.world) for kept in self._kept)

    @property
    def alpha(self) -> float:
        """The point between the last two ticks at which to draw: see `clock.TickClock`."""
        return 1.0 if self.paused else self._clock.alpha

    @property
    def text(self) -> str:
        """The state of time as a text, empty if normal."""
        words = [translated("paused")] if self.paused else []
        if self.rate != 1.0:
            words.append(translated("time ×{rate}").format(rate=f"{self.rate:g}"))
        if self.paused and self.tick < self.latest:
            back_s = f"{(self.latest - self.tick) * TICK_S:.1f}"
            words.append(translated("{seconds} s back").format(seconds=back_s))
        return ", ".join(words)

    def pause(self) -> None:
        """Pause or continue."""
        self.paused = not self.paused
        if not self.paused:
            self._clock.fill()  # the last tick was already shown in full

    def single(self) -> None:
        """Make one more tick, then pause."""
        if not self.paused:
            self.pause()
        self._singles += 1

    def run_at(self, rate: float) -> None:
        """Set the rate, one of RATES."""
        self.rate = rate
        self._clock.max_ticks = round(MAX_TICKS_PER_FRAME * max(rate, 1.0))

    def slower(self) -> None:
        """Halve the rate, down to a quarter."""
        self.run_at(max(self.rate / 2.0, RATES[0]))

    def faster(self) -> None:
        """Double the rate, up to four times."""
        self.run_at(min(self.rate * 2.0, RATES[-1]))

    def rewind(self, seconds: float = 1.0) -> int:
        """Go back before the next picture, at most to `earliest`; repeated calls add up.

        Running time continues from there. Returns the tick to go to.
        """
        tick = self.tick if self._wanted is None else self._wanted
        self._wanted = max(tick - round(seconds / TICK_S), self.earliest)
        return self._wanted

    def stand_at(self, tick: int) -> None:
        """Pause at this tick from the next picture on, or at the nearest that can be restored."""
        if not self.paused:
            self.pause()
        self._wanted = tick

    def due(self, elapsed_s: float) -> int:
        """The number of ticks to make, `elapsed_s` after the last call.

        This restores past ticks. Single ticks in the past repeat the original ones; running time
        makes new ones.
        """
        if self._wanted is not None:
            self.go(self._wanted)
        if not self.paused:
            return self._clock.advance(elapsed_s * self.rate)
        singles, self._singles = self._singles, 0
        again = min(singles, self.latest - self.tick)
        if again:
            self.go(self.tick + again)
        return singles - again

    def make(self, order: Order) -> None:
        """Make the next tick with this order, and forget later ones."""
        self._forget_later()
        self._made.append(_Made(order, dict(self._world.seen_light)))
        step(self._world, order)
        if self.tick - self._kept[-1].tick >= KEPT_TICKS:
            self._keep()

    def go(self, tick: int) -> None:
        """Go to a tick, limited to `earliest` and `latest`.

        If it cannot be restored, go to the next one beyond it, as seen from the current tick.
        """
        self._wanted = None
        tick = min(max(tick, self.earliest), self.latest)
        number = next(k for k in reversed(range(len(self._kept))) if self._kept[k].tick <= tick)
        start = self._kept[number]
        if tick > start.sure and tick > self.tick:
            start = self._kept[number + 1]
            tick = start.tick
        tick = int(min(tick, start.sure))
        if not start.tick <= self.tick <= tick:  # else go on from here
            set_tunables(self._world, start.constants)
            snapshot.restore(self._world, start.world)
        while self.tick < tick:
            made = self._made[self.tick - self.earliest]
            self._world.seen_light.clear()
            self._world.seen_light.update(made.seen_light)
            step(self._world, made.order)

    def feed(self) -> bool:
        """Scatter food before the submarine, as `scatter_food`; True if some was due."""
        fed = scatter_food(self._world)
        if fed:
            self.touch()
        return fed

    def touch(self) -> None:
        """Store a snapshot now, because the world was changed since the last tick."""
        self._forget_later()
        if self._kept[-1].tick == self.tick:
            self._kept.pop()
        self._keep(touched=True)

    def _forget_later(self) -> None:
        """Drop all ticks after the current one."""
        del self._made[self.tick - self.earliest :]
        while self._kept[-1].tick > self.tick:
            self._kept.pop()
        self._kept[-1] = self._kept[-1]._replace(sure=np.inf)

    def _keep(self, touched: bool = False) -> None:
        """Store a snapshot, and drop old ones until all fit."""
        world, constants = snapshot.take(self._world), get_tunables(self._world)
        self._kept.append(_Kept(self.tick, world, constants, touched))
        begin, spare = self.earliest, self.bytes - self._most_bytes
        while spare > 0 and (dense := self._dense()):
            left = self._kept.pop(dense)
            spare -= len(left.world)
            before = self._kept[dense - 1]
            self._kept[dense - 1] = before._replace(sure=min(before.sure, left.tick - 1))
        while len(self._kept) > 1 and (spare > 0 or self._kept[1].tick <= self.tick - REACH_TICKS):
            spare -= len(self._kept.pop(0).world)
        del self._made[: self.earliest - begin]

    def _dense(self) -> int:
        """The index of the first touched snapshot within a second of others, else 0."""
        kept = self._kept
        return next(
            (
                k
                for k in range(1, len(kept) - 1)
                if kept[k].touched and kept[k + 1].tick - kept[k - 1].tick <= KEPT_TICKS
            ),
            0,
        )
