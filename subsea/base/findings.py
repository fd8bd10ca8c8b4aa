"""Measured quantities beside published ranges: as text, as Markdown and as JSON."""

import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from subsea.base.errors import UserError
from subsea.base.file_kinds import json_file
from subsea.base.files import check_file, read_text, replacing

REPORT = json_file("a validation report", "findings")
PASS, FAIL, MISSING, NO_RANGE = "pass", "fails", "not recorded", "–"
HEADINGS = ("of", "quantity", "ours", "published", "source", "verdict")
_MADE = re.compile(r"<!-- made by subsea[ \w-]* -->.*<!-- end of subsea[ \w-]* -->", re.DOTALL)
RED = '<span style="color:red">**fails**</span>'


class RangeCheck(NamedTuple):
    """One quantity of one species, school or sea; NaN where nothing of the kind was recorded."""

    subject: str
    quantity: str
    value: float
    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    source: str = ""
    note: str = ""  # such as the number of samples

    @property
    def verdict(self) -> str:
        """`PASS`, `FAIL`, `MISSING`, or `NO_RANGE` without a published range."""
        if math.isnan(self.value):
            return MISSING
        if self.low == -math.inf and self.high == math.inf:
            return NO_RANGE
        return PASS if self.low <= self.value <= self.high else FAIL


def text_table(findings: Sequence[RangeCheck]) -> list[str]:
    """Lines of an aligned table."""
    rows = [HEADINGS, *(_cells(one, FAIL.upper()) for one in findings)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def summary(findings: Sequence[RangeCheck]) -> str:
    """The number of quantities for each verdict."""
    counts = dict.fromkeys((PASS, FAIL, MISSING, NO_RANGE), 0)
    for one in findings:
        counts[one.verdict] += 1
    return (
        f"{counts[PASS]} within the published range, {counts[FAIL]} outside, "
        f"{counts[MISSING]} not recorded, {counts[NO_RANGE]} without a range"
    )


def markdown(findings: Sequence[RangeCheck]) -> list[str]:
    """Lines of a Markdown table; what fails is red."""
    rows = [HEADINGS, ("---",) * len(HEADINGS), *(_cells(one, RED) for one in findings)]
    return ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]


def sources_named(findings: Sequence[RangeCheck], sources: Mapping[str, str]) -> list[str]:
    """Lines of a list of the sources that findings name by their keys."""
    named = " ".join(one.source for one in findings)
    lines = [
        f"- `{key}`: {text}." for key, text in sources.items() if re.search(rf"\b{key}\b", named)
    ]
    return ["Sources:", "", *lines] if lines else []


def report_lines(findings: Sequence[RangeCheck], sources: Mapping[str, str]) -> list[str]:
    """Lines of a page: the summary, the table and its sources."""
    table = markdown(findings)
    return [f"{summary(findings)}.", "", *table, "", *sources_named(findings, sources)]


def to_json(findings: Iterable[RangeCheck], **more: Any) -> str:
    """The findings and more values as JSON; NaN and unlimited ends are null."""
    rows = [one._asdict() | {"verdict": one.verdict} for one in findings]
    for row in rows:
        for key in ("value", "low", "high"):
            row[key] = row[key] if math.isfinite(row[key]) else None
    return json.dumps(more | {"findings": rows}, indent=1, allow_nan=False) + "\n"


def check_page(path: Path, name: str, force: bool = False) -> None:
    """Raise a UserError unless `path` can be written and is new or a page of reports."""
    check_file(path)
    if force or not path.is_file() or path.stat().st_size == 0:
        return
    if not _MADE.search(read_text(path)):
        begin, end = _marks(name)
        raise UserError(
            f"exists without the lines `{begin}` and `{end}`; choose another name or give --force",
            file=path,
        )


def write_page(path: Path, name: str, lines: Sequence[str]) -> None:
    """Write lines between the marks of `name` in a page, or at its end with new marks.

    The rest of a page of reports is kept; any other file is replaced.
    """
    begin, end = _marks(name)
    part = "\n".join([begin, "", *lines, "", end])
    text = read_text(path) if path.is_file() else ""
    own = re.compile(f"{re.escape(begin)}.*?{re.escape(end)}", re.DOTALL)
    if own.search(text):
        whole = own.sub(lambda _: part, text, count=1)
    elif _MADE.search(text):
        whole = f"{text.rstrip()}\n\n{part}\n"
    else:
        whole = f"# Validation\n\n{part}\n"
    with replacing(path) as temporary:
        temporary.write_text(whole, encoding="utf-8")


def _marks(name: str) -> tuple[str, str]:
    return f"<!-- made by {name} -->", f"<!-- end of {name} -->"


def _cells(one: RangeCheck, failure: str) -> tuple[str, ...]:
    """The cells of a row; `failure` is the word for what fails."""
    ours = "–" if math.isnan(one.value) else f"{one.value:.3g}{one.unit}"
    if one.note:
        ours += f" ({one.note})"
    verdict = failure if one.verdict == FAIL else one.verdict
    return one.subject, one.quantity, ours, _range(one), one.source or "–", verdict


def _range(one: RangeCheck) -> str:
    if one.low == -math.inf and one.high == math.inf:
        return "–"
    if one.high == math.inf:
        return f"≥ {one.low:.3g}{one.unit}"
    if one.low == -math.inf:
        return f"≤ {one.high:.3g}{one.unit}"
    return f"{one.low:.3g}–{one.high:.3g}{one.unit}"
