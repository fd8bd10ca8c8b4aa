"""Compare worlds of every scenario on different numbers of threads, bit for bit.

.venv/bin/python tools/check_threads.py [SCENARIO[:FISHES] ...] [--ticks N] [--threads 1,2,3,16]

Prints the first tick at which the checksums differ, and exits with 1 if any do. It takes a minute
or more with all scenarios.
"""

import argparse
import sys

from subsea.base.system import resource_path
from subsea.kernels.threads import use_threads
from subsea.scenario.load import load_scenario
from subsea.submarine.vessel import Helm
from subsea.world.build import create_world
from subsea.world.snapshot import checksum
from subsea.world.step import step

AHEAD = Helm(surge=0.4)


def checksums(name: str, fishes: int | None, threads: int, ticks: int) -> list[str]:
    """The checksum of a world after each tick."""
    use_threads(threads)
    world = create_world(load_scenario(name)[0], fish=fishes)
    found = []
    for _ in range(ticks):
        step(world, AHEAD)
        found.append(checksum(world))
    return found


def main() -> int:
    """Print a line for each scenario."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenario", nargs="*", metavar="SCENARIO[:FISHES]")
    parser.add_argument("--ticks", type=int, default=300)
    parser.add_argument("--threads", default="1,2,3,16")
    options = parser.parse_args()
    every = sorted(path.stem for path in resource_path("assets/scenarios").glob("*.toml"))
    numbers = [int(word) for word in options.threads.split(",")]
    wrong = 0
    for word in options.scenario or every:
        name, _, fishes = word.partition(":")
        first, *others = (
            checksums(name, int(fishes) if fishes else None, number, options.ticks)
            for number in numbers
        )
        for number, other in zip(numbers[1:], others, strict=True):
            if other != first:
                tick = next(k for k in range(options.ticks) if other[k] != first[k])
                print(f"{word}: {number} threads differ from {numbers[0]} after tick {tick}")
                wrong += 1
        print(f"{word}: {first[-1]}", flush=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
