"""Make the pictures of docs/concepts/spine.md: `python docs/make_spine_pictures.py [FOLDER]`.

spine_swings.png: a beat of the ribbon eel's spine from above, for both swing functions and two
rules of propagation (KS's movies B1 and B2).
spine_factors.png: KS's common fish, with each of its four factors changed, and a beat of it.
spine_beats.jpg: a rendered beat of each spine-driven species from two sides.
"""

from typing import Any

import msgspec
import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from picture_files import BLUE, GREY, ORANGE, STYLE, output_folder, save, save_plot
from PIL import Image

from subsea.base.system import resource_path
from subsea.fish.species import load_species, shipped_species
from subsea.fish.spine import JOINTS, MIDDLES, UNITS, Swing, pose_spine, swing_angles
from subsea.frame.packet import (
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

EVEN = ((0.0, 0.6), (1.0, 0.6))
KS_FISH = Swing(
    angle=34.0,
    inflections=(0.02, 0.5, 0.98),
    flexibility=((0.0, 0.2), (0.25, 0.25), (0.6, 0.6), (1.0, 1.3)),
)
"""KS's common fish: three inflection points, a stiff head and a soft tail (KS II)."""
FACTORS: dict[str, dict[str, dict[str, Any]]] = {
    "swing function": {"sinusoidal": {}, "linear": {"function": "linear"}},
    "inflection points": {"far apart": {}, "close": {"inflections": (0.26, 0.5, 0.74)}},
    "propagation": {"tailward": {}, "at once": {"propagation": "at once"}},
    "stiffness": {"stiff head": {}, "even": {"flexibility": EVEN}},
}


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
    records = resting_instances(len(names) * BESIDE)
    records[:, IDENTITY] = 0.5
    views = []
    for k in range(len(records)):
        kind, moment = divmod(k, BESIDE)
        scale = SHOWN_CM / species[kind].length_cm
        place = np.array([APART_CM * (k - len(records) / 2), 0.0, -DEPTH_CM])
        ends = poses[kind][..., 0]
        middle = place - [0.5 * scale * (ends.min() + ends.max()), 0.0, 0.0]
        # Body x, y, z to world: a quarter turn about x sets the fish upright, heading along x.
        records[k, ORIENTATION] = np.sqrt((0.5, 0.5, 0.0, 0.0))
        records[k, POSITION], records[k, SCALE], records[k, KIND] = middle, scale, kind
        records[k, ROW_A] = records[k, ROW_B] = k
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


def posed(beat: Any, **change: Any) -> Any:
    """Places (moments, points, 2) of the spine of KS's fish, with a factor changed."""
    rules = load_species(SPECIES).spine
    assert rules
    turn = msgspec.structs.replace(rules.turn, sharp_beats=20)
    plan = msgspec.structs.replace(
        rules, swing=msgspec.structs.replace(KS_FISH, **change), turn=turn
    )
    return pose_spine(plan, beat, 1.0, np.zeros((len(beat), UNITS)), np.ones(UNITS)).place


def factors() -> Any:
    """Plot KS's four factors, a beat with either swing function, and how far each part swings."""
    picture = Figure(figsize=(7.4, 9.6), layout="constrained")
    top, strips, bottom = picture.subfigures(3, 1, height_ratios=(1.6, 1.1, 1.0))
    for axes, (name, choices) in zip(top.subplots(2, 4).T, FACTORS.items(), strict=True):
        for axis, (label, change) in zip(axes, choices.items(), strict=True):
            half = posed(np.linspace(0.0, 0.5, 7), **change)
            for k, place in enumerate(half):
                axis.plot(-place[:, 1], place[:, 0], color=BLUE, alpha=0.2 + 0.8 * k / len(half))
            axis.set_title(label if change else f"{name}:\n{label}", fontsize=9)
            axis.axvline(0.0, color=GREY, linewidth=0.6, linestyle=":", zorder=0)
            marks = 0.35 - np.array(change.get("inflections", KS_FISH.inflections))
            axis.plot([0.0] * 3, marks, "_", color=ORANGE, markersize=14)
            bare(axis, 0.16)
    for row, (function, colour) in zip(strips.subplots(2, 8), COLOURS.items(), strict=True):
        row[0].set_ylabel(function)
        for k, (axis, place) in enumerate(
            zip(row, posed(np.arange(8) / 8, function=function), strict=True)
        ):
            axis.plot(-place[:, 1], place[:, 0], color=colour)
            axis.set_title("" if function == "linear" else f"{k}/8 beat", fontsize=8)
            bare(axis, 0.22)
    left, right = bottom.subplots(1, 2)
    over = np.linspace(0.0, 2.0, 400)
    for function, colour in COLOURS.items():
        swing = msgspec.structs.replace(KS_FISH, function=function)
        rate = np.gradient(np.degrees(swing_angles(swing, np.full(1, 0.8), over, 1.0)), over)
        left.plot(over, rate, color=colour, label=function)
    left.set(xlabel="beats", ylabel="turning of a unit at 0.8 L,\n° a beat",
             title="the linear one ticks")  # fmt: skip
    left.set_ylim(None, 1.45 * left.get_ylim()[1])
    left.legend(loc="upper right", ncols=2)
    beat = np.arange(40) / 40
    for label, line in (("stiff head", "-"), ("even", "--")):
        sway = np.abs(posed(beat, **FACTORS["stiffness"][label])[:, :, 1]).max(axis=0)
        right.plot(JOINTS, sway, line, color=BLUE, label=label)
    right.set(xlabel="behind the nose, L", ylabel="farthest to a side, L", ylim=(0, None),
              title="how far each part swings")  # fmt: skip
    right.legend()
    apart = np.abs(posed(beat) - posed(beat, function="linear")).max()
    print(f"sinusoidal and linear swing lie {apart:.3f} L apart at most")
    return picture


def bare(axis: Any, width: float) -> None:
    """Leave a small plot of a spine without frame and ticks."""
    axis.set(aspect="equal", xlim=(-width, width), ylim=(-0.7, 0.4), xticks=[], yticks=[])
    axis.spines[:].set_visible(False)


if __name__ == "__main__":
    folder = output_folder()
    save(beats(), folder / "spine_beats.jpg")
    with rc_context(STYLE):
        save_plot(swings(), folder / "spine_swings.png")
        save_plot(factors(), folder / "spine_factors.png")
