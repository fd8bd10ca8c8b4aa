"""Make the pictures of the sea itself: `python docs/make_sea_pictures.py [FOLDER] [NAME ...]`.

dive.jpg: the bay, for the first page. swimming.webp: some seconds of it. qualities.jpg: the
presets side by side. places.jpg: five views of every scenario. visitors.jpg, preying.jpg: single
pictures of others. equirectangular.jpg: all round. lagoon.jpg: the sea of the tutorials, as their
blocks build it.
scenarios: the pictures of the menu, beside the scenario files.
"""

import os
import re
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from picture_files import output_folder, save
from PIL import Image, ImageDraw, ImageFont

from subsea.base.system import ROOT, resource_path
from subsea.dive.start import headless, picture_maker
from subsea.frame.packet import pack
from subsea.rendering.output.quality import PRESETS
from subsea.scenario.load import SHIPPED, load_scenario
from subsea.submarine.vessel import NEUTRAL
from subsea.view.display_rigs import display_rig, views_for
from subsea.view.rig import CameraPose
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S

Array = NDArray[np.floating[Any]]


class Shot(NamedTuple):
    """A view of a world: time, target and eye."""

    scenario: str
    seed: int
    tick: int
    fishes: tuple[int, int]  # the first of them, and the next that is not: toward their middle ...
    eye_cm: tuple[float, float, float]  # ... from there
    past_cm: tuple[float, float, float]  # the view passes beside it by this


BAY = Shot("peaceful", 1, 300, (0, 33), (-150.0, 70.0, 10.0), (0.0, -14.0, 7.0))
VISITORS = Shot("visitors", 4, 160, (0, 1), (-105.0, -17.0, 18.0), (0.0, 8.0, 14.0))
PREYING = Shot("preying", 2, 410, (0, 1), (-50.0, -155.0, 6.0), (-28.0, -8.0, 6.0))
THUMBNAILS = {
    "peaceful": BAY,
    "visitors": VISITORS,
    "preying": Shot("preying", 2, 120, (0, 1), (125.0, -85.0, 5.0), (8.0, 8.0, 0.0)),
    "schooling": Shot("schooling", 3, 360, (0, 36), (-45.0, -110.0, 8.0), (0.0, 0.0, 0.0)),
    "mating": Shot("mating", 1, 150, (0, 3), (-27.0, 15.0, 2.0), (2.0, 4.0, 0.0)),
    "go-fish": Shot("go-fish", 1, 525, (15, 16), (-60.0, 20.0, 5.0), (0.0, 0.0, 0.0)),
    "rendezvous": Shot("rendezvous", 1, 400, (0, 2), (-52.0, -18.0, 5.0), (0.0, 9.0, 0.0)),
    "twilight": Shot("twilight", 3, 700, (0, 32), (-120.0, 70.0, 14.0), (0.0, 0.0, -10.0)),
    "open-ocean": Shot("open-ocean", 2, 40, (0, 1800), (-600.0, 360.0, 60.0), (0.0, 0.0, 0.0)),
}
THUMBNAIL, THUMBNAIL_QUALITY = (192, 108), 80
FIRST, OTHER = (1600, 700), (1120, 500)
SWIMMING = BAY._replace(tick=270)
STRIP, TICKS, EVERY, STRIP_QUALITY = (720, 316), 96, 2, 62
SHARE = (400, 190, 600, 350)  # of a picture, which is shown twice as large for each preset
LETTERS, PLACES_WIDE = 18, 1280
TUTORIALS = "first-dive.md", "first-fish.md"
JEWEL = "reef_jewel"  # the species of the tutorials


def filmed(shot: Shot, size: tuple[int, int], quality: str = "high", ticks: int = 1) -> list[Array]:
    """Pictures of a shot from its tick on, with a fixed eye."""
    world = create_world(load_scenario(shot.scenario)[0], seed=shot.seed)
    while world.state.tick < shot.tick:
        step(world, NEUTRAL)
    middle = np.median(world.state.fishes.position[slice(*shot.fishes)], axis=0).astype(float)
    forward = np.subtract(shot.past_cm, shot.eye_cm)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    up = np.cross(right / np.linalg.norm(right), forward)
    views = views_for("mono", size, CameraPose(middle + shot.eye_cm, forward, up))
    rig, preset = display_rig("mono", size), PRESETS[quality]
    pictures = []
    with headless() as context, picture_maker(context, world, rig, preset) as renderer:
        for tick in range(ticks):
            if tick % EVERY == 0:
                renderer.draw(pack(world, views, 1.0, preset.packing))
                pictures.append(renderer.read_pixels())
            step(world, NEUTRAL)
    return pictures


def one(shot: Shot, size: tuple[int, int]) -> Image.Image:
    """The first picture of a shot."""
    return Image.fromarray(filmed(shot, size)[0])


