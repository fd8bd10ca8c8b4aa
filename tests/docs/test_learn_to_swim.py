"""docs/learn_to_swim.py, with little of everything."""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from subsea.lab.environments.swim import SwimVectorEnv

DOCS = Path(__file__).parents[2] / "docs"
LEARNED = (0.295, 0.19, 0.36, 0.18, 0.44, 0.4, 0.9, 0.85, 0.82)  # as environments.md reports
RECORDED = 0.983  # L/s


@pytest.fixture
def script(monkeypatch):
    monkeypatch.syspath_prepend(DOCS)
    return import_module("learn_to_swim")


def test_a_brief_search_prints_and_draws(script, tmp_path, capsys):
    script.main([str(tmp_path), "--quick"])
    assert f"recorded fast swim: {RECORDED} L/s" in capsys.readouterr().out
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"environment-swim.png", "environment-swimmer.jpg"}


def test_the_learned_swim_is_faster_than_the_recorded_one(script):
    env = SwimVectorEnv(8)
    speeds = script.returns(env, np.tile(LEARNED, (8, 1)), seed=5, start=150, measured=100)
    env.close()
    assert np.median(speeds) > 1.05 * RECORDED  # from some starts it veers
