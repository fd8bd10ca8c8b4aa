"""Time a tick of the motor system for many fishes, against a copy of its arrays.

.venv/bin/python tools/measure_motor.py [FISHES]
"""

import sys
import time
from functools import partial

import numpy as np
from fastest import fastest_ms

from subsea.motor.controller import command
from subsea.motor.fins import flap
from subsea.motor.playback import play
from subsea.scenario.load import load_scenario
from subsea.state import Clock
from subsea.world.build import create_world
from subsea.world.world import TICK_S

fastest = partial(fastest_ms, clock=time.thread_time, repeats=20)
TOUCHED = (
    "position", "orientation", "row_a", "row_b", "weight", "span", "previous_position",
    "previous_orientation", "previous_row_a", "previous_row_b", "previous_weight",
    "previous_span", "velocity", "segment", "wanted_segment", "tempo", "thrust", "steering",
    "roll", "scale", "rate", "species",
)  # fmt: skip


def main() -> None:
    """Print a small table."""
    number = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    world = create_world(load_scenario("peaceful")[0], fish=number)
    fishes, library = world.state.fishes, world.library
    who = np.arange(number)
    arrays = [getattr(fishes, name) for name in TOUCHED]
    copies = [np.empty_like(a) for a in arrays]
    copying = fastest(lambda: [*map(np.copyto, copies, arrays)])
    rows = {
        "copy the arrays that playback touches": copying,
        "playback of root motion": fastest(lambda: play(who, fishes, library, TICK_S)),
        "secondary controller": fastest(lambda: command(who, fishes, library, Clock(1, 0, TICK_S))),
        "fins and breath": fastest(lambda: flap(who, fishes, library, TICK_S)),
    }
    print(f"{number} fishes, a tick")
    for name, duration in rows.items():
        print(f"{name:40s}{duration:9.2f} ms{duration / copying:8.2f} ×")


if __name__ == "__main__":
    main()
