"""Fins and mouths of clips are those of the dive, in loops that close."""

import numpy as np
import pytest

from subsea.export.clips import Surface
from subsea.export.fin_motion import MOST_BEATS, NEAR, FinPlayer, _fitted
from subsea.fish.species import load_species, repertoire_file
from subsea.fish.surface import along, rest_control_points
from subsea.motor import fins as dive
from subsea.motor.playback import SLOW
from subsea.repertoire import read_repertoire
from subsea.state import DORSAL, LIFT_LEFT, MOUTH, SWEEP_LEFT, TAIL
from tests.support.scenes import BARE

BREATH = slice(SWEEP_LEFT, LIFT_LEFT)


def _player(name: str) -> tuple[FinPlayer, float]:
    species, repertoire = load_species(name), read_repertoire(repertoire_file(name))
    scale = float(np.mean(species.size_cm)) / repertoire.body_length_cm
    return FinPlayer(species, repertoire, scale), scale


@pytest.mark.parametrize("name", ["fusilier", "emperor_angelfish", "spotted_eagle_ray"])
def test_a_loop_closes_and_goes_on_as_smoothly_as_within(name: str) -> None:
    """Fins and mouth return to where they began, with the same motion."""
    player, _ = _player(name)
    for segment in ("swim_slow", "swim_medium", "swim_fast", "turn_left_gradual"):
        beats, moved = player.clip(segment)
        assert 1 <= beats <= MOST_BEATS and (len(moved) - 1) % beats == 0
        np.testing.assert_array_equal(moved[0], moved[-1])
        steps = np.abs(np.diff(moved, axis=0)).max(axis=1)
        around = np.abs(moved[1] - moved[0]).max(), np.abs(moved[-1] - moved[-2]).max()
        assert max(around) <= steps.max() * 1.001
        assert np.ptp(moved[:, MOUTH]) == pytest.approx(dive.GAPE, rel=0.05)
        assert (moved[:, SWEEP_LEFT] != moved[0, SWEEP_LEFT]).any()


TICK, TICKS = 0.033, 90


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("bluecheek_butterflyfish", 0.1, 0.25),
        ("fusilier", 0.02, 0.12),
        ("blacktip_reef_shark", 0, 0),
    ],
)
def test_the_edges_of_median_fins_wave_in_a_hovering_fish(
    name: str, low: float, high: float
) -> None:
    """A wave runs rearwards along the edge, of an amplitude in shares of the fin's height."""
    species = load_species(name)
    player, _ = _player(name)
    player._begin(SLOW, 0.0)
    player._fishes.thrust[:] = 0.0
    fins = np.array([player._step(0, TICK) for _ in range(2 * TICKS)])[TICKS:]
    surface = Surface(species, 1.0, 0)
    control = rest_control_points(species.surface, 1.0, 0.0)
    points, _ = surface.at(np.repeat(control[None], TICKS, axis=0), fins)
    plan = species.surface
    for fin, ridge in (("dorsal", plan.back), ("ventral", plan.belly)):
        feet, edge = np.split(points[:, surface.fins[fin]], 2, axis=1)
        np.testing.assert_allclose(feet[..., 2], 0.0, atol=1e-6)
        tall = np.abs(edge[..., 1] - along(ridge, -edge[0, :, 0])).mean(axis=0)
        wide = np.ptp(edge[..., 2], axis=0) / 2.0
        assert low <= wide.max() / tall.max() <= high
        if high == 0.0:
            continue
        beat = np.fft.rfft(edge[..., 2], axis=0)
        peak = int(np.abs(beat[1:]).sum(axis=1).argmax()) + 1
        hertz = peak / (TICKS * TICK) / player._fishes.size_rate[0]
        assert 1.5 <= hertz <= 4.0
        # Places farther behind move later.
        lag = -np.diff(np.unwrap(np.angle(beat[peak])))
        assert (lag > 0.0).all() and 1.0 <= lag.sum() / (2.0 * np.pi) <= 1.5


