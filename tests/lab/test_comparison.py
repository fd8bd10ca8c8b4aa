"""Several records: the measures of each as a row, and of groups with their uncertainty."""

import json
import lzma
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from subsea.cli.main import main
from subsea.lab.comparison import (
    Estimate,
    comparison_table,
    estimate,
    flat_measures,
    grouped,
    student,
)
from subsea.lab.report import measure
from subsea.lab.sweep import Sweep, sweep
from subsea.media.record import Origin
from tests.support.records import INTENTIONS, OLDEST_RECORD, a_record, row, still
from tests.support.scenes import BARE

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "records.md"


def school_of(n):
    """Fishes that follow the first."""
    leader = np.zeros((60, n), np.int32)
    return a_record(still(60, *row(n, 1.0)), leader=leader, intention=leader + 2)


def test_nested_measures_have_names_with_dots():
    found = measure(school_of(4))
    flat = flat_measures(found)
    assert flat["sea.fish_ticks"] == 240.0
    assert flat["minds.time_budget.fish.school"] == 1.0
    assert flat["species.fish"] == 4.0
    assert flat["minds.escapes_after_fear_share"] is None
    assert all(value is None or isinstance(value, float) for value in flat.values())


def test_schools_become_one():
    found = measure(school_of(4))
    one = found["schools"][0]
    other = one | {"fishes": 6, "splits": 2, "longest_split_s": 3.0, "cruising_share": 0.0}
    flat = flat_measures(found | {"schools": [one, other]})
    assert flat["schools.number"] == 2.0
    assert flat["schools.fishes"] == 10.0
    assert flat["schools.splits"] == 2.0
    assert flat["schools.longest_split_s"] == 3.0
    assert flat["schools.cruising_share"] == pytest.approx(one["cruising_share"] / 2)
    assert flat["schools.nearest_bl.p50"] == one["nearest_bl"]["p50"]
    alone = flat_measures(found | {"schools": []})
    assert alone.keys() == flat.keys()
    assert alone["schools.number"] == 0.0 and alone["schools.polarisation_median"] is None


def test_the_documentation_lists_every_column():
    flat = flat_measures(measure(school_of(4)))
    columns = {
        re.sub(rf"\.({'|'.join(INTENTIONS)})$", ".INTENTION", re.sub(r"\.fish\b", ".SPECIES", name))
        for name in flat
    }
    section = PAGE.read_text(encoding="utf-8").partition("## Columns of a sweep")[2]
    table = [line for line in section.splitlines() if line.startswith("| `")]
    assert {name for line in table for name in re.findall(r"`([\w.]+)`", line)} == columns


@pytest.mark.parametrize("freedom", [*range(1, 31), 100, 10_000])
def test_quantiles_are_those_of_students_distribution(freedom):
    from scipy import stats

    assert student(freedom) == pytest.approx(stats.t.ppf(0.975, freedom), rel=2e-4)


def test_an_estimate_is_the_mean_with_its_interval():
    from scipy import stats

    rows = [{"x": 1.0}, {"x": 2.0}, {"x": 6.0}, {"x": None}, {}]
    found = estimate(rows, "x")
    low, high = stats.t.interval(0.95, 2, loc=3.0, scale=stats.sem([1.0, 2.0, 6.0]))
    assert found.number == 3
    assert found.mean == pytest.approx(3.0)
    assert found.half_width == pytest.approx((high - low) / 2, rel=1e-4)
    assert estimate(rows[:1], "x") == Estimate(1, 1.0, None)
    assert estimate(rows[3:], "x") == Estimate(0, None, None)


def test_records_that_differ_by_seed_are_a_group(tmp_path):
    shy, same = ("nature.timidity=2",), Origin("Reef", "abc", (), 5)
    origins = [same, same._replace(changes=shy), same, same._replace(fish=6)]
    rows = [(k, {"x": float(k), "none": 0.0}) for k in range(4)]
    groups = grouped([tmp_path / f"{k}.h5" for k in range(4)], origins, rows)
    assert [group.seeds for group in groups] == [[0, 2], [1], [3]]
    assert [group.label for group in groups] == [
        "as in the scenario (5 fishes)", "nature.timidity=2", "as in the scenario (6 fishes)",
    ]  # fmt: skip
    assert groups[0].estimates["x"].mean == 1.0
    lines = comparison_table(groups)
    assert lines[0] == "group 1: 2 records, as in the scenario (5 fishes)"
    assert lines[-1].split() == ["x", "1", "±", "13",
                                 "1", "3"]  # fmt: skip
    others = grouped(["a", "b"], [same, same._replace(title="Cave", scenario_sha256="d")], rows[:2])
    assert [group.label for group in others] == ["Reef", "Cave"]


@pytest.fixture(scope="module")
def records(tmp_path_factory):
    folder = tmp_path_factory.mktemp("compare")
    sweep(Sweep(str(BARE), (1, 2), 3, values={"fish.0.number": (3, 4)}), folder, records=True)
    return sorted((folder / "records").iterdir())


def test_the_command_prints_draws_and_writes_groups(records, tmp_path, capsys):
    out, report = tmp_path / "plots", tmp_path / "compared.json"
    paths = [*map(str, records)]
    assert main(["study", *paths, "--out", str(out), "--json", str(report)]) == 0
    text = capsys.readouterr().out
    assert "2 records, fish.0.number=3" in text and "2 records, fish.0.number=4" in text
    assert text.splitlines()[-1] == str(out / "comparison.png")
    found = json.loads(report.read_text())
    assert found["confidence"] == 0.95
    assert sorted(path for group in found["groups"] for path in group["records"]) == paths
    for group in found["groups"]:
        number = float(group["changes"][0][-1]) + 2
        assert group["seeds"] == [1, 2] or group["seeds"] == [2, 1]
        assert group["measures"]["fishes"] == {"number": 2, "mean": number, "half_width": 0.0}
    picture = np.asarray(Image.open(out / "comparison.png"))
    assert picture.std() > 5 and picture.shape[1] >= 600


def test_an_older_record_is_a_group_of_unknown_origin(records, tmp_path, capsys):
    old = tmp_path / "old.h5"
    old.write_bytes(lzma.decompress(OLDEST_RECORD.read_bytes()))
    assert main(["study", str(old), str(records[0])]) == 0
    assert "group 1: 1 record, records of unknown origin" in capsys.readouterr().out


def test_faults_are_one_line_before_the_work(records, tmp_path, capsys):
    one, two = map(str, records[:2])
    for options, words in (
        ([one, two, "--json", one], "is the record too"),
        ([one, one], "a record is given twice"),
        ([one, str(tmp_path / "none.h5")], "no such file"),
    ):
        assert main(["study", *options]) == 2
        out = capsys.readouterr()
        assert not out.out and words in out.err and len(out.err.splitlines()) == 1
