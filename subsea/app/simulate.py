"""`subsea simulate`: what every fish does, for those who study them. No OpenGL."""

from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from subsea import hdf5, interrupts
from subsea.app.start import start_world
from subsea.behavior.table import INTENTIONS
from subsea.errors import UserError
from subsea.ocean import step
from subsea.places import check_file
from subsea.repertoire import SEGMENTS
from subsea.scenario import load_scenario
from subsea.state import COURTSHIP, MENTAL_STATES
from subsea.submarine.helm import HANDS_OFF
from subsea.world import TICK_S, World

FORMAT, VERSION = "subsea-record", 1
SUFFIXES = (".h5", ".hdf5")
BLOCK_FISH_TICKS = 200_000  # what is held in memory between two writes: some 16 MB

Rows = dict[str, NDArray[Any]]


def simulate(ticks: int, out: Path, scenario: str, fish: int | None, seed: int | None) -> int:
    """Record `ticks` ticks of a world into `out`; returns the exit code.

    The submarine drifts where it starts. Ctrl-C leaves a valid file with the ticks so far.
    """
    if out.suffix.lower() not in SUFFIXES:
        raise UserError(f"{out}: expected a name that ends in {' or '.join(SUFFIXES)}")
    check_file(out)
    chosen, source = load_scenario(scenario)
    if not any(shoal.number for shoal in chosen.fish):
        raise UserError(f"{source}: holds no fishes, there is nothing to record")
    world = start_world(scenario, seed, fish)
    number = len(world.state.fishes.species)
    length = int(np.clip(BLOCK_FISH_TICKS // number, 1, min(64, ticks)))
    block = _empty_block(length, number)
    held = 0
    attributes = _attributes(world, source.read_text(encoding="utf-8"))
    with (
        interrupts.deferred() as check,
        hdf5.recording(out, attributes, _constants(world)) as append,
    ):
        try:
            for k in tqdm(range(ticks), unit="tick", disable=None):
                check()
                if k:  # the world is at its first tick when it has started
                    step(world, HANDS_OFF)
                _note(world, block, held)
                held += 1
                if held == length or k == ticks - 1:
                    append({name: rows[:held] for name, rows in block.items()})
                    held = 0
        except KeyboardInterrupt:
            if held:
                append({name: rows[:held] for name, rows in block.items()})
            raise
    print(f"{out}: {ticks} ticks of {number} fishes")
    return 0


def _empty_block(length: int, n: int) -> Rows:
    """Room for `length` ticks of `n` fishes."""
    f, i = np.float32, np.int32
    return {
        "time": np.zeros(length, np.float64),
        "fish/position": np.zeros((length, n, 3), f),
        "fish/orientation": np.zeros((length, n, 4), f),
        "fish/velocity": np.zeros((length, n, 3), f),
        "fish/intention": np.zeros((length, n), np.uint8),
        "fish/segment": np.zeros((length, n), np.uint8),
        "fish/mental_state": np.zeros((length, n, len(MENTAL_STATES)), f),
        "fish/alive": np.zeros((length, n), np.bool_),
        "fish/courtship": np.zeros((length, n), np.uint8),
        "fish/partner": np.zeros((length, n), i),
        "fish/target": np.zeros((length, n), i),
        "plankton/count": np.zeros(length, i),
        "submarine/position": np.zeros((length, 3), np.float64),
    }


def _note(world: World, block: Rows, row: int) -> None:
    """Write the present tick into a row of the block."""
    state = world.state
    block["time"][row] = state.tick * TICK_S
    for name in ("position", "orientation", "velocity", "segment", "alive"):
        block[f"fish/{name}"][row] = getattr(state.fishes, name)
    block["fish/mental_state"][row] = state.minds.mental
    for name in ("intention", "courtship", "partner", "target"):
        block[f"fish/{name}"][row] = getattr(state.minds, name)
    block["plankton/count"][row] = (state.sea.absent == 0.0).sum()
    block["submarine/position"][row] = state.submarine.position


def _constants(world: World) -> Rows:
    fishes = world.state.fishes
    return {"fish/species": fishes.species, "fish/length": fishes.length}


def _attributes(world: World, scenario_text: str) -> dict[str, Any]:
    """The names behind every code, and all that is needed to run the same again."""
    bounds = world.scenario.bounds
    return {
        "format": FORMAT,
        "version": VERSION,
        "program": f"subsea {version('subsea')}",
        "tick_s": TICK_S,
        "seed": world.state.seed,
        "fish": len(world.state.fishes.species),
        "scenario": scenario_text,
        "radius_cm": bounds.radius_cm,
        "depth_cm": bounds.depth_cm,
        "species_keys": sorted({shoal.species for shoal in world.scenario.fish}),
        "species_names": [species.name for species in world.species],
        "intention_names": list(INTENTIONS),
        "segment_names": list(SEGMENTS),
        "mental_state_names": list(MENTAL_STATES),
        "courtship_names": list(COURTSHIP),
    }
