"""Steps a second of `subsea/Swim-v0` beside dm_control's fish, in turn in one run.

`python benchmarks/swim_environment.py` prints the table of docs/developers/benchmarks.md.
dm_control is optional: `--dm-control PYTHON` names an interpreter that has it (default: this
one). Without it only subsea is measured.
"""

import argparse
import os
import statistics
import subprocess
import sys
import time

import gymnasium
import numpy as np

import subsea.lab.environments  # noqa: F401  registers the environments
from subsea.base.system import cores

STEPS, BODIES, VECTOR_STEPS = 1000, 1024, 8
OTHER = """
import os, sys, time, warnings
warnings.simplefilter("ignore")
os.environ.setdefault("MUJOCO_GL", "disable")
import numpy as np
from dm_control import suite
env = suite.load("fish", "swim", task_kwargs={"random": 0})
shape = env.action_spec().shape
actions = np.random.default_rng(0).uniform(-1, 1, (int(sys.argv[1]), *shape))
env.reset()
print("ready", flush=True)
for _ in sys.stdin:
    wall, own = time.perf_counter(), time.process_time()
    for action in actions:
        if env.step(action).last():
            env.reset()
    print(time.perf_counter() - wall, time.process_time() - own, flush=True)
"""


class Fish:
    """dm_control's fish, swimming in a process of its own."""

    def __init__(self, python: str) -> None:
        """Start it; ImportError without dm_control."""
        self.process = subprocess.Popen(
            [python, "-c", OTHER, str(STEPS)], text=True, env={**os.environ, "PYTHONPATH": ""},
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        if self.process.stdout.readline() != "ready\n":
            raise ImportError

    def begin(self) -> None:
        self.process.stdin.write("\n")
        self.process.stdin.flush()

    def end(self) -> tuple[float, float]:
        """Seconds by the clock and of the processor, for STEPS steps."""
        wall, own = self.process.stdout.readline().split()
        return float(wall), float(own)


def timed(work, steps):
    """Steps a second by the clock and of the processor."""
    wall, own = time.perf_counter(), time.process_time()
    work()
    return steps / (time.perf_counter() - wall), steps / (time.process_time() - own)


def main() -> int:
    """Measure and print; returns the exit code."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--rounds", type=int, default=9)
    options.add_argument("--dm-control", metavar="PYTHON", default=sys.executable)
    given = options.parse_args()
    try:
        fishes = [Fish(given.dm_control) for _ in range(cores())]
    except (ImportError, OSError):
        fishes = []
        print(f"dm_control is not installed for {given.dm_control}: measuring subsea only")

    env = gymnasium.make("subsea/Swim-v0")
    many = gymnasium.make_vec("subsea/Swim-v0", BODIES, vectorization_mode="vector_entry_point")
    draw = np.random.default_rng(0)
    actions = draw.uniform(-1, 1, (STEPS, 16)).astype(np.float32)
    batches = draw.uniform(-1, 1, (VECTOR_STEPS, BODIES, 16)).astype(np.float32)

    def one_body():
        for action in actions:
            _, _, terminated, truncated, _ = env.step(action)
            if terminated or truncated:
                env.reset()

    def many_bodies():
        for batch in batches:
            many.step(batch)

    env.reset(seed=0)
    many.reset(seed=0)
    one_body()
    many_bodies()
    found = {name: [] for name in ("one", "fish", "many", "fishes")}
    for _ in range(given.rounds):
        found["one"].append(timed(one_body, STEPS))
        if fishes:
            fishes[0].begin()
            found["fish"].append(tuple(STEPS / took for took in fishes[0].end()))
        found["many"].append(timed(many_bodies, BODIES * VECTOR_STEPS))
        if fishes:
            for fish in fishes:
                fish.begin()
            took = [fish.end() for fish in fishes]
            total = len(fishes) * STEPS
            found["fishes"].append(
                (total / max(wall for wall, _ in took), total / sum(own for _, own in took))
            )
    many.close()
    for fish in fishes:
        fish.process.stdin.close()
        fish.process.wait()

    names = {
        "one": "subsea, one body, `gymnasium.make`",
        "fish": "dm_control fish-swim, one environment",
        "many": f"subsea, {BODIES} bodies, {cores()} threads",
        "fishes": f"dm_control fish-swim, {cores()} processes",
    }
    print("| environment | steps/s by the clock | steps per second of processor time |")
    print("| --- | --- | --- |")
    for key, rates in found.items():
        if rates:
            wall, own = (statistics.median(column) for column in zip(*rates, strict=True))
            print(f"| {names[key]} | {wall:,.0f} | {own:,.0f} |")
    for ours, theirs, what in (
        ("one", "fish", "one body, one core"),
        ("many", "fishes", "whole machine"),
        ("many", "fish", "vectorised, over one environment of dm_control"),
    ):
        if found[theirs]:
            ratios = [
                [mine / other for mine, other in zip(a, b, strict=True)]
                for a, b in zip(found[ours], found[theirs], strict=True)
            ]
            wall, own = (statistics.median(column) for column in zip(*ratios, strict=True))
            print(f"{what}: {wall:.1f} × by the clock, {own:.1f} × by processor time")
    return 0


if __name__ == "__main__":
    sys.exit(main())
