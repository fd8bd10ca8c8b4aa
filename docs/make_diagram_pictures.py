"""Make pictures for the documentation: `python docs/make_diagram_pictures.py [FOLDER]`.

diagrams.jpg: the peaceful bay with one or two diagrams at a time, and as a wireframe.
lights.jpg: the ocean's floor and the bay without and with the submarine's lights.
"""

import numpy as np
from picture_files import output_folder, save
from PIL import Image, ImageDraw, ImageFont

from subsea.dive.start import headless, picture_maker, start_world
from subsea.dive.tour import Tour
from subsea.frame.diagrams import DiagramBuilder, place_labels
from subsea.frame.packet import PackOptions, pack
from subsea.geometry.solids import height_at
from subsea.media.film import lettered
from subsea.rendering.output.quality import PRESETS
from subsea.view.display_rigs import cockpit, display_rig
from subsea.view.rig import pose_from_angles, views
from subsea.world.step import step

SIZE = (640, 360)
TICKS = 250
PLATES = (
    (("scaffold", "axes"), "scaffold, axes", False),
    (("control mesh", "indices"), "control mesh, indices", False),
    (("sensitivity", "paths"), "sensitivity, paths", False),
    (("school",), "school", False),
    (("perception", "bounds"), "perception, bounds", False),
    ((), "wireframe", True),
)
# Scenario, ticks of the autopilot, and where the submarine is put then: x, y, height over the sand,
# cm, heading and pitch, degrees.
LIT = (
    ("open-ocean", 60, (0.0, 0.0, 140.0, 40.0, -8.0)),
    ("peaceful", TICKS, None),
)
LEADER_AHEAD = (-95.0, -75.0, 8.0)  # cm, from the school's fish that is looked at to the eye


def plate() -> Image.Image:
    """Draw two columns of three pictures."""
    world, tour = start_world("peaceful"), Tour()
    builder, rig = DiagramBuilder(world), display_rig("mono", SIZE)
    for _ in range(TICKS):
        step(world, tour.steer(world))
        builder.follow()
    fishes, minds = world.state.fishes, world.state.minds
    led = minds.schools & (minds.leader >= 0)
    middle = np.median(fishes.position[led], axis=0)
    fish = int(np.argmin(np.where(led, np.linalg.norm(fishes.position - middle, axis=1), np.inf)))
    eye = fishes.position[fish] + LEADER_AHEAD
    ahead = fishes.position[fish] - eye
    pitch = np.arctan2(ahead[2], np.hypot(*ahead[:2]))
    seen = views(rig, pose_from_angles(eye, float(np.arctan2(ahead[1], ahead[0])), float(pitch)))
    font = ImageFont.load_default(18)
    sheet = Image.new("RGB", (2 * SIZE[0] + 8, 3 * SIZE[1] + 16), "white")
    with headless() as context, picture_maker(context, world, rig, PRESETS["high"]) as renderer:
        for k, (names, caption, wireframe) in enumerate(PLATES):
            chosen = fish if "perception" in names else None
            drawing = builder.draw(names, seen, 1.0, chosen)
            renderer.wireframe = wireframe
            renderer.draw(pack(world, seen, 1.0, PackOptions(detail=1.6), lines=drawing.lines))
            words = place_labels(rig, seen, drawing.labels)
            picture = Image.fromarray(lettered(renderer.read_pixels(), words, 0))
            ImageDraw.Draw(picture).text(
                (14, SIZE[1] - 14), caption, "white", font, anchor="ls",
                stroke_width=2, stroke_fill=(0, 25, 40),
            )  # fmt: skip
            sheet.paste(picture, (k % 2 * (SIZE[0] + 8), k // 2 * (SIZE[1] + 8)))
    return sheet


def lights() -> Image.Image:
    """Draw two places, dark on the left and lit on the right."""
    sheet = Image.new("RGB", (2 * SIZE[0] + 8, 2 * SIZE[1] + 8), "white")
    rig = display_rig("mono", SIZE)
    for row, (name, ticks, place) in enumerate(LIT):
        world, tour = start_world(name), Tour()
        for _ in range(ticks):
            step(world, tour.steer(world))
        submarine = world.state.submarine
        if place is not None:
            x, y, high, heading, pitch = place
            floor = height_at(world.state.sea.heights, world.state.sea.half_width, x, y)
            submarine.position[:] = submarine.previous_position[:] = x, y, floor + high
            submarine.angles[:] = submarine.previous_angles[:] = np.radians((heading, pitch))
        seen = views(rig, cockpit(submarine, 1.0))
        with headless() as context, picture_maker(context, world, rig, PRESETS["high"]) as renderer:
            for column, on in enumerate((False, True)):
                submarine.lights[:] = on
                renderer.draw(pack(world, seen, 1.0, PackOptions(detail=1.6)))
                picture = Image.fromarray(renderer.read_pixels())
                sheet.paste(picture, (column * (SIZE[0] + 8), row * (SIZE[1] + 8)))
    return sheet


if __name__ == "__main__":
    folder = output_folder()
    save(plate(), folder / "diagrams.jpg")
    save(lights(), folder / "lights.jpg")
