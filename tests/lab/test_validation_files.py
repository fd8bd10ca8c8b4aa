"""The files of a validation."""

import json

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.base.findings import FAIL
from subsea.base.report_files import ReportFiles
from subsea.lab.measures import Outside, Predation
from subsea.lab.schooling import BEARINGS, Schooling
from subsea.lab.validation import SeaMeasures, SeaTrial
from subsea.lab.validation_report import VALIDATION_PLOTS, seed_words, validate

SHARES = np.full(BEARINGS, 1 / BEARINGS)
SCHOOL = Schooling(
    0, 10, 0.95, 0.8, 0.1, 1.0, 0.3, SHARES, np.zeros(0), np.zeros(0), np.zeros(0, bool), 0.0
)
MEASURES = SeaMeasures(
    {}, [SCHOOL], [Outside("Fish", 1000, 1, 4.0, "seabed", 1.0)], Predation(3, 2, [2], 180.0)
)


def test_crashed_runs_are_an_error_after_the_files_are_written(tmp_path, capsys):
    jobs = [SeaTrial("sea", "preying", seed, 100) for seed in (1, 2)]

    def pool(work, given, check):
        yield from ((k, MEASURES if k else None) for k in given)

    files = ReportFiles("subsea me", tmp_path / "a.json", tmp_path / "a.md", tmp_path / "plots")
    files.check(VALIDATION_PLOTS, force=False)
    with pytest.raises(UserError, match="without 1 run whose process crashed \\(sea, seed 1\\)"):
        validate(jobs, files, pool, lambda: None)
    report = json.loads(files.json.read_text())
    assert report["seeds"] == [2]
    assert sum(row["verdict"] == FAIL for row in report["findings"]) == 1
    assert "Seeds 2, 3 s each." in files.page.read_text()
    assert {path.name for path in files.plots.iterdir()} == set(VALIDATION_PLOTS)
    assert "FAILS" in capsys.readouterr().out


def test_seeds_in_words():
    assert [seed_words(one) for one in ([1, 2, 3], [1, 3], [])] == ["1 to 3", "1, 3", "none"]
