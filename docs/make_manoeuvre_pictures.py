"""Make film strips of what fishes do: `python docs/make_manoeuvre_pictures.py [FOLDER]`.

manoeuvres.jpg: a C-start from below, a strike from the side, a wrasse that rows, a ray that banks.
life.jpg: grazing, cleaning, a display, the rush of spawning, a clownfish in its anemone, and night.
The camera stands still in the C-start and keeps beside the fish in the others.
"""

from collections import Counter, deque
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from picture_files import output_folder, save
from PIL import Image, ImageDraw

import subsea
from subsea.behavior.table import INTENTIONS
from subsea.geometry.rotation import matrix
from subsea.motor.playback import CSTARTS, ROW
from subsea.state import SPAWNING
from subsea.world.world import TICK_S

Array = NDArray[np.floating[Any]]

CELL = (200, 150)  # pixels of one picture
LIMIT_S = 240.0
CAPTION = 16  # pixels
OPEN_CM, APART_CM = 12.0, 60.0  # around a fish, without another, and without a shark


class Strip(NamedTuple):
    """A manoeuvre and how to look at it."""

    title: str
    scenario: str
    seed: int
    begins: Callable[[subsea.World], int | None]  # the fish that does it now, if any
    before: int  # ticks before that at which the strip begins
    every: int  # ticks from picture to picture
    place: tuple[float, float, float]  # of the camera: ahead, left and up of the fish, lengths
    follows: bool
    hour: float | None = None  # instead of the scenario's


def main() -> None:
    """Write the plates."""
    folder = output_folder()
    save(plate(manoeuvres(), 8), folder / "manoeuvres.jpg")
    save(plate(life(), 6), folder / "life.jpg")


def manoeuvres() -> list[Strip]:
    """Strips of how fishes move."""
    return [
        Strip("C-start of a fusilier, from below", "preying", 5, _starts, 1, 1,
              (-0.1, 0.0, -2.4), False),
        Strip("Strike of a blacktip reef shark", "visitors", 1, _strikes, 24, 4,
              (0.4, 1.0, 0.25), True),
        Strip("A moon wrasse rows with its pectoral fins", "peaceful", 1, _rows, 0, 1,
              (0.5, 0.9, 0.4), True),
        Strip("A spotted eagle ray banks into a turn", "visitors", 1, _banks, 40, 10,
              (-0.9, 0.0, 0.3), True),
    ]  # fmt: skip


def life() -> list[Strip]:
    """Strips of what fishes do on stone and with each other."""
    return [
        Strip("A blue tang grazes", "peaceful", 1, _does("graze", "Blue tang", 1.0), 0, 12,
              (0.6, 1.3, 0.4), True),
        Strip("A cleaner and its client", "visitors", 1, _cleans, 0, 12,
              (0.5, 5.0, 1.0), True),
        Strip("A display before a bite", "peaceful", 2, _does("guard", None, 0.6), 0, 12,
              (-1.5, 2.5, 0.9), True),
        Strip("The rush of spawning", "mating", 1, _spawns, 0, 6,
              (-0.5, 3.4, 0.3), True),
        Strip("A clownfish bathes in its anemone", "peaceful", 1, _does("bathe", None, 8.0), 0, 16,
              (0.4, 3.2, 1.2), True),
        Strip("In a shelter at night", "peaceful", 1, _does("shelter", None, 20.0), 0, 30,
              (1.0, 2.6, 0.6), False, 20.5),
    ]  # fmt: skip


def plate(strips: list[Strip], frames: int) -> Image.Image:
    """Draw strips of `frames` pictures below each other, with captions."""
    wide, high = CELL
    sheet = Image.new("RGB", (wide * frames, (high + CAPTION) * len(strips)), "white")
    draw = ImageDraw.Draw(sheet)
    for k, strip in enumerate(strips):
        top = k * (high + CAPTION)
        rate = f"a picture every {1000 * strip.every * TICK_S:.0f} ms"
        draw.text((4, top + 2), f"{strip.title}; {rate}", fill="black")
        for n, picture in enumerate(pictures(strip, frames)):
            sheet.paste(picture, (n * wide, top + CAPTION))
    return sheet


def pictures(strip: Strip, frames: int) -> list[Image.Image]:
    """The pictures of a strip, from shortly before the manoeuvre begins."""
    changes = {} if strip.hour is None else {"water.hour": strip.hour}
    world = subsea.load(strip.scenario, seed=strip.seed, changes=changes)
    past: deque[bytes] = deque(maxlen=strip.before + 1)
    while world.time_s < LIMIT_S:
        world.step()
        past.append(world.snapshot())
        fish = strip.begins(world)
        if fish is not None and len(past) > strip.before:
            break
    else:
        raise SystemExit(f"{strip.title}: not within {LIMIT_S:.0f} s, try another seed")
    world.restore(past[0])
    found: list[Image.Image] = []
    camera = None
    for _ in range(frames):
        if strip.follows or camera is None:
            eye = _beside(world, fish, strip.place)
            camera = subsea.camera(eye, world.fishes.position[fish])
        found.append(Image.fromarray(subsea.render(world, camera, CELL, "high")))
        world.step(strip.every)
    return found


