"""Make film strips of how each species moves: `python docs/film_gaits.py FOLDER [SPECIES ...]`.

gaits_SPECIES.jpg: a fish alone that swims slowly, cruises, turns at both speeds, starts, stops and
hovers, each in twelve pictures from the side, from above and from the front.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from picture_files import output_folder, save
from PIL import Image, ImageDraw

import subsea
from subsea.base.arrays import Ints
from subsea.fish.paint import paint
from subsea.fish.species import shipped_species
from subsea.geometry.rotation import quaternion, x_axis
from subsea.motor.controller import command
from subsea.motor.fins import flap
from subsea.motor.playback import play
from subsea.rendering.fish.preview import FishPreview, Orbit
from subsea.rendering.gl.context import headless_context
from subsea.state import Clock
from subsea.view.retina import control_points_at
from subsea.world.world import TICK_S

Array = NDArray[np.floating[Any]]

CELL = (220, 150)  # pixels of one picture
FRAMES = 12
CAPTION = 14  # pixels
CAMERAS = {  # of a fish that heads left
    "side": Orbit(0.1, 0.05),
    "above": Orbit(0.0, 1.5),
    "front": Orbit(1.2, 0.1, 1.4),
}
SCENARIO = """title = "One fish"
seed = 1
[bounds]
radius_cm = 2000.0
depth_cm = 1200.0
[water]
type = "IB"
hour = 12.0
plankton = 0
[terrain]
dune_height_cm = 10.0
dune_length_cm = 700.0
seed = 5
[submarine]
position_cm = [-1000.0, -1000.0, -300.0]
heading_deg = 0.0
[[fish]]
species = "{species}"
number = 1
position_cm = [0.0, 0.0, -300.0]
"""


class Action(NamedTuple):
    """An action: the goal before and in it, and how it is shown."""

    name: str
    before: float  # speed, over the fast swim's
    speed: float
    turn: float = 0.0  # degrees to the left
    every: int = 1  # ticks from picture to picture


ACTIONS = (
    Action("slow", 0.25, 0.25, every=3),
    Action("cruise", 0.65, 0.65, every=3),
    Action("slow turn", 0.25, 0.25, 60.0, every=3),
    Action("turn at cruise", 0.65, 0.65, 60.0, every=2),
    Action("start", 0.0, 0.7, every=2),
    Action("stop", 0.7, 0.0, every=3),
    Action("hover", 0.0, 0.0, every=2),
)


def main() -> None:
    """Write a plate of each species, or of those that are named after the folder."""
    for species in sys.argv[2:] or shipped_species():
        save(plate(species), output_folder() / f"gaits_{species}.jpg")


def plate(species: str) -> Image.Image:
    """Draw all actions of a species, a row for each camera."""
    wide, high = CELL
    rows = len(ACTIONS) * len(CAMERAS)
    picture = Image.new("RGB", (wide * FRAMES, high * rows + CAPTION * len(ACTIONS)), "white")
    draw, top = ImageDraw.Draw(picture), 0
    for action in ACTIONS:
        rate = f"a picture every {1000 * action.every * TICK_S:.0f} ms"
        draw.text((4, top + 1), f"{species}: {action.name}; {rate}", fill="black")
        top += CAPTION
        for n, frames in enumerate(filmed(species, action)):
            for k, frame in enumerate(frames):
                picture.paste(frame, (n * wide, top + k * high))
        top += high * len(CAMERAS)
    return picture


def filmed(species: str, action: Action) -> list[list[Image.Image]]:
    """Draw the pictures of an action from all cameras."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "one.toml"
        path.write_text(SCENARIO.format(species=species), encoding="utf-8")
        world = subsea.load(str(path))
    kind, course = world.internal.species[0], heading(world)
    everyone = np.zeros(1, np.int64)
    advance(world, everyone, action.before, course, 90)
    goal = course + np.radians(action.turn)
    frames = []
    with headless_context() as context:
        fish = FishPreview(context, kind, paint(kind))
        for _ in range(FRAMES):
            turned = heading(world) - course
            frames.append([seen(world, fish, at.moved(turned, 0.0)) for at in CAMERAS.values()])
            advance(world, everyone, action.speed, goal, action.every)
        fish.release()
    return frames


def heading(world: subsea.World) -> float:
    """Return the heading of the fish, rad from the x axis to the left."""
    ahead = x_axis(quaternion(world.fishes.orientation[0]))
    return float(np.arctan2(ahead[1], ahead[0]))


def advance(world: subsea.World, who: Ints, speed: float, goal: float, ticks: int) -> None:
    """Let the fish swim toward a heading, rad, by its controller alone."""
    inner = world.internal  # moves by its body alone, without a mind
    fishes, library = inner.state.fishes, inner.library
    for _ in range(ticks):
        fishes.goal_direction[:] = np.cos(goal), np.sin(goal), 0.0
        fishes.goal_speed[:] = speed
        clock = Clock(1, inner.state.tick, TICK_S)
        command(who, fishes, library, clock)
        play(who, fishes, library, TICK_S)
        flap(who, fishes, library, TICK_S)
        inner.state.tick += 1


def seen(world: subsea.World, fish: FishPreview, orbit: Orbit) -> Image.Image:
    """Draw the pose of the fish, in the middle of the picture, from an orbit about its body."""
    points = control_points_at(world.internal, 0, 1.0)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    points[:, ::2] += (fish.middle - middle)[::2]
    fish.draw(points, orbit, CELL, tuple(world.fishes.fins[0]))
    return Image.fromarray(fish.read_pixels())


if __name__ == "__main__":
    main()
