"""Make the pictures of courtship: `python docs/make_behavior_pictures.py [FOLDER]`.

courtship.jpg: moments of the scenario `mating`, in close-up. courtship_seeds.png: states of its
males over time with ten seeds; counts the seeds with the whole sequence of Tu's film (§10.5).
"""

from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib import rc_context
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray
from picture_files import STYLE, output_folder, save, save_plot
from PIL import Image, ImageDraw

from subsea.dive.start import headless, picture_maker
from subsea.frame.packet import pack
from subsea.geometry.rotation import matrix
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.renderer import Renderer
from subsea.scenario.load import load_scenario
from subsea.state import ASCENDING, CIRCLING, COURTSHIP, LOOPING, NO_COURTSHIP, NUZZLING, SPAWNING
from subsea.submarine.vessel import NEUTRAL
from subsea.view.camera import NEAR_CM, View, look, off_axis
from subsea.view.display_rigs import display_rig
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S, World

Array = NDArray[np.floating[Any]]

CELL = (400, 270)  # pixels of one moment
BESIDE = 3  # moments in a row
HALF_FIELD = 0.25  # tangent of half the horizontal angle of view
NEARNESS = 0.8  # how much of its picture a moment fills
LIMIT_S = 150.0
# By index of the scenario's fishes.
FEMALE, LARGE, SMALL, BUTTERFLY, ANGEL, HIS_MATE = range(6)


