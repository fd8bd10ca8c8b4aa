"""docs/learn_to_forage.py, with little of everything."""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

DOCS = Path(__file__).parents[2] / "docs"
LEARNED = np.array(
    [3.34, -1.49, 3.24, 1.82, 0.11, 2.4, 0.16, 0.55, 0.86, 0.47, -0.37, -0.75, 0.51]
)  # output of docs/learn_to_forage.py


@pytest.fixture
def script(monkeypatch):
    monkeypatch.syspath_prepend(DOCS)
    return import_module("learn_to_forage")


def test_a_brief_search_prints_and_draws(script, tmp_path, capsys):
    script.main([str(tmp_path), "--quick"])
    assert "own mind:" in capsys.readouterr().out
    assert [path.name for path in tmp_path.iterdir()] == ["environment-forage.png"]


def test_the_learned_policy_finds_more_food_than_the_minds_of_the_fishes(script):
    sea = script.make_sea()
    own, learned = (
        script.meals_a_minute(sea, 20_000, by, steps=100).mean() for by in (None, LEARNED)
    )
    assert learned > 1.2 * own > 0.0
