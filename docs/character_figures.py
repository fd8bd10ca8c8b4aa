"""Figures of behavior-figures.md on individuals: `python docs/character_figures.py [SEEDS]`.

Runs the scenario `schooling` with seeds 1 to SEEDS (3) for a minute each. Prints how well a fish's
speed and place in its school repeat from one half of the run to the other (Spearman's rank
correlation), and the correlation of each trait of its character with what it does.
"""

import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.scenario.load import load_scenario
from subsea.submarine.vessel import NEUTRAL
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S, World

TRAITS = ("timidity", "activity", "sociability")
SETTLE_S, SECONDS = 10.0, 60.0
EVERY = 6  # ticks between two samples

Columns = dict[str, NDArray[np.floating]]


def ranks_agree(first: NDArray[Any], second: NDArray[Any]) -> float:
    """Compute Spearman's rank correlation of two columns (n,)."""
    if np.ptp(first) == 0.0 or np.ptp(second) == 0.0:
        return 0.0
    ranks = [np.argsort(np.argsort(column)).astype(float) for column in (first, second)]
    return float(np.corrcoef(*ranks)[0, 1])


def school_sample(world: World, those: NDArray[Any]) -> Columns:
    """Measure speed, place along the heading, from the middle, and next neighbour, in lengths."""
    fishes = world.state.fishes
    length = float(fishes.length[those].mean())
    place, velocity = fishes.position[those] / length, fishes.velocity[those]
    course = velocity.mean(axis=0)
    course /= max(float(np.linalg.norm(course)), 1e-6)
    offset = place - np.median(place, axis=0)
    gaps = np.linalg.norm(place[:, None] - place[None], axis=2)
    np.fill_diagonal(gaps, np.inf)
    return {
        "speed": np.linalg.norm(velocity, axis=1) / length,
        "front": offset @ course,
        "from the middle": np.linalg.norm(offset, axis=1),
        "next neighbour": gaps.min(axis=1),
    }


def schooling(seed: int, name: str = "schooling") -> dict[str, float]:
    """Run a scenario, and correlate halves of the run, and traits with the means of the run."""
    world = create_world(load_scenario(name)[0], seed=seed)
    species = world.state.fishes.species[world.state.minds.schools]
    most = int(np.bincount(species).argmax())
    those = np.flatnonzero(world.state.minds.schools & (world.state.fishes.species == most))
    samples: list[Columns] = []
    for tick in range(round(SECONDS / TICK_S)):
        step(world, NEUTRAL)
        if tick * TICK_S > SETTLE_S and tick % EVERY == 0:
            samples.append(school_sample(world, those))
    half = len(samples) // 2
    figures = {}
    for what in samples[0]:
        column = np.array([sample[what] for sample in samples])
        halves = column[:half].mean(axis=0), column[half:].mean(axis=0)
        figures[f"{what} repeats"] = ranks_agree(*halves)
        for trait in TRAITS:
            values = getattr(world.state.minds, trait, None)
            if values is not None:
                figures[f"{trait}: {what}"] = ranks_agree(values[those], column.mean(axis=0))
        figures[f"{what}, mean"] = float(column.mean())
    return figures


def main() -> None:
    """Print the mean and the least and greatest of each figure over the seeds."""
    seeds = range(1, int(sys.argv[1]) + 1 if len(sys.argv) > 1 else 4)
    runs = [schooling(seed) for seed in seeds]
    for what in runs[0]:
        values = [run[what] for run in runs]
        print(f"{what}: {np.mean(values):.2f} ({min(values):.2f} to {max(values):.2f})")


if __name__ == "__main__":
    main()
