"""Passes of a tick over parts of the fishes, each compiled as one kernel.

Threads take turns to hold the interpreter's lock between two kernels. With one kernel for each part
they do so less often.
"""

from subsea.base.arrays import Array, Ints
from subsea.behavior.bursting import tire
from subsea.behavior.mental_state import update_mental_state
from subsea.behavior.steering import ease_goals
from subsea.behavior.table import compute_desires
from subsea.habitat.bow_wave import add_bow_wave
from subsea.habitat.current import set_drift
from subsea.habitat.rock_cells import RockCells
from subsea.habitat.separation import separate
from subsea.kernels import kernel
from subsea.motor.containment import contain
from subsea.motor.fins import flap
from subsea.motor.playback import play
from subsea.repertoire.library import Library
from subsea.state import Clock, Fishes, Minds, Nature, Sea


@kernel
def carry(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, cells: RockCells, flow: Array) -> None:
    """Set the drift of the fishes `who` by the current `flow` (3,), cm/s, the hull and others."""
    set_drift(who, fishes, sea, cells, flow)
    add_bow_wave(who, fishes, sea)
    separate(who, fishes, minds)


@kernel
def feel(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Update mental states and desires of the fishes `who`."""
    update_mental_state(who, fishes, minds, nature, clock)
    compute_desires(who, fishes, minds, sea, nature, clock)


@kernel
def ease(who: Ints, fishes: Fishes, minds: Minds, clock: Clock) -> None:
    """Turn the goals of the fishes `who` toward their urges, and let bursts tire them."""
    ease_goals(who, fishes, minds, clock)
    tire(who, fishes, minds, clock)


@kernel
def play_back(who: Ints, fishes: Fishes, library: Library, sea: Sea, dt: float) -> None:
    """Advance bodies and fins of the fishes `who` by one tick, within the free water."""
    play(who, fishes, library, dt)
    contain(who, fishes, library.nodes, sea, dt)
    flap(who, fishes, library, dt)
