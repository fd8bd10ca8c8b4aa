"""Points of a sweep: drawn within ranges by a design, or listed in a table."""

import csv
import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.base.files import read_text
from subsea.base.system import require

Point = dict[str, Any]  # a value for each key
Range = Sequence[float]  # the least and the greatest value; of whole numbers, both are
MOST_POINTS = 100_000
DIGITS = 6  # of a drawn number


def latin_hypercube(ranges: Mapping[str, Range], number: int, seed: int = 0) -> list[Point]:
    """Draw points for a sweep by a Latin hypercube (McKay et al. 1979).

    Each range is cut into as many strata as there are points, and each stratum has one point.

    Args:
        ranges: The least and the greatest value of each key: `{"nature.timidity": (0.5, 2.0)}`.
            Two whole numbers, as of a number of fish, give whole numbers.
        number: How many points to draw.
        seed: The seed of the draw.

    Returns:
        A value of each key for each point, for `values` of `subsea.sweep`.

    Raises:
        ValueError: A range that is not of two finite numbers in order, or no point.

    Examples:
        >>> points = subsea.latin_hypercube({"fish.0.number": (1, 40)}, 4, seed=1)
        >>> [point["fish.0.number"] for point in points]
        [2, 20, 24, 35]
    """
    _check(ranges, number)
    random = np.random.default_rng(seed)
    strata = np.array([random.permutation(number) for _ in ranges]).T
    return _points(ranges, (strata + random.random(strata.shape)) / number)


def sobol(ranges: Mapping[str, Range], number: int, seed: int = 0) -> list[Point]:
    """Draw points for a sweep from a Sobol sequence with Owen's scrambling.

    The points fill the ranges more evenly than random ones, best if their number is a power of 2.
    More points of the same seed begin with the same ones. Needs the extra `sobol`.

    Args:
        ranges: As of `subsea.latin_hypercube`.
        number: How many points to draw.
        seed: The seed of the scrambling.

    Returns:
        A value of each key for each point, for `values` of `subsea.sweep`.

    Raises:
        UserError: SciPy is not installed.
        ValueError: As of `subsea.latin_hypercube`.

    Examples:
        >>> points = subsea.sobol({"nature.timidity": (0.5, 2.0), "fish.0.number": (1, 40)}, 8)
        >>> len(points)
        8
    """
    _check(ranges, number)
    require("sobol", "a Sobol sequence")
    from scipy.stats import qmc

    sequence = qmc.Sobol(len(ranges), rng=np.random.default_rng(seed))
    return _points(ranges, sequence.random_base2(math.ceil(math.log2(number)))[:number])


DESIGNS = {"latin": latin_hypercube, "sobol": sobol}


def _check(ranges: Mapping[str, Range], number: int) -> None:
    if not ranges:
        raise ValueError("ranges: expected at least one key")
    for key, given in ranges.items():
        two = isinstance(given, Sequence) and not isinstance(given, str) and len(given) == 2
        if not two or not all(map(_is_number, given)) or not given[0] < given[1]:
            raise ValueError(f"ranges: {key}: {given!r}, expected two finite numbers in order")
    if not 1 <= number <= MOST_POINTS:
        raise ValueError(f"number: {number!r}, expected 1 to {MOST_POINTS:,}")


def _is_number(value: Any) -> bool:
    number = isinstance(value, int | float | np.integer | np.floating)
    return number and not isinstance(value, bool) and math.isfinite(value)


def _points(ranges: Mapping[str, Range], shares: Array) -> list[Point]:
    """Scale shares (number, keys) from 0 to 1 to the ranges; whole numbers are equally likely."""
    columns = {}
    for (key, (least, most)), share in zip(ranges.items(), shares.T, strict=True):
        drawn: list[float]
        if isinstance(least, int | np.integer) and isinstance(most, int | np.integer):
            drawn = [
                int(least) + min(int(s * (most - least + 1)), int(most - least)) for s in share
            ]
        else:
            drawn = [float(f"{least + s * (most - least):.{DIGITS}g}") for s in share]
        columns[key] = drawn
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def read_points(path: Path) -> list[Point]:
    """Read points from a CSV file, whose first line has the keys; a UserError for a faulty one."""
    rows = [row for row in csv.reader(io.StringIO(read_text(path))) if row]
    keys = [key.strip() for key in rows[0]] if rows else []
    if len(rows) < 2 or not all(keys) or len(set(keys)) < len(keys):
        raise UserError("expected a line with the keys, and a line with values per run", file=path)
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(keys) or not all(value.strip() for value in row):
            raise UserError(f"expected {len(keys)} values", file=path, line=number)
    return [dict(zip(keys, map(str.strip, row), strict=True)) for row in rows[1:]]


def read_ranges(settings: Sequence[str]) -> dict[str, Range]:
    """Read ranges such as ``nature.timidity=0.5:2``; a UserError for anything else."""
    found: dict[str, Range] = {}
    for setting in settings:
        key, _, text = setting.partition("=")
        try:
            least, most = (_number(part) for part in text.split(":"))
            _check({key: (least, most)}, 1)
        except ValueError:
            raise UserError(
                "expected KEY=LEAST:MOST such as nature.timidity=0.5:2", file=f"--draw {setting}"
            ) from None
        key = ".".join(step.strip() for step in key.split("."))
        if not key or key in found:
            raise UserError("give each key once", file=f"--draw {setting}")
        found[key] = least, most
    return found


def _number(text: str) -> float:
    try:
        return int(text)
    except ValueError:
        return float(text)
