"""Make the pictures of docs/concepts/spine.md: `python docs/make_spine_pictures.py [FOLDER]`.

spine_swings.png: a beat of the ribbon eel's spine from above, for both swing functions and two
rules of propagation (KS's movies B1 and B2).
spine_beats.jpg: a rendered beat of each spine-driven species from two sides.
"""

from typing import Any

import msgspec
import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from picture_files import BLUE, ORANGE, STYLE, output_folder, save, save_plot
from PIL import Image

from subsea.base.system import resource_path
from subsea.fish.species import load_species, shipped_species
from subsea.fish.spine import MIDDLES, UNITS, pose_spine, swing_angles
from subsea.frame.packet import INSTANCE_COLUMNS, Batch, Packet, RenderScene
from subsea.rendering.gl.context import headless_context
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.renderer import Renderer
from subsea.repertoire import read_repertoire
from subsea.scenario.schema import Water
from subsea.view.camera import NEAR_CM, View, look, off_axis
from subsea.view.display_rigs import display_rig

SPECIES = "ribbon_eel"
MOMENTS = 9
COLOURS = {"sinusoidal": BLUE, "linear": ORANGE}

CELL = (280, 170)  # pixels of one look
FINER = 2  # it is drawn, for slender bodies
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
    """Draw a fast beat of each spine-driven species, from left to right."""
    names = [name for name in shipped_species() if load_species(name).spine]
    species = tuple(load_species(name) for name in names)
    poses = []
    for name in names:
        swim = read_repertoire(resource_path(f"repertoires/{name}.h5")).segments["swim_fast"]
        assert swim.control_points is not None
        moments = np.arange(BESIDE) * len(swim.nodes) // BESIDE
        poses.append(swim.control_points[moments])
    rows = len(names) * len(LOOKS)
    wide, high = FINER * CELL[0], FINER * CELL[1]
    size = (wide * BESIDE, high * rows)
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
        records[k, 8:20] = (k, k, 0.0, 0.5, 0.6, 0.6, 0.0, 0.0, 0.0, 1.0, 0.0, kind)
        for look_number, (away, up) in enumerate(LOOKS):
            eye = place + SHOWN_CM * np.array(away)
            row = rows - 1 - (kind * len(LOOKS) + look_number)
            viewport = (moment * wide, row * high, wide, high)
            half = NEAR_CM * HALF_FIELD * np.array([1.0, CELL[1] / CELL[0]])
            projection = off_axis(-half[0], half[0], -half[1], half[1])
            views.append(View(viewport, look(eye, place - eye, np.array(up)), projection, eye))
    scene = RenderScene(
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
    return picture.resize((size[0] // FINER, size[1] // FINER), Image.Resampling.LANCZOS)


def swings() -> Any:
    """Plot the spine during half a beat, and the directions of its units."""
    plan = load_species(SPECIES).spine
    assert plan
    picture = Figure(figsize=(9, 4.8), layout="constrained")
    left, right = picture.subfigures(1, 2, width_ratios=(1.3, 1))
    shapes = left.subplots(1, 4, sharey=True)
    charts = right.subplots(2, 1)
    beat = np.linspace(0.0, 0.5, MOMENTS)
    straight = np.zeros((MOMENTS, UNITS))
    for row, propagation in enumerate(("tailward", "at once")):
        for column, (function, colour) in enumerate(COLOURS.items()):
            axis = shapes[2 * row + column]
            swing = msgspec.structs.replace(plan.swing, function=function, propagation=propagation)
            one = msgspec.structs.replace(plan, swing=swing)
            place = pose_spine(one, beat, 1.0, straight, np.ones(UNITS)).place
            for k, shape in enumerate(place):
                axis.plot(-shape[:, 1], shape[:, 0], color=colour, alpha=0.25 + 0.75 * k / MOMENTS)
            axis.set(aspect="equal", xlim=(-0.12, 0.12), xticks=(-0.1, 0.1))
            axis.set_title(f"{function},\n{propagation}")
            if propagation == "tailward":
                along, over = MIDDLES, np.zeros(1)
            else:
                along, over = np.full(1, plan.swing.inflections[1]), np.linspace(0.0, 2.0, 200)
            direction = np.degrees(swing_angles(swing, along, over, 1.0))
            charts[row].plot(
                along if len(over) == 1 else over, direction, color=colour, label=function
            )
    shapes[0].set_ylabel("ahead of the centre, L")
    left.supxlabel("to the right, L", fontsize=10)
    for at in plan.swing.inflections:
        charts[0].axvline(at, color="0.8", zorder=0)
    charts[0].set(xlabel="behind the snout, L", title="along the spine, as a beat begins")
    charts[1].set(xlabel="time, beats", title="at the central inflection point")
    charts[0].legend(loc="lower left")
    for chart in charts:
        chart.set_ylabel("direction of units, °")
    return picture


if __name__ == "__main__":
    folder = output_folder()
    save(beats(), folder / "spine_beats.jpg")
    with rc_context(STYLE):
        save_plot(swings(), folder / "spine_swings.png")
