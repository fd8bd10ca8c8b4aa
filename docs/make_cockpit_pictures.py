"""docs/pictures/dive-1-start.png, menu.png and instruments.png: what a visitor sees of the cockpit.

Run from the root of a checkout, where there is a display (or by xvfb-run -a -s "-screen 0
1280x800x24"): python docs/make_cockpit_pictures.py
"""

from contextlib import closing
from pathlib import Path

from PIL import Image

from subsea.app.dive import Dive

SIZE, SMALL = (1280, 720), (960, 540)
FOLDER = Path(__file__).parent / "pictures"


def main() -> None:
    """A dive, and pictures on its way."""
    with closing(Dive("peaceful", "mono", SIZE, seed=1, quality="high")) as dive:
        _go(dive, 3.0)
        _save(dive, "dive-1-start")
        dive.grant("menu")
        _go(dive, 1.0)
        _save(dive, "menu", SMALL)
        dive.menu.back()
        dive.overlay.toggle_help()
        dive.pilot.hold("up", "Up", 0.2)
        dive.pilot.wheel(4)
        _go(dive, 3.0)
        _save(dive, "instruments", SMALL)


def _go(dive: Dive, seconds: float) -> None:
    for _ in range(round(seconds / 0.1)):
        dive.frame(0.1)


def _save(dive: Dive, name: str, size: tuple[int, int] = SIZE) -> None:
    shown = dive.picture._context.screen.read(viewport=(0, 0, *dive.window.size), components=3)
    picture = Image.frombytes("RGB", dive.window.size, shown)
    out = FOLDER / f"{name}.png"
    picture.transpose(Image.Transpose.FLIP_TOP_BOTTOM).resize(size).save(out, optimize=True)
    print(out)


if __name__ == "__main__":
    main()
