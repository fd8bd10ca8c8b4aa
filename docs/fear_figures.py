"""Measure how long intentions and fear last: `python docs/fear_figures.py [SEEDS] [SCENARIO …]`.

Runs scenarios for a minute each with seeds 1 to SEEDS (4) and prints a line for each run:

- bouts: intentions that began and ended within the run
- short: share of bouts below 0.5 s, of those that no danger or collision ended
- short_all: share of all bouts below 0.5 s
- flips: passages of fear through f0 for each prey and minute
- lasts_s: quartiles of the time from the last sight of a predator that alarms until fear is below
  f0
- starts, flight_bl_s: C-starts, and the fastest half second of the 2.5 s after them, median, L/s
- clear_cm: median distance of a hunter that is within 250 cm of a school to the nearest fish of it
- angle: median angle between the flight of fishes within 250 cm and their way to the hunter, °
- reform_s: times from the hunter's leaving (400 cm) until the school is as close as before it

The scenarios `raid` (a shark, a school and single fishes among rocks), `strike` (a shark and a
school in the open) and `visit` (a submarine that circles about schools) exist only here.
"""

import sys
from collections import Counter
from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple

import msgspec
import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.behavior.table import INTENTIONS
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Rock, Scenario, Shoal
from subsea.state import AVOID, ESCAPE, FEAR, PREDATOR, PREY
from subsea.submarine.vessel import STATION, Helm
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S, World

SECONDS = 60.0
SHORT_S = 0.5
ATTACKED_CM, GONE_CM = 250.0, 400.0  # distances of a hunter that is near, and that has left
MANY = 10  # fishes of a school that is measured
STRUGGLE = INTENTIONS.index("struggle")
REACTIONS = (AVOID, ESCAPE, STRUGGLE)
LITTLE = "water.plankton=200", "seaweed=[]", "reef=[]"


class Watched(NamedTuple):
    """A record of n fishes in T ticks."""

    intention: Ints  # (T, n)
    fear: Array  # (T, n)
    sees: Bools  # (T, n), whether an alarming predator or submarine is in sight
    alive: Bools  # (T, n)
    position: Array  # (T, n, 3) cm
    velocity: Array  # (T, n, 3) cm/s
    startled: Array  # (T, n) s since the last C-start
    length: Array  # (n,) cm
    school: Bools  # (n,), prey that schools
    hunter: int  # the first predator, or -1
    prey: Bools  # (n,)
    alarmed: float


def raid() -> Scenario:
    """A hungry shark before a school of fusiliers among rocks."""
    bay = load_scenario("schooling", LITTLE).scenario
    rocks = [
        Rock(position_cm=(x, y), size_cm=(90.0, 70.0, 160.0))
        for x, y in ((-250.0, 160.0), (120.0, -180.0), (330.0, 240.0), (-60.0, 420.0))
    ]
    fish = [
        Shoal(species="fusilier", number=40, position_cm=(-150.0, 0.0, -380.0), spread_cm=110.0),
        Shoal(species="fusilier", number=6, position_cm=(150.0, 200.0, -400.0), spread_cm=300.0,
              schooling=False),
        Shoal(species="blacktip_reef_shark", number=1, position_cm=(600.0, 60.0, -360.0),
              heading_deg=180.0, hunger=1.0, spread_cm=50.0),
    ]  # fmt: skip
    nature = msgspec.structs.replace(bay.nature, submarine_cm=0.0)
    return msgspec.structs.replace(
        bay, fish=fish, rock=rocks, outcrop=[], ridge=[], pillar=[], nature=nature
    )


def strike() -> Scenario:
    """A hungry shark before a school of fusiliers in the open."""
    scene = raid()
    school = msgspec.structs.replace(scene.fish[0], position_cm=(0.0, 0.0, -340.0))
    return msgspec.structs.replace(scene, fish=[school, scene.fish[2]], rock=[])


