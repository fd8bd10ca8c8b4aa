"""Make the plots of studies: `python docs/make_study_plots.py [FOLDER]`.

Records peaceful for ten minutes and schooling for two, plots both and prints the tables. Also
writes the end of the second table into docs/tutorials/first-study.md, which shows its command.
"""

import re
import sys
import tempfile
from pathlib import Path

from PIL import Image

from subsea.lab.plots import plot
from subsea.lab.report import measure, table
from subsea.lab.simulate import simulate
from subsea.media.record import read_record

SHOWN = {
    ("peaceful", 18182): ("time_budget", "minds", "schools", "clearance"),
    ("schooling", 3636): ("paths", "schools"),
}


PAGE = Path(__file__).parent / "tutorials" / "first-study.md"
TABLE = re.compile(r"(?<=```text\n)school of.*?(?=```)", re.DOTALL)


def write_table(lines: list[str]) -> None:
    """Write the lines about schools into the tutorial."""
    first = next(k for k, line in enumerate(lines) if line.startswith("school of"))
    text = PAGE.read_text(encoding="utf-8")
    assert TABLE.search(text)
    rows = "\n".join(lines[first:]) + "\n"
    PAGE.write_text(TABLE.sub(lambda _: rows, text), encoding="utf-8")


def main() -> None:
    """Write `study-SCENARIO-PLOT.png` into the folder."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "docs/pictures")
    for (scenario, ticks), names in SHOWN.items():
        with tempfile.TemporaryDirectory() as place:
            file = Path(place) / "record.h5"
            simulate(ticks, file, scenario, None, None)
            record = read_record(file)
            lines = table(measure(record))
            print("\n".join([scenario, *lines]), flush=True)
            if scenario == "schooling":
                write_table(lines)
            drawn = {path.stem: path for path in plot(record, Path(place))}
            for name in names:
                picture = Image.open(drawn[name]).convert("RGB").quantize(64)
                picture.save(folder / f"study-{scenario}-{name}.png", optimize=True)


if __name__ == "__main__":
    main()
