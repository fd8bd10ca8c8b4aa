"""docs/pictures/retina.jpg: the view of a fish: colours, objects and distances (as Tu fig. 6.9).

Run from the root of a checkout: python docs/make_retina_picture.py [FISH SECONDS]
"""

import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from picture_files import FOLDER, save
from PIL import Image

from subsea.dive.ride import SIDES
from subsea.media.eye_frames import film_eyes
from subsea.media.film import EyeFilmOptions
from subsea.scenario.load import load_scenario

SIZE, GAP = (480, 360), 6
FISH, SECONDS = "9", 7.425
GREY_CM = 260.0  # over which what is farther gets darker by a factor e

out = FOLDER / "retina.jpg"
fish, seconds = sys.argv[1:3] if len(sys.argv) > 2 else (FISH, SECONDS)
with TemporaryDirectory() as name:
    folder = Path(name) / "seen"
    film_eyes(
        EyeFilmOptions(
            out=folder,
            loaded=load_scenario("peaceful"),
            eyes=fish,
            seconds=1 / 30,
            start=float(seconds),
            size=SIZE,
        )
    )

    def read(part: str) -> np.ndarray:
        """Read the images of both eyes, side by side."""
        found = [np.asarray(Image.open(folder / part / side / "frame_00000.png")) for side in SIDES]
        found = [np.repeat(one[..., None], 3, 2) if one.ndim == 2 else one for one in found]
        return np.concatenate([found[0], np.full((SIZE[1], GAP, 3), 255), found[1]], axis=1)

    depth_cm = read("depth") / 10.0
    grey = np.where(depth_cm > 0.0, 255.0 * np.exp(-depth_cm / GREY_CM), 0.0)
    rows = [read(""), read("coded"), grey]
    between = np.full((GAP, rows[0].shape[1], 3), 255)
    sheet = np.concatenate([rows[0], between, rows[1], between, rows[2]])
    save(Image.fromarray(sheet.astype(np.uint8)), out)
    about = json.loads((folder / "camera.json").read_text(encoding="utf-8"))
    print(about["fish"], about["frames"][0]["fish"]["intention"])
