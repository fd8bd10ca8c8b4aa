"""go-fish-show.jpg: six moments of the shipped show "Go Fish!".

Run from the root of a checkout, where there is a display (or by xvfb-run -a -s "-screen 0
1280x800x24"): python docs/make_show_picture.py [FOLDER]
"""

from contextlib import closing
from dataclasses import replace

from picture_files import output_folder, save, window_image
from PIL import Image

from subsea.dive.options import DisplayOptions, DiveOptions
from subsea.dive.part import planned
from subsea.stage.parts import ShowPart, show_of
from subsea.stage.show_file import show_path
from subsea.ui.dive import Dive

SIZE = (640, 360)
DISPLAY = DisplayOptions(size=SIZE, quality="high")
# Seconds of the show at each picture, and the item that is on.
MOMENTS = (4.0, 0), (5.0, 1), (4.0, 2), (5.0, 3), (13.0, 5), (11.0, 6)
FRAME_S = 0.1


def main() -> None:
    """Make the picture."""
    tiles = []
    options = planned(DiveOptions("any", display=DISPLAY, parts=(ShowPart(show_path("go-fish")),)))
    screens = show_of(options.parts)
    assert screens is not None
    with closing(Dive(replace(options, seed=5))) as dive:
        for seconds, item in MOMENTS:
            while screens.player.shown != item:
                screens.cue()
                for _ in range(20):
                    dive.frame(FRAME_S)
            for _ in range(round(seconds / FRAME_S)):
                dive.frame(FRAME_S)
            tiles.append(window_image(dive))
        screens.end(dive)
    sheet = Image.new("RGB", (3 * SIZE[0] // 2, SIZE[1]))
    for k, tile in enumerate(tiles):
        small = tile.resize((SIZE[0] // 2, SIZE[1] // 2), Image.Resampling.LANCZOS)
        sheet.paste(small, (k % 3 * SIZE[0] // 2, k // 3 * SIZE[1] // 2))
    save(sheet, output_folder() / "go-fish-show.jpg")


if __name__ == "__main__":
    main()
