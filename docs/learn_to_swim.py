"""Learn to swim by CMA-ES in `subsea/Swim-v0`: `python docs/learn_to_swim.py [FOLDER]`.

The policy is open loop: each of the three muscle segments contracts left and right in turn, with a
level, an amplitude and a lag of its own, at one frequency: nine numbers. The reward is that of the
task "speed". Prints the speed beside that of the recorded fast swim and draws
FOLDER/environment-swim.png and FOLDER/environment-swimmer.jpg (default docs/pictures).
`--quick` learns briefly, for the tests.
"""

import argparse
import time
from pathlib import Path
from typing import Any, NamedTuple

import cma
import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from picture_files import BLUE, FOLDER, ORANGE, SKY, STYLE, save, save_plot
from PIL import Image

from subsea.base.arrays import Array
from subsea.base.system import resource_path
from subsea.biomechanics.body import MUSCLE_LEFT, MUSCLE_SEGMENT, MUSCLES
from subsea.biomechanics.controllers import ease
from subsea.biomechanics.solver import TICK_S
from subsea.fish.species import load_species
from subsea.lab.environments.swim import SwimEnv, SwimVectorEnv
from subsea.lab.environments.swim_bodies import ACTIONS
from subsea.repertoire.files import read_repertoire

SPECIES = "fusilier"
HERTZ = (1.0, 5.0)
START = np.array([0.5, 0.3, 0.3, 0.3, 0.5, 0.5, 0.5, 0.3, 0.6])  # of the search, in the unit box
SPREAD = 0.2
SEED = 2


class Effort(NamedTuple):
    """Size of the search; times are in ticks."""

    population: int = 32
    generations: int = 120
    start: int = 120  # not measured
    measured: int = 400  # so long that a gait that bursts the body later is found
    checks: int = 16  # starts of the winner
    check_ticks: int = 600


QUICK = Effort(6, 2, 10, 10, 2, 20)


def gaits(points: Array, ticks: int) -> Array:
    """Actions (ticks, n, 16) of policies (n, 9): frequency, lags, levels and amplitudes."""
    points = np.atleast_2d(points)
    time_s = TICK_S * np.arange(1, ticks + 1)[:, None, None]
    low, high = HERTZ
    hertz = (low + points[:, :1] * (high - low))[None]
    lag = np.pad(2 * np.pi * points[:, 1:3], ((0, 0), (1, 0)))[:, MUSCLE_SEGMENT]
    level, amplitude = (points[:, part][:, MUSCLE_SEGMENT] for part in (slice(3, 6), slice(6, 9)))
    wave = np.sin(2 * np.pi * hertz * time_s - lag) * MUSCLE_LEFT
    share = np.clip(level + amplitude * wave, 0.0, 1.0) * ease(time_s)
    actions = np.zeros((ticks, len(points), ACTIONS), np.float32)
    actions[:, :, :MUSCLES] = 2.0 * share - 1.0
    return actions


def returns(env: SwimVectorEnv, points: Array, seed: int, start: int, measured: int) -> Array:
    """Mean speeds (n,), L/s, after ``start`` ticks; -1 to 0 for a body that bursts."""
    env.reset(seed=seed)
    total = np.zeros(env.num_envs)
    lost = np.full(env.num_envs, start + measured)
    for tick, actions in enumerate(gaits(points, start + measured)):
        _, rewards, terminated, _, _ = env.step(actions)
        if tick >= start:
            total += rewards
        lost = np.where(terminated, np.minimum(lost, tick), lost)
    sound = lost == start + measured
    return np.where(sound, total / (measured * TICK_S), lost / (start + measured) - 1.0)


