"""Figures of docs/behavior.md: `python docs/study_figures.py [SCENARIO SECONDS SEEDS]`.

Records each scenario from each seed, for so many seconds, and prints what `subsea study` measures;
without arguments all that the page tells of: `peaceful 600 1,2`, `schooling 50 3,4,5` and
`schooling 200 3,4,5,6`.
"""

import sys
import tempfile
from pathlib import Path

from subsea.app.records import read_record
from subsea.app.simulate import simulate
from subsea.app.study import measure
from subsea.app.study_table import table
from subsea.world import TICK_S

TOLD = (
    ("peaceful", 600.0, (1, 2)),
    ("schooling", 50.0, (3, 4, 5)),
    ("schooling", 200.0, (3, 4, 5, 6)),
)


def main() -> None:
    """A table for each seed."""
    told = TOLD
    if len(sys.argv) > 1:
        if len(sys.argv) != 4:
            raise SystemExit(__doc__)
        scenario, seconds, seeds = sys.argv[1:]
        told = ((scenario, float(seconds), tuple(map(int, seeds.split(",")))),)
    for scenario, seconds, seeds in told:
        for seed in seeds:
            with tempfile.TemporaryDirectory() as place:
                file = Path(place) / "record.h5"
                simulate(round(seconds / TICK_S), file, scenario, None, seed)
                lines = table(measure(read_record(file)))
            print("\n".join([f"{scenario}, {seconds:g} s, seed {seed}", *lines, ""]), flush=True)


if __name__ == "__main__":
    main()
