"""docs/fish_in_two_dimensions.py: its physics, what it learns, and all of it with little effort."""

import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def flat() -> Iterator[ModuleType]:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(DOCS)
        yield import_module("fish_in_two_dimensions")
        for name in ("fish_in_two_dimensions", "picture_files"):
            del sys.modules[name]


@pytest.fixture(scope="module")
def body(flat: ModuleType) -> Any:
    return flat.flat_body()


def moving(body: Any) -> np.ndarray:
    """A state (2, n, 2) that is bent, stretched and in motion."""
    rng = np.random.default_rng(3)
    return np.stack([1.03 * body.rest, rng.normal(0.0, 0.5, body.rest.shape)])


def at_ease(body: Any, steps: int) -> np.ndarray:
    return np.tile(body.length[:6], (steps, 1))


@pytest.mark.parametrize(("implicit", "step"), [(True, 0.055), (False, 0.002)])
def test_in_a_vacuum_momentum_stays(
    flat: ModuleType, body: Any, implicit: bool, step: float
) -> None:
    start = moving(body)
    frames = flat.swim(body._replace(drag=0.0), start, at_ease(body, 400), step, implicit, 100)
    momentum = np.einsum("n,tnk->tk", body.mass, frames[:, 1])
    np.testing.assert_allclose(momentum, np.tile(momentum[0], (5, 1)), rtol=1e-9)
    assert np.abs(frames[-1, 0] - start[0]).max() > 0.1


def test_water_presses_on_the_edges_that_press_on_it(flat: ModuleType, body: Any) -> None:
    limp = body._replace(stiffness=0 * body.stiffness, viscosity=0 * body.viscosity)
    force = np.zeros_like(body.rest)
    flat.add_forces(body.rest, np.tile([0.0, 1.0], (12, 1)), limp, body.length, force)
    left, right = force[1:11:2], force[2:11:2]
    assert (left[:, 1] < 0).all()  # a fish that is moved to the left ...
    assert (right == 0).all()  # ... feels nothing on its right
    # On edges along x that is µ, area and speed multiplied.
    expected = -2.0 * (body.rest[1:11:2, 0][:-1] - body.rest[1:11:2, 0][1:]) * body.height[1:5]
    inner = np.convolve(expected, [0.5, 0.5], "valid")
    np.testing.assert_allclose(left[1:4, 1], inner, rtol=0.02)


def test_water_takes_momentum_away(flat: ModuleType, body: Any) -> None:
    start = np.stack([body.rest, np.full_like(body.rest, 1.0)])
    frames = flat.swim(body, start, at_ease(body, 200), 0.055, True, 200)
    speed = np.einsum("n,nk->k", body.mass, frames[-1, 1]) / body.mass.sum()
    # Slender: it is braked across its length far more than along it.
    assert 0.7 < speed[0] < 0.95
    assert 0.0 < speed[1] < 0.4


def test_explicit_euler_explodes_beyond_its_limit_and_implicit_does_not(
    flat: ModuleType, body: Any
) -> None:
    found = {name: energy for name, (_, energy) in flat.released(body, 40.0).items()}
    below, above, _, far, implicit = found.values()
    assert 0.1 < below[-1] < 1.0
    assert above[-1] > 2.0 * below[-1]
    assert np.isnan(far[-1])
    # Implicit Euler loses energy with every step, 19 times beyond the limit.
    assert (np.diff(implicit) <= 1e-12).all()
    assert implicit[-1] < 0.05


def test_the_limit_is_that_of_the_stiffest_units(flat: ModuleType, body: Any) -> None:
    """Were all units alike it would be their viscosity over stiffness, whatever the masses."""
    alike = body._replace(stiffness=np.full_like(body.stiffness, 60.0))
    assert flat.explicit_limit(alike) == pytest.approx(0.2 / 60.0, rel=1e-6)
    ratio = body.viscosity / body.stiffness
    assert ratio.min() <= flat.explicit_limit(body) <= ratio.max()


