"""How the pictures of the documentation are kept: small, and their plots of one look.

The sea and windows are kept as .jpg, plots and drawings as .png of at most 256 colours. The table
in CONTRIBUTING.md says which script makes which.
"""

import sys
from io import BytesIO
from pathlib import Path
from typing import Any

from PIL import Image

FOLDER = Path(__file__).parent / "pictures"
QUALITY = 86  # of JPEG: at the size shown none looks different above it
COLOURS = 256  # of PNG
DPI = 100

# Figures are at most 9 inches wide: what is 9 pt here is so on a page, too.
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
# Okabe and Ito's, which nobody mistakes for one another.
BLUE, ORANGE, GREEN, PINK, SKY, BLACK, GREY = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#222222", "#999999",
)  # fmt: skip


def folder_asked() -> Path:
    """Where a script writes: what its first argument says, or the documentation's own."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def keep(picture: Image.Image, path: Path) -> None:
    """Write a picture as small as its kind allows, which `path` names by .jpg or .png."""
    picture = picture.convert("RGB")
    if path.suffix == ".jpg":
        picture.save(path, quality=QUALITY, subsampling="4:2:0", optimize=True, progressive=True)
    else:
        few = picture.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
        few.save(path, optimize=True)
    print(f"{path}: {path.stat().st_size / 1024:.0f} KiB")


def keep_plot(figure: Any, path: Path) -> None:
    """Write a figure of matplotlib."""
    with BytesIO() as drawn:
        figure.savefig(drawn, format="png", dpi=DPI)
        keep(Image.open(drawn), path)


def window_of(dive: Any) -> Image.Image:
    """What the window of a dive shows."""
    size = dive.window.size
    shown = dive.picture._context.screen.read(viewport=(0, 0, *size), components=3)
    return Image.frombytes("RGB", size, shown).transpose(Image.Transpose.FLIP_TOP_BOTTOM)
