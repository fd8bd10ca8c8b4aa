"""Make the pictures of behavior.md: `python docs/make_hunting_pictures.py [FOLDER] [NAME]`.

capture.jpg: a reef shark sucks in a prey, moment by moment.
scatter.png: the paths of a school, seen from above, before and after the shark comes near.
hook.jpg: the bait, the bite, the way up.
"""

import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from numpy.typing import NDArray
from picture_files import STYLE, output_folder, save, save_plot
from PIL import Image

from subsea.behavior.chasing import mouth_of
from subsea.frame.packet import make_scene, pack
from subsea.geometry.rotation import x_axis
from subsea.rendering.gl.context import headless_context
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.renderer import Renderer
from subsea.scenario.load import load_scenario
from subsea.state import ESCAPE, HOOKED, PREDATOR, PREY
from subsea.submarine.vessel import NEUTRAL
from subsea.view.display_rigs import display_rig, views_for
from subsea.view.rig import CameraPose
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S, World

Array = NDArray[np.floating[Any]]

CELL = (400, 260)  # pixels of one moment
SHOWN_CM = 700.0  # farther away the shark is not drawn in the chart
LONGEST = 3000  # ticks in which something must have happened
HUNT_SEED, HOOK_SEED = 1, 5


def run(scenario: str, seed: int) -> Iterator[World]:
    """The world after each tick."""
    world = create_world(load_scenario(scenario)[0], seed=seed)
    for _ in range(LONGEST):
        step(world, NEUTRAL)
        yield world


def shot(renderer: Renderer, world: World, eye: Array, at: Array) -> Image.Image:
    """Draw the view from `eye` to `at`, cm."""
    forward = (at - eye) / np.linalg.norm(at - eye)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    up = np.cross(right / np.linalg.norm(right), forward)
    renderer.draw(pack(world, views_for("mono", CELL, CameraPose(eye, forward, up)), 1.0))
    return Image.fromarray(renderer.read_pixels())