def thumbnail(name: str) -> None:
    """Save the picture of a shipped scenario."""
    wide, high = THUMBNAIL
    picture = one(THUMBNAILS[name], (4 * wide, 4 * high)).resize(
        THUMBNAIL, Image.Resampling.LANCZOS
    )
    path = resource_path(SHIPPED) / f"{name}.jpg"
    picture.save(path, quality=THUMBNAIL_QUALITY, optimize=True)
    print(f"{path}: {path.stat().st_size} bytes")


def swimming(path: Path) -> None:
    """Film some seconds of the bay in real time."""
    frames = [Image.fromarray(one) for one in filmed(SWIMMING, STRIP, ticks=TICKS)]
    # Each picture whole: those that tell only what changed show blocks in the water.
    frames[0].save(
        path, save_all=True, append_images=frames[1:], loop=0, kmin=0, kmax=1,
        quality=STRIP_QUALITY, duration=round(1000 * EVERY * TICK_S),
    )  # fmt: skip
    print(f"{path}: {path.stat().st_size / 1024:.0f} KiB")


def qualities() -> Image.Image:
    """Draw the same part of the bay with each preset."""
    wide, high = 2 * (SHARE[2] - SHARE[0]), 2 * (SHARE[3] - SHARE[1])
    sheet = Image.new("RGB", (len(PRESETS) * wide, high))
    font = ImageFont.load_default(LETTERS)
    for k, name in enumerate(PRESETS):
        picture = Image.fromarray(filmed(BAY, OTHER, name)[0])
        picture = picture.crop(SHARE).resize((wide, high), Image.Resampling.NEAREST)
        ImageDraw.Draw(picture).text((12, 10), name, "white", font)
        sheet.paste(picture, (k * wide, 0))
    return sheet


def places() -> Image.Image:
    """A row of five views for each shipped scenario."""
    with TemporaryDirectory() as folder:
        command = sys.executable, str(ROOT / "tools" / "viewpoints.py"), folder
        size = "--size", "960x540", "--seconds", "20"
        subprocess.run([*command, *size], check=True)
        sheet = Image.open(Path(folder) / "contact.png").convert("RGB")
    high = round(PLACES_WIDE * sheet.height / sheet.width)
    return sheet.resize((PLACES_WIDE, high), Image.Resampling.LANCZOS)


def filmed_by(*arguments: str, pages: tuple[str, ...] = ()) -> Image.Image:
    """Run `subsea film` in a home folder with the files of tutorials."""
    with TemporaryDirectory() as home:
        surroundings = os.environ | {"XDG_DATA_HOME": home, "PYTHONPATH": str(ROOT)}

        def run(*command: str) -> None:
            subprocess.run([sys.executable, "-m", *command], cwd=home, env=surroundings, check=True)

        if pages:
            furnish(Path(home), pages)
            run("capture", "record", JEWEL)
        run("subsea", "film", "picture.png", *arguments)
        return Image.open(Path(home) / "picture.png").convert("RGB")


def furnish(home: Path, pages: tuple[str, ...]) -> None:
    """Write the files and copy the species of tutorials, in their order."""
    folder = Path(__file__).parent / "tutorials"
    text = "".join((folder / page).read_text(encoding="utf-8") for page in pages)
    for block in re.findall(r"^```toml\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        name = re.match(r"# ([\w.]+)", block)
        assert name
        with (home / name[1]).open("a", encoding="utf-8") as file:
            file.write(block)
    species = home / "subsea" / "species"
    species.mkdir(parents=True)
    wrasse = (ROOT / "assets/species/moon_wrasse.toml").read_text(encoding="utf-8")
    (species / f"{JEWEL}.toml").write_text(wrasse, encoding="utf-8")


def main() -> None:
    """Make all pictures or the named ones."""
    folder = output_folder()
    lagoon = ("--scenario", "lagoon.toml", "--tour", "directed", "--seconds", "8")
    made = {
        "dive": lambda: one(BAY, FIRST),
        "qualities": qualities,
        "places": places,
        "visitors": lambda: one(VISITORS, OTHER),
        "preying": lambda: one(PREYING, OTHER),
        "equirectangular": lambda: filmed_by(
            "--display", "equirectangular", "--seconds", "8", "--size", "1600x800"
        ),
        "lagoon": lambda: filmed_by(*lagoon, "--size", "1200x500", pages=TUTORIALS),
    }
    wanted = sys.argv[2:] or ["swimming", "scenarios", *made]
    for name, make in made.items():
        if name in wanted:
            save(make(), folder / f"{name}.jpg")
    if "swimming" in wanted:
        swimming(folder / "swimming.webp")
    if "scenarios" in wanted:
        for name in THUMBNAILS:
            thumbnail(name)


if __name__ == "__main__":
    main()
