"""Make the pictures of the documentation: `python docs/make_pictures.py [FOLDER]`.

species.png: every species from its left flank, three-quarter and from above, at rest.
"""

import sys
from pathlib import Path

import numpy as np
from PIL import Image

from subsea.biomechanics.body import rest_nodes
from subsea.frame import INSTANCE_COLUMNS, Batch, Packet, Scene
from subsea.kinematics.surface import rest_control_points
from subsea.render import Renderer, headless_context
from subsea.scenario import Water
from subsea.species import load_species
from subsea.view.camera import NEAR_CM, View, look, off_axis

SPECIES = ("fusilier", "emperor_angelfish")
CELL = (440, 330)  # pixels of one fish
DEPTH_CM = 120.0
APART_CM = 500.0
SEABED_CM = -420.0
HALF_FIELD = 0.18  # tangent of half the horizontal angle of view
LOOKS = (  # from where, in lengths of the fish that heads along x, and what is up
    ((0.0, 3.4, 0.15), (0.0, 0.0, 1.0)),
    ((2.5, 2.2, 0.55), (0.0, 0.0, 1.0)),
    ((0.0, 0.0, 3.4), (0.0, -1.0, 0.0)),
)


def species_plate() -> Image.Image:
    """One row per species, one column per look."""
    species = tuple(load_species(name) for name in SPECIES)
    nodes = [rest_nodes(one.body) for one in species]
    points = [
        rest_control_points(one.surface, one.body.length, node[0, 0])
        for one, node in zip(species, nodes, strict=True)
    ]
    scene = Scene(
        species=species,
        control_points=np.array(points, np.float32),
        recorded_length_cm=tuple(one.body.length for one in species),
        terrain=np.full((81, 81), SEABED_CM, np.float32),
        terrain_half_width_cm=2000.0,
        water=Water(fog=(0.012, 0.115, 0.20), visibility_cm=1500.0),
    )
    size = (CELL[0] * len(LOOKS), CELL[1] * len(species))
    records = np.zeros((len(species), INSTANCE_COLUMNS), np.float32)
    views = []
    for row, (one, rest) in enumerate(zip(species, points, strict=True)):
        place = np.array([0.0, APART_CM * row, -DEPTH_CM])
        # Body x, y, z to world: a quarter turn about x sets the fish upright, heading along x.
        records[row, :8] = (*place, 1.0, np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0)
        records[row, 8:] = (row, row, 0.0, 0.5, 0.6, 0.6, 0.0, 0.0, 0.0, 1.0, 0.0)
        middle = place + [(rest[:, 0].min() + rest[:, 0].max()) / 2, 0.0, 0.0]
        for column, (away, up) in enumerate(LOOKS):
            eye = middle + one.body.length * np.array(away)
            viewport = (column * CELL[0], (len(species) - 1 - row) * CELL[1], *CELL)
            half = NEAR_CM * HALF_FIELD * np.array([1.0, CELL[1] / CELL[0]])
            projection = off_axis(-half[0], half[0], -half[1], half[1])
            views.append(View(viewport, look(eye, middle - eye, np.array(up)), projection, eye))
    batches = tuple(Batch(row, 0, row, 1) for row in range(len(species)))
    packet = Packet(1.0, tuple(views), records, batches, np.zeros((0, 3), np.float32), 0)
    with headless_context() as context:
        renderer = Renderer(context, scene, size, samples=4)
        renderer.draw(packet)
        picture = Image.fromarray(renderer.read_pixels())
        renderer.release()
    return picture


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "pictures"
    folder.mkdir(exist_ok=True)
    species_plate().save(folder / "species.png")