def strip(
    scenario: str,
    seed: int,
    moments: dict[int, Callable[[World], tuple[Array, Array]]],
    beside: int,
) -> Image.Image:
    """Pictures at the given ticks, each with its eye and target."""
    pictures: list[Image.Image] = []
    with headless_context() as context:
        renderer = None
        for world in run(scenario, seed):
            renderer = renderer or Renderer(
                context, make_scene(world), display_rig("mono", CELL), PRESETS["high"]
            )
            if world.state.tick in moments:
                pictures.append(shot(renderer, world, *moments[world.state.tick](world)))
            if world.state.tick >= max(moments):
                break
        if renderer:
            renderer.release()
    rows = -(-len(pictures) // beside)
    sheet = Image.new("RGB", (CELL[0] * beside, CELL[1] * rows))
    for k, picture in enumerate(pictures):
        sheet.paste(picture, (k % beside * CELL[0], k // beside * CELL[1]))
    return sheet


def capture() -> Image.Image:
    """The last second before fish 0, the hunter, swallows its first prey."""
    caught = next(w.state.tick for w in run("preying", HUNT_SEED) if not w.state.fishes.alive.all())

    def beside(world: World) -> tuple[Array, Array]:
        fishes = world.state.fishes
        mouth = np.array(mouth_of(fishes, 0))
        ahead = np.array(x_axis(fishes.orientation[0]))
        right = np.cross(ahead, (0.0, 0.0, 1.0))
        middle = mouth - 2.0 * ahead
        return middle + 34.0 * ahead + 44.0 * right - (0.0, 0.0, 4.0), middle

    return strip("preying", HUNT_SEED, {caught - ago: beside for ago in (14, 8, 5, 3, 1, -5)}, 3)


def hook() -> Image.Image:
    """Hungry fishes around the bait, the bite, and the catch on its way up."""
    bitten = next(w.state.tick for w in run("go-fish", HOOK_SEED) if w.state.sea.catch[0] == HOOKED)

    def near(*eye: float) -> Callable[[World], tuple[Array, Array]]:
        def look(world: World) -> tuple[Array, Array]:
            place = world.state.sea.hook.copy()
            return place + np.array(eye), place

        return look

    return strip("go-fish", HOOK_SEED, {
        bitten - 6: near(-40.0, -50.0, 4.0), bitten + 14: near(-24.0, -30.0, 2.0),
        bitten + 90: near(-26.0, -32.0, -2.0), bitten + 135: near(-28.0, -35.0, -14.0),
    }, 2)  # fmt: skip


def scatter() -> Figure:
    """Paths and size of a school while most of it flees, and afterwards."""
    paths, fled, alive = [], [], []
    for world in run("preying", HUNT_SEED):
        fishes, minds = world.state.fishes, world.state.minds
        school = np.flatnonzero((minds.kind == PREY) & minds.schools)
        hunter = np.flatnonzero(minds.kind == PREDATOR)[:1]
        paths.append(fishes.position[np.concatenate([hunter, school])].copy())
        fled.append((minds.intention[school] == ESCAPE).sum())
        alive.append(fishes.alive[school].copy())
    places, living, fleeing = np.array(paths), np.array(alive), np.array(fled)
    window = round(4.0 / TICK_S)
    worst = int(np.convolve(fleeing, np.ones(window), "same").argmax())
    figure = Figure(figsize=(9.6, 4.0), layout="constrained")
    axes = figure.subplots(1, 3, width_ratios=(1, 1, 1.1))
    spans = ((worst - window, worst + window // 2), (worst + window // 2, worst + 7 * window))
    for ax, (first, last), title in zip(axes, spans, ("it comes near", "and after"), strict=False):
        first = max(first, 0)
        track = places[first:last]
        ax.plot(*track[:, 0, :2].T, color="black", lw=2.5, label="shark")
        ax.plot(*track[-1, 0, :2], "o", color="black")
        for k in range(1, track.shape[1]):
            seen = living[first:last, k - 1]
            ax.plot(*track[seen, k, :2].T, color="#c8401e", lw=1.2)
            if seen.any():
                ax.plot(*track[seen, k, :2][-1], "o", color="#c8401e", ms=4)
        ax.set_aspect("equal", "datalim")
        ax.set_title(f"{title}: {first * TICK_S:.0f} to {last * TICK_S:.0f} s")
        ax.set_xlabel("x, cm")
    axes[0].set_ylabel("y, cm")
    radius = [
        np.linalg.norm(row[1:][left] - np.median(row[1:][left], axis=0), axis=1).mean()
        for row, left in zip(places, living, strict=True)
    ]
    gap = np.linalg.norm(places[:, 1:] - places[:, :1], axis=2)
    gap[~living] = np.inf
    time = TICK_S * np.arange(len(places))
    nearest = np.where(gap.min(axis=1) < SHOWN_CM, gap.min(axis=1), np.nan)
    axes[2].plot(time, radius, color="#c8401e", label="of the school's fishes from its middle")
    axes[2].plot(time, nearest, color="black", label="of the shark from the nearest")
    axes[2].set_ylim(0, 1.3 * SHOWN_CM)
    axes[2].set_xlabel("time, s")
    axes[2].set_ylabel("distance, cm")
    axes[2].legend(loc="upper left")
    return figure


def main() -> None:
    """Make all pictures or the named one."""
    folder = output_folder()
    pictures = {"capture": capture, "hook": hook, "scatter": scatter}
    for name, make in pictures.items():
        if len(sys.argv) > 2 and name not in sys.argv[2:]:
            continue
        with rc_context(STYLE):
            made = make()
            if isinstance(made, Figure):
                save_plot(made, folder / f"{name}.png")
            else:
                save(made, folder / f"{name}.jpg")


if __name__ == "__main__":
    main()
