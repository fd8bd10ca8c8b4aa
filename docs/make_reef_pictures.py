"""Make the plate of corals in the documentation: `python docs/make_reef_pictures.py [FOLDER]`.

corals.jpg: every kind of `habitat.reef.KINDS`, by name, on level sand.
"""

import numpy as np
from picture_files import output_folder, save
from PIL import Image, ImageDraw

from subsea.fish.species import load_species
from subsea.fish.surface import rest_control_points
from subsea.frame.packet import INSTANCE_COLUMNS, Packet, RenderScene
from subsea.habitat.reef import KINDS
from subsea.rendering.gl.context import headless_context
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.renderer import Renderer
from subsea.scenario.schema import Water
from subsea.state import Reef
from subsea.view.display_rigs import display_rig, views_for
from subsea.view.rig import pose_from_angles

SIZE = (1280, 520)
DEPTH_CM = 420.0
ROWS_CM = (90.0, 152.0)  # how far away each row of growths is
APART_CM = (27.0, 42.0)
HIGH_CM, WIDE_CM = (26.0, 52.0), (12.0, 18.0)  # the largest height and radius that a growth has
TINTS = (0.1, 0.45, 0.1, 0.35, 0.1, 0.45, 0.8, 0.1, 0.1, 0.3, 0.1, 0.6, 0.1, 0.1)


def plate() -> Image.Image:
    """Draw all kinds, low ones in front."""
    order = sorted(range(len(KINDS)), key=lambda k: [*KINDS.values()][k].height)
    rows = order[: len(order) // 2], order[len(order) // 2 :]
    places = [
        (away, apart * ((len(row) - 1) / 2 - k), -DEPTH_CM)
        for row, away, apart in zip(rows, ROWS_CM, APART_CM, strict=True)
        for k in range(len(row))
    ]
    kinds = np.array([k for row in rows for k in row])
    height = np.array([kind.height for kind in KINDS.values()])[kinds]
    n = len(kinds)
    which = np.repeat((0, 1), [len(row) for row in rows])
    reef = Reef(
        kind=kinds.astype(np.uint8),
        place=np.array(places, np.float32),
        axis=np.tile(np.float32([0.0, 0.0, 1.0]), (n, 1)),
        turn=np.full(n, np.pi / 2, np.float32),  # fans face the eye
        radius=np.minimum(np.array(WIDE_CM)[which], np.array(HIGH_CM)[which] / height).astype(
            np.float32
        ),
        own=np.linspace(0.02, 0.97, n, dtype=np.float32),
        light=np.ones(n, np.float32),
        hue=np.array(TINTS, np.float32)[kinds],
        on_rock=np.zeros(n, np.bool_),
    )
    species = load_species("fusilier")
    scene = RenderScene(
        species=(species,),
        control_points=rest_control_points(species.surface, 20.0, 0.0)[None].astype(np.float32),
        recorded_length_cm=(20.0,),
        terrain=np.full((81, 81), -DEPTH_CM, np.float32),
        terrain_half_width_cm=3000.0,
        water=Water(fog=(0.012, 0.115, 0.20), visibility_cm=2000.0),
        reef=reef,
    )
    (view,) = views_for(
        "mono", SIZE, pose_from_angles(np.array([0.0, 0.0, -DEPTH_CM + 72.0]), 0.0, -0.42)
    )
    packet = Packet(
        2.0, (view,), np.zeros((0, INSTANCE_COLUMNS), np.float32), ((),), np.zeros((0, 3)), 0
    )
    with headless_context() as context:
        renderer = Renderer(context, scene, display_rig("mono", SIZE), PRESETS["high"])
        renderer.draw(packet)
        picture = Image.fromarray(renderer.read_pixels())
        renderer.release()
    draw = ImageDraw.Draw(picture)
    matrix = view.projection.astype(float) @ view.view.astype(float)
    for kind, place in zip(kinds, places, strict=True):
        x, y, _, w = matrix @ (*np.subtract(place, (14.0, 0.0, 3.0)), 1.0)
        at = SIZE[0] * (0.5 + 0.5 * x / w), SIZE[1] * (0.5 - 0.5 * y / w)
        draw.text(at, [*KINDS][kind], fill=(20, 24, 28), anchor="ma", font_size=17)
    return picture


if __name__ == "__main__":
    save(plate(), output_folder() / "corals.jpg")
