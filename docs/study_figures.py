"""Figures of behavior-figures.md: `python docs/study_figures.py [SCENARIO SECONDS SEEDS]`.

Records each scenario with each seed and prints the measures of `subsea study`; without arguments,
all figures of the page: `peaceful 600 1,2`, `schooling 50 3,4,5` and
`schooling 200 3,4,5,6`.

`python docs/study_figures.py hungry SCENARIO MINUTES SEEDS` records nothing; every ten minutes it
counts the fishes with full hunger.
"""

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from subsea.lab.report import measure, table
from subsea.lab.simulate import simulate
from subsea.media.record import read_record
from subsea.scenario.load import load_scenario
from subsea.state import HUNGER
from subsea.submarine.vessel import NEUTRAL
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S

RUNS = (
    ("peaceful", 600.0, (1, 2)),
    ("schooling", 50.0, (3, 4, 5)),
    ("schooling", 200.0, (3, 4, 5, 6)),
)
LOOKS_MIN = 10.0  # minutes between two looks at who is hungry


def hungry(scenario: str, minutes: float, seed: int) -> Iterator[str]:
    """Print the number of fishes of each species with full hunger, every ten minutes."""
    world = create_world(load_scenario(scenario)[0], seed=seed)
    fishes, minds = world.state.fishes, world.state.minds
    every = round(60.0 * LOOKS_MIN / TICK_S)
    for look in range(1, int(minutes / LOOKS_MIN) + 1):
        for _ in range(every):
            step(world, NEUTRAL)
        hunger = minds.mental[:, HUNGER] >= 1.0
        counts = [
            f"{np.sum(hunger & those)} of {np.sum(those)} {one.name}"
            for k, one in enumerate(world.species)
            if (those := fishes.alive & (fishes.species == k)).any()
        ]
        yield f"after {look * LOOKS_MIN:g} minutes: {', '.join(counts)}"


def measured(scenario: str, seconds: float, seed: int) -> Iterator[str]:
    """The measures of a record by `subsea study`."""
    with tempfile.TemporaryDirectory() as place:
        file = Path(place) / "record.h5"
        simulate(round(seconds / TICK_S), file, scenario, None, seed)
        yield from table(measure(read_record(file)))


def main() -> None:
    """Print a table for each seed."""
    given = sys.argv[1:]
    counts = given[:1] == ["hungry"]
    runs = RUNS
    if given:
        if len(given) != 3 + counts:
            raise SystemExit(__doc__)
        scenario, long, seeds = given[counts:]
        runs = ((scenario, float(long), tuple(map(int, seeds.split(",")))),)
    for scenario, long, seeds in runs:
        for seed in seeds:
            print(f"{scenario}, {long:g} {'minutes' if counts else 's'}, seed {seed}")
            for line in (hungry if counts else measured)(scenario, long, seed):
                print(line, flush=True)
            print()


if __name__ == "__main__":
    main()
