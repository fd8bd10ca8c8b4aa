"""Draw the vessel around the audience of a dome: `python docs/make_vessel_picture.py [FOLDER]`."""

import os
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory

from picture_files import output_folder, save, window_image

from subsea.dive.options import DisplayOptions, DiveOptions
from subsea.dive.part import planned
from subsea.stage.parts import TheatrePart
from subsea.ui.dive import Dive
from tools.monkey import virtual_display

START_S = 4.0
THEATRE = """
level = true
[[window]]
name = "dome"
size = [900, 900]
[[channel]]
name = "dome"
window = "dome"
dome = { tilt_deg = 30 }
[vessel]
tilt_deg = 30
rim_deg = 5
panel_deg = 60
"""


def main() -> None:
    """Write vessel.jpg."""
    folder = output_folder()
    display = DisplayOptions("mono", (900, 900), quality="high")
    with TemporaryDirectory() as scratch, virtual_display() as name:
        os.environ["DISPLAY"] = name
        path = Path(scratch) / "dome.toml"
        path.write_text(THEATRE)
        parts = [TheatrePart(str(path))]
        options = planned(DiveOptions("peaceful", seed=1, display=display, parts=parts))
        with closing(Dive(options)) as dive:
            dive.overlay.hide_help()
            for _ in range(round(START_S / 0.1)):
                dive.frame(0.1)
            save(window_image(dive), folder / "vessel.jpg")


if __name__ == "__main__":
    main()
