"""Make the pictures of docs/spine.md: `python docs/make_spine_pictures.py [FOLDER]`.

spine_swings.png: a beat of the ribbon eel's spine seen from above, for both swing functions and
for two rules of propagation (KS's movies B1 and B2).
spine_beats.png: a beat of each such species as it is drawn, from two sides.
"""

import sys
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from subsea.frame import INSTANCE_COLUMNS, Batch, Packet, Scene
from subsea.kinematics.spine import MIDDLES, UNITS, spines, swung
from subsea.render import Renderer, headless_context
from subsea.render.quality import PRESETS
from subsea.repertoire import read_repertoire
from subsea.resources import resource_path
from subsea.scenario import Water
from subsea.species import load_species, shipped_species
from subsea.view.camera import NEAR_CM, View, look, off_axis
from subsea.view.rigs import display_rig

SPECIES = "ribbon_eel"
MOMENTS = 9
COLOURS = ("#0b3c8c", "#d8a200")

CELL = (280, 170)  # pixels of one look
BESIDE = 4  # moments of a beat
SHOWN_CM = 24.0
DEPTH_CM = 120.0
APART_CM = 300.0
SEABED_CM = -420.0
HALF_FIELD = 0.155  # tangent of half the horizontal angle of view
LOOKS = (  # from where, in lengths of the fish that heads along x, and what is up
    ((0.0, 0.0, 3.4), (0.0, -1.0, 0.0)),
    ((2.4, 1.6, 1.2), (0.0, 0.0, 1.0)),
)


def beats() -> Image.Image:
    """A fast beat of each species that its spine moves: moments from left to right."""
    names = [name for name in shipped_species() if load_species(name).spine]
    species = tuple(load_species(name) for name in names)
    poses = []
    for name in names:
        swim = read_repertoire(resource_path(f"repertoires/{name}.h5")).segments["swim_fast"]
        assert swim.control_points is not None
        moments = np.arange(BESIDE) * len(swim.nodes) // BESIDE
        poses.append(swim.control_points[moments])
    rows = len(names) * len(LOOKS)
    size = (CELL[0] * BESIDE, CELL[1] * rows)
    records = np.zeros((len(names) * BESIDE, INSTANCE_COLUMNS), np.float32)
    views = []
    for k in range(len(records)):
        kind, moment = divmod(k, BESIDE)
        scale = SHOWN_CM / species[kind].length_cm
        place = np.array([APART_CM * (k - len(records) / 2), 0.0, -DEPTH_CM])
        ends = poses[kind][..., 0]
        middle = place - [0.5 * scale * (ends.min() + ends.max()), 0.0, 0.0]
        # Body x, y, z to world: a quarter turn about x sets the fish upright, heading along x.
        records[k, :8] = (*middle, scale, np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0)
        records[k, 8:] = (k, k, 0.0, 0.5, 0.6, 0.6, 0.0, 0.0, 0.0, 1.0, 0.0, kind, 0.0, 0.0)
        for look_number, (away, up) in enumerate(LOOKS):
            eye = place + SHOWN_CM * np.array(away)
            row = rows - 1 - (kind * len(LOOKS) + look_number)
            viewport = (moment * CELL[0], row * CELL[1], *CELL)
            half = NEAR_CM * HALF_FIELD * np.array([1.0, CELL[1] / CELL[0]])
            projection = off_axis(-half[0], half[0], -half[1], half[1])
            views.append(View(viewport, look(eye, place - eye, np.array(up)), projection, eye))
    scene = Scene(
        species=species,
        control_points=np.concatenate(poses).astype(np.float32),
        recorded_length_cm=tuple(one.length_cm for one in species),
        terrain=np.full((81, 81), SEABED_CM, np.float32),
        terrain_half_width_cm=4000.0,
        water=Water(fog=(0.012, 0.115, 0.20), visibility_cm=1500.0),
    )
    batches = (Batch(0, 0, len(records)),)
    every = (batches,) * len(views)
    packet = Packet(1.0, tuple(views), records, every, np.zeros((0, 3), np.float32), 0)
    with headless_context() as context:
        renderer = Renderer(context, scene, display_rig("mono", size), PRESETS["high"])
        renderer.draw(packet)
        picture = Image.fromarray(renderer.read_pixels())
        renderer.release()
    return picture


def swings() -> Any:
    """The spine at moments of half a beat, and the directions of its units."""
    plan = load_species(SPECIES).spine
    assert plan
    picture = Figure(figsize=(11, 7))
    rows = picture.subplots(2, 3, width_ratios=(1, 1, 1.1))
    beat = np.linspace(0.0, 0.5, MOMENTS)
    straight = np.zeros((MOMENTS, UNITS))
    for row, propagation in zip(rows, ("tailward", "at once"), strict=True):
        for axis, function, colour in zip(row, ("sinusoidal", "linear"), COLOURS, strict=False):
            swing = msgspec.structs.replace(plan.swing, function=function, propagation=propagation)
            one = msgspec.structs.replace(plan, swing=swing)
            place = spines(one, beat, 1.0, straight, np.ones(UNITS)).place
            for k, shape in enumerate(place):
                axis.plot(-shape[:, 1], shape[:, 0], color=colour, alpha=0.25 + 0.75 * k / MOMENTS)
            axis.set(aspect="equal", xlim=(-0.2, 0.2), title=f"{function}, {propagation}")
            axis.tick_params(labelsize=7)
            if row is rows[0]:
                along, over = MIDDLES, np.zeros(1)
            else:
                along, over = np.full(1, plan.swing.inflections[1]), np.linspace(0.0, 2.0, 200)
            direction = np.degrees(swung(swing, along, over, 1.0))
            row[2].plot(along if len(over) == 1 else over, direction, color=colour, label=function)
        row[2].set_ylabel("direction of the units, degrees")
        row[2].legend(fontsize=8)
    for at in plan.swing.inflections:
        rows[0, 2].axvline(at, color="0.8", zorder=0)
    rows[0, 2].set(xlabel="behind the snout, L", title="along the spine, as a beat begins")
    rows[1, 2].set(xlabel="beats", title="at the central inflection point")
    rows[0, 0].set_ylabel("ahead of the centre, L")
    rows[1, 0].set_ylabel("ahead of the centre, L")
    picture.tight_layout()
    return picture


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "pictures"
    folder.mkdir(exist_ok=True)
    beats().save(folder / "spine_beats.png")
    swings().savefig(folder / "spine_swings.png", dpi=80, metadata={"Software": None})
