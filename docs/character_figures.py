"""Figures of behavior-figures.md on individuals: `python docs/character_figures.py [SEEDS]`.

Runs scenarios with seeds 1 to SEEDS (3) for a minute or more. Prints how well a fish's speed and
place in its school repeat from one half of the run to the other (Spearman's rank correlation), and
the correlation of each trait of its character with what it does: in a school, alone and hunted.
"""

import sys
from typing import Any

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from subsea.behavior.table import INTENTIONS
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Shoal
from subsea.state import FEAR, WANDER
from subsea.state.school_rules import REST
from subsea.submarine.vessel import NEUTRAL
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S, World

TRAITS = ("timidity", "activity", "sociability")
SETTLE_S, SECONDS, LONG_S = 10.0, 60.0, 150.0
PAUSE = 0.25  # share of the fast swim below which a wanderer pauses
FEW = 48  # fishes alone
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
    """Run a scenario, and correlate halves of the run, and traits with the means of the run.

    Schools travel: while they feed, places change.
    """
    world = create_world(load_scenario(name)[0], seed=seed)
    world.state.minds.rules[:, REST] = 0.0
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


def alone(seed: int) -> dict[str, float]:
    """Run some tangs in the bay, and correlate traits with what each of them does."""
    scenario = load_scenario("peaceful").scenario
    shoal = Shoal(species="blue_tang", number=FEW, libido_rate=0.0, hunger=0.5)
    world = create_world(replace(scenario, fish=[shoal], individual=[], tour=[]), seed=seed)
    fishes, minds = world.state.fishes, world.state.minds
    ticks = round(LONG_S / TICK_S)
    near, first, meals = np.full(FEW, LONG_S), np.full(FEW, LONG_S), np.zeros(FEW)
    cruising: list[NDArray[Any]] = []
    eaten = minds.eaten.copy()
    for tick in range(ticks):
        step(world, NEUTRAL)
        gap = np.linalg.norm(fishes.position - world.state.submarine.position, axis=1)
        met = (gap < world.nature.curiosity_cm) & (near == LONG_S)
        near[met] = tick * TICK_S
        watching = minds.intention == INTENTIONS.index("curious")
        first = np.where(watching & (first == LONG_S), tick * TICK_S, first)
        meals += minds.eaten > eaten
        eaten = minds.eaten.copy()
        if tick % EVERY == 0:
            speed = np.linalg.norm(fishes.velocity - fishes.drift, axis=1) / fishes.fast
            cruising.append(np.where(minds.intention == WANDER, speed, np.nan))
    speeds = np.array(cruising)
    return {
        "activity: speed of a wanderer": ranks_agree(minds.activity, np.nanmean(speeds, axis=0)),
        "activity: share of pauses": ranks_agree(
            minds.activity, np.nanmean(np.where(np.isnan(speeds), np.nan, speeds < PAUSE), axis=0)
        ),
        "wanders, share": float(np.isfinite(speeds).mean()),
        "timidity: delay of a look at the submarine": ranks_agree(
            minds.timidity[near < LONG_S], (first - near)[near < LONG_S]
        ),
        "appetite: meals": ranks_agree(minds.voracity, meals),
    }


def hunted(seed: int) -> dict[str, float]:
    """Run the reef of `preying`, and correlate timidity with the distance of the first flight."""
    world = create_world(load_scenario("preying")[0], seed=seed)
    fishes, minds = world.state.fishes, world.state.minds
    far = np.full(len(fishes.length), np.nan)
    for _ in range(round(SECONDS / TICK_S)):
        step(world, NEUTRAL)
        alarmed = (minds.mental[:, FEAR] > world.nature.alarmed) & (minds.predator >= 0)
        for i in np.flatnonzero(alarmed & np.isnan(far) & fishes.alive):
            far[i] = np.linalg.norm(fishes.position[i] - fishes.position[minds.predator[i]])
    seen = np.isfinite(far)
    return {"timidity: distance of alarm": ranks_agree(minds.timidity[seen], far[seen])}


def main() -> None:
    """Print the mean and the least and greatest of each figure over the seeds."""
    seeds = range(1, int(sys.argv[1]) + 1 if len(sys.argv) > 1 else 4)
    for run in (schooling, alone, hunted):
        figures = [run(seed) for seed in seeds]
        for what in figures[0]:
            values = [each[what] for each in figures]
            print(f"{what}: {np.mean(values):.2f} ({min(values):.2f} to {max(values):.2f})")


if __name__ == "__main__":
    main()
