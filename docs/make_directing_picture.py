"""Make the picture of docs/how-to/directing.md: `python docs/make_directing_picture.py [FOLDER]`.

rendezvous.jpg: nine moments of the scenario `rendezvous` as its directed camera films it.
"""

import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from picture_files import output_folder, save
from PIL import Image

CELL = (400, 225)  # pixels of one moment
MOMENTS_S = (0, 6, 11, 14, 16, 19, 22, 26, 31)
SEED = 1


def main() -> None:
    """Film one picture per second and save some."""
    folder = output_folder()
    wide, high = CELL
    sheet = Image.new("RGB", (3 * wide, 3 * high))
    with TemporaryDirectory() as film:
        size = f"{2 * wide}x{2 * high}"
        subprocess.run(
            [sys.executable, "-m", "subsea", "film", film, "--scenario", "rendezvous", "--tour",
             "directed", "--seed", str(SEED), "--fps", "1", "--size", size],
            check=True,
        )  # fmt: skip
        for k, second in enumerate(MOMENTS_S):
            frame = Image.open(Path(film) / f"frame_{second:05d}.png").convert("RGB")
            sheet.paste(frame.resize(CELL, Image.Resampling.LANCZOS), (k % 3 * wide, k // 3 * high))
    save(sheet, folder / "rendezvous.jpg")


if __name__ == "__main__":
    main()
