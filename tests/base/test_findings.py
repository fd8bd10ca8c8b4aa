"""Verdicts of findings, and the page that keeps the text around its marks."""

import json
import math

import pytest

from subsea.base.errors import UserError
from subsea.base.findings import (
    FAIL,
    MISSING,
    NO_RANGE,
    PASS,
    RangeCheck,
    check_page,
    report_lines,
    summary,
    text_table,
    to_json,
    write_page,
)

FOUND = [
    RangeCheck("fusilier", "stride", 0.5, " L", 0.6, 0.8, "videler_1991 (27 species)"),
    RangeCheck("fusilier", "angle", math.nan, "°", 60, 150, "domenici_1997"),
    RangeCheck("shark", "speed", 0.5, " L/s", 0.5, 1.2, "webb_1982"),
    RangeCheck("sea", "ticks", 3.0),
]


def test_verdicts_include_the_ends_of_a_range():
    assert [one.verdict for one in FOUND] == [FAIL, MISSING, PASS, NO_RANGE]
    assert FOUND[0]._replace(value=0.8).verdict == PASS
    assert FOUND[0]._replace(high=math.inf).verdict == FAIL
    assert summary(FOUND) == (
        "1 within the published range, 1 outside, 1 not recorded, 1 without a range"
    )


def test_failures_are_capitals_in_text_and_red_on_the_page():
    table = text_table(FOUND)
    assert table[1].split()[-1] == "FAILS" and len(table) == 5
    page = report_lines(FOUND, {"videler_1991": "Videler", "other": "Other"})
    assert sum("color:red" in line for line in page) == 1
    assert "- `videler_1991`: Videler." in page
    assert not [line for line in page if "Other" in line]


def test_json_has_null_for_what_is_no_number():
    rows = json.loads(to_json(FOUND, seeds=[1]))
    assert rows["seeds"] == [1]
    assert [row["value"] for row in rows["findings"]] == [0.5, None, 0.5, 3.0]
    assert rows["findings"][3]["low"] is None


ONE, TWO = "subsea one", "subsea-two --validate"


def test_a_page_keeps_what_is_outside_its_marks(tmp_path):
    page = tmp_path / "page.md"
    write_page(page, ONE, ["first"])
    write_page(page, TWO, ["second \\1"])
    page.write_text(page.read_text() + "\nEnd.\n")
    write_page(page, ONE, ["again"])
    lines = [line for line in page.read_text().splitlines() if line and line[0] != "<"]
    assert lines == ["# Validation", "again", "second \\1", "End."]
    check_page(page, TWO)
    check_page(page, "subsea three")  # adds its part


def test_a_page_without_marks_is_not_replaced(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("# Mine\n")
    with pytest.raises(UserError, match="exists without the lines"):
        check_page(page, ONE)
    check_page(page, ONE, force=True)
    write_page(page, ONE, ["first"])
    assert "Mine" not in page.read_text()
    check_page(tmp_path / "new.md", ONE)
