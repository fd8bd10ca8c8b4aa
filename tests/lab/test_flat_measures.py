"""The measures as columns of a table."""

import re
from pathlib import Path

import numpy as np
import pytest

from subsea.lab.comparison import flat_measures
from subsea.lab.report import measure
from tests.support.records import INTENTIONS, a_record, row, still

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