def _beside(world: subsea.World, fish: int, place: tuple[float, float, float]) -> Array:
    """The place of the camera, cm, given ahead, left and up of a fish in its lengths."""
    ahead = matrix(world.fishes.orientation[fish].astype(np.float64))[:, 0] * [1.0, 1.0, 0.0]
    ahead /= np.linalg.norm(ahead)
    left = np.array([-ahead[1], ahead[0], 0.0])
    offset = place[0] * ahead + place[1] * left + place[2] * np.array([0.0, 0.0, 1.0])
    return world.fishes.position[fish] + float(world.fishes.length[fish]) * offset


def _of(world: subsea.World, species: str) -> NDArray[np.bool_]:
    return world.fishes.species == world.species.index(species)


def _first(chosen: NDArray[np.bool_]) -> int | None:
    return int(np.flatnonzero(chosen)[0]) if chosen.any() else None


def _starts(world: subsea.World) -> int | None:
    """A fusilier that nobody hides from below."""
    startled = np.isin(world.fishes.segment, list(CSTARTS)) & _of(world, "Yellowback fusilier")
    for fish in np.flatnonzero(startled):
        gap = world.fishes.position - world.fishes.position[fish]
        aside = np.linalg.norm(gap[:, :2], axis=1) - 0.5 * world.fishes.length
        hiding = (aside < OPEN_CM) & (gap[:, 2] < 0.0) & (gap[:, 2] > -2.5 * OPEN_CM)
        if not np.delete(hiding, fish).any():
            return int(fish)
    return None


def _alone(world: subsea.World, fish: int, away_cm: float) -> bool:
    """True if no shark but this fish is nearer to it."""
    gap = np.linalg.norm(world.fishes.position - world.fishes.position[fish], axis=1)
    near = (gap < away_cm) & _of(world, "Blacktip reef shark")
    near[fish] = False
    return not near.any()


def _strikes(world: subsea.World) -> int | None:
    """A shark that has just swallowed prey."""
    ate = _of(world, "Blacktip reef shark") & (world.minds.last_meal > world.time_s - 0.05)
    return _first(ate & np.array([_alone(world, k, 3.0 * APART_CM) for k in range(len(ate))]))


def _rows(world: subsea.World) -> int | None:
    rows = (world.fishes.segment == ROW) & (world.fishes.thrust > 0.7)
    return _first(rows & _of(world, "Moon wrasse") & (world.tick > 90))


def _banks(world: subsea.World) -> int | None:
    """Find a ray that leans by more than 8 degrees."""
    axes = matrix(world.fishes.orientation.astype(np.float64))
    lean = np.degrees(np.arcsin(np.clip(np.abs(axes[:, 2, 2]), 0.0, 1.0)))
    return _first(_of(world, "Spotted eagle ray") & (lean > 8.0))


def _does(
    intention: str, species: str | None, seconds: float
) -> Callable[[subsea.World], int | None]:
    """Find a fish that has had an intention for some seconds."""
    code, since = INTENTIONS.index(intention), Counter[int]()

    def begins(world: subsea.World) -> int | None:
        now = world.minds.intention == code
        if species is not None:
            now &= _of(world, species)
        for fish in np.flatnonzero(~now):
            since.pop(int(fish), None)
        since.update(np.flatnonzero(now).tolist())
        return next((k for k, ticks in since.items() if ticks * TICK_S > seconds), None)

    return begins


def _cleans(world: subsea.World) -> int | None:
    """Find a cleaner at its client."""
    minds, place = world.minds, world.fishes.position
    at_work = np.flatnonzero((minds.intention == INTENTIONS.index("clean")) & (minds.client >= 0))
    for fish in at_work:
        client = int(minds.client[fish])
        gap = np.linalg.norm(place[client] - place[fish])
        if gap < 0.5 * (world.fishes.length[client] + world.fishes.length[fish]):
            return int(fish)
    return None


def _spawns(world: subsea.World) -> int | None:
    """Find a female angelfish that begins to rush upward."""
    rushes = (world.minds.courtship == SPAWNING) & ~world.minds.male
    return _first(rushes & _of(world, "Emperor angelfish"))


if __name__ == "__main__":
    main()
