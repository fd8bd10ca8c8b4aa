"""Figures of behavior-figures.md: `python docs/hunting_figures.py preying|go-fish [SEEDS]`.

Runs the scenario with seeds 1 to SEEDS (10) and prints a line for each.
"""

import sys
from collections.abc import Iterator
from typing import Any

import numpy as np

from subsea.scenario.load import load_scenario
from subsea.state import EAT, ESCAPE, FEAR, HOOKED, LANDED, PACIFIST, PREDATOR, PREY
from subsea.submarine.vessel import NEUTRAL
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S, World

SECONDS = {"preying": 180.0, "go-fish": 75.0}


def ticks(name: str, seed: int, seconds: float) -> Iterator[World]:
    """The world of a scenario after each tick."""
    world = create_world(load_scenario(name)[0], seed=seed)
    for _ in range(round(seconds / TICK_S)):
        step(world, NEUTRAL)
        yield world


def preying(seed: int, seconds: float = SECONDS["preying"]) -> dict[str, Any]:
    """Print the catches, whether each escape followed fear, and the spread of the school."""
    caught: list[tuple[float, bool]] = []
    escapes = fearless = troubled = fed = 0
    alive = before = None
    radii, hunting = [], 0
    for world in ticks("preying", seed, seconds):
        fishes, minds = world.state.fishes, world.state.minds
        now = world.state.tick * TICK_S
        if alive is None or before is None:
            alive, before = fishes.alive.copy(), minds.intention.copy()
        caught += [(now, bool(minds.schools[j])) for j in np.flatnonzero(alive & ~fishes.alive)]
        begun = (minds.intention == ESCAPE) & (before != ESCAPE) & fishes.alive
        escapes += int(begun.sum())
        fearless += int((minds.mental[begun, FEAR] <= world.nature.alarmed).sum())
        peaceful = minds.kind == PACIFIST
        troubled += int((minds.mental[peaceful, FEAR] > 0).sum())
        fed += int((minds.intention[peaceful] == EAT).sum())
        hunting += int((minds.intention[minds.kind == PREDATOR] == EAT).sum())
        five = fishes.species == fishes.species[np.flatnonzero(minds.kind == PREY)[0]]
        school = fishes.position[fishes.alive & minds.schools & five]
        middle = np.median(school, axis=0) if len(school) else 0.0
        radii.append(float(np.linalg.norm(school - middle, axis=1).mean()) if len(school) else 0.0)
        alive, before = fishes.alive.copy(), minds.intention.copy()
    prey = minds.kind == PREY
    return {
        "schooling": int((prey & minds.schools).sum()),
        "stragglers": int((prey & ~minds.schools).sum()),
        "schooling caught": sum(schooled for _, schooled in caught),
        "stragglers caught": sum(not schooled for _, schooled in caught),
        "times s": [round(at) for at, _ in caught],
        "escapes": escapes,
        "without fear": fearless,
        "pacifists afraid": troubled,
        "pacifists' meals share": round(fed / max(int(peaceful.sum()) * len(radii), 1), 2),
        "hunted s": round(hunting * TICK_S),
        "school's radius cm": [round(np.percentile(radii, q)) for q in (10, 50, 100)],
        "at last cm": round(radii[-1]),
    }


def go_fish(seed: int, seconds: float = SECONDS["go-fish"]) -> dict[str, Any]:
    """Print when the first fish bit and when it was removed."""
    bitten = landed = None
    for world in ticks("go-fish", seed, seconds):
        state, now = world.state.sea.catch[0], world.state.tick * TICK_S
        if state == HOOKED and bitten is None:
            bitten = round(now, 1)
        if not world.state.fishes.alive.all() and landed is None:
            landed = round(now, 1)
        if state == LANDED:
            break
    return {"bitten s": bitten, "gone s": landed}


def main() -> None:
    """Print a line for each seed."""
    name = sys.argv[1] if len(sys.argv) > 1 else ""
    measures = {"preying": preying, "go-fish": go_fish}
    if name not in measures:
        raise SystemExit(__doc__)
    seeds = range(1, 1 + (int(sys.argv[2]) if len(sys.argv) > 2 else 10))
    rows = []
    for seed in seeds:
        rows.append(measures[name](seed))
        print(seed, rows[-1], flush=True)
    if name == "preying":
        for who in ("schooling", "stragglers"):
            share = sum(row[f"{who} caught"] for row in rows) / sum(row[who] for row in rows)
            print(f"{who}: {share:.0%} caught")


if __name__ == "__main__":
    main()