def test_fins_move_as_a_fish_of_the_dive_moves_them() -> None:
    """A fish that keeps a segment: the same range, and rates within the tolerance of loops."""
    import subsea

    world = subsea.load(str(BARE), seed=3)
    fishes = world.fishes
    seen: dict[int, list[np.ndarray]] = {}
    for _ in range(240):
        world.step(1)
        for i in range(len(fishes.species)):
            seen.setdefault(i, []).append(
                np.array([*fishes.fins[i], fishes.segment[i], fishes.goal_speed[i]])
            )
    player, _ = _player("fusilier")
    _, moved = player.clip("swim_medium")
    fastest = player._share(1)  # of swim_medium, as a share of swim_fast
    for i in range(4):  # the fusiliers
        rows = np.array(seen[i])
        middle, held = rows[:, SWEEP_LEFT], dive.REST_RAD - dive.FOLD_RAD * rows[:, -1]
        # Steering moves them besides.
        assert np.percentile(np.abs(middle - held), 90) < dive.FLAP_RAD + dive.EFFORT_RAD + 0.3
    held = dive.REST_RAD - dive.FOLD_RAD * fastest
    low, high = moved[:, SWEEP_LEFT].min(), moved[:, SWEEP_LEFT].max()
    assert (low + high) / 2 == pytest.approx(held, abs=0.02)
    assert (high - low) / 2 == pytest.approx(dive.FLAP_RAD, rel=0.05)
    assert moved[0, DORSAL] == pytest.approx(1.0 - dive.FOLDED * fastest**2, abs=1e-5)


def test_a_sharp_turn_spreads_the_tail_and_an_escape_folds_the_fins() -> None:
    player, _ = _player("fusilier")
    _, turning = player.clip("turn_left_sharp")
    assert turning[0, TAIL] < 0.02 and turning[-1, TAIL] > 0.15
    _, escaping = player.clip("cstart_left_wide")
    assert np.ptp(escaping[:, BREATH]) < 1e-6 and escaping[0, SWEEP_LEFT] < 0.1


def test_rowing_gaits_beat_the_pectoral_fins_once_a_cycle() -> None:
    """In phase with the recorded row, however long the clip."""
    player, _ = _player("emperor_angelfish")
    beats, moved = player.clip("row_forward")
    sweep = moved[:-1, SWEEP_LEFT].reshape(beats, -1)
    np.testing.assert_allclose(sweep, sweep[:1].repeat(beats, axis=0), atol=1e-5)
    assert np.ptp(sweep) == pytest.approx(2.0 * dive.ROW_RAD[1], rel=0.1)
    rows = sweep.shape[1]
    stroke = 2.0 * np.pi * (np.arange(rows) + 1) / rows
    middle, reach = dive.ROW_RAD
    np.testing.assert_allclose(sweep[0], middle + reach * np.cos(stroke), atol=1e-5)


@pytest.mark.parametrize(
    ("cycles", "beats", "whole"),
    [
        ((1.0, 1.0, 1.0), 1, (1, 1, 1)),
        ((0.5, 0.5, 1.5), 2, (1, 1, 3)),
        ((-0.5, 0.5, 1.05), 2, (-1, 1, 2)),
        ((0.0, 0.0, 0.9), 1, (0, 0, 1)),
        ((0.3, 0.3, 0.44), 4, (1, 1, 2)),
    ],
)
def test_the_fewest_beats_that_fit(
    cycles: tuple[float, ...], beats: int, whole: tuple[int, ...]
) -> None:
    found, numbers = _fitted(np.array(cycles))
    assert found == beats and tuple(numbers) == whole
    moving = np.array(cycles) != 0.0
    off = numbers[moving] / (beats * np.array(cycles)[moving]) - 1.0
    assert np.abs(off).max() <= NEAR
