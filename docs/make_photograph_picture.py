"""Make the picture skin-tuna.jpg of docs/how-to/skin.md.

`python docs/make_photograph_picture.py [FOLDER]` draws the photograph docs/outlines/tuna.webp, the
fitted meshes, and the tuna of docs/outlines/tuna.toml with the skin from it, from two sides.
"""

import tomllib
from pathlib import Path

import cv2
import msgspec
import numpy as np
from make_dressed_pictures import BACKDROP, with_meshes
from picture_files import output_folder, save
from PIL import Image

from subsea.base.system import resource_path
from subsea.fish.outline_file import read_outline
from subsea.fish.scaffold import fit_scaffold
from subsea.fish.species import Species
from subsea.fish.surface import rest_control_points
from subsea.rendering.fish.preview import FishPreview, Orbit
from subsea.rendering.gl.context import headless_context
from subsea.studio.fitting import find_fish
from subsea.studio.lift import lift_sheet
from subsea.studio.photograph import read_photograph

CELL = (560, 202)  # pixels
VIEWS = (Orbit(0.0, 0.0), Orbit(np.radians(40.0), np.radians(12.0)))


def plain_tuna(outline: Path) -> Species:
    """Make a species of an outline, as `subsea-capture fit` begins with."""
    surface = read_outline(outline, None, None)
    text = resource_path("assets/outline_species.toml").read_text("utf-8")
    plain = msgspec.convert(tomllib.loads(text), Species)
    skin = msgspec.structs.replace(plain.skin, dorsal=None, ventral=None)
    return msgspec.structs.replace(plain, surface=surface, body=fit_scaffold(surface), skin=skin)


def main() -> None:
    """Make the picture."""
    folder, outlines = output_folder(), resource_path("docs/outlines")
    photograph = read_photograph(outlines / "tuna.webp")
    tuna = plain_tuna(outlines / "tuna.toml")
    found = find_fish(photograph, tuna.surface)
    sheet = lift_sheet(photograph.colour, found.meshes, tuna, found.mask)
    assert tuna.body
    points = rest_control_points(tuna.surface, tuna.length_cm, tuna.body.stations[2])
    with headless_context() as context:
        preview = FishPreview(context, tuna, sheet)
        worn = []
        for orbit in VIEWS:
            preview.draw(points, orbit, CELL)
            worn.append(preview.read_pixels())
        preview.release()
    assert photograph.opacity is not None
    over = photograph.opacity[..., None] / 255.0
    plain = (over * photograph.colour + (1.0 - over) * BACKDROP).astype(np.uint8)
    rows = [[plain, with_meshes(plain, found.meshes)], worn]
    cells = [[cv2.resize(cell, CELL, interpolation=cv2.INTER_AREA) for cell in row] for row in rows]
    picture = np.vstack([np.hstack(row) for row in cells])
    save(Image.fromarray(picture), folder / "skin-tuna.jpg")


if __name__ == "__main__":
    main()