def courtship_plate() -> Image.Image:
    """Six moments in order of time, with captions."""
    world = create_world(load_scenario("mating")[0])
    moments = [
        ("Two males loop before her", (FEMALE, LARGE, SMALL), _rivalry, 25.0, 18.0),
        ("The smaller turns to another", (SMALL, BUTTERFLY), _flirt, 60.0, 5.0),
        ("Circling", (FEMALE, LARGE), _lasting(LARGE, CIRCLING, 5.0), 60.0, 22.0),
        ("Spawning ascent", (FEMALE, LARGE), _lasting(LARGE, ASCENDING, 3.0), 75.0, 0.0),
        ("Nuzzling", (FEMALE, LARGE), _lasting(LARGE, NUZZLING, None), 75.0, 0.0),
        ("Spawning rush", (HIS_MATE, ANGEL), _lasting(ANGEL, SPAWNING, 0.9), 60.0, 10.0),
    ]
    rows = -(-len(moments) // BESIDE)
    plate = Image.new("RGB", (CELL[0] * BESIDE, CELL[1] * rows))
    pictures: dict[str, Image.Image] = {}
    with (
        headless() as context,
        picture_maker(context, world, display_rig("mono", CELL), PRESETS["high"]) as renderer,
    ):
        for _ in range(int(LIMIT_S / TICK_S)):
            step(world, NEUTRAL)
            for title, who, comes, *look_from in moments:
                if title not in pictures and comes(world):
                    pictures[title] = _moment(renderer, world, who, title, *look_from)
            if len(pictures) == len(moments):
                break
    for k, picture in enumerate(pictures.values()):
        plate.paste(picture, (k % BESIDE * CELL[0], k // BESIDE * CELL[1]))
    return plate


def seeds_plate(seeds: Sequence[int]) -> Figure:
    """The states of the three males with each seed, and how often the film played."""
    figure, axes = plt.subplots(1, 3, figsize=(11, 3.2), sharey=True, layout="constrained")
    colours = ListedColormap(
        ["0.93", *plt.get_cmap("viridis")(np.linspace(0.15, 0.95, len(COURTSHIP) - 1))]
    )
    names = {LARGE: "larger male", SMALL: "smaller male", ANGEL: "angelfish"}
    courted = np.array([_courted(seed) for seed in seeds])
    for axis, (fish, name) in zip(axes, names.items(), strict=True):
        axis.imshow(
            courted[:, :, fish], cmap=colours, vmin=0, vmax=len(COURTSHIP) - 1, aspect="auto",
            interpolation="nearest", extent=(0, LIMIT_S, len(seeds), 0),
        )  # fmt: skip
        axis.set(
            title=name, xlabel="time, s", yticks=np.arange(len(seeds)) + 0.5, yticklabels=seeds
        )
    axes[0].set_ylabel("seed")
    handles = [Patch(color=colours(k), label=name) for k, name in enumerate(COURTSHIP)]
    figure.legend(handles=handles, loc="outside right center")
    whole = [all(_completes(one[:, fish]) for fish in (LARGE, ANGEL)) for one in courted]
    print(
        f"larger male and angelfish from approach to spawning: {sum(whole)} of {len(seeds)} seeds"
    )
    left = [_is_turned_down(one[:, SMALL]) for one in courted]
    print(f"smaller male turned down: {sum(left)} of {len(seeds)} seeds")
    return figure


def _courted(seed: int) -> Array:
    """States of courtship (T, n) over the scenario's time."""
    world = create_world(load_scenario("mating")[0], seed)
    rows = []
    for _ in range(int(LIMIT_S / TICK_S)):
        step(world, NEUTRAL)
        rows.append(world.state.minds.courtship.copy())
    return np.array(rows)


def _completes(states: Array) -> bool:
    """True if a fish went through all states in order."""
    changes = states[np.flatnonzero(np.diff(states, append=255))]
    return " ".join(map(str, range(1, len(COURTSHIP)))) + " 0" in " ".join(map(str, changes))


def _is_turned_down(states: Array) -> bool:
    """True if a fish was rejected by the first one that he courted."""
    changes = list(states[np.flatnonzero(np.diff(states, append=255))])
    return LOOPING in changes and changes[changes.index(LOOPING) + 1] < LOOPING


def _rivalry(world: World) -> bool:
    minds = world.state.minds
    both = minds.courtship[LARGE] == minds.courtship[SMALL] == LOOPING
    return bool(both and minds.courtship_count[LARGE] >= 1)


def _flirt(world: World) -> bool:
    minds = world.state.minds
    loops = minds.partner[SMALL] == BUTTERFLY and minds.courtship[SMALL] == LOOPING
    return bool(loops and minds.courtship_count[SMALL] >= 1)


def _lasting(fish: int, state: int, seconds: float | None) -> Any:
    """When a fish has been in a state for this long; with None, when it has nudged."""

    def comes(world: World) -> bool:
        minds = world.state.minds
        if minds.courtship[fish] == NO_COURTSHIP or minds.courtship[fish] != state:
            return False
        if seconds is None:
            return bool(minds.courtship_count[[fish, minds.partner[fish]]].max() >= 1)
        return bool(minds.courtship_time[fish] > seconds)

    return comes


def _moment(
    renderer: Renderer, world: World, who: tuple[int, ...], title: str, aside: float, above: float
) -> Image.Image:
    """A close-up of fishes.

    The camera is `aside` degrees from the heading of the first one, on the side of the submarine,
    and `above` degrees above the horizon.
    """
    places = world.state.fishes.position[list(who)].astype(np.float64)
    lengths = world.state.fishes.length[list(who)]
    middle = (places.min(axis=0) + places.max(axis=0)) / 2
    extent = np.linalg.norm(places - middle, axis=1).max() + 0.8 * lengths.max()
    x, y, _ = matrix(world.state.fishes.orientation[who[0]].astype(np.float64))[:, 0]
    toward = world.state.submarine.position - middle
    side = np.copysign(1.0, x * toward[1] - y * toward[0])
    course, height = np.arctan2(y, x) + side * np.radians(aside), np.radians(above)
    level = np.cos(height)
    away = np.array([level * np.cos(course), level * np.sin(course), np.sin(height)])
    eye = middle + NEARNESS * extent / HALF_FIELD * CELL[0] / CELL[1] * away
    half = NEAR_CM * HALF_FIELD * np.array([1.0, CELL[1] / CELL[0]])
    projection = off_axis(-half[0], half[0], -half[1], half[1])
    up = np.array([0.0, 0.0, 1.0])
    view = View((0, 0, *CELL), look(eye, middle - eye, up), projection, eye)
    renderer.draw(pack(world, (view,), 1.0))
    picture = Image.fromarray(renderer.read_pixels())
    time = world.state.tick * TICK_S
    ImageDraw.Draw(picture).text((10, 8), f"{title}, {time:.0f} s", fill="white", font_size=18)
    return picture


if __name__ == "__main__":
    folder = output_folder()
    save(courtship_plate(), folder / "courtship.jpg")
    with rc_context(STYLE):
        save_plot(seeds_plate(range(1, 11)), folder / "courtship_seeds.png")
