"""Measure the scene for docs/developers/behavior-figures.md.

`python docs/rendezvous_figures.py [SEEDS] [SCENARIO]`

Runs the first minute of the scenario `rendezvous` with SEEDS (10) seeds from 0, and prints when all
parts of its scene were in the picture of its camera at the same time.
"""

import sys
from typing import Any, NamedTuple

import numpy as np

from subsea.dive.directed_camera import directed_steering
from subsea.scenario.load import load_scenario
from subsea.state import CHEWING, EAT, LOOPING, MATE, RECOVERING
from subsea.view.display_rigs import VERTICAL_FOV, cockpit
from subsea.view.rig import CameraPose
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S, World

PAIR, SCHOOL, SHARK = slice(0, 2), slice(2, 38), 38  # the numbers of the scenario's fishes
ASPECT = 16 / 9
FRONT_CM = 250.0  # distance from the camera within which the pair is in front
BEHIND_CM = 100.0  # how much farther away the school is
MOST = 0.5  # share of the living school in view
LEAST_S = 3.0  # shortest time without a break
SECONDS = 60.0
PARTS = ("pair", "school", "shark")


class Seen(NamedTuple):
    """Which parts of the scene are present in a tick."""

    pair: bool  # it courts, in front of the camera and in view
    school: bool  # it is in view behind the pair
    shark: bool  # it hunts one of the school, chews it or circles out after a miss, in view


def seen(world: World) -> Seen:
    """Observe the current tick."""
    fishes, minds = world.state.fishes, world.state.minds
    camera = cockpit(world.state.submarine, 1.0)
    far = np.linalg.norm(fishes.position - camera.eye, axis=1)
    inside = in_view(fishes.position, camera)
    courts = (minds.courtship[PAIR] >= LOOPING) & (minds.intention[PAIR] == MATE)
    school = fishes.alive[SCHOOL]
    behind = inside[SCHOOL] & (far[SCHOOL] > far[PAIR].max() + BEHIND_CM) & school
    prey = minds.target[SHARK]
    hunts = SCHOOL.start <= prey < SCHOOL.stop and minds.intention[SHARK] == EAT
    hunts |= minds.hunt[SHARK] in (CHEWING, RECOVERING)
    return Seen(
        bool(courts.all() and inside[PAIR].all() and far[PAIR].max() < FRONT_CM),
        bool(behind.sum() >= max(MOST * school.sum(), 1)),
        bool(hunts and inside[SHARK]),
    )


def in_view(places: Any, camera: CameraPose) -> Any:
    """Which points (n, 3) are in the picture."""
    right = np.cross(camera.forward, camera.up)
    x, y, z = ((places - camera.eye) @ axis for axis in (right, camera.up, camera.forward))
    tall = z * np.tan(VERTICAL_FOV / 2)
    return (z > 0.0) & (abs(y) < tall) & (abs(x) < ASPECT * tall)


def rendezvous(seed: int, name: str = "rendezvous", enough: bool = False) -> dict[str, Any]:
    """Start and duration of each part and of all together, s, up to `enough`."""
    world = create_world(load_scenario(name)[0], seed=seed)
    steer, moments = directed_steering(world), []
    least = round(LEAST_S / TICK_S) + 1
    for _ in range(round(SECONDS / TICK_S)):
        step(world, steer(world))
        moments.append(seen(world))
        if enough and np.all(moments[-least:]) and len(moments) >= least:
            break
    so = np.array(moments)
    both = so.all(axis=1)
    runs = np.split(np.arange(len(both)), np.flatnonzero(np.diff(both)) + 1)
    longest = max((run for run in runs if both[run[0]]), key=len, default=np.arange(0))
    return {
        **{part: round(float(so[:, k].sum()) * TICK_S, 1) for k, part in enumerate(PARTS)},
        "together": round(float(both.sum()) * TICK_S, 1),
        "longest": round(len(longest) * TICK_S, 1),
        "from": round(float(longest[0]) * TICK_S, 1) if len(longest) else None,
        "eaten": int((~world.state.fishes.alive).sum()),
        "so": bool(len(longest) * TICK_S >= LEAST_S),
    }


def main() -> None:
    """Print a line for each seed, and the number of successes."""
    number = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    name = sys.argv[2] if len(sys.argv) > 2 else "rendezvous"
    rows = []
    for seed in range(number):
        rows.append(rendezvous(seed, name))
        print(seed, rows[-1], flush=True)
    print(f"{sum(row['so'] for row in rows)} of {number}")


if __name__ == "__main__":
    main()
