"""A report as a table, a page, JSON and plots."""

import json

import pytest

from subsea.base.errors import UserError
from subsea.base.findings import RangeCheck
from subsea.base.report_files import Report, ReportFiles

ROWS = [RangeCheck("fusilier", "stride", 0.5, " L", 0.6, 0.8, "videler_1991")]
REPORT = Report(
    ROWS, {"videler_1991": "Videler"}, "Three seeds.", {"seeds": [1, 2, 3]},
    {"a.png": lambda figure: figure.subplots()}, ["Budgets: none."],
)  # fmt: skip


def test_all_files_are_of_one_report(tmp_path, capsys):
    files = ReportFiles("subsea me", tmp_path / "a.json", tmp_path / "a.md", tmp_path / "plots")
    files.check(REPORT.plots, force=False)
    files.write(REPORT)
    out = capsys.readouterr().out.splitlines()
    assert out[1].split()[-1] == "FAILS" and out[-1] == str(files.plots / "a.png")
    stored = json.loads(files.json.read_text())
    assert stored["seeds"] == [1, 2, 3] and stored["findings"][0]["value"] == 0.5
    page = files.page.read_text()
    assert page.startswith("# Validation\n\n<!-- made by subsea me -->\n\nThree seeds.\n")
    assert "- `videler_1991`: Videler.\n\nBudgets: none.\n" in page
    assert [path.name for path in files.plots.iterdir()] == ["a.png"]
    files.check(REPORT.plots, force=False)  # its own files are replaced


def test_without_files_only_the_table_is_printed(tmp_path, capsys):
    ReportFiles("subsea me").write(REPORT)
    assert "stride" in capsys.readouterr().out
    assert not [*tmp_path.iterdir()]


def test_an_interrupt_leaves_no_file(tmp_path):
    def check():
        raise KeyboardInterrupt

    files = ReportFiles("subsea me", tmp_path / "a.json", tmp_path / "a.md", tmp_path / "plots")
    with pytest.raises(KeyboardInterrupt):
        files.write(REPORT, check)
    assert not files.json.exists() and not files.page.exists()


def test_each_file_of_another_kind_is_refused(tmp_path):
    mine = tmp_path / "mine"
    mine.write_text("mine\n")
    for files in (
        ReportFiles("subsea me", json=mine),
        ReportFiles("subsea me", page=mine),
        ReportFiles("subsea me", plots=mine),
    ):
        with pytest.raises(UserError, match="mine"):
            files.check(["a.png"], force=False)
