"""Time rebuilding a world after a change of its scenario.

.venv/bin/python tools/measure_editing.py

Processor time of the peaceful bay, the least of several runs, with a temporary disk cache.
"""

import os
import tempfile
import time
from collections.abc import Callable
from typing import Any

from msgspec.structs import replace

from subsea.scenario.load import load_scenario
from subsea.world.build import create_world

TIMES = 4
# Moved by one centimetre at a time: key and first position.
MOVED = {
    "a school": ("fish.0.position_cm", (-130.0, 40.0, -340.0)),
    "seaweed": ("seaweed.0.position_cm", (-120.0, 150.0)),
    "a reef": ("reef.0.position_cm", (-150.0, 205.0)),
    "the arch": ("arch.0.position_cm", (90.0, -10.0)),
}


def moved(key: str, place: tuple[float, ...], k: int) -> str:
    """A change of the scenario: `place` moved by k cm."""
    return f"{key}={[place[0] + k, *place[1:]]}"


def all_moved(k: int) -> dict[str, list[Any]]:
    """All positions of the peaceful bay, moved by k cm."""
    scenario = load_scenario("peaceful")[0]
    return {
        kind: [
            replace(one, position_cm=(one.position_cm[0] + k, *one.position_cm[1:]))
            for one in getattr(scenario, kind)
            if one.position_cm is not None
        ]
        for kind in ("arch", "outcrop", "rock", "reef", "seaweed", "vent")
    }


def least_s(make: Callable[[int], object]) -> float:
    """The least processor time, s, of `make` with 1, 2, …"""
    took = []
    for k in range(1, 1 + TIMES):
        start = time.process_time()
        make(k)
        took.append(time.process_time() - start)
    return min(took)


def main() -> None:
    """Print a line for each change."""
    create_world(load_scenario("peaceful")[0])  # compiles, and reads repertoires

    def rebuild(k: int) -> None:
        with tempfile.TemporaryDirectory() as empty:
            os.environ["XDG_CACHE_HOME"] = empty
            create_world(replace(load_scenario("peaceful")[0], **all_moved(k)))

    whole = least_s(rebuild)
    print(f"{'everything':20s}{whole:8.2f} s")
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_CACHE_HOME"] = folder
        create_world(load_scenario("peaceful")[0])
        for name, (key, place) in MOVED.items():
            took = least_s(
                lambda k, key=key, place=place: create_world(  # type: ignore[misc]
                    load_scenario("peaceful", [moved(key, place, k)])[0]
                )
            )
            print(f"{name:20s}{took:8.2f} s{took / whole:8.2f} of it")


if __name__ == "__main__":
    main()