def learn(effort: Effort) -> tuple[Array, Array]:
    """The best policy (9,) and the history (generations, 2): best and median speed, L/s."""
    options = {
        "bounds": [0.0, 1.0], "popsize": effort.population, "seed": SEED, "verbose": -9,
        "maxiter": effort.generations,
    }  # fmt: skip
    strategy = cma.CMAEvolutionStrategy(START, SPREAD, options)
    env = SwimVectorEnv(effort.population, species=SPECIES)
    history = []
    for generation in range(effort.generations):
        points = np.array(strategy.ask())
        speeds = returns(env, points, 1000 * generation, effort.start, effort.measured)
        strategy.tell(points, -speeds)
        history.append((speeds.max(), np.median(speeds)))
    env.close()
    return np.clip(strategy.result.xfavorite, 0.0, 1.0), np.array(history)


def draw(history: Array, effort: Effort, recorded: float, path: Path) -> None:
    """Draw the speeds of all generations beside the recorded one."""
    figure = Figure(figsize=(8, 4.2), layout="constrained")
    axis = figure.subplots()
    swims = effort.population * np.arange(1, len(history) + 1)
    axis.plot(swims, history[:, 0], color=BLUE, label="best of a generation")
    axis.plot(swims, history[:, 1], color=SKY, label="median of a generation")
    axis.axhline(recorded, color=ORANGE, linestyle="--", label="recorded fast swim")
    axis.set(xlabel="episodes of 17 s", ylabel="speed, L/s", xlim=(0, swims[-1]))
    axis.set_ylim(bottom=min(0.0, float(history[:, 1].min())))
    axis.legend(loc="lower right")
    save_plot(figure, path)


def film_strip(point: Array, path: Path, pictures: int = 6) -> None:
    """Draw one beat of the learned swim, from left to right and then below."""
    env = SwimEnv(species=SPECIES, render_mode="rgb_array")
    env.reset(seed=0)
    low, high = HERTZ
    beat = 1.0 / (low + point[0] * (high - low)) / TICK_S
    warm_up = 150
    wanted = {round(warm_up + k * beat / pictures) for k in range(pictures)}
    shots: list[Any] = []
    for tick, actions in enumerate(gaits(point, max(wanted) + 1)):
        env.step(actions[0])
        if tick in wanted:
            shots.append(env.render()[40:-40])
    env.close()
    rows = [np.concatenate(shots[k : k + 3], axis=1) for k in range(0, len(shots) - 2, 3)]
    strip = Image.fromarray(np.concatenate(rows))
    save(strip.resize((960, round(960 * strip.height / strip.width))), path)


def main(arguments: list[str] | None = None) -> None:
    """Learn, check, print and draw."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("folder", type=Path, nargs="?", default=FOLDER)
    options.add_argument("--quick", action="store_true")
    given = options.parse_args(arguments)
    effort = QUICK if given.quick else Effort()
    length = load_species(SPECIES).length_cm
    swim = read_repertoire(resource_path(f"repertoires/{SPECIES}.h5")).segments["swim_fast"]
    recorded = swim.speed_cm_s / length

    began, own = time.perf_counter(), time.process_time()
    point, history = learn(effort)
    took, own = time.perf_counter() - began, time.process_time() - own
    env = SwimVectorEnv(effort.checks, species=SPECIES)
    half = effort.check_ticks // 2
    points = np.tile(point, (effort.checks, 1))
    speeds = returns(env, points, 1, half, half)
    env.close()
    low, high = HERTZ
    print(
        f"learned in {took:.0f} s, {own:.0f} s of processor time, {history.size // 2} generations"
    )
    print(f"policy: {low + point[0] * (high - low):.2f} Hz, {np.round(point, 3).tolist()}")
    print(f"speed over {half * TICK_S:.0f} s, {effort.checks} starts: "
          f"{speeds.min():.3f} to {speeds.max():.3f} L/s")  # fmt: skip
    print(f"recorded fast swim: {recorded:.3f} L/s; ratio {np.median(speeds) / recorded:.2f}")
    with rc_context(STYLE):
        draw(history, effort, recorded, given.folder / "environment-swim.png")
    film_strip(point, given.folder / "environment-swimmer.jpg")


if __name__ == "__main__":
    main()
