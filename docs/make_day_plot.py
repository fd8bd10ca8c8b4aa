"""Draw docs/pictures/day.png: how the fishes of the bay spend a whole day, by species and hour.

`python docs/make_day_plot.py [FOLDER [SEED]]` runs `peaceful` for a day of 24 minutes, and prints
shares of the day's light and of the night.
"""

import sys

import matplotlib.pyplot as plt
import msgspec
import numpy as np
from picture_files import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PINK,
    SKY,
    STYLE,
    output_folder,
    save_plot,
)

from subsea.base.arrays import Array
from subsea.behavior.table import INTENTIONS
from subsea.scenario.load import load_scenario
from subsea.submarine.vessel import NEUTRAL
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S, World

DAY_MINUTES = 24.0
STEPS = 48  # of half an hour
DAY, NIGHT = (7.0, 16.0), (20.0, 4.5)  # hours of the printed shares
DOINGS: dict[str, tuple[str, tuple[str, ...]]] = {
    "feed": (GREEN, ("eat", "graze", "pick")),
    "school": (BLUE, ("school",)),
    "court": (PINK, ("mate",)),
    "clean, be cleaned": (ORANGE, ("clean", "pose")),
    "guard, give way": (BLACK, ("guard", "yield")),
    "bathe, in cover": (GREY, ("bathe", "shelter")),
    "avoid, escape": ("#f0e442", ("avoid", "escape")),
    "swim about, watch": (SKY, ()),
}


def whole_day(seed: int) -> tuple[World, Array]:
    """Run the bay for a day. Returns the counts of fish-ticks (STEPS, species, doings)."""
    scenario = load_scenario("peaceful")[0]
    water = msgspec.structs.replace(scenario.water, hour=0.0, day_minutes=DAY_MINUTES)
    world = create_world(msgspec.structs.replace(scenario, water=water), seed=seed)
    fishes, minds = world.state.fishes, world.state.minds
    doing = np.full(len(INTENTIONS), len(DOINGS) - 1)
    for k, (_, names) in enumerate(DOINGS.values()):
        doing[[INTENTIONS.index(name) for name in names]] = k
    count = np.zeros((STEPS, len(world.species), len(DOINGS)))
    ticks = round(60.0 * DAY_MINUTES / TICK_S)
    for tick in range(ticks):
        step(world, NEUTRAL)
        alive = fishes.alive
        now = tick * STEPS // ticks
        np.add.at(count[now], (fishes.species[alive], doing[minds.intention[alive]]), 1.0)
    return world, count


def share_within(count: Array, first: float, end: float) -> Array:
    """Shares of doings (species, doings) from an hour to another, also over midnight."""
    hour = (np.arange(STEPS) + 0.5) * 24.0 / STEPS
    chosen = (hour >= first) & (hour < end) if first < end else (hour >= first) | (hour < end)
    total = count[chosen].sum(axis=0)
    return np.asarray(total / np.maximum(total.sum(axis=1, keepdims=True), 1.0))


def main() -> None:
    """Run, print and draw."""
    folder = output_folder()
    world, count = whole_day(int(sys.argv[2]) if len(sys.argv) > 2 else 1)
    print("| species | hours |", " | ".join(DOINGS), "|")
    for first, end in (DAY, NIGHT):
        for one, shares in zip(world.species, share_within(count, first, end), strict=True):
            cells = " | ".join(f"{share:.1%}" for share in shares)
            print(f"| {one.name} | {first:g} to {end:g} | {cells} |")
    plt.rcParams.update(STYLE)
    rows = -(-len(world.species) // 3)
    figure, axes = plt.subplots(
        rows, 3, figsize=(9, 0.5 + 1.7 * rows), sharex=True, sharey=True, layout="constrained"
    )
    hour = (np.arange(STEPS) + 0.5) * 24.0 / STEPS
    for axis in axes.flat[len(world.species) :]:
        axis.set_visible(False)
    for axis, one, each in zip(axes.flat, world.species, count.swapaxes(0, 1), strict=False):
        share = each / np.maximum(each.sum(axis=1, keepdims=True), 1.0)
        colours = [colour for colour, _ in DOINGS.values()]
        axis.stackplot(hour, share.T, colors=colours, labels=list(DOINGS), step="mid")
        axis.set(title=one.name, xlim=(0, 24), ylim=(0, 1), xticks=range(0, 25, 6))
        axis.yaxis.set_major_formatter("{x:.0%}")
    figure.supxlabel("hour", fontsize=10)
    figure.legend(*axes.flat[0].get_legend_handles_labels(), loc="outside upper center", ncols=4)
    save_plot(figure, folder / "day.png")


if __name__ == "__main__":
    main()
