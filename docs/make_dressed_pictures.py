"""Pictures of docs/how-to/skin.md: `python docs/make_dressed_pictures.py [FOLDER]`.

skin-photograph.jpg: a rendered fish in place of a photograph (none could be shipped); the meshes
before and after the fit; the extracted texture. skin-worn.jpg: the same fish painted, and with that
texture, from other sides.
"""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np
from msgspec import structs
from picture_files import output_folder, save
from PIL import Image

from subsea.fish.color_sheet import write
from subsea.frame.packet import make_scene, pack
from subsea.geometry.rotation import rotate
from subsea.rendering.gl.context import headless_context
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.renderer import Renderer
from subsea.scenario.load import load_scenario
from subsea.studio.deformable_mesh import BODY, FishMeshes
from subsea.studio.fitting import align_shape, find_fish
from subsea.studio.lift import lift_sheet
from subsea.studio.photograph import Photograph, downscale
from subsea.studio.side_view import make_fish_meshes, mesh_outlines
from subsea.submarine.vessel import NEUTRAL
from subsea.view.display_rigs import display_rig, views_for
from subsea.view.rig import CameraPose
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import World

SCENARIO, SEED, TICKS, LATER = "peaceful", 1, 60, 12
FISH = "Emperor angelfish"
SIZE = (1120, 760)
SHOWN = (560, 380)
ASIDE = 1.35  # lengths of the fish to its left, where the camera is
BACKDROP = (38, 52, 66)  # behind what is clear on the sheet
INK = {BODY: (255, 236, 120), "dorsal": (120, 235, 255), "ventral": (120, 235, 255)}


def shot(renderer: Renderer, world: World, fish: int, turn: float, away: float) -> np.ndarray:
    """A picture of a fish from its left, rotated by `turn` degrees towards its face."""
    fishes = world.state.fishes
    ahead, right = (
        np.array(rotate(fishes.orientation[fish], axis)) for axis in ((1, 0, 0), (0, 0, 1))
    )
    at = fishes.position[fish].astype(float)
    turn = np.radians(turn)
    eye = at + fishes.length[fish] * away * (np.sin(turn) * ahead - np.cos(turn) * right)
    forward = (at - eye) / np.linalg.norm(at - eye)
    beside = np.cross(forward, (0.0, 0.0, 1.0))
    up = np.cross(beside / np.linalg.norm(beside), forward)
    renderer.draw(pack(world, views_for("mono", SIZE, CameraPose(eye, forward, up)), 1.0))
    return renderer.read_pixels()


def with_meshes(colour: np.ndarray, meshes: FishMeshes) -> np.ndarray:
    """A photograph overlaid with meshes."""
    picture = colour.copy()
    for (name, one), ring in zip(meshes.parts.items(), mesh_outlines(meshes), strict=True):
        lines = [*one.nodes, *one.nodes.transpose(1, 0, 2)]
        for line in lines:
            points = [np.round(16 * line).astype(np.int32)]
            cv2.polylines(picture, points, False, INK[name], 1, cv2.LINE_AA, 4)
        points = [np.round(16 * ring).astype(np.int32)]
        cv2.polylines(picture, points, True, INK[name], 2, cv2.LINE_AA, 4)
    return picture


def shrunk(picture: np.ndarray) -> np.ndarray:
    """Scale a picture to its size on the page."""
    return cv2.resize(picture, SHOWN, interpolation=cv2.INTER_AREA)


def main() -> None:
    """Make both pictures."""
    folder = output_folder()
    world = create_world(load_scenario(SCENARIO)[0], seed=SEED)
    kind = [one.name for one in world.species].index(FISH)
    fish = int(np.flatnonzero(world.state.fishes.species == kind)[0])
    species = world.species[kind]
    for _ in range(TICKS):
        step(world, NEUTRAL)
    rig, scene = display_rig("mono", SIZE), make_scene(world)
    with headless_context() as context, TemporaryDirectory() as name:
        renderer = Renderer(context, scene, rig, PRESETS["high"])
        colour = shot(renderer, world, fish, 0.0, ASIDE)
        one = find_fish(Photograph(Path("angelfish.png"), colour, None), species.surface)
        sheet = lift_sheet(colour, one.meshes, species, one.mask)
        for _ in range(LATER):
            step(world, NEUTRAL)
        views = [(-25.0, 1.2), (30.0, 1.2)]
        painted = [shot(renderer, world, fish, *view) for view in views]
        renderer.release()
        write(Path(name) / "sheet.png", sheet)
        skin = structs.replace(species.skin, sheet=str(Path(name) / "sheet.png"))
        worn = list(scene.species)
        worn[kind] = structs.replace(species, skin=skin)
        dressed = Renderer(context, replace(scene, species=tuple(worn)), rig, PRESETS["high"])
        wearing = [shot(dressed, world, fish, *view) for view in views]
        dressed.release()
    less, share = downscale(Photograph(Path("angelfish.png"), colour, None))
    matte = cv2.resize(one.mask.astype(np.uint8), less.shape[1::-1], interpolation=cv2.INTER_AREA)
    matrix, _ = align_shape(species.surface, matte > 0)
    flat = sheet[::-1].astype(np.float32)
    over = flat[..., 3:] / 255.0
    flat = flat[..., :3] * over + np.array(BACKDROP) * (1.0 - over)
    tall = SHOWN[0] * 640 // 1024
    frame = np.full((*SHOWN[::-1], 3), BACKDROP, np.uint8)
    frame[(SHOWN[1] - tall) // 2 :][:tall] = cv2.resize(
        flat.astype(np.uint8), (SHOWN[0], tall), interpolation=cv2.INTER_AREA
    )
    rows = [
        [
            shrunk(colour),
            shrunk(with_meshes(colour, make_fish_meshes(species.surface, matrix / share))),
        ],
        [shrunk(with_meshes(colour, one.meshes)), frame],
    ]
    for path, cells in (
        (folder / "skin-photograph.jpg", rows),
        (folder / "skin-worn.jpg", [list(map(shrunk, painted)), list(map(shrunk, wearing))]),
    ):
        save(Image.fromarray(np.vstack([np.hstack(row) for row in cells])), path)


if __name__ == "__main__":
    main()
