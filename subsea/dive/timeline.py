"""Time at the visitor's hand: it stands still, goes tick by tick, slower, faster, and back.

Whatever steered each tick of the last minute is kept, and about once a second all that changes in
the world. So every tick of that minute can be had again: the world as it was before it, and from
there the same ticks once more. They do not ask any hand or tour again: the same orders give the
same world, to the byte (`snapshot.checksum`).

What changes the world between two ticks, as a panel does, must say so (`Timeline.touch`): the
world is kept there, too. While a slider is dragged that is many worlds; where there is no room for
them, some are left out, and with each the ticks that cannot be had without it: less than a second.
"""

from typing import NamedTuple

import numpy as np

from subsea.dive.clock import MAX_TICKS_PER_FRAME, TickClock
from subsea.world import snapshot
from subsea.world.step import Order, step
from subsea.world.tunables import Tunables, get_tunables, set_tunables
from subsea.world.world import TICK_S, World

RATES = (0.25, 0.5, 1.0, 2.0, 4.0)
REACH_TICKS = round(60.0 / TICK_S)  # so far back all is kept ...
KEPT_TICKS = round(1.0 / TICK_S)  # ... and so often the whole world, from which ticks are made anew
MOST_BYTES = 256 * 2**20  # of worlds kept; where that is too little, time goes back less far


class _Kept(NamedTuple):
    """The world before a tick."""

    tick: int
    world: bytes  # see `snapshot.take`
    constants: Tunables
    touched: bool  # whether it is not what the tick before made of it
    sure: float = np.inf  # the last tick that can be made from it: later the world was touched


class _Made(NamedTuple):
    """What a tick was made of, besides the world."""

    order: Order
    seen_light: dict[int, float]


class Timeline:
    """The time of a world that no other computer shares."""

    def __init__(self, world: World, most_bytes: int = MOST_BYTES) -> None:
        """It runs, and begins with the world as it is. At most about `most_bytes` are kept."""
        self._world, self._most_bytes = world, most_bytes
        self._clock = TickClock(TICK_S)
        self._kept: list[_Kept] = []  # by rising tick; the first is the earliest that can be had
        self._made: list[_Made] = []  # all ticks since the first that is kept
        self._singles = 0  # ticks asked for one by one
        self._wanted: int | None = None  # the tick that time is to go back to
        self.rate = 1.0  # seconds of the world in a second
        self.paused = False
        self._keep()

    @property
    def tick(self) -> int:
        """The present one."""
        return self._world.state.tick

    @property
    def earliest(self) -> int:
        """The first tick that can be had again."""
        return self._kept[0].tick

    @property
    def latest(self) -> int:
        """The last tick that was made: later than the present one after time went back."""
        return self._kept[0].tick + len(self._made)

    @property
    def bytes(self) -> int:
        """How much memory the worlds take that are kept."""
        return sum(len(kept.world) for kept in self._kept)

    @property
    def alpha(self) -> float:
        """The point between the last two ticks at which to draw: see `clock.Clock`."""
        return 1.0 if self.paused else self._clock.alpha

    @property
    def text(self) -> str:
        """What is not as usual, in words."""
        words = ["paused"] if self.paused else []
        if self.rate != 1.0:
            words.append(f"time ×{self.rate:g}")
        if self.paused and self.tick < self.latest:
            words.append(f"{(self.latest - self.tick) * TICK_S:.1f} s back")
        return ", ".join(words)

    def pause(self) -> None:
        """Stand still, or go on."""
        self.paused = not self.paused
        if not self.paused:
            self._clock.fill()  # the last tick has been shown to its end

    def single(self) -> None:
        """Stand still after one more tick."""
        if not self.paused:
            self.pause()
        self._singles += 1

    def run_at(self, rate: float) -> None:
        """Make time go so fast, one of RATES."""
        self.rate = rate
        self._clock.max_ticks = round(MAX_TICKS_PER_FRAME * max(rate, 1.0))

    def slower(self) -> None:
        """Half as fast, down to a quarter."""
        self.run_at(max(self.rate / 2.0, RATES[0]))

    def faster(self) -> None:
        """Twice as fast, up to four times."""
        self.run_at(min(self.rate * 2.0, RATES[-1]))

    def rewind(self, seconds: float = 1.0) -> None:
        """Go so far back, or as far as the past reaches, before the next picture.

        A minute in steps of a second is one way back. Time that runs goes on from there.
        """
        tick = self.tick if self._wanted is None else self._wanted
        self._wanted = max(tick - round(seconds / TICK_S), self.earliest)

    def stand_at(self, tick: int) -> None:
        """Stand still, from the next picture on at this tick, or at the nearest that can be had."""
        if not self.paused:
            self.pause()
        self._wanted = tick

    def due(self, elapsed_s: float) -> int:
        """How many ticks are to be made now that `elapsed_s` have passed since the last call.

        What is to be had again, from the past or of it, is there then. In the past single ticks
        are those that were made; time that runs makes others.
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
        """The next tick, in which this is done; what came after the present one is forgotten."""
        self._forget_later()
        self._made.append(_Made(order, dict(self._world.seen_light)))
        step(self._world, order)
        if self.tick - self._kept[-1].tick >= KEPT_TICKS:
            self._keep()

    def go(self, tick: int) -> None:
        """To a tick from `earliest` to `latest`, or to the nearest of these.

        Where one cannot be had, to the next beyond it, as seen from here.
        """
        self._wanted = None
        tick = min(max(tick, self.earliest), self.latest)
        number = next(k for k in reversed(range(len(self._kept))) if self._kept[k].tick <= tick)
        start = self._kept[number]
        if tick > start.sure and tick > self.tick:
            start = self._kept[number + 1]
            tick = start.tick
        tick = int(min(tick, start.sure))
        if not start.tick <= self.tick <= tick:  # else the way from here is shorter
            set_tunables(self._world, start.constants)
            snapshot.restore(self._world, start.world)
        while self.tick < tick:
            made = self._made[self.tick - self.earliest]
            self._world.seen_light.clear()
            self._world.seen_light.update(made.seen_light)
            step(self._world, made.order)

    def touch(self) -> None:
        """Keep the world as it is now: it is no longer what the last tick made of it."""
        self._forget_later()
        if self._kept[-1].tick == self.tick:
            self._kept.pop()
        self._keep(touched=True)

    def _forget_later(self) -> None:
        """What followed the present tick did not happen."""
        del self._made[self.tick - self.earliest :]
        while self._kept[-1].tick > self.tick:
            self._kept.pop()
        self._kept[-1] = self._kept[-1]._replace(sure=np.inf)

    def _keep(self, touched: bool = False) -> None:
        """Keep the world of now, and no more of the past than there is room for."""
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
        """The number of the earliest touched world within a second of others, else 0."""
        kept = self._kept
        return next(
            (
                k
                for k in range(1, len(kept) - 1)
                if kept[k].touched and kept[k + 1].tick - kept[k - 1].tick <= KEPT_TICKS
            ),
            0,
        )