def visit() -> Scenario:
    """Schools of fusiliers and silversides around which the submarine circles."""
    bay = load_scenario("schooling", LITTLE).scenario
    here = bay.submarine.position_cm
    fish = [
        Shoal(species="fusilier", number=24, position_cm=(here[0] + 150.0, here[1] + 150.0, -320.0),
              spread_cm=110.0),
        Shoal(species="hardyhead_silverside", number=40,
              position_cm=(here[0] + 40.0, here[1] + 220.0, -260.0), spread_cm=80.0),
    ]  # fmt: skip
    return msgspec.structs.replace(bay, fish=fish, outcrop=[], ridge=[], pillar=[], rock=[])


MADE: dict[str, Callable[[], Scenario]] = {"raid": raid, "strike": strike, "visit": visit}
CIRCLES = Helm(surge=0.25, yaw=0.22)
NAMES = "preying", "rendezvous", "schooling", "raid", "strike", "visit"


def scenario_of(name: str) -> Scenario:
    """Make or load a scenario."""
    return MADE[name]() if name in MADE else load_scenario(name)[0]


def watch(name: str, seed: int, seconds: float = SECONDS) -> Watched:
    """Run a scenario, and keep what its fishes intend, fear and see."""
    world = create_world(scenario_of(name), seed=seed)
    order = CIRCLES if name == "visit" else STATION
    rows: list[tuple[Any, ...]] = []
    for _ in range(round(seconds / TICK_S)):
        step(world, order)
        rows.append(_now(world))
    minds = world.state.minds
    parts = (np.array(part) for part in zip(*rows, strict=True))
    hunters, prey = np.flatnonzero(minds.kind == PREDATOR), minds.kind == PREY
    return Watched(
        *parts, world.state.fishes.length.copy(), prey & minds.schools,
        int(hunters[0]) if len(hunters) else -1, prey, world.nature.alarmed,
    )  # fmt: skip


def _now(world: World) -> tuple[Any, ...]:
    fishes, minds = world.state.fishes, world.state.minds
    return (
        minds.intention.copy(), minds.mental[:, FEAR].copy(), minds.menaces > world.nature.alarmed,
        fishes.alive.copy(), fishes.position.copy(), fishes.velocity - fishes.drift,
        minds.startled.copy(),
    )  # fmt: skip


def bouts(seen: Watched) -> list[tuple[int, int, float]]:
    """List the bouts that began and ended: intention, the next one, and length, s."""
    found = []
    for i in range(seen.intention.shape[1]):
        living = int(seen.alive[:, i].sum())
        row = seen.intention[:living, i]
        starts = np.flatnonzero(np.diff(row)) + 1
        for a, b in pairwise(starts):
            found.append((int(row[a]), int(row[b]), (b - a) * TICK_S))
    return found


def lasting(seen: Watched) -> list[float]:
    """Measure the times from the last sight of a predator until fear falls below f0, s.

    Those that the end of the run cuts off count as they are, as do those that a new sight ends.
    """
    times = []
    for i in np.flatnonzero(seen.prey):
        living = int(seen.alive[:, i].sum())
        sees, afraid = seen.sees[:living, i], seen.fear[:living, i] > seen.alarmed
        for t in np.flatnonzero(sees[:-1] & ~sees[1:] & afraid[:-1]) + 1:
            ends = np.flatnonzero(sees[t:] | ~afraid[t:])
            if len(ends) and sees[t + ends[0]] and afraid[t + ends[0]]:
                continue  # seen again while it was still afraid
            times.append((ends[0] if len(ends) else living - t) * TICK_S)
    return times


