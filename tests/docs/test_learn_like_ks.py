"""docs/learn_like_ks.py, with little of everything."""

import sys
from collections.abc import Iterator
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from subsea.biomechanics.body import TRIANGLES, build_body
from subsea.biomechanics.simulation import at_rest, simulate

SCRIPT = Path(__file__).parents[2] / "docs" / "learn_like_ks.py"


@pytest.fixture(scope="module")
def ks() -> Iterator[ModuleType]:
    spec = spec_from_file_location("learn_like_ks", SCRIPT)
    assert spec
    assert spec.loader
    module = module_from_spec(spec)
    sys.modules["learn_like_ks"] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules["learn_like_ks"]


def test_all_four_experiments_run_and_repeat(
    ks: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    told = []
    for only in ("a", "b", "a"):
        ks.main([str(tmp_path), "--quick", "--only", only])
        told.append(capsys.readouterr().out)
    assert told[0] == told[2]
    assert "six frequencies" in told[0]
    assert "steering map" in told[1]
    assert {path.name for path in tmp_path.iterdir()} == {"ks_frequencies.png", "ks_turning.png"}


def test_strong_sinusoids_fold_the_body_and_weak_ones_do_not(
    ks: ModuleType, tmp_path: Path
) -> None:
    shares = ks.folding(build_body(ks.muscles_of("fusilier").body), ks.QUICK, tmp_path)
    assert shares[0.05] == shares[0.1] == 0
    assert shares[0.6] > 0.5


@pytest.mark.nightly
def test_one_diagonal_rolls_the_fish_and_both_do_not(ks: ModuleType, tmp_path: Path) -> None:
    found = ks.rolling(ks.QUICK, tmp_path)
    for name in ("fusilier", "emperor_angelfish"):
        assert abs(found[f"{name}, one diagonal"][-1, 0]) > 45
        assert abs(found[f"{name}, both diagonals"][-1, 0]) < 2


def test_one_diagonal_covers_the_same_hull(ks: ModuleType) -> None:
    """Its normals still sum to nothing: the hull is closed, and each face is there once."""
    triangles, weights = ks.one_diagonal()
    x = build_body(ks.muscles_of("fusilier").body).rest
    a, b, c = (x[triangles[:, corner]] for corner in range(3))
    normals = np.cross(b - a, c - a) * weights[:, None]
    np.testing.assert_allclose(normals.sum(axis=0), 0, atol=1e-12)
    assert len(triangles) < len(TRIANGLES)


@pytest.mark.nightly
def test_the_recompiled_kernel_agrees_for_the_same_hull(ks: ModuleType) -> None:
    from subsea.biomechanics.body import TRIANGLE_WEIGHTS

    body = build_body(ks.muscles_of("fusilier").body)
    contraction = ks.contraction_of(ks.sinusoids(np.full(13, 0.3), True), 60)
    again = ks.simulate_with(TRIANGLES, TRIANGLE_WEIGHTS)(body, at_rest(body), contraction)
    np.testing.assert_array_equal(again, simulate(body, at_rest(body), contraction))
