"""Make the plots of capture.md and biomechanics.md: `python docs/make_capture_plots.py`.

fusilier.png, fusilier_swim_fast.png, fusilier_turn_left_sharp.png and
emperor_angelfish_swim_fast.png: as `subsea-capture plot` draws them.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

from picture_files import output_folder, save
from PIL import Image

from capture.plots.pages import plot_repertoire
from subsea.base.system import resource_path
from subsea.repertoire import read_repertoire

SHOWN = {
    "fusilier": ("fusilier", "fusilier_swim_fast", "fusilier_turn_left_sharp"),
    "emperor_angelfish": ("emperor_angelfish_swim_fast",),
}


def main() -> None:
    """Plot both repertoires and save some pages."""
    folder = output_folder()
    for species, pages in SHOWN.items():
        with TemporaryDirectory() as drawn:
            plot_repertoire(
                read_repertoire(resource_path(f"repertoires/{species}.h5")), Path(drawn)
            )
            for page in pages:
                save(Image.open(Path(drawn) / f"{page}.png"), folder / f"{page}.png")


if __name__ == "__main__":
    main()
