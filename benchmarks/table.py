"""Time every kernel for docs/developers/performance.md: `python benchmarks/table.py`."""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

from subsea.base.files import replacing

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
    """Build a Markdown table: a row for each work, with the medians of the kernel and of others."""
    lines = ["\n| work | kernel, µs | others: times as long |\n| --- | --- | --- |\n"]
    groups = dict.fromkeys(run["group"] for run in runs)
    for group in groups:
        kernel, *others = (run for run in runs if run["group"] == group)
        median = kernel["stats"]["median"]
        ratios = [f"{run['name']} {run['stats']['median'] / median:.2g}" for run in others]
        lines.append(f"| {group} | {1e6 * median:.3g} | {'; '.join(ratios)} |\n")
    return "".join([*lines, "\n"])


if __name__ == "__main__":
    sys.exit(main())