def test_small_implicit_and_explicit_steps_agree(flat: ModuleType, body: Any) -> None:
    start = moving(body)
    ends = [
        flat.swim(body, start, at_ease(body, 4000), 0.0005, implicit, 4000)[-1, 0]
        for implicit in (False, True)
    ]
    moved = np.abs(ends[0] - start[0]).max()
    assert np.abs(ends[0] - ends[1]).max() < 0.02 * moved


def test_it_learns_to_swim_farther_with_one_frequency(flat: ModuleType, body: Any) -> None:
    rng = np.random.default_rng(5)
    unlearned = [flat.distance(body, flat.controller_at(rng.random(13))) for _ in range(20)]
    lessons = flat.learn(flat.QUICK)
    learned = np.median([one.best[-1] for one in lessons.swims])
    assert learned > 5 * max(0.05, np.mean([far for far in unlearned if far > -1.0]))
    assert learned > 1.2 * np.median([one.best[-1] for one in lessons.many])
    # The same seed finds the same again, and the mirrored fish swims the mirrored way.
    one = lessons.swimmer
    left, right = (
        flat.run(body, flat.lengths(body, who, flat.steps_of(30.0)))[-1, 0]
        for who in (one, one.mirrored())
    )
    other = np.array([0, *(k + 1 if k % 2 else k - 1 for k in range(1, 11)), 11])
    np.testing.assert_allclose(left, right[other] * [1, -1], atol=1e-6)


def test_it_learns_to_turn(flat: ModuleType, body: Any) -> None:
    lessons = flat.learn(flat.QUICK)
    swum = flat.run(body, flat.lengths(body, lessons.swimmer, flat.steps_of(60.0)))
    to_left = flat.turned(body, swum[-1], lessons.turner)
    assert to_left == lessons.turns[0].scores.max()
    rng = np.random.default_rng(5)
    unlearned = [flat.turned(body, swum[-1], flat.controller_at(rng.random(13))) for _ in range(12)]
    assert to_left > 15.0 + np.mean([degrees for degrees in unlearned if degrees > -180.0])


@pytest.mark.parametrize("way", ["parameters", "phases", "lengths"])
def test_a_transition_leads_from_one_controller_to_the_other(
    flat: ModuleType, body: Any, way: str
) -> None:
    lessons = flat.learn(flat.QUICK)
    muscles = flat.passage(body, lessons.swimmer, lessons.turner, 50.0, way)
    before = flat.steady(body, lessons.swimmer, 50.0, 1)
    after = flat.steady(body, lessons.turner, 50.0 + 0.055 * (len(muscles) - 1), 1)
    np.testing.assert_allclose(muscles[[0]], before, rtol=2e-2)
    np.testing.assert_allclose(muscles[[-1]], after, rtol=2e-2)


def test_great_amplitudes_fold_the_body(flat: ModuleType, body: Any) -> None:
    assert flat.folded(body, 0.05, 12) == 0
    assert flat.folded(body, 0.5, 12) > 0.8


def test_the_outline_lies_in_the_scaffold_and_moves_with_it(flat: ModuleType, body: Any) -> None:
    assert flat.skin()[1].min() > -1e-9
    turned = body.rest @ np.array([[0.0, 1.0], [-1.0, 0.0]]) + 3.0
    at_rest = flat.outline_of(body, body.rest)
    expected = at_rest @ np.array([[0.0, 1.0], [-1.0, 0.0]]) + 3.0
    np.testing.assert_allclose(flat.outline_of(body, turned), expected, atol=1e-9)


@pytest.mark.nightly
def test_all_parts_are_drawn(
    flat: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flat.main([str(tmp_path), "--quick"])
    told = capsys.readouterr().out
    assert "one frequency: median" in told and "folded" in told
    assert {path.name for path in tmp_path.iterdir()} == {f"flat_{name}.png" for name in flat.PARTS}
