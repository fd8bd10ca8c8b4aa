"""Make the pictures of the documentation: `python docs/make_pictures.py [FOLDER]`.

species.png: every species, by name, from its left flank and three-quarter, at rest; those that
their spine moves from above and three-quarter, swimming.
"""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from subsea.frame import INSTANCE_COLUMNS, Batch, Packet, Scene
from subsea.kinematics.surface import rest_control_points
from subsea.render import Renderer, headless_context
from subsea.render.quality import PRESETS
from subsea.repertoire import read_repertoire
from subsea.resources import resource_path
from subsea.scenario import Water
from subsea.species import Species, load_species, species_names
from subsea.view.camera import NEAR_CM, View, look, off_axis

Array = NDArray[np.floating[Any]]

CELL = (320, 240)  # pixels of one look
BESIDE = 2  # species in a row
DEPTH_CM = 120.0
APART_CM = 300.0
DRAWN_CM = 24.0  # every fish as long as the others
SEABED_CM = -420.0
HALF_FIELD = 0.18  # tangent of half the horizontal angle of view
LOOKS = (  # from where, in lengths of the fish that heads along x, and what is up
    ((0.0, 3.4, 0.15), (0.0, 0.0, 1.0)),
    ((2.5, 2.2, 0.55), (0.0, 0.0, 1.0)),
)
LOOKS_DOWN = (((0.0, 0.0, 3.4), (0.0, -1.0, 0.0)), ((2.0, 1.8, 1.7), (0.0, 0.0, 1.0)))


def species_plate(names: Sequence[str]) -> Image.Image:
    """The species, some beside each other, each from every look."""
    species = tuple(load_species(name) for name in names)
    points = [_pose(name, one) for name, one in zip(names, species, strict=True)]
    scene = Scene(
        species=species,
        control_points=np.array(points, np.float32),
        recorded_length_cm=tuple(one.length_cm for one in species),
        terrain=np.full((81, 81), SEABED_CM, np.float32),
        terrain_half_width_cm=2000.0,
        water=Water(fog=(0.012, 0.115, 0.20), visibility_cm=1500.0),
    )
    beside = min(BESIDE, len(species))
    rows = -(-len(species) // beside)
    size = (CELL[0] * len(LOOKS) * beside, CELL[1] * rows)
    records = np.zeros((len(species), INSTANCE_COLUMNS), np.float32)
    views = []
    for k in range(rows * beside):  # behind the last species the water is empty
        place = np.array([APART_CM * (k - rows * beside / 2), 0.0, -DEPTH_CM])
        row, block = divmod(k, beside)
        flat = k < len(species) and not species[k].muscles
        for column, (away, up) in enumerate(LOOKS_DOWN if flat else LOOKS):
            eye = place + DRAWN_CM * np.array(away)
            corner = (block * len(LOOKS) + column, rows - 1 - row)
            viewport = (corner[0] * CELL[0], corner[1] * CELL[1], *CELL)
            half = NEAR_CM * HALF_FIELD * np.array([1.0, CELL[1] / CELL[0]])
            projection = off_axis(-half[0], half[0], -half[1], half[1])
            views.append(View(viewport, look(eye, place - eye, np.array(up)), projection, eye))
        if k == len(species):
            break
        scale = DRAWN_CM / species[k].length_cm
        middle = place - [scale * (points[k][:, 0].min() + points[k][:, 0].max()) / 2, 0.0, 0.0]
        # Body x, y, z to world: a quarter turn about x sets the fish upright, heading along x.
        records[k, :8] = (*middle, scale, np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0)
        records[k, 8:] = (k, k, 0.0, 0.5, 0.6, 0.6, 0.0, 0.0, 0.0, 1.0, 0.0, k, 0.0, 0.0)
    batches = (Batch(0, 0, len(species)),)
    packet = Packet(1.0, tuple(views), records, batches, np.zeros((0, 3), np.float32), 0)
    with headless_context() as context:
        renderer = Renderer(context, scene, size, PRESETS["high"])
        renderer.draw(packet)
        picture = Image.fromarray(renderer.read_pixels())
        renderer.release()
    return picture


def _pose(name: str, species: Species) -> Array:
    """Control points (426, 3) in body axes, cm: at rest, but a rope has no shape at rest."""
    if species.muscles:
        return rest_control_points(species.surface, species.length_cm, 0.0)
    repertoire = read_repertoire(resource_path("repertoires") / f"{name}.h5")
    swimming = repertoire.segments["swim_medium"].control_points
    assert swimming is not None  # what its spine moves has them recorded
    return np.asarray(swimming[0])


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "pictures"
    folder.mkdir(exist_ok=True)
    species_plate(species_names()).save(folder / "species.png")
