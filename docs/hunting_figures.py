"""Figures of behavior-figures.md: `python docs/hunting_figures.py SCENARIO [SEEDS]`.

Runs a scenario with seeds 1 to SEEDS (10) and prints a line for each: `preying`, `go-fish`, or the
hunts of `preying`, `rendezvous`, `visitors`, `peaceful` (with a shark) and `pack` (three sharks and
schools among pillars) as `hunts:preying` and so on.
"""

import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
from msgspec.structs import replace

from subsea.lab.hunting import Hunts, hunts
from subsea.lab.simulate import live_records
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Scenario, Shoal
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


SHARK = "blacktip_reef_shark"
MINUTES = {"rendezvous": 1.2}  # of a run; others take three


def scene(name: str) -> Scenario:
    """Load the scenario for the measures of hunts, with the predators that its name promises."""
    if name == "peaceful":
        bay = load_scenario(name)[0]
        shark = Shoal(species=SHARK, number=1, position_cm=(500.0, 300.0, -250.0), hunger=1.0)
        return replace(bay, fish=[*bay.fish, shark])
    if name == "pack":
        pillars = load_scenario("schooling")[0]
        sharks = [
            Shoal(species=SHARK, number=1, size_cm=(size, size + 2.0), hunger=0.9, spread_cm=200.0,
                  position_cm=(600.0, -300.0 + 300.0 * k, -300.0))
            for k, size in enumerate((115.0, 135.0, 155.0))
        ]  # fmt: skip
        return replace(pillars, fish=[*pillars.fish, *sharks])
    return load_scenario(name)[0]


def hunts_of(name: str, seed: int) -> Hunts:
    """Measure the hunts of the first minutes of a scenario."""
    ticks = round(60.0 * MINUTES.get(name, 3.0) / TICK_S)
    (record,) = live_records(create_world(scene(name), seed=seed), ticks, 10**9)
    return hunts(record)


def row_of(found: Hunts) -> dict[str, Any]:
    """Sum up the hunts of a run."""
    rushes = found.rushes
    close = [rush for rush in rushes if rush.close and rush.school]
    return {
        "patrol": f"{found.patrol_share:.0%} at {found.patrol_bl_s:.2f} L/s",
        "rushes": len(rushes),
        "close at a school": len(close),
        "first s": round(rushes[0].start_s) if rushes else None,
        "first close at a school s": round(close[0].start_s) if close else None,
        "caught s": [round(at) for at in found.caught_s],
        "hits": sum(rush.hit for rush in rushes),
        "below or behind": sum(rush.below or rush.behind for rush in rushes),
        "from L": _range([rush.start_bl for rush in rushes]),
        "for s": _range([rush.duration_s for rush in rushes]),
        "peak L/s": _range([rush.peak_bl_s for rush in rushes]),
        "gap cm": round(found.least_gap_cm, 1),
    }


def _range(values: list[float]) -> str:
    """Write the least, median and greatest of some values."""
    return "/".join(f"{np.percentile(values, q):.1f}" for q in (0, 50, 100)) if values else "-"


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
    of_hunts = name.removeprefix("hunts:") if name.startswith("hunts:") else ""
    if name not in measures and not of_hunts:
        raise SystemExit(__doc__)
    seeds = range(1, 1 + (int(sys.argv[2]) if len(sys.argv) > 2 else 10))
    rows = []
    for seed in seeds:
        of_run = row_of(hunts_of(of_hunts, seed)) if of_hunts else measures[name](seed)
        rows.append(of_run)
        print(seed, rows[-1], flush=True)
    if name == "preying":
        for who in ("schooling", "stragglers"):
            share = sum(row[f"{who} caught"] for row in rows) / sum(row[who] for row in rows)
            print(f"{who}: {share:.0%} caught")


if __name__ == "__main__":
    main()
