"""Write the pictures of the documentation as small files, and plots in one style.

Scenes and windows are .jpg, plots and drawings .png with at most 256 colours. The table in
CONTRIBUTING.md lists the script of each picture.
"""

import sys
from io import BytesIO
from pathlib import Path
from typing import Any

from PIL import Image

FOLDER = Path(__file__).parent / "pictures"
QUALITY = 82  # of JPEG; higher ones look the same at this size
COLOURS = 256  # of PNG
DPI = 100

# Figures are at most 9 inches wide, so font sizes are those of the page.
STYLE: dict[str, Any] = {
    "font.size": 10,
    "axes.titlesize": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "axes.axisbelow": True,
}
# The palette of Okabe and Ito, safe for colour-blind readers.
BLUE, ORANGE, GREEN, PINK, SKY, BLACK, GREY = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#222222", "#999999",
)  # fmt: skip


def output_folder() -> Path:
    """The folder of the first argument, or docs/pictures."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def save(picture: Image.Image, path: Path) -> None:
    """Write a picture as a small .jpg or .png file."""
    picture = picture.convert("RGB")
    if path.suffix == ".jpg":
        picture.save(path, quality=QUALITY, subsampling="4:2:0", optimize=True, progressive=True)
    else:
        few = picture.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
        few.save(path, optimize=True)
    print(f"{path}: {path.stat().st_size / 1024:.0f} KiB")


def save_plot(figure: Any, path: Path) -> None:
    """Write a matplotlib figure."""
    with BytesIO() as drawn:
        figure.savefig(drawn, format="png", dpi=DPI)
        save(Image.open(drawn), path)


def window_image(dive: Any) -> Image.Image:
    """The picture in the window of a dive."""
    size = dive.window.size
    shown = dive.picture._context.screen.read(viewport=(0, 0, *size), components=3)
    return Image.frombytes("RGB", size, shown).transpose(Image.Transpose.FLIP_TOP_BOTTOM)
