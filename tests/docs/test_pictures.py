"""The pictures of the documentation: each has one script, and those scripts still draw."""

import re
import sys
from fnmatch import fnmatch
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from subsea.fish.species import load_species
from subsea.fish.surface import rest_control_points
from subsea.frame.packet import FINS, KIND, ROW_A, ROW_B
from subsea.state import FINS_AT_EASE

ROOT = Path(__file__).parents[2]
PICTURES = sorted(path.name for path in (ROOT / "docs/pictures").iterdir())
TABLE = re.findall(
    r"^\| (?:`(\w+\.py)`.*?|by hand) \| ([\w.* -]+) \| ([\w. -]+) \|$",
    (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8"),
    re.MULTILINE,
)


def test_every_picture_is_made_by_one_script_and_every_script_is_listed():
    makers = {name: [row for row in TABLE for one in row[1].split() if fnmatch(name, one)]
              for name in PICTURES}  # fmt: skip
    assert {name: len(rows) for name, rows in makers.items() if len(rows) != 1} == {}
    listed = {row[0] for row in TABLE if row[0]}
    scripts = {path.name for path in (ROOT / "docs").glob("make_*.py")}
    scripts -= {"make_reference.py"}  # which makes pages
    assert scripts <= listed
    assert all((ROOT / "docs" / name).exists() for name in listed)


def test_every_picture_is_shown_where_the_list_says():
    pages = {path.name: path.read_text(encoding="utf-8")
             for path in [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")]}  # fmt: skip
    for script, patterns, shown in TABLE:
        made = [name for name in PICTURES if any(fnmatch(name, one) for one in patterns.split())]
        assert made, patterns
        where = {page for page, text in pages.items() for name in made
                 if f"pictures/{name})" in text}  # fmt: skip
        assert where == set(shown.split()), script


def test_no_picture_is_large():
    sizes = {path.name: path.stat().st_size for path in (ROOT / "docs/pictures").iterdir()}
    assert {name: size for name, size in sizes.items() if size > 1_500_000} == {}
    assert sum(sizes.values()) < 10_000_000


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("script", "draw"), [("make_reef_pictures", "plate"), ("make_spine_pictures", "beats")]
)
def test_plates_with_their_own_records_are_drawn(script, draw, monkeypatch):
    """Nothing but these scripts writes the records of fishes and growths that it draws."""
    monkeypatch.syspath_prepend(ROOT / "docs")
    module = import_module(script)
    if script == "make_reef_pictures":
        monkeypatch.setattr(module, "SIZE", (256, 104))
    else:
        monkeypatch.setattr(module, "CELL", (70, 42))
    picture = np.asarray(getattr(module, draw)())
    for name in (script, "picture_files"):
        del sys.modules[name]
    assert picture.std(axis=(0, 1)).min() > 8


def test_a_plate_draws_each_species_as_itself_with_its_fins_at_ease(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.syspath_prepend(ROOT / "docs")
    make_pictures = import_module("make_pictures")
    fusilier = load_species("fusilier")
    points = rest_control_points(fusilier.surface, fusilier.length_cm, 0.0)
    record = make_pictures._record(3, fusilier, points, 0, (0.5, 0.5), 4, 1.0)
    assert record[KIND] == 3 and record[ROW_A] == record[ROW_B] == 3
    np.testing.assert_allclose(record[FINS][2:], FINS_AT_EASE[2:], rtol=1e-6)
