"""The measures of a record as one row of numbers, for tables."""

from statistics import fmean
from typing import Any

from subsea.lab.table import Measured

Row = dict[str, float | None]  # None: nothing to measure

# Of several schools these are added, or the largest is taken; of others the mean.
_SUMS = "fishes", "splits", "not_rejoined"
_MOST = "longest_split_s"
_OF_SCHOOLS = (
    "fishes", "cruising_share", "polarisation_median", "polarisation_p5", "nearest_bl.p5",
    "nearest_bl.p50", "nearest_bl.p95", "splits", "longest_split_s", "not_rejoined",
)  # fmt: skip
_INPUTS = "seed", "ticks"


def flat_measures(found: Measured) -> Row:
    """The numbers of `subsea.lab.report.measure` by name, such as ``sea.overlap_share``.

    docs/reference/records.md lists them. Names of species are in lower case with underscores.
    Texts and lists of single events are left out.
    """
    row = {name: value for name, value in _numbers(found).items() if name not in _INPUTS}
    schools = [_numbers(school) for school in found["schools"]]
    row["schools.number"] = float(len(schools))
    for name in _OF_SCHOOLS:
        values = [value for one in schools if (value := one[name]) is not None]
        if name in _SUMS:
            row[f"schools.{name}"] = sum(values, 0.0)
        else:
            whole = max if name == _MOST else fmean
            row[f"schools.{name}"] = round(whole(values), 6) if values else None
    return row


def _numbers(found: Any, prefix: str = "") -> Row:
    row: Row = {}
    for key, value in found.items():
        name = f"{prefix}{key}".lower().replace(" ", "_")
        if isinstance(value, dict):
            row |= _numbers(value, f"{name}.")
        elif value is None or isinstance(value, int | float):
            row[name] = None if value is None else float(value)
    row.pop("sea.least_clearance_from", None)  # a text, or None
    return row
