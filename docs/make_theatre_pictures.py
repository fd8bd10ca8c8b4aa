"""Make docs/pictures/theatre.jpg: the images of three projectors and their screen.

python docs/make_theatre_pictures.py
"""

import numpy as np
from picture_files import output_folder, save
from PIL import Image

from subsea.dive.start import headless, picture_maker, start_world
from subsea.dive.tour import Tour
from subsea.frame.packet import PackOptions, pack
from subsea.rendering.output.quality import PRESETS
from subsea.stage.setup import set_up_theatre
from subsea.view.display_rigs import cockpit
from subsea.view.rig import views
from subsea.view.test_pattern import lineup
from subsea.world.step import step
from subsea.world.world import TICK_S

SECONDS = 12.0
SHRINK = 3
GAP = 8
GAMMA = 2.2
OVERLAP = 160 / 1440  # of a projector's picture
SCREEN_CM = 550, 250  # its pixels are higher than wide


def main() -> None:
    """Film for a while, then draw the sea and the test pattern."""
    house = set_up_theatre("three-projectors", shrink=SHRINK)
    quality = PRESETS["high"]
    with headless() as context:
        world, tour = start_world("peaceful"), Tour()
        while world.state.tick * TICK_S < SECONDS:
            step(world, tour.steer(world))
        with picture_maker(context, world, house.rig, quality) as renderer:
            observer = cockpit(world.state.submarine, 1.0)
            numbers = range(len(house.windows))
            renderer.draw(pack(world, views(house.rig, observer), 1.0, PackOptions(quality.detail)))
            sea = [renderer.read_pixels(number) for number in numbers]
            renderer.show(lineup(house.rig))
            patterns = [renderer.read_pixels(number) for number in numbers]
    rows = [_beside(sea), _lit(sea), _beside(patterns)]
    width = max(row.shape[1] for row in rows)
    sheet = Image.new("RGB", (width, sum(row.shape[0] + GAP for row in rows) - GAP), "white")
    top = 0
    for row in rows:
        sheet.paste(Image.fromarray(row), ((width - row.shape[1]) // 2, top))
        top += row.shape[0] + GAP
    save(sheet, output_folder() / "theatre.jpg")


def _beside(pictures: list[np.ndarray]) -> np.ndarray:
    """The images of the projectors side by side, with gaps."""
    gap = np.full((pictures[0].shape[0], GAP, 3), 255, np.uint8)
    return np.hstack([part for picture in pictures for part in (picture, gap)][:-1])


def _lit(pictures: list[np.ndarray]) -> np.ndarray:
    """The screen: the sum of the light of all projectors."""
    height, width, _ = pictures[0].shape
    across = width - round(OVERLAP * width)
    light = np.zeros((height, across * (len(pictures) - 1) + width, 3))
    for number, picture in enumerate(pictures):
        light[:, number * across : number * across + width] += (picture / 255.0) ** GAMMA
    shown = (255.0 * np.clip(light, 0.0, 1.0) ** (1.0 / GAMMA)).astype(np.uint8)
    size = shown.shape[1], round(shown.shape[1] * SCREEN_CM[1] / SCREEN_CM[0])
    return np.asarray(Image.fromarray(shown).resize(size, Image.Resampling.LANCZOS))


if __name__ == "__main__":
    main()
