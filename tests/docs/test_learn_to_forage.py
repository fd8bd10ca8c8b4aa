"""docs/learn_to_forage.py, with little of everything."""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

DOCS = Path(__file__).parents[2] / "docs"
LEARNED = np.array(
    [6.76, -2.23, 2.34, 4.24, 0.39, 6.78, 1.06, 0.28, 3.79, 0.52, 0.78, 1.05, -0.17]
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
    assert learned > 1.1 * own > 0.0
