"""docs/pictures/dive-1-start.jpg, menu.jpg and instruments.jpg: the cockpit of a visitor.

Run from the root of a checkout, where there is a display (or by xvfb-run -a -s "-screen 0
1280x800x24"): python docs/make_cockpit_pictures.py
"""

from contextlib import closing

from picture_files import output_folder, save, window_image
from PIL import Image

from subsea.dive.options import DisplayOptions, DiveOptions
from subsea.ui.dive import Dive

SIZE, SMALL = (1280, 720), (960, 540)


def main() -> None:
    """Save pictures during a dive."""
    with closing(
        Dive(DiveOptions("peaceful", seed=1, display=DisplayOptions(size=SIZE, quality="high")))
    ) as dive:
        _go(dive, 3.0)
        _save(dive, "dive-1-start")
        dive.run_command("menu")
        dive.gui.pointed(0.0, 0.0)  # beside its entries
        _go(dive, 1.0)
        _save(dive, "menu", SMALL)
        dive.menu.back()
        dive.overlay.hide_help()
        dive.pilot.hold("up", "Up", 0.2)
        dive.pilot.wheel(4)
        _go(dive, 3.0)
        _save(dive, "instruments", SMALL)


def _go(dive: Dive, seconds: float) -> None:
    for _ in range(round(seconds / 0.1)):
        dive.frame(0.1)


def _save(dive: Dive, name: str, size: tuple[int, int] = SIZE) -> None:
    save(window_image(dive).resize(size, Image.Resampling.LANCZOS), output_folder() / f"{name}.jpg")


if __name__ == "__main__":
    main()
