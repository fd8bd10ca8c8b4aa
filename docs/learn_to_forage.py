"""Learn to forage, against the mind of the same fish: `python docs/learn_to_forage.py [FOLDER]`.

Sixteen emperor angelfish of the bay in learn_to_forage.toml are steered, each by its own try of a
policy of 13 numbers, and CMA-ES learns from their meals alone. Then all follow the learned policy,
or their own minds (Tu §7.8), in the same episodes with other seeds. They are never full, or their
minds would rest. Prints meals a minute and draws FOLDER/environment-forage.png (default
docs/pictures). `--quick` runs briefly, for the tests.
"""

import argparse
import time
from pathlib import Path
from typing import NamedTuple

import cma
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from subsea.lab.environments.living_sea import NAMES, LivingSea, SeaOptions, senses
from subsea.world.world import TICK_S

Floats = NDArray[np.floating]

NEVER_FULL = 1000.0  # meals
WEIGHTS = 13
# Of the search: a fish that turns towards food ahead at half its speed.
START = np.array([3.0, -1.0, 3.0, 2.0, 0.0, 2.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0])
# Columns (3, 4) of the three nearest specks.
FOODS = np.array(
    [
        [NAMES.index(f"food {k} {part}") for part in ("ahead", "up", "right", "nearness")]
        for k in range(3)
    ]
)
PITCH, SPEED = NAMES.index("pitch"), NAMES.index("velocity ahead")
SPREAD_CM = 150.0  # of the starts
HELD_OUT = 10_000  # first of the seeds that learning does not see


class Effort(NamedTuple):
    """Sizes of the experiment."""

    generations: int = 25
    episodes: int = 2  # of a generation
    steps: int = 200  # decisions in an episode, 0.1 s each
    held_out: int = 6  # episodes


QUICK = Effort(generations=1, episodes=1, steps=5, held_out=2)


def policy(weights: Floats, sensed: Floats) -> Floats:
    """Turn, rise and speed (k, 3) for weights (k, 13) or (13,) and senses (k, m).

    Chooses among the three nearest specks, steers there and sets the pace.
    """
    w = np.broadcast_to(weights, (len(sensed), WEIGHTS)).T
    ahead, up, right, near = np.moveaxis(sensed[:, FOODS].astype(float), 2, 0)
    worth = w[0][:, None] * ahead + w[1][:, None] * np.abs(up) + w[2][:, None] * near
    share = np.exp(worth - worth.max(axis=1, keepdims=True))
    share /= share.sum(axis=1, keepdims=True)
    ahead, up, left, near = ((share * part).sum(axis=1) for part in (ahead, up, -right, near))
    aside = np.hypot(left, up)
    turn = (w[3] + w[4] * near) * left
    rise = (w[5] + w[6] * near) * up + w[7] * sensed[:, PITCH]
    pace = w[8] + w[9] * ahead + w[10] * near + w[11] * aside + w[12] * sensed[:, SPEED]
    return np.tanh(np.column_stack([turn, rise, pace]))


def make_sea() -> LivingSea:
    """The bay, with fishes that are never full."""
    sea = LivingSea(SeaOptions(str(Path(__file__).with_suffix(".toml"))))
    sea.world.state.minds.appetite[:] = NEVER_FULL
    return sea


def meals_a_minute(sea: LivingSea, seed: int, weights: Floats | None, steps: int) -> Floats:
    """Meals of each fish in an episode, by its policy or, without weights, by its own mind."""
    rng, who = np.random.default_rng(seed), np.arange(len(sea.species))
    sea.begin(rng)
    sea.scatter(who, rng, SPREAD_CM)
    sea.advance(who, np.zeros((len(who), 3)), ticks=1)
    meals = np.zeros(len(who))
    for _ in range(steps):
        actions = None if weights is None else policy(weights, senses(sea.world, who))
        meals += sea.advance(who, actions).meals
    return meals * 60.0 / (steps * sea.options.ticks * TICK_S)


def learn(sea: LivingSea, effort: Effort) -> tuple[Floats, list[float]]:
    """The mean of the last generation, and the mean meals a minute of each generation."""
    population = len(sea.species)
    settings = {"popsize": population, "seed": 1, "verbose": -9}
    search = cma.CMAEvolutionStrategy(START, 0.5, settings)
    curve = []
    for generation in range(effort.generations):
        points = np.array(search.ask())
        scores = np.zeros(population)
        for k in range(effort.episodes):
            fish = np.roll(np.arange(population), 5 * k)  # nobody keeps a good fish or place
            seed = generation * effort.episodes + k
            scores[fish] += meals_a_minute(sea, seed, points[fish], effort.steps)
        scores /= effort.episodes
        search.tell(list(points), list(-scores))
        curve.append(float(scores.mean()))
        print(f"generation {generation + 1:2d}: {curve[-1]:5.1f} meals a minute", flush=True)
    return np.asarray(search.result.xfavorite), curve


def main(arguments: list[str] | None = None) -> None:
    """Learn, compare and draw."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, default=Path(__file__).parent / "pictures")
    parser.add_argument("--quick", action="store_true", help="run briefly")
    given = parser.parse_args(arguments)
    effort = QUICK if given.quick else Effort()
    sea = make_sea()
    start = time.process_time()
    weights, curve = learn(sea, effort)
    print(f"learned in {time.process_time() - start:.0f} s of processor time")
    print(np.array2string(weights, precision=2, separator=", "))
    seeds = range(HELD_OUT, HELD_OUT + effort.held_out)
    found = {
        name: np.array([meals_a_minute(sea, seed, by, effort.steps).mean() for seed in seeds])
        for name, by in (("own mind", None), ("learned", weights))
    }
    for name, meals in found.items():
        spread = meals.std(ddof=1) / np.sqrt(len(meals))
        print(f"{name:>9}: {meals.mean():5.2f} ± {spread:.2f} meals a minute, held-out seeds")
    draw(curve, found, given.folder / "environment-forage.png")


def draw(curve: list[float], found: dict[str, Floats], path: Path) -> None:
    """The curve of learning, and the meals of each held-out episode."""
    picture = Figure(figsize=(8.4, 3.4))
    left, right = picture.subplots(1, 2, sharey=True, width_ratios=(3, 2))
    left.plot(np.arange(1, len(curve) + 1), curve, color="C0", label="mean of a generation")
    for name, colour in (("own mind", "C3"), ("learned", "C0")):
        label = f"{name}, held-out seeds"
        left.axhline(found[name].mean(), color=colour, linestyle="--", label=label)
    left.set_xlabel("generation")
    left.set_ylabel("meals a minute of a fish")
    left.legend(fontsize=8)
    right.plot(np.array([found["own mind"], found["learned"]]), color="0.7", linewidth=0.8)
    for k, (name, colour) in enumerate((("own mind", "C3"), ("learned", "C0"))):
        right.plot(np.full(len(found[name]), k), found[name], "o", color=colour)
    right.set_xticks([0, 1], ["own mind", "learned"])
    right.set_xlim(-0.5, 1.5)
    right.set_xlabel("the same episodes")
    left.set_ylim(0, None)
    picture.tight_layout()
    picture.savefig(path, dpi=100)


if __name__ == "__main__":
    main()