def flights(seen: Watched) -> dict[str, Any]:
    """Measure the fastest half second after each C-start."""
    half, long = round(0.5 / TICK_S), round(2.5 / TICK_S)
    way = np.linalg.norm(seen.position[half:] - seen.position[:-half], axis=2)
    speed = way / seen.length / (half * TICK_S)
    began = (seen.startled[1:] < seen.startled[:-1]) & seen.alive[1:]
    best = [speed[t : t + long, i].max() for t, i in np.argwhere(began) if t < len(speed)]
    return {"starts": len(best), "flight_bl_s": round(float(np.median(best)), 2) if best else 0}


def attacks(seen: Watched) -> dict[str, Any]:
    """Measure the flight of prey, and the shape of a school around the hunter."""
    found = flights(seen)
    speed = np.linalg.norm(seen.velocity, axis=2) / seen.length
    members = np.flatnonzero(seen.school)
    if seen.hunter < 0 or len(members) < MANY:
        return found
    toward = seen.position[:, [seen.hunter]] - seen.position[:, members]
    far = np.where(seen.alive[:, members], np.linalg.norm(toward, axis=2), np.inf)
    nearest = far.min(axis=1)
    near = nearest < ATTACKED_CM
    fast = seen.velocity[:, members]
    with np.errstate(invalid="ignore", divide="ignore"):
        along = (toward * fast).sum(axis=2) / far / np.linalg.norm(fast, axis=2)
    close = (far < ATTACKED_CM) & (speed[:, members] > 2.0)
    radius = np.array([
        np.median(np.linalg.norm(place - np.median(place, axis=0), axis=1))
        for place in (seen.position[t, members[seen.alive[t, members]]] for t in range(len(near)))
    ])  # fmt: skip
    usual = 1.5 * np.median(radius[: round(5.0 / TICK_S)])
    left = np.flatnonzero((nearest[1:] > GONE_CM) & (nearest[:-1] <= GONE_CM)) + 1
    again = [np.flatnonzero(radius[t:] < usual) for t in left if radius[t] >= usual]
    return found | {
        "clear_cm": round(float(np.median(nearest[near]))) if near.any() else None,
        "angle": round(float(np.degrees(np.arccos(np.median(along[close]))))) if close.any() else 0,
        "reform_s": [round(float(k[0] * TICK_S), 1) if len(k) else None for k in again],
    }


def figures(seen: Watched) -> dict[str, Any]:
    """Compute the measures of a run."""
    every = bouts(seen)
    short = [bout for bout in every if bout[2] < SHORT_S]
    calm = [bout for bout in every if bout[1] not in REACTIONS]
    both = seen.alive[1:] & seen.alive[:-1] & seen.prey
    afraid = seen.fear > seen.alarmed
    flips = ((afraid[1:] != afraid[:-1]) & both).sum()
    minutes = both.sum() * TICK_S / 60.0
    times = lasting(seen)
    return {
        "bouts": len(every),
        "short": share(sum(bout[2] < SHORT_S for bout in calm), len(calm)),
        "short_all": share(len(short), len(every)),
        "flips": round(float(flips / max(minutes, 1e-9)), 2),
        "afraid": round(float((afraid & seen.alive)[:, seen.prey].mean()), 3),
        "lasts_s": np.percentile(times, (25, 50, 75)).round(1).tolist() if times else [],
        "of": len(times),
        **attacks(seen),
    }


def share(part: int, whole: int) -> float:
    """Compute a share, 0 of nothing."""
    return round(float(part) / max(whole, 1), 3)


def main() -> None:
    """Print a line for each run, and which short bouts are most frequent."""
    seeds = range(1, 1 + (int(sys.argv[1]) if len(sys.argv) > 1 else 4))
    for name in sys.argv[2:] or NAMES:
        kinds: Counter[str] = Counter()
        for seed in seeds:
            seen = watch(name, seed)
            print(name, seed, figures(seen), flush=True)
            for was, then, length in bouts(seen):
                if length < SHORT_S:
                    kinds[f"{INTENTIONS[was]} > {INTENTIONS[then]}"] += 1
        print(name, dict(kinds.most_common(6)), flush=True)


if __name__ == "__main__":
    main()
