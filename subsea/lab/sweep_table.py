"""Tables of sweeps as Parquet and CSV files: equal rows give equal bytes."""

import csv
import tomllib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from subsea.base.atomic_io import replacing
from subsea.base.file_kinds import csv_file, signed

PARQUET = signed("a Parquet table", b"PAR1")
CSV = csv_file("a table of `subsea sweep`", "run", "seed")

Line = dict[str, Any]  # a run: texts of TOML values before the column `ticks`, numbers after it


def columns_of(lines: Sequence[Line]) -> dict[str, list[Any]]:
    """The columns of all lines, in the order of their first appearance; None for missing numbers.

    A swept key is a column of numbers, or of true and false, if all its values are; else of texts.
    """
    names = dict.fromkeys(name for line in lines for name in line)
    columns = {name: [line.get(name) for line in lines] for name in names}
    return {name: _converted(values) for name, values in columns.items()}


def _converted(texts: list[Any]) -> list[Any]:
    if not all(isinstance(text, str) for text in texts):
        return texts
    values: list[Any] = []
    for text in texts:
        with suppress(ValueError, RecursionError):
            values.append(tomllib.loads(f"value = {text}")["value"])
    if len(values) == len(texts):
        if len({isinstance(value, bool) for value in values}) == 1 and all(
            isinstance(value, int) and abs(value) < 2**63 for value in values
        ):
            return values
        if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
            return [float(value) for value in values]
        if all(isinstance(value, str) for value in values):
            return values
    return texts


def write_parquet(path: Path, lines: Sequence[Line]) -> None:
    """Write a table as a Parquet file."""
    import pyarrow
    from pyarrow import parquet

    columns = columns_of(lines)
    measures = [*columns][[*columns].index("ticks") + 1 :] if columns else []
    arrays = {
        name: pyarrow.array(values, pyarrow.float64() if name in measures else None)
        for name, values in columns.items()
    }
    with replacing(path) as temporary:
        parquet.write_table(pyarrow.table(arrays), temporary)


def write_csv(path: Path, lines: Sequence[Line]) -> None:
    """Write a table as a CSV file."""
    columns = columns_of(lines)
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))
