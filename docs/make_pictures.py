"""Make the pictures of the documentation: `python docs/make_pictures.py [FOLDER]`.

species.jpg: every species, by name, from its left flank and three-quarter, swimming slowly, in one
picture of the sea; below them six individuals of one species and a courting male.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from picture_files import output_folder, save
from PIL import Image, ImageDraw, ImageFont

from subsea.base.system import resource_path
from subsea.fish.skinning import couple, place
from subsea.fish.species import Species, load_species, shipped_species
from subsea.fish.surface import rest_control_points
from subsea.frame.packet import (
    DISPLAY,
    FINS,
    IDENTITY,
    KIND,
    ORIENTATION,
    POSITION,
    ROW_A,
    ROW_B,
    SCALE,
    Batch,
    Packet,
    RenderScene,
    resting_instances,
)
from subsea.geometry.rotation import multiply
from subsea.rendering.gl.context import headless_context
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.renderer import Renderer
from subsea.repertoire import read_repertoire
from subsea.scenario.schema import Water
from subsea.state import SWEEP_LEFT, SWEEP_RIGHT
from subsea.view.camera import NEAR_CM, View, look, off_axis
from subsea.view.display_rigs import display_rig

Array = NDArray[np.floating[Any]]

CELL = (400, 232)  # pixels
CELL_CM = 18.0  # its width
LETTERS = 22
BESIDE = 2  # species in a row
ROOM = (0.84, 0.86)  # shares of a cell that a fish takes at most
DEPTH_CM = 130.0  # of the upper edge of the picture
SAND_CM = 30.0  # below its lower edge
HALF_FIELD = 0.22  # tangent of half the horizontal angle of view
TURNED, TILTED = np.radians(48.0), np.radians(58.0)  # toward the eye; of those flat or thin
SWEEP_RAD = 0.55  # of pectoral fins
VARIED = "moon_wrasse"  # whose individuals are shown
IDENTITIES = (0.07, 0.21, 0.38, 0.55, 0.69, 0.93, 0.45)  # the last one courts


def species_plate(names: Sequence[str], varied: str | None = None) -> Image.Image:
    """Draw all species from two sides; below, individuals of `varied`."""
    species = tuple(load_species(name) for name in names)
    points = [_pose(name, one) for name, one in zip(names, species, strict=True)]
    beside = min(BESIDE, len(species))
    columns, rows = 2 * beside, -(-len(species) // beside) + bool(varied)
    size = (CELL[0] * columns, CELL[1] * rows)
    cm = CELL_CM / CELL[0]  # a pixel's width
    scene = RenderScene(
        species=species,
        control_points=np.array(points, np.float32),
        recorded_length_cm=tuple(one.length_cm for one in species),
        terrain=np.full((81, 81), -DEPTH_CM - size[1] * cm - SAND_CM, np.float32),
        terrain_half_width_cm=3000.0,
        water=Water(fog=(0.012, 0.115, 0.20), visibility_cm=2000.0),
    )
    records = []
    for k, one in enumerate(species):
        row, block = divmod(k, beside)
        for side in range(2):
            cell = (block * 2 + side + 0.5, row + 0.5)
            records.append(_record(k, one, points[k], side, cell, columns, 1.0))
    if varied:
        k = list(names).index(varied)
        for number, identity in enumerate(IDENTITIES):
            share = columns / len(IDENTITIES)
            cell = ((number + 0.5) * share, rows - 0.5)
            record = _record(k, species[k], points[k], 0, cell, columns, share)
            record[IDENTITY], record[DISPLAY] = identity, number == len(IDENTITIES) - 1
            records.append(record)
    away = columns * CELL_CM / 2 / HALF_FIELD
    eye = np.array([0.0, away, -DEPTH_CM - size[1] * cm / 2])
    half = NEAR_CM * HALF_FIELD * np.array([1.0, size[1] / size[0]])
    view = View(
        (0, 0, *size),
        look(eye, np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.0, 1.0])),
        off_axis(-half[0], half[0], -half[1], half[1]),
        eye,
    )
    instances = np.array(records, np.float32)
    batches = (Batch(0, 0, len(instances)),)
    packet = Packet(1.0, (view,), instances, (batches,), np.zeros((0, 3), np.float32), 0)
    with headless_context() as context:
        renderer = Renderer(context, scene, display_rig("mono", size), PRESETS["high"])
        renderer.draw(packet)
        picture = Image.fromarray(renderer.read_pixels())
        renderer.release()
    draw, font = ImageDraw.Draw(picture), ImageFont.load_default(LETTERS)
    for k, one in enumerate(species):
        row, block = divmod(k, beside)
        at = (2 * block + 1) * CELL[0], (row + 1) * CELL[1] - 4
        draw.text(at, one.name, "white", font, "ms", stroke_width=2, stroke_fill=(8, 40, 60))
    return picture


def _record(
    kind: int,
    species: Species,
    points: Array,
    side: int,
    cell: tuple[float, float],
    columns: int,
    share: float,
) -> Array:
    """The record of a fish in the middle of a cell (column, row from the top), heading left."""
    # Body x, y, z to world: a quarter turn about x sets the fish upright, heading along x.
    turn = np.array([np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0])
    if side:
        turn = multiply(np.array([np.cos(TURNED / 2), 0.0, 0.0, np.sin(TURNED / 2)]), turn)
    if not species.muscles:  # its back toward the eye
        turn = multiply(turn, np.array([np.cos(TILTED / 2), -np.sin(TILTED / 2), 0.0, 0.0]))
    seen = np.array([_turned(turn, point) for point in points])
    low, high = seen.min(axis=0), seen.max(axis=0)
    room = share * CELL_CM * ROOM[0], min(1.0, 1.3 * share) * CELL_CM * CELL[1] / CELL[0] * ROOM[1]
    scale = min(room[0] / (high[0] - low[0]), room[1] / (high[2] - low[2]))
    record = resting_instances(1)[0]
    middle = (
        (columns / 2 - cell[0]) * CELL_CM,
        0.0,
        -DEPTH_CM - cell[1] * CELL_CM * CELL[1] / CELL[0],
    )
    record[POSITION] = middle - scale * (low + high) / 2
    record[SCALE], record[ORIENTATION] = scale, turn
    record[ROW_A] = record[ROW_B] = record[KIND] = kind
    record[IDENTITY] = 0.5
    record[FINS][[SWEEP_LEFT, SWEEP_RIGHT]] = SWEEP_RAD
    return record


def _turned(q: Array, v: Array) -> Array:
    t = 2.0 * np.cross(q[1:], v)
    return np.asarray(v + q[0] * t + np.cross(q[1:], t))


def _pose(name: str, species: Species) -> Array:
    """Control points (426, 3), body axes, cm, of a slow swimmer; at rest without a repertoire."""
    path = resource_path("repertoires") / f"{name}.h5"
    if not path.exists():
        return rest_control_points(species.surface, species.length_cm, 0.0)
    repertoire = read_repertoire(path)
    segment = repertoire.segments["swim_slow" if species.muscles else "swim_medium"]
    if segment.control_points is not None:
        return np.asarray(segment.control_points[0])
    nodes = repertoire.rest_nodes
    rest = rest_control_points(species.surface, repertoire.body_length_cm, nodes[0, 0])
    return np.asarray(place(couple(species.surface.coupling, nodes, rest), segment.nodes[:1])[0])


if __name__ == "__main__":
    folder = output_folder()
    names = shipped_species()
    names.sort(key=lambda name: not load_species(name).muscles)
    save(species_plate(names, VARIED), folder / "species.jpg")
