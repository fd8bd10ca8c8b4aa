"""Time every kernel for docs/developers/performance.md: `python benchmarks/table.py`."""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

from subsea.core.atomic_io import replacing

HERE = Path(__file__).parent
PAGE = HERE.parent / "docs" / "developers" / "performance.md"
BEGIN, END = "<!-- kernels: benchmarks/table.py -->\n", "<!-- end of kernels -->\n"


def main() -> int:
    """Run the benchmarks, rewrite the page; returns the exit code."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.json"
        done = subprocess.run(
            [sys.executable, "-m", "pytest", "-c", HERE / "pytest.ini", "--rootdir", HERE, HERE,
             "-q", f"--benchmark-json={report}"], check=False,
        )  # fmt: skip
        if done.returncode:
            return done.returncode
        runs = json.loads(report.read_text())["benchmarks"]
    before, _, rest = PAGE.read_text().partition(BEGIN)
    _, _, after = rest.partition(END)
    with replacing(PAGE) as temporary:
        temporary.write_text(before + BEGIN + table(runs) + END + after)
    return 0


def table(runs: list[dict]) -> str:
    """Markdown: a row for each, medians with the quartiles' distance, and over the first's."""
    lines = ["\n| work | by | µs | over the kernel |\n| --- | --- | --- | --- |\n"]
    groups = dict.fromkeys(run["group"] for run in runs)
    for group in groups:
        mine = [run for run in runs if run["group"] == group]
        first = mine[0]["stats"]["median"]
        for k, run in enumerate(mine):
            stats = run["stats"]
            ratio = "" if k == 0 else f"{stats['median'] / first:.2g}"
            took = f"{1e6 * stats['median']:.3g} ± {0.5e6 * stats['iqr']:.1g}"
            lines.append(f"| {group if k == 0 else ''} | {run['name']} | {took} | {ratio} |\n")
    return "".join([*lines, "\n"])


if __name__ == "__main__":
    sys.exit(main())
