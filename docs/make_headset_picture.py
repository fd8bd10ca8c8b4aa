"""Draw what both eyes of a headset see: `python docs/make_headset_picture.py [FOLDER]`."""

import os
from contextlib import closing

import moderngl
import numpy as np
from picture_files import output_folder, save
from PIL import Image

from subsea.dive.options import DisplayOptions, DiveOptions
from subsea.stage.headset import display as headset_display
from subsea.stage.parts import HeadsetPart
from subsea.ui.dive import Dive
from tests.support.headset import FakeHeadset, turned
from tools.monkey import virtual_display

EYE = 720, 720
WINDOW = 960, 540
START_S = 4.0
DOWN_DEG = 8.0


def main() -> None:
    """Write headset.jpg."""
    folder = output_folder()
    made: list[FakeHeadset] = []

    def open_headset() -> FakeHeadset:
        made.append(FakeHeadset(moderngl.create_context(), EYE))
        return made[-1]

    headset_display.open_headset = open_headset
    with virtual_display() as name:
        os.environ["DISPLAY"] = name
        display = DisplayOptions("headset", WINDOW, quality="high")
        options = DiveOptions("peaceful", seed=1, display=display, parts=[HeadsetPart()])
        with closing(Dive(options)) as dive:
            dive.overlay.hide_help()
            made[0].orientation = turned(-DOWN_DEG, (1.0, 0.0, 0.0))
            for _ in range(round(START_S / 0.1)):
                dive.frame(0.1)
            eyes = np.concatenate(list(made[0].pictures()), axis=1)
    save(Image.fromarray(eyes.astype(np.uint8)), folder / "headset.jpg")


if __name__ == "__main__":
    main()
